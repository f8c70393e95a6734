#include "worlds/spec.h"

#include <occlude/core/rng.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

namespace occlude::worlds {

namespace {

/// Values of an enum, as the description of the option lists them: "... (one of a b c)".
std::vector<std::string> listed_values(const std::string& description)
{
    const size_t begin = description.rfind("(one of ");
    if (begin == std::string::npos) {
        return {};
    }
    std::istringstream words{
        description.substr(begin + 8, description.find(')', begin) - begin - 8)};
    std::vector<std::string> values;
    for (std::string word; words >> word;) {
        values.push_back(word);
    }
    return values;
}

std::string random_value(const OptionInfo& option, Rng& rng)
{
    if (option.default_value == "true" || option.default_value == "false") {
        return rng.below(2) == 0 ? "true" : "false";
    }
    if (const auto values = listed_values(option.description); !values.empty()) {
        return values[rng.below(static_cast<uint32_t>(values.size()))];
    }
    double value = 0.0;
    const char* end = option.default_value.data() + option.default_value.size();
    std::from_chars(option.default_value.data(), end, value);
    constexpr std::array kFactors{0.0, 0.25, 0.5, 1.0, 2.0, 5.0};
    const double changed = value * kFactors[rng.below(kFactors.size())];
    const bool whole = option.default_value.find_first_of(".e") == std::string::npos;
    if (whole) {
        constexpr std::array kSmall{0, 1, 2, 3, 7};
        const bool small = rng.below(2) == 0;
        return std::to_string(small ? kSmall[rng.below(kSmall.size())]
                                    : static_cast<int64_t>(changed));
    }
    std::ostringstream text;
    text << changed;
    return text.str();
}

/// Options that make an image approximate have other tests. Seeds change nothing that is checked.
bool keeps_exact(const OptionInfo& option)
{
    constexpr std::array kApproximate{"threshold", "finish", "seed", "max_visible_samples"};
    return std::find(kApproximate.begin(), kApproximate.end(), option.name) == kApproximate.end();
}

void choose_culler(Spec& spec, Rng& rng, const std::string& algorithm)
{
    const auto all = algorithms();
    const AlgorithmInfo* info = algorithm.empty()
                                    ? &all[rng.below(static_cast<uint32_t>(all.size()))]
                                    : find_algorithm(algorithm);
    spec.algorithm = info->name;
    if (rng.below(3) != 0) {
        for (const OptionInfo& option : info->options) {
            if (keeps_exact(option) && rng.below(3) == 0) {
                spec.options.emplace_back(option.name, random_value(option, rng));
            }
        }
    }
    if (info->name == "prioritized") { // its default draws part of the scene
        spec.options.emplace_back("finish", "true");
    }
    if (info->name == "uniform_grid") { // its default cells are as large as these worlds
        spec.options.emplace_back("cell_triangles", "24");
    }
    const auto kinds = hierarchy_kinds();
    spec.hierarchy = kinds[rng.below(static_cast<uint32_t>(kinds.size()))].name;
    spec.leaf_triangles = std::array{0u, 24u, 100u, 400u}[rng.below(4)];
    spec.clock = rng.below(3) == 0;
    spec.views = rng.below(4) == 0 ? 2 + rng.below(3) : 1;
}

Faults random_faults(Rng& rng)
{
    Faults faults;
    faults.seed = rng.next();
    if (rng.below(3) == 0) {
        return faults;
    }
    const auto now_and_then = [&](uint32_t most) {
        return rng.below(3) == 0 ? rng.below(most) : 0;
    };
    faults.lost = now_and_then(400);
    faults.never_ready = now_and_then(400);
    faults.depth_fails = now_and_then(600);
    faults.max_polls = now_and_then(12);
    faults.max_frames = now_and_then(5);
    faults.expires_after_frames = now_and_then(4);
    faults.max_outstanding = rng.below(5) == 0 ? 1 + rng.below(40) : 0;
    faults.same_frame_results = rng.below(12) != 0;
    return faults;
}

const char* lens_text(Lens lens)
{
    constexpr std::array kTexts{"", ", orthographic", ", infinite", ", off-centre", ", oblique"};
    return kTexts[static_cast<size_t>(lens)];
}

} // namespace

Spec random_spec(uint64_t seed, const std::string& algorithm)
{
    Rng rng{seed};
    Spec spec;
    spec.seed = seed;
    spec.items = 2 + rng.below(rng.below(6) == 0 ? 300 : 70);
    spec.unit = std::array{1.0f, 1.0f, 0.001f, 1000.0f}[rng.below(4)];
    spec.offset = std::array{0.0f, 0.0f, 3.0f, 100.0f, 1e4f, 1e6f}[rng.below(6)];
    spec.flags = rng.below(3) == 0;
    spec.moves = rng.below(3) == 0;
    spec.rebuilds = rng.below(5) == 0;
    spec.frames = 3 + rng.below(10);
    spec.size_px = {1 + static_cast<int>(rng.below(90)), 1 + static_cast<int>(rng.below(70))};
    spec.convention = {rng.below(2) == 0 ? DepthRange::minus_one_to_one : DepthRange::zero_to_one,
                       rng.below(2) == 0 ? DepthOrder::near_is_small : DepthOrder::near_is_large};
    spec.lens = std::array{Lens::perspective, Lens::perspective, Lens::orthographic,
                           Lens::infinite,    Lens::off_centre,  Lens::oblique}[rng.below(6)];
    spec.near_plane = std::array{0.1f, 0.1f, 0.001f, 1.0f}[rng.below(4)];
    spec.mirrored = rng.below(8) == 0;
    spec.depth_clamp = rng.below(8) == 0;
    // In world coordinates, far positions round by more than the size of the world.
    spec.camera_relative = rng.below(spec.offset > 100.0f ? 16 : 2) != 0;
    spec.resets = rng.below(5) == 0;
    choose_culler(spec, rng, algorithm);
    spec.method = rng.below(3) == 0 ? TestMethod::pyramid : TestMethod::queries;
    spec.faults = random_faults(rng);
    return spec;
}

std::string to_text(const Spec& spec)
{
    std::ostringstream text;
    text << "seed " << spec.seed << ": " << spec.items << " items, unit " << spec.unit
         << ", offset " << spec.offset << ", " << spec.frames << " frames of " << spec.size_px.x
         << 'x' << spec.size_px.y
         << (spec.convention.range == DepthRange::zero_to_one ? ", [0,1]" : "")
         << (spec.convention.order == DepthOrder::near_is_large ? ", reverse Z" : "")
         << lens_text(spec.lens) << (spec.near_plane != 0.1f ? ", near " : "")
         << (spec.near_plane != 0.1f ? std::to_string(spec.near_plane) : "")
         << (spec.mirrored ? ", mirrored" : "") << (spec.depth_clamp ? ", depth clamp" : "")
         << (spec.camera_relative ? ", camera-relative" : "") << (spec.flags ? ", flags" : "")
         << (spec.moves ? ", moves" : "") << (spec.rebuilds ? ", rebuilds" : "")
         << (spec.resets ? ", resets" : "") << "; " << spec.algorithm;
    for (const auto& [name, value] : spec.options) {
        text << ' ' << name << '=' << value;
    }
    const Faults& faults = spec.faults;
    text << " on " << spec.hierarchy << " of leaves " << spec.leaf_triangles
         << (spec.clock ? ", clock" : "") << ", " << spec.views << " views; " << name(spec.method)
         << ", faults: lost " << faults.lost << ", never ready " << faults.never_ready
         << ", depth fails " << faults.depth_fails << ", polls " << faults.max_polls << ", frames "
         << faults.max_frames << ", expire " << faults.expires_after_frames << ", tickets "
         << faults.max_outstanding
         << (faults.same_frame_results ? "" : ", no results in the same frame") << ", fault seed "
         << faults.seed;
    return text.str();
}

std::vector<Spec> simpler(const Spec& spec)
{
    std::vector<Spec> all;
    const auto with = [&](auto&& change) {
        Spec changed = spec;
        change(changed);
        if (to_text(changed) != to_text(spec)) {
            all.push_back(std::move(changed));
        }
    };
    with([](Spec& s) { s.faults = Faults{}; });
    with([](Spec& s) { s.options.clear(); });
    with([](Spec& s) { s.items = 1 + s.items / 2; });
    with([](Spec& s) { s.frames = 1 + s.frames / 2; });
    with([](Spec& s) { s.items = std::max(1u, s.items - 1); });
    with([](Spec& s) { s.frames = std::max(1u, s.frames - 1); });
    with([](Spec& s) { s.moves = false; });
    with([](Spec& s) { s.rebuilds = false; });
    with([](Spec& s) { s.resets = false; });
    with([](Spec& s) { s.flags = false; });
    with([](Spec& s) { s.clock = false; });
    with([](Spec& s) { s.views = 1; });
    with([](Spec& s) { s.unit = 1.0f; });
    with([](Spec& s) { s.offset = 0.0f; });
    with([](Spec& s) { s.convention = {}; });
    with([](Spec& s) { s.lens = Lens::perspective; });
    with([](Spec& s) { s.near_plane = 0.1f; });
    with([](Spec& s) { s.mirrored = false; });
    with([](Spec& s) { s.depth_clamp = false; });
    with([](Spec& s) { s.camera_relative = false; });
    with([](Spec& s) { s.hierarchy = "bvh"; });
    with([](Spec& s) { s.leaf_triangles = 0; });
    with([](Spec& s) { s.method = TestMethod::queries; });
    with([](Spec& s) { s.faults.lost = 0; });
    with([](Spec& s) { s.faults.never_ready = 0; });
    with([](Spec& s) { s.faults.depth_fails = 0; });
    with([](Spec& s) { s.faults.max_polls = 0; });
    with([](Spec& s) { s.faults.max_frames = 0; });
    with([](Spec& s) { s.faults.expires_after_frames = 0; });
    with([](Spec& s) { s.faults.max_outstanding = 0; });
    with([](Spec& s) { s.faults.same_frame_results = true; });
    for (size_t i = 0; i < spec.options.size(); ++i) {
        with([i](Spec& s) { s.options.erase(s.options.begin() + static_cast<std::ptrdiff_t>(i)); });
    }
    return all;
}

} // namespace occlude::worlds
