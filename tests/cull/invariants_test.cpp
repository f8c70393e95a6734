// What must hold after every frame of every algorithm that tests, whatever the answers and however
// late they come: invariants I1 to I5, the device contract, and decisions that do not depend on
// latency, threads or compiler. (I6, the image itself, is in exactness_test.cpp.)
#include "cull/invariant_cases.h"
#include "support/visibility_script.h"
#include "support/walks.h"

#include <occlude/device/counting_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace occlude {
namespace {

using namespace test::invariants;

// Depth for algorithms that read it: tiles of 8x8 pixels, near and far at random.
bool tiled_depth(uint64_t frame, const PixelRect& rect, std::span<float> out)
{
    for (size_t i = 0; i < out.size(); ++i) {
        const uint64_t x = static_cast<uint64_t>(rect.x) + i % static_cast<size_t>(rect.width);
        const uint64_t y = static_cast<uint64_t>(rect.y) + i / static_cast<size_t>(rect.width);
        out[i] = hash64(frame / 5, x / 8, y / 8) % 4 == 0 ? 1.0f : 0.995f;
    }
    return true;
}

Latency random_latency(uint64_t seed, uint64_t test)
{
    const uint64_t random = hash64(seed, test);
    return random % 11 == 0 ? Latency::never() : Latency::after_polls(uniform_below(random, 9));
}

class Invariants : public ::testing::TestWithParam<Case> {
protected:
    static constexpr uint64_t kFrames = 48;

    std::unique_ptr<Culler> make() const
    {
        return std::move(make_culler(GetParam().algorithm, tree_, GetParam().options).value());
    }
    DeviceScript script(float share = 0.2f)
    {
        DeviceScript script{.boxes = test::consistent_visibility(tree_, 9, frame_, share)};
        script.caps.draw_and_query = true;
        script.caps.read_depth = true;
        script.caps.methods.push_back({.method = TestMethod::raster, .exact_counts = false});
        script.depth = [this](const PixelRect& rect, std::span<float> out) {
            return tiled_depth(frame_, rect, out);
        };
        return script;
    }

    const HierarchyKind& kind_ = *find_hierarchy_kind(GetParam().hierarchy);
    const Hierarchy tree_ = kind_.build(test::random_boxes(600, 21), 300);
    uint64_t frame_ = 0;
};

/// Algorithms whose hidden nodes are those that a test of the device found hidden.
class QueryInvariants : public Invariants {};

/// Algorithms that know every answer before the frame ends.
class LatencyInvariants : public Invariants {};

TEST_P(Invariants, TheDeviceContractHoldsAndNoQueueOutlivesTheFrame)
{
    DeviceScript late = script();
    late.latency = [](uint64_t test) { return random_latency(4, test); };
    ScriptedDevice scripted(late);
    std::vector<std::string> violations;
    ValidatingDevice device(scripted,
                            {.on_violation = [&](std::string_view rule, std::string_view text) {
                                violations.push_back(std::string{rule} + " " + std::string{text});
                            }});
    const auto culler = make();
    for (frame_ = 0; frame_ < kFrames; ++frame_) {
        culler->cull(test::rough_walk(frame_), device);
        ASSERT_TRUE(scripted.outstanding() == 0 || tests_for_later_frames(GetParam())); // I2
        ASSERT_LE(scripted.outstanding(), scripted.caps().max_outstanding / 2);
    }
    EXPECT_EQ(violations, std::vector<std::string>{}); // I3 is C10, I5 is C5
}

TEST_P(QueryInvariants, EveryItemInTheFrustumIsDrawnOrCoveredByATestOfThisFrame)
{
    ScriptedDevice device(script());
    const auto culler = make();
    uint64_t drawn = 0;
    uint64_t hidden = 0;
    for (frame_ = 0; frame_ < kFrames; ++frame_) {
        device.clear_trace();
        const View view = test::rough_walk(frame_);
        culler->cull(view, device);
        std::set<NodeId> asked; // nodes whose test, or whose group's test, found nothing
        std::map<Ticket, std::vector<NodeId>> tests;
        for (const auto& event : device.trace()) {
            uint32_t first = 0;
            for (size_t i = 0; i < event.test_ends.size(); ++i) {
                tests[event.tickets[i]].assign(event.subjects.begin() + first,
                                               event.subjects.begin() + event.test_ends[i]);
                first = event.test_ends[i];
            }
            const bool answer = event.verb == ScriptedDevice::Verb::poll ||
                                event.verb == ScriptedDevice::Verb::wait;
            if (answer && event.answer.state == AnswerState::ready && event.answer.samples == 0) {
                asked.insert(tests[event.tickets[0]].begin(), tests[event.tickets[0]].end());
            }
        }
        const std::set<ItemId> in_image(culler->drawn_items().begin(), culler->drawn_items().end());
        const std::vector<Decision> decisions = culler->decisions().by_item(tree_);
        std::vector<bool> covered(decisions.size());
        for (const NodeId node : asked) {
            for (const ItemId item : tree_.subtree_items(node)) {
                covered[item.value] = true;
            }
        }
        for (size_t i = 0; i < tree_.items().size(); ++i) {
            const ItemId item = tree_.items()[i];
            if (view.frustum().classify(tree_.item_bounds()[i].box) == Containment::outside) {
                continue;
            }
            const bool is_in_image = in_image.contains(item);
            ASSERT_TRUE(is_in_image || covered[item.value]) << "item " << item.value; // I1
            ASSERT_EQ(is_in_image, is_drawn(decisions[item.value]));
            (is_in_image ? drawn : hidden) += 1;
        }
    }
    // Both outcomes are frequent, so that the scene is evidence.
    EXPECT_GT(drawn, (drawn + hidden) / 10);
    EXPECT_GT(hidden, (drawn + hidden) / 10);
}

TEST_P(LatencyInvariants, LatencyChangesWaitsNeverDecisions)
{
    const auto run = [&](std::function<Latency(uint64_t)> latency) {
        DeviceScript late = script();
        late.latency = std::move(latency);
        ScriptedDevice device(late);
        const auto culler = make();
        std::vector<uint64_t> hashes;
        for (frame_ = 0; frame_ < kFrames; ++frame_) {
            culler->cull(test::rough_walk(frame_), device);
            hashes.push_back(culler->decisions().hash(tree_, frame_));
        }
        return hashes;
    };
    const auto at_once = run({});
    EXPECT_EQ(at_once, run([](uint64_t) { return Latency::never(); }));
    EXPECT_EQ(at_once, run([](uint64_t) { return Latency::after_polls(3); }));
    EXPECT_EQ(at_once, run([](uint64_t test) { return random_latency(8, test); }));
}

TEST_P(Invariants, TheReportAgreesWithACountFromOutside)
{
    ScriptedDevice scripted(script());
    std::vector<uint32_t> triangles(tree_.items().size());
    for (size_t i = 0; i < triangles.size(); ++i) {
        triangles[tree_.items()[i].value] = tree_.item_bounds()[i].triangles;
    }
    CountingDevice device(scripted, {.triangles_by_item = triangles});
    const auto culler = make();
    for (frame_ = 0; frame_ < kFrames; ++frame_) {
        FrameCounters told = culler->cull(test::rough_walk(frame_), device).counters;
        const FrameCounters& seen = device.frame();
        told.nodes_visited = 0; // only the algorithm knows these two
        told.cells_asked = 0;
        for_each_counter(told, [&](const char* name, uint64_t value) {
            for_each_counter(seen, [&](const char* other, uint64_t expected) {
                if (std::string_view{name} == other) {
                    ASSERT_EQ(value, expected) << name << " in frame " << frame_;
                }
            });
        });
    }
}

TEST_P(QueryInvariants, LostAnswersOnlyMakeMoreVisible)
{
    DeviceScript lossy = script();
    lossy.latency = [](uint64_t test) { return test % 3 == 0 ? Latency::lost() : Latency{}; };
    ScriptedDevice scripted(lossy);
    ScriptedDevice reliable(script());
    const auto culler = make();
    uint64_t lost = 0;
    for (frame_ = 0; frame_ < kFrames; ++frame_) {
        const View view = test::rough_walk(frame_);
        lost += culler->cull(view, scripted).counters.lost_answers;
        const std::set<ItemId> in_image(culler->drawn_items().begin(), culler->drawn_items().end());
        for (size_t i = 0; i < tree_.items().size(); ++i) {
            const ItemId item = tree_.items()[i];
            if (test::item_visible(9, frame_, item, 0.2f) &&
                view.frustum().classify(tree_.item_bounds()[i].box) != Containment::outside) {
                ASSERT_TRUE(in_image.contains(item));
            }
        }
    }
    EXPECT_GT(lost, 0u);
}

TEST_P(Invariants, ADeviceWithoutAnswersInTheSameFrameDrawsEverything)
{
    DeviceScript slow = script();
    slow.caps.same_frame_results = false;
    slow.caps.read_depth = false;
    ScriptedDevice device(slow);
    const auto culler = make();
    for (frame_ = 0; frame_ < 4; ++frame_) {
        const View view = test::rough_walk(frame_);
        culler->cull(view, device);
        size_t in_frustum = 0;
        for (const ItemBounds& item : tree_.item_bounds()) {
            in_frustum += view.frustum().classify(item.box) != Containment::outside ? 1 : 0;
        }
        EXPECT_EQ(culler->drawn_items().size(), in_frustum);
    }
}

TEST_P(Invariants, OddHierarchiesAreHarmless)
{
    std::vector<ItemBounds> odd = test::random_boxes(40, 5);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    odd[3].box.min.x = nan;
    odd[4].box = Aabb::everything();
    odd[5].box = Aabb::empty();
    odd[6].box.max = odd[6].box.min; // a point
    odd[7].box.max.y = odd[7].box.min.y;
    for (const std::vector<ItemBounds>& items :
         {odd, std::vector<ItemBounds>{odd[4]}, std::vector<ItemBounds>{odd[5]},
          std::vector<ItemBounds>{}}) {
        const Hierarchy tree = kind_.build(items, 300);
        DeviceScript none_visible{.boxes = visible_subjects({})};
        none_visible.caps.draw_and_query = true;
        ScriptedDevice scripted(none_visible);
        std::vector<std::string> violations;
        ValidatingDevice device(
            scripted, {.on_violation = [&](std::string_view rule, std::string_view text) {
                violations.push_back(std::string{rule} + " " + std::string{text});
            }});
        const auto culler =
            std::move(make_culler(GetParam().algorithm, tree, GetParam().options).value());
        for (uint64_t frame = 0; frame < 3; ++frame) {
            culler->cull(test::rough_walk(frame), device);
        }
        EXPECT_EQ(violations, std::vector<std::string>{});
        // Unknown and unbounded boxes are always drawn.
        const std::set<ItemId> drawn(culler->drawn_items().begin(), culler->drawn_items().end());
        if (items.size() == odd.size()) {
            EXPECT_TRUE(drawn.contains(ItemId{3u}));
            EXPECT_TRUE(drawn.contains(ItemId{4u}));
            EXPECT_FALSE(drawn.contains(ItemId{5u}));
        }
    }
}

TEST_P(Invariants, ADegenerateViewCullsNothing)
{
    ScriptedDevice device(script(0.0f));
    const auto culler = make();
    culler->cull(View::from_clip(glm::mat4{0.0f}, {64, 64}), device);
    EXPECT_EQ(culler->drawn_items().size(), tree_.items().size());
}

TEST_P(Invariants, AResetForgetsEverything)
{
    ScriptedDevice device(script());
    const auto culler = make();
    std::vector<std::string> first_frames;
    for (int run = 0; run < 2; ++run) {
        device.clear_trace();
        frame_ = 0;
        culler->cull(test::rough_walk(0), device);
        std::string text = device.trace_text();
        text = text.substr(text.find('\n') + 1);
        while (text.starts_with("poll ")) { // of abandoned tests
            text = text.substr(text.find('\n') + 1);
        }
        first_frames.push_back(text);
        for (frame_ = 1; frame_ < 9; ++frame_) {
            culler->cull(test::rough_walk(frame_), device);
        }
        culler->reset();
    }
    EXPECT_EQ(first_frames[0], first_frames[1]);
}

// A new algorithm without a line in invariant_cases.h would be free to break them.
TEST(InvariantsCases, HoldEveryExactAlgorithmThatTestsBoxes)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.needs.queries && info.exact && !info.needs.visible_set) {
            EXPECT_TRUE(std::ranges::any_of(cases(), [&](const Case& c) {
                return c.algorithm == info.name;
            })) << info.name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Cull, Invariants, ::testing::ValuesIn(cases_on_every_hierarchy()),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Cull, LatencyInvariants,
                         ::testing::ValuesIn(cases_that_wait_for_every_answer()), name_of);
INSTANTIATE_TEST_SUITE_P(Cull, QueryInvariants, ::testing::ValuesIn(cases_with_queries()), name_of);

} // namespace
} // namespace occlude
