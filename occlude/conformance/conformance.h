// Checks whether a device keeps the contract of core/query_device.h (C1 to C12), for everyone who
// writes one. Needs no test framework: violations come back as sentences.
//
//   struct MyHost : occlude::conformance::Host { ... };
//   MyHost host;
//   for (const auto& v : occlude::conformance::check_device(host).violations) {
//       std::fprintf(stderr, "%s: %s\n", v.rule.c_str(), v.message.c_str());
//   }
//
// The truth is independent of the device: rays through pixels against the drawn boxes, in double
// precision. A sample counts as visible only if five rays through its pixel agree, so that neither
// the rasterisation rules nor the sample positions matter.
//
// Checked for every method of caps().methods and for `automatic`:
//   C2   a test sees the draws before it, not those after it; a frame starts cleared
//   C3   a test of something visible is not answered with 0, over random worlds
//   C4   a test does not change depth: later tests, draws and read_depth find it unchanged
//   C6   boxes of a test are a union, boxes may have transforms, tickets belong to their tests
//   C7   a spent, invented or invalid ticket answers lost, also when its slot has a new owner
//   C8   an answer that is not ready reads as visible
//   C9   wait never answers pending
//   C11  a test beyond max_outstanding is lost, and the device recovers
//   C12  tickets outlive their frame and keep the answer of the frame that issued them
//   passes, draw_and_query, read_depth, read_depth_tiles: as documented there
// C1, C5 and C10 bind the caller: ValidatingDevice checks them. Whether poll blocks cannot be seen
// seen from outside.
#pragma once

#include <occlude/core/query_device.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace occlude::conformance {

/// The device, and content that the suite knows.
class Host {
public:
    virtual ~Host() = default;

    virtual QueryDevice& device() = 0;

    /// Sets the content from the next frame on: item i is the solid, opaque box boxes[i], and
    /// nothing else exists. The host draws both sides of its faces or only its outside. Called
    /// outside of frames.
    virtual void set_items(std::span<const Aabb> boxes) = 0;

    /// The size of the target. At least 16x16; small targets are faster.
    virtual glm::ivec2 size_px() const { return {96, 64}; }

    /// The clip convention of the device.
    virtual ClipConvention convention() const { return {}; }
};

struct Options {
    uint64_t seed = 1;
    /// Random worlds per method. Each has 24 boxes and about 30 tests.
    uint32_t worlds = 6;
    /// A device that finds nothing hidden keeps the contract, but is useless. By default this is a
    /// violation of the rule "useful". Set it to false for devices that answer from scripts.
    bool must_find_hidden = true;
    /// A lost answer is allowed (C8). By default it is a violation of the rule "useful" unless
    /// caps().max_outstanding explains it. Set this to true for devices that lose answers on
    /// purpose.
    bool may_lose_answers = false;
    /// By default read_depth must agree with the rays. Set this to true for devices whose depth is
    /// a bound that is never nearer than what is drawn, such as CpuFastDevice.
    bool depth_may_be_farther = false;
};

struct Violation {
    std::string rule;    ///< "C3", "read_depth", "useful", ...
    std::string message; ///< a sentence, with the method and the world's seed where there is one
};

struct Report {
    std::vector<Violation> violations;
    // The amount of evidence.
    uint64_t tests = 0;           ///< tests issued
    uint64_t visible = 0;         ///< tests that must be visible according to the rays
    uint64_t hidden = 0;          ///< tests that the device found hidden
    uint64_t lost = 0;            ///< tests that the device lost
    uint64_t depths_compared = 0; ///< pixels of read_depth compared with rays

    bool passed() const { return violations.empty(); }
};

/// Runs all checks. The same host, options and device give the same report. A rule that is broken
/// repeatedly is named at most eight times.
Report check_device(Host& host, const Options& options = {});

/// The report in lines: the counts, then one violation a line.
std::string to_string(const Report& report);

} // namespace occlude::conformance
