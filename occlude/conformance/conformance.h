// Whether a device keeps the contract of core/query_device.h (C1 to C12): for everyone who writes
// one. Needs no test framework: the violations come back as sentences.
//
//   struct MyHost : occlude::conformance::Host { ... };
//   MyHost host;
//   for (const auto& v : occlude::conformance::check_device(host).violations) {
//       std::fprintf(stderr, "%s: %s\n", v.rule.c_str(), v.message.c_str());
//   }
//
// The truth is independent of the device: rays through pixels against the boxes that are drawn, in
// double precision. A sample counts as visible only if five rays through its pixel agree, so no
// rule of rasterisation and no sample position decides.
//
// Checked, by every method of caps().methods and by `automatic`:
//   C2   a test sees the draws before it, not those after it; a frame starts cleared
//   C3   a test of something that can be seen is not answered with 0, over random worlds
//   C4   a test leaves depth alone: later tests, draws and read_depth find it as it was
//   C6   boxes of a test are a union, boxes may have transforms, tickets belong to their tests
//   C7   a spent, invented or invalid ticket answers lost, also when its slot has a new owner
//   C8   whatever is not ready reads as visible
//   C9   wait never answers pending
//   C11  a test beyond max_outstanding is lost, and the device recovers
//   C12  tickets outlive their frame and keep the answer of the frame that asked
//   passes, draw_and_query, read_depth, read_depth_tiles: as their own comments say
// C1, C5 and C10 bind the caller: ValidatingDevice checks them. That poll never blocks cannot be
// seen from outside.
#pragma once

#include <occlude/core/query_device.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace occlude::conformance {

/// The device and what the suite needs besides: content that it knows.
class Host {
public:
    virtual ~Host() = default;

    virtual QueryDevice& device() = 0;

    /// From the next frame on, item i is the solid box boxes[i], opaque, and nothing else exists.
    /// Draw both sides of its faces or its outside only. Called outside of frames.
    virtual void set_items(std::span<const Aabb> boxes) = 0;

    /// Of the target. At least 16x16; small targets are faster.
    virtual glm::ivec2 size_px() const { return {96, 64}; }

    /// What the device draws with.
    virtual ClipConvention convention() const { return {}; }
};

struct Options {
    uint64_t seed = 1;
    /// Random worlds per method. Each has 24 boxes and about 30 tests.
    uint32_t worlds = 6;
    /// A device that finds nothing hidden keeps the contract and is useless. By default that is a
    /// violation of the rule "useful"; false for devices that answer from scripts.
    bool must_find_hidden = true;
    /// By default a lost answer, though allowed (C8), is a violation of the rule "useful" unless
    /// caps().max_outstanding explains it; true for devices that lose answers on purpose.
    bool may_lose_answers = false;
    /// By default read_depth must be what rays say. True for devices whose depth is a bound, never
    /// nearer than what is drawn, as that of CpuFastDevice is.
    bool depth_may_be_farther = false;
};

struct Violation {
    std::string rule;    ///< "C3", "read_depth", "useful", ...
    std::string message; ///< a sentence, with the method and the world's seed where there is one
};

struct Report {
    std::vector<Violation> violations;
    // How much evidence there is.
    uint64_t tests = 0;           ///< asked
    uint64_t visible = 0;         ///< ... of which rays say that they must be visible
    uint64_t hidden = 0;          ///< ... that the device found hidden
    uint64_t lost = 0;            ///< ... that the device lost
    uint64_t depths_compared = 0; ///< pixels of read_depth compared with rays

    bool passed() const { return violations.empty(); }
};

/// Runs everything. The same host, options and device give the same report. A rule that is broken
/// again and again is named at most eight times.
Report check_device(Host& host, const Options& options = {});

/// The report in lines: the counts, then one violation a line.
std::string to_string(const Report& report);

} // namespace occlude::conformance
