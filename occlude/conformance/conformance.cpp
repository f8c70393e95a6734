#include <occlude/conformance/conformance.h>

#include <occlude/conformance/detail/checker.h>

namespace occlude::conformance {

Report check_device(Host& host, const Options& options)
{
    Report report;
    Checker checker{host, options, report};
    std::vector<TestMethod> methods{TestMethod::automatic};
    for (const TestCost& cost : host.device().caps().methods) {
        methods.push_back(cost.method);
    }
    for (const TestMethod method : methods) {
        checker.use(method);
        check_order(checker);
        check_unions(checker);
        check_tickets(checker);
        check_worlds(checker);
    }
    checker.check("useful", report.hidden > 0 || !options.must_find_hidden,
                  "nothing was ever found hidden");
    return report;
}

std::string to_string(const Report& report)
{
    std::string text = std::to_string(report.tests) + " tests, " + std::to_string(report.visible) +
                       " of them visible by rays, " + std::to_string(report.hidden) +
                       " found hidden, " + std::to_string(report.lost) + " lost; " +
                       std::to_string(report.depths_compared) + " depths compared; " +
                       std::to_string(report.violations.size()) + " violations\n";
    for (const Violation& violation : report.violations) {
        text += violation.rule + ": " + violation.message + "\n";
    }
    return text;
}

} // namespace occlude::conformance
