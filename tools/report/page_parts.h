// The parts of HTML reports that are put in at build time, so that reports stand alone.
#pragma once

namespace occlude::tools {

/// The source of Chart.js, minified, with its licence. MIT; https://www.chartjs.org
const char* chart_js();

/// report.css and report.js beside this file.
const char* report_css();
const char* report_js();

} // namespace occlude::tools
