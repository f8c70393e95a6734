// The plotting library of HTML reports, put in at build time so that reports stand alone.
#pragma once

namespace occlude::tools {

/// The source of Chart.js, minified, with its licence. MIT; https://www.chartjs.org
const char* chart_js();

} // namespace occlude::tools
