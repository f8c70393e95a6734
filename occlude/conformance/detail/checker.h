// The common parts of all checks: the device, the report, and tests in one line.
#pragma once

#include <occlude/conformance/conformance.h>

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::conformance {

/// The required answer to a test of known content.
enum class Expect : uint8_t {
    visible, ///< never 0
    hidden,  ///< 0, unless the device may call everything visible
    nothing, ///< any valid answer
};

class Checker {
public:
    Checker(Host& host, const Options& options, Report& report)
        : host_(host)
        , options_(options)
        , report_(report)
    {
    }

    const Options& options() const { return options_; }
    Report& report() { return report_; }
    QueryDevice& device() { return host_.device(); }
    Host& host() { return host_; }

    /// The method of all tests from now on.
    void use(TestMethod method) { method_ = method; }
    TestMethod method() const { return method_; }

    /// A camera at `eye` that looks along `ahead`, 90 degrees high, near 0.25, far 100.
    View view(const glm::vec3& eye = glm::vec3{0.0f},
              const glm::vec3& ahead = {0.0f, 0.0f, -1.0f}) const;

    void begin(const View& view);
    void end() { device().end_frame(); }
    void draw(std::initializer_list<size_t> items, DrawPass pass = DrawPass::shade);

    /// One test over these boxes of the world; grown as algorithms grow theirs.
    Ticket ask(std::initializer_list<Aabb> boxes);
    /// One batch: a test for each box.
    std::vector<Ticket> ask_each(std::span<const Aabb> boxes);
    std::vector<Ticket> ask(std::span<const QueryBox> boxes, std::span<const uint32_t> ends);

    /// The box as it goes to a test under the view of this frame.
    Aabb grown(const Aabb& box) const { return view_.inflated_for_test(box); }

    /// Ends the frame and collects: by wait, or by polls over further frames.
    Answer resolve(Ticket ticket);

    /// Resolves the ticket and compares the answer.
    Answer expect(std::string_view rule, Ticket ticket, Expect expected, std::string_view what);
    void check(std::string_view rule, bool kept, std::string_view sentence);
    /// Checks that `answer` is lost and reads as visible.
    void expect_lost(std::string_view rule, const Answer& answer, std::string_view what);

private:
    Host& host_;
    Options options_;
    Report& report_;
    View view_;
    TestMethod method_ = TestMethod::automatic;
};

/// The four parts of check_device.
void check_order(Checker& checker);
void check_unions(Checker& checker);
void check_tickets(Checker& checker);
void check_worlds(Checker& checker);

} // namespace occlude::conformance
