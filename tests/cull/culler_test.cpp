// What Culler guarantees for every algorithm: with hierarchies that stay in place, frames that end
// in the middle, and tickets whose answers nobody needs.
#include <occlude/cull/culler.h>

#include "support/box_scene.h"
#include "support/trees.h"

#include <occlude/core/assert.h>
#include <occlude/cull/adaptive.h>
#include <occlude/cull/batch_and_wait.h>
#include <occlude/cull/chc.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/lazy_grid.h>
#include <occlude/cull/next_frame.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/parts/ticket_ledger.h>
#include <occlude/cull/prioritized.h>
#include <occlude/cull/registry.h>
#include <occlude/cull/statistical.h>
#include <occlude/cull/stop_and_wait.h>
#include <occlude/cull/two_level.h>
#include <occlude/cull/two_phase.h>
#include <occlude/cull/uniform_grid.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <type_traits>

namespace occlude {
namespace {

// --- hierarchies ---------------------------------------------------------------------------------

template <class... Cullers>
constexpr bool kNoneTakesATemporary = (... && (std::is_constructible_v<Cullers, const Hierarchy&> &&
                                               !std::is_constructible_v<Cullers, Hierarchy> &&
                                               !std::is_constructible_v<Cullers, const Hierarchy>));

static_assert(kNoneTakesATemporary<Adaptive, BatchAndWait, Chc, ChcPlusPlus, FrustumCuller, Ideal,
                                   LazyGrid, NextFrame, Opt, Prioritized, Statistical, StopAndWait,
                                   TwoLevel, TwoPhase, UniformGrid>);
static_assert(!std::is_invocable_v<decltype(make_culler), const char*, Hierarchy,
                                   std::span<const OptionValue>, SecondsClock>);

#if !OCCLUDE_ASSERTS // a caller's bug: builds with assertions stop
TEST(Culler, OverAHierarchyThatWasMovedAwayDrawsNothingUntilThereIsAnother)
{
    Hierarchy tree = test::row_tree(1);
    FrustumCuller culler(tree);
    ScriptedDevice device;
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 2u);
    Hierarchy elsewhere = std::move(tree);
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 0u);
    tree = test::row_tree(2);
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 4u);
    EXPECT_EQ(elsewhere.items().size(), 2u);
}
#endif

TEST(Culler, SaysThatItsHierarchyWasMovedAway)
{
    Hierarchy tree = test::row_tree(1);
    EXPECT_FALSE(tree.moved_from());
    const Hierarchy elsewhere = std::move(tree);
    EXPECT_TRUE(tree.moved_from());
    EXPECT_TRUE(tree.empty());
    EXPECT_FALSE(elsewhere.moved_from());
#if OCCLUDE_ASSERTS
    FrustumCuller culler(tree);
    ScriptedDevice device;
    const AssertHandler before =
        set_assert_handler([](std::string_view, std::string_view message, std::string_view, int) {
            throw std::logic_error{std::string{message}};
        });
    std::string said;
    try {
        culler.cull(test::look_ahead(), device);
    } catch (const std::logic_error& error) {
        said = error.what();
    }
    set_assert_handler(before);
    EXPECT_NE(said.find("moved away"), std::string::npos) << said;
#endif
}

// --- frames that end in the middle ---------------------------------------------------------------

/// Throws at one call of draw() or query(), the first being 1.
class ThrowingDevice final : public QueryDevice {
public:
    explicit ThrowingDevice(QueryDevice& inner)
        : inner_(inner)
    {
    }

    void throw_at(uint32_t call) { left_ = call; }

    const DeviceCaps& caps() const override { return inner_.caps(); }
    void begin_frame(const View& view) override { inner_.begin_frame(view); }
    void draw(std::span<const ItemId> items, DrawPass pass) override
    {
        count();
        inner_.draw(items, pass);
    }
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        count();
        inner_.query(batch, tickets);
    }
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override
    {
        count();
        return inner_.draw_and_query(items, pass);
    }
    void flush() override { inner_.flush(); }
    Answer poll(Ticket ticket) override { return inner_.poll(ticket); }
    Answer wait(Ticket ticket) override { return inner_.wait(ticket); }
    bool read_depth(const PixelRect& rect, std::span<float> out) override
    {
        return inner_.read_depth(rect, out);
    }
    void end_frame() override { inner_.end_frame(); }

private:
    void count()
    {
        if (left_ > 0 && --left_ == 0) {
            throw std::runtime_error{"the engine's draw callback threw"};
        }
    }

    QueryDevice& inner_;
    uint32_t left_ = 0;
};

enum class Afterwards { nothing, reset, smaller_tree };

class DrawThatThrows : public testing::TestWithParam<Afterwards> {};

// Every exact algorithm, with an exception at each of the first draws and tests of the third frame.
// The next frame shows the full image, and the device contract holds throughout.
TEST_P(DrawThatThrows, LeavesTheNextFrameRight)
{
    const std::vector<ItemBounds> many = test::random_boxes(150, 8, 24.0f, 9.0f);
    const std::vector<ItemBounds> few(many.begin(), many.begin() + 12);
    const View view = test::look({0.0f, 0.0f, 40.0f}, {0.0f, 0.0f, 0.0f});
    const test::BoxCpuScene scene(many);
    for (const AlgorithmInfo& info : algorithms()) {
        if (!info.exact || info.needs.visible_set) {
            continue;
        }
        uint32_t thrown = 0;
        for (uint32_t call = 1; call <= 40; call += call < 8 ? 1 : 4) {
            Hierarchy tree = build_bvh(many, {.leaf_triangles = 300});
            CpuDevice cpu(scene);
            DelayingDevice late(cpu, {.seed = call, .max_polls = 4});
            ValidatingDevice valid(late);
            ThrowingDevice device(valid);
            const auto culler = std::move(make_culler(info.name, tree).value());
            culler->cull(view, device);
            culler->cull(view, device);
            device.throw_at(call);
            try {
                culler->cull(view, device);
                break; // a frame has fewer calls
            } catch (const std::runtime_error&) {
                ++thrown;
            }
            device.throw_at(0);
            if (GetParam() == Afterwards::reset) {
                culler->reset();
            } else if (GetParam() == Afterwards::smaller_tree) {
                tree = build_bvh(few, {.leaf_triangles = 300});
            }
            for (int frame = 0; frame < 2; ++frame) {
                CpuDevice reference(scene);
                FrustumCuller all(tree);
                all.cull(view, reference);
                culler->cull(view, device);
                ASSERT_TRUE(std::ranges::equal(cpu.depth(), reference.depth()))
                    << info.name << " after a throw at call " << call;
            }
        }
        EXPECT_GT(thrown, 0u) << info.name;
    }
}

INSTANTIATE_TEST_SUITE_P(Culler, DrawThatThrows,
                         testing::Values(Afterwards::nothing, Afterwards::reset,
                                         Afterwards::smaller_tree));

// --- tickets -------------------------------------------------------------------------------------

TEST(Culler, AResetSpendsTheTicketsOfAlgorithmsThatKeepThem)
{
    const Hierarchy tree = test::row_tree(3);
    NextFrame culler(tree, {.read = NextFrameOptions::Read::poll, .max_latency = 100});
    ScriptedDevice scripted(
        {.latency = [](uint64_t) { return Latency{.polls = 30}; },
         .caps = {.name = "scripted", .max_outstanding = 40, .methods = {TestCost{}}}});
    ValidatingDevice device(scripted); // asserts that no more than 40 tests are unspent
    for (int frame = 0; frame < 60; ++frame) {
        const FrameReport report = culler.cull(test::look_ahead(), device);
        EXPECT_EQ(report.counters.lost_answers, 0u) << frame;
        culler.reset();
    }
}

TEST(TicketLedger, KnowsTheTicketsThatAreUnspent)
{
    TicketLedger ledger;
    const std::vector<Ticket> tickets{{7, 1}, {8, 1}, {3, 2}};
    ledger.issued(tickets);
    EXPECT_EQ(ledger.unspent().size(), 3u);
    ledger.answered(tickets[1]);
    EXPECT_TRUE(std::ranges::equal(ledger.unspent(), std::vector<Ticket>{{7, 1}, {3, 2}}));
    ledger.abandon(tickets[0]);
    EXPECT_TRUE(std::ranges::equal(ledger.unspent(), std::vector<Ticket>{{3, 2}}));
    ledger.answered(tickets[2]);
    EXPECT_TRUE(ledger.unspent().empty());
}

// --- what oracles hear ---------------------------------------------------------------------------

TEST(Opt, DrawsEverythingIfTheTreeIsAnotherThanTheRecordedOne)
{
    Hierarchy tree = test::row_tree(3);
    Opt culler(tree);
    ScriptedDevice device;
    culler.record(test::look_ahead(), device, {});
    tree = test::row_tree(1);
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 2u);
}

TEST(Ideal, DrawsEverythingIfTheTreeIsAnotherThanTheRecordedOne)
{
    Hierarchy tree = test::row_tree(3);
    Ideal culler(tree);
    ScriptedDevice device;
    const std::vector<ItemId> owners{ItemId{7u}};
    culler.record(test::look_ahead(), device, owners);
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 1u);
    tree = test::row_tree(1);
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 2u);
}

#if !OCCLUDE_ASSERTS
TEST(Ideal, IgnoresAnOwnerThatIsNoItemOfTheTree)
{
    const Hierarchy tree = test::row_tree(2);
    Ideal culler(tree);
    ScriptedDevice device;
    const std::vector<ItemId> owners{ItemId{1u}, ItemId{4'000'000u}, ItemId{}};
    culler.record(test::look_ahead(), device, owners);
    culler.cull(test::look_ahead(), device);
    EXPECT_TRUE(std::ranges::equal(culler.drawn_items(), std::vector<ItemId>{ItemId{1u}}));
}
#endif

// --- messages ------------------------------------------------------------------------------------

// The names of the messages of `culler` in two frames of `view` on `device`.
std::string names_of_messages(Culler& culler, QueryDevice& device, const View& view)
{
    std::string names;
    culler.set_message_handler([&](const Message& message) {
        names += std::string(message.name) + " ";
        EXPECT_FALSE(message.text.empty());
    });
    culler.cull(view, device);
    culler.cull(view, device);
    return names;
}

TEST(Culler, TellsItsHostOfAClockThatStandsStill)
{
    const Hierarchy tree = test::row_tree(4);
    ScriptedDevice device;
    device.script().caps.read_depth = true;
    device.script().caps.us_per_triangle = 100.0f;
    device.script().depth = [](const PixelRect&, std::span<float> out) {
        std::fill(out.begin(), out.end(), 0.992f);
        return true;
    };
    Adaptive culler(tree, {.method = AdaptiveOptions::Method::pyramid}, [] { return 7.0; });
    std::string names;
    culler.set_message_handler(
        [&](const Message& message) { names += std::string(message.name) + " "; });
    for (int frame = 0; frame < 8; ++frame) {
        culler.cull(test::look_ahead(), device);
    }
    EXPECT_EQ(names, "culler.useless_clock ");
}

TEST(Culler, TellsItsHostOnceOfFaultsOfTheDeviceAndTheView)
{
    const Hierarchy tree = test::row_tree(2);
    ScriptedDevice good;
    ScriptedDevice lossy({.latency = [](uint64_t) { return Latency::lost(); }});
    ScriptedDevice blind({.depth = [](const PixelRect&, std::span<float>) { return false; }});
    blind.script().caps.read_depth = true;
    const View view = test::look_ahead();
    StopAndWait asks(tree);
    EXPECT_EQ(names_of_messages(asks, good, view), "");
    EXPECT_EQ(names_of_messages(asks, lossy, view), "culler.lost_answers ");
    TwoPhase reads(tree);
    EXPECT_EQ(names_of_messages(reads, blind, view), "culler.depth_read ");
    EXPECT_EQ(names_of_messages(asks, good, View::from_clip(glm::mat4{1.0f}, {0, 0})),
              "culler.empty_view ");
}

} // namespace
} // namespace occlude
