// The decisions of every algorithm on a made-up walk, as one hash each. They are the same with
// every compiler, build type and number of threads. A changed hash means changed decisions: give
// the reason for a new value in the commit message.
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include "support/visibility_script.h"
#include "support/walks.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <thread>

namespace occlude {
namespace {

uint64_t decisions_on(ScriptedDevice& device, uint64_t& frame, const std::string& algorithm,
                      const Hierarchy& tree, std::span<const OptionValue> options = {})
{
    auto culler = make_culler(algorithm, tree, options);
    uint64_t hash = 0;
    for (; frame < 48; ++frame) {
        (*culler)->cull(test::rough_walk(frame), device);
        hash = walk_hash(hash, (*culler)->decisions().hash(tree, frame));
    }
    return hash;
}

uint64_t decisions_of(const std::string& algorithm, const Hierarchy& tree)
{
    uint64_t frame = 0;
    DeviceScript script{.boxes = test::consistent_visibility(tree, 9, frame, 0.2f)};
    script.caps.draw_and_query = true;
    ScriptedDevice device(script);
    return decisions_on(device, frame, algorithm, tree);
}

// Decisions on a device with every method, where tests pay. Boxes are answered by the made-up
// truth; depth is tiles of 8x8 pixels, near and far at random.
uint64_t decisions_by(const std::string& algorithm, const Hierarchy& tree,
                      std::vector<OptionValue> options)
{
    uint64_t frame = 0;
    DeviceScript script{.boxes = test::consistent_visibility(tree, 9, frame, 0.2f)};
    script.depth = [&frame](const PixelRect& rect, std::span<float> out) {
        for (size_t i = 0; i < out.size(); ++i) {
            const size_t x = i % static_cast<size_t>(rect.width);
            const size_t y = i / static_cast<size_t>(rect.width);
            out[i] = hash64(frame / 5, x / 8, y / 8) % 4 == 0 ? 1.0f : 0.995f;
        }
        return true;
    };
    script.caps.read_depth = true;
    script.caps.us_per_triangle = 1.0f;
    script.caps.us_per_item = 3.0f;
    script.caps.methods = {{TestMethod::queries, 10.0f, 5.0f, 1.0f},
                           {TestMethod::raster, 20.0f, 2.5f, 2.5f}};
    ScriptedDevice device(script);
    return decisions_on(device, frame, algorithm, tree, options);
}

Hierarchy tree_of(const HierarchyKind& kind)
{
    return kind.build(test::random_boxes(600, 21), 300);
}

// As the tables have it, to be copied from a failure.
std::string hex(uint64_t hash)
{
    std::ostringstream text;
    text << "0x" << std::hex << hash;
    return text.str();
}

struct Golden {
    const char* hierarchy;
    const char* algorithm;
    uint64_t hash;
};

// One entry for each hierarchy and algorithm.
constexpr Golden kGolden[] = {
    {"bvh", "frustum", 0x5bd294905829ada},
    {"bvh", "stop_and_wait", 0xddc7de1b56686eea},
    {"bvh", "chc", 0x5cc13c832dd7deec},
    {"bvh", "chc_plus_plus", 0x6c6fde316ff23d04},
    {"bvh", "statistical", 0x79a2300ebabb5551},
    {"bsp", "frustum", 0xe8284d18a95994d9},
    {"bsp", "stop_and_wait", 0x191557e9e90d1152},
    {"bsp", "chc", 0x31b625d4ec83d75},
    {"bsp", "chc_plus_plus", 0x1ae24d9f78befd2a},
    {"bsp", "statistical", 0x2ea11108dba3c517},
    {"bvh", "two_level", 0x8ff645aca175250b},
    {"bsp", "two_level", 0xe4aa735be75e5c57},
    {"two_level", "two_level", 0x36a46411508aa847},
    {"bvh", "uniform_grid", 0x4e560ff2ccc67bd9},
    {"bvh", "prioritized", 0xe2a652a31c0cd2ab},
    {"bvh", "batch_and_wait", 0x375287a8e1029e4e},
    {"grid", "batch_and_wait", 0x42550c2762655a0},
    {"bvh", "next_frame", 0x72a0cce4c19a9048},
    {"grid", "next_frame", 0x5f9a3f7991092d76},
};

TEST(GoldenDecisions, AreTheSameEverywhere)
{
    for (const Golden& golden : kGolden) {
        const HierarchyKind* kind = find_hierarchy_kind(golden.hierarchy);
        ASSERT_NE(kind, nullptr);
        EXPECT_EQ(hex(decisions_of(golden.algorithm, tree_of(*kind))), hex(golden.hash))
            << golden.algorithm << " on " << golden.hierarchy;
    }
}

struct GoldenByMethod {
    const char* hierarchy;
    const char* algorithm;
    const char* method; ///< of `adaptive`
    uint64_t hash;
};

constexpr GoldenByMethod kGoldenByMethod[] = {
    {"bvh", "lazy_grid", "", 0x83951623bb708fd},
    {"bsp", "lazy_grid", "", 0xc14ab3a42648fd37},
    {"two_level", "lazy_grid", "", 0x3dd372905c784ae4},
    {"bvh", "two_phase", "", 0xce1ae444ca7bf638},
    {"bvh", "adaptive", "automatic", 0xfecf10789b171eb5},
    {"bvh", "adaptive", "queries", 0x211ab888e844715d},
    {"bvh", "adaptive", "raster", 0x1629063200f778a3},
    {"bvh", "adaptive", "pyramid", 0x9e50e75c1a4fc50a},
    {"bsp", "two_phase", "", 0x7c9a5ca8969fed12},
    {"bsp", "adaptive", "automatic", 0xc8e5052ac4e7246f},
    {"bsp", "adaptive", "queries", 0xcc7a4e2caea4285d},
    {"bsp", "adaptive", "raster", 0x1bef443db77466b2},
    {"bsp", "adaptive", "pyramid", 0x65b199fde2e5aa22},
    {"octree", "two_phase", "", 0xad6580ca205bae14},
    {"octree", "adaptive", "automatic", 0xf9a5fe29d6a0f0e4},
    {"octree", "adaptive", "queries", 0x23aa703ba5b0660b},
    {"octree", "adaptive", "raster", 0x72aa89d536781e46},
    {"octree", "adaptive", "pyramid", 0x4e8c94910976f687},
    {"grid", "two_phase", "", 0xe1ea7c4e44f42856},
    {"grid", "adaptive", "automatic", 0xd7d5cdb3652ae586},
    {"grid", "adaptive", "queries", 0x5760bbc698129c70},
    {"grid", "adaptive", "raster", 0xeaf37f1bf64de849},
    {"grid", "adaptive", "pyramid", 0x6f71ac47eb895930},
    {"two_level", "two_phase", "", 0xee6e903b5d90eff},
    {"two_level", "adaptive", "automatic", 0xfb97d7737c39132f},
    {"two_level", "adaptive", "queries", 0x8072ad2ff722b542},
    {"two_level", "adaptive", "raster", 0xd2704a4bf9667682},
    {"two_level", "adaptive", "pyramid", 0x89491a0055ce3460},
};

TEST(GoldenDecisions, OfTheAlgorithmsThatReadDepthAreTheSameEverywhereByEveryMethod)
{
    for (const GoldenByMethod& golden : kGoldenByMethod) {
        const HierarchyKind* kind = find_hierarchy_kind(golden.hierarchy);
        ASSERT_NE(kind, nullptr);
        std::vector<OptionValue> options;
        if (golden.method[0] != '\0') {
            options.emplace_back("method", golden.method);
        }
        EXPECT_EQ(hex(decisions_by(golden.algorithm, tree_of(*kind), options)), hex(golden.hash))
            << golden.algorithm << " " << golden.method << " on " << golden.hierarchy;
    }
}

// Every algorithm needs a line here: otherwise its decisions could change unnoticed.
TEST(GoldenDecisions, CoverEveryAlgorithm)
{
    for (const AlgorithmInfo& info : algorithms()) {
        const auto is_it = [&](const auto& golden) { return info.name == golden.algorithm; };
        EXPECT_TRUE(info.needs.visible_set || std::ranges::any_of(kGolden, is_it) ||
                    std::ranges::any_of(kGoldenByMethod, is_it))
            << info.name;
    }
}

TEST(GoldenDecisions, DoNotDependOnTheNumberOfThreads)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        std::vector<uint64_t> hashes;
        for (const size_t threads : {size_t{1}, size_t{2}}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            hashes.push_back(decisions_of("chc_plus_plus", tree_of(kind)));
        }
        EXPECT_EQ(hashes[0], hashes[1]) << kind.name;
    }
}

// All algorithms at once over one tree, each in its own thread. ThreadSanitizer then proves that
// cullers share only const data.
TEST(GoldenDecisions, DoNotDependOnCullersInOtherThreads)
{
    std::vector<std::string> names;
    for (const AlgorithmInfo& algorithm : algorithms()) {
        if (!algorithm.needs.visible_set) {
            names.push_back(algorithm.name);
        }
    }
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        const Hierarchy tree = tree_of(kind);
        std::vector<uint64_t> together(names.size());
        std::vector<std::thread> threads;
        for (size_t i = 0; i < names.size(); ++i) {
            threads.emplace_back([&, i] { together[i] = decisions_of(names[i], tree); });
        }
        for (std::thread& thread : threads) {
            thread.join();
        }
        for (size_t i = 0; i < names.size(); ++i) {
            EXPECT_EQ(together[i], decisions_of(names[i], tree)) << names[i] << " on " << kind.name;
        }
    }
}

} // namespace
} // namespace occlude
