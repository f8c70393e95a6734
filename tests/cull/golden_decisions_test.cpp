// The decisions of every algorithm on a made-up walk, as one hash each: the same from every
// compiler, build type and number of threads. A change here is a change of what algorithms decide:
// promote a new value only with the reason in the commit message.
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include "support/visibility_script.h"
#include "support/walks.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <thread>

namespace occlude {
namespace {

uint64_t decisions_of(const std::string& algorithm, const Hierarchy& tree)
{
    uint64_t frame = 0;
    DeviceScript script{.boxes = test::consistent_visibility(tree, 9, frame, 0.2f)};
    script.caps.draw_and_query = true;
    ScriptedDevice device(script);
    auto culler = make_culler(algorithm, tree);
    uint64_t hash = 0;
    for (; frame < 48; ++frame) {
        (*culler)->cull(test::rough_walk(frame), device);
        hash = walk_hash(hash, (*culler)->decisions().hash(tree, frame));
    }
    return hash;
}

Hierarchy tree_of(const HierarchyKind& kind)
{
    return kind.build(test::random_boxes(600, 21), 300);
}

struct Golden {
    const char* hierarchy;
    const char* algorithm;
    uint64_t hash;
};

// One entry per hierarchy and algorithm.
constexpr Golden kGolden[] = {
    {"bvh", "frustum", 0x5bd294905829ada},        {"bvh", "stop_and_wait", 0xddc7de1b56686eea},
    {"bvh", "chc", 0x5cc13c832dd7deec},           {"bvh", "chc_plus_plus", 0x6c6fde316ff23d04},
    {"bvh", "statistical", 0x79a2300ebabb5551},   {"bsp", "frustum", 0xe8284d18a95994d9},
    {"bsp", "stop_and_wait", 0x191557e9e90d1152}, {"bsp", "chc", 0x31b625d4ec83d75},
    {"bsp", "chc_plus_plus", 0x1ae24d9f78befd2a}, {"bsp", "statistical", 0x2ea11108dba3c517},
};

TEST(GoldenDecisions, AreTheSameEverywhere)
{
    for (const Golden& golden : kGolden) {
        const HierarchyKind* kind = find_hierarchy_kind(golden.hierarchy);
        ASSERT_NE(kind, nullptr);
        EXPECT_EQ(decisions_of(golden.algorithm, tree_of(*kind)), golden.hash)
            << golden.algorithm << " on " << golden.hierarchy;
    }
}

TEST(GoldenDecisions, DoNotDependOnTheNumberOfThreads)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        std::vector<uint64_t> hashes;
        for (const size_t threads : {1, 2}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            hashes.push_back(decisions_of("chc_plus_plus", tree_of(kind)));
        }
        EXPECT_EQ(hashes[0], hashes[1]) << kind.name;
    }
}

// All algorithms at once over one tree, each in a thread of its own: under ThreadSanitizer a proof
// that cullers share nothing but what is const.
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
