// How much memory the library takes, and how often it allocates: this program replaces the global
// operator new and counts.
#include "support/walks.h"

#include <occlude/core/assert.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/scene/scene.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace {

std::atomic<size_t> allocations{0};
std::atomic<size_t> live_bytes{0}; // as the allocator rounds them

} // namespace

// Not inlined: compilers would see malloc() meet delete, and warn.
__attribute__((noinline)) void* operator new(size_t size)
{
    ++allocations;
    if (void* memory = std::malloc(size > 0 ? size : 1)) {
        live_bytes += malloc_usable_size(memory);
        return memory;
    }
    throw std::bad_alloc{};
}
// Otherwise AddressSanitizer answers with memory of its own, which delete below would hand to free.
__attribute__((noinline)) void* operator new(size_t size, const std::nothrow_t&) noexcept
{
    ++allocations;
    void* memory = std::malloc(size > 0 ? size : 1);
    live_bytes += memory != nullptr ? malloc_usable_size(memory) : 0;
    return memory;
}
// GCC 12 sees malloc and operator delete, and not that this one is its counterpart.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void operator delete(void* memory) noexcept
{
    live_bytes -= memory != nullptr ? malloc_usable_size(memory) : 0;
    std::free(memory);
}
void operator delete(void* memory, size_t) noexcept
{
    operator delete(memory);
}

namespace occlude {
namespace {

constexpr uint64_t kRound = 16; // frames of the walk, which goes round and round

// A test device that allocates nothing. Inner nodes are visible, and a third of the leaves, which
// changes every few frames of the walk.
class QuietDevice final : public QueryDevice {
public:
    explicit QuietDevice(const Hierarchy& hierarchy)
        : hierarchy_(hierarchy)
    {
        caps_.name = "quiet";
        caps_.read_depth = true;
        caps_.draw_and_query = true;
        caps_.max_outstanding = ~0u;
        answers_.resize(1 << 16);
    }
    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View&) override { ++frame_; }
    void draw(std::span<const ItemId>, DrawPass) override {}
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        for (size_t i = 0; i < tickets.size(); ++i) {
            bool visible = false;
            for (uint32_t box = i == 0 ? 0 : batch.test_ends[i - 1]; box < batch.test_ends[i];
                 ++box) {
                visible = visible || node_visible(batch.boxes[box].subject);
            }
            tickets[i] = answer(visible);
        }
    }
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass) override
    {
        return answer(!items.empty() && items[0].value % 3 == 0);
    }
    void flush() override {}
    Answer poll(Ticket ticket) override
    {
        return Answer::ready(answers_[ticket.index] != 0 ? 10 : 0);
    }
    Answer wait(Ticket ticket) override { return poll(ticket); }
    bool read_depth(const PixelRect&, std::span<float> out) override
    {
        std::fill(out.begin(), out.end(), 0.995f);
        return true;
    }
    void end_frame() override {}

private:
    bool node_visible(NodeId node) const
    {
        return (node.valid() && !hierarchy_.is_leaf(node)) ||
               hash64(node.value, frame_ % kRound / 4) % 3 == 0;
    }
    Ticket answer(bool visible)
    {
        next_ = (next_ + 1) % static_cast<uint32_t>(answers_.size());
        answers_[next_] = visible ? 1 : 0;
        return Ticket{next_, 1};
    }

    const Hierarchy& hierarchy_;
    DeviceCaps caps_;
    uint64_t frame_ = 0;
    std::vector<uint8_t> answers_;
    uint32_t next_ = 0;
};

class Allocations : public ::testing::TestWithParam<std::string> {};

TEST_P(Allocations, ThereAreNoneInAFrameAfterTheFirstRounds)
{
    const Hierarchy tree = test::random_bvh(3000, 21);
    auto culler = make_culler(GetParam(), tree);
    ASSERT_TRUE(culler);
    QuietDevice device(tree);
    std::vector<View> walk;
    for (uint64_t i = 0; i < kRound; ++i) {
        walk.push_back(test::rough_walk(i));
    }
    for (uint64_t frame = 0; frame < 16 * kRound; ++frame) {
        (*culler)->cull(walk[frame % kRound], device);
    }
    const size_t before = allocations;
    size_t drawn = 0;
    for (uint64_t frame = 0; frame < 2 * kRound; ++frame) {
        drawn += (*culler)->cull(walk[frame % kRound], device).counters.items_drawn;
    }
    EXPECT_EQ(allocations - before, 0u);
    EXPECT_GT(drawn, 0u);
}

// All memory: nodes, items, bounds, and the state and draw lists of two cullers, after frames in
// which they saw every corner of the scene.
size_t bytes_per_object(const BvhOptions& options, const char* algorithm)
{
    constexpr uint32_t kObjects = 200000;
    std::vector<ItemBounds> boxes = test::random_boxes(kObjects, 4, 400.0f, 2.0f);
    for (ItemBounds& box : boxes) {
        box.triangles = 12;
    }
    std::vector<View> walk;
    for (uint64_t i = 0; i < kRound; ++i) {
        walk.push_back(test::rough_walk(i));
    }
    const size_t before = live_bytes;
    const Hierarchy tree = build_bvh(boxes, options);
    const size_t of_tree = live_bytes - before;
    EXPECT_LT(of_tree, tree.memory_bytes() + 65536);
    EXPECT_GE(of_tree, tree.memory_bytes());
    QuietDevice device(tree);
    auto culler = make_culler(algorithm, tree);
    for (uint64_t frame = 0; frame < 2 * kRound; ++frame) {
        (*culler)->cull(walk[frame % walk.size()], device);
    }
    const size_t result = (live_bytes - before) / kObjects;
    ::testing::Test::RecordProperty(algorithm, static_cast<int>(result));
    return result;
}

TEST(Memory, AnObjectTakesAtMost96BytesByDefault)
{
    for (const char* algorithm : {"frustum", "chc", "chc_plus_plus", "two_phase", "adaptive"}) {
        EXPECT_LE(bytes_per_object({}, algorithm), 96u) << algorithm;
    }
}

TEST(Memory, AnObjectWithALeafOfItsOwnTakesTwice)
{
    EXPECT_LE(bytes_per_object({.max_leaf_items = 1}, "chc_plus_plus"), 192u);
}

// The same with a shape for every item, each of which moves in every frame.
TEST(Shapes, AllocateNothingInAFrameAfterTheFirstRounds)
{
    const std::vector<ItemBounds> boxes = test::random_boxes(1000, 21);
    const auto halves = std::make_shared<const Shape>(
        Shape{{glm::vec3{-1.0f}, {1.0f, 1.0f, 0.0f}}, {{-1.0f, -1.0f, 0.0f}, glm::vec3{1.0f}}});
    Scene scene;
    std::vector<ObjectId> objects;
    for (const ItemBounds& box : boxes) {
        const ItemDesc item{{glm::vec3{-1.0f}, glm::vec3{1.0f}}, 3000, ItemFlags::none, halves};
        objects.push_back(scene.add(glm::translate(glm::mat4{1.0f}, box.box.min), {&item, 1}));
    }
    Hierarchy tree = build_bvh(scene.item_bounds(), {.leaf_triangles = 300});
    tree.set_shapes(&scene.shapes());
    for (const char* name : {"two_phase", "adaptive"}) {
        auto culler = make_culler(name, tree);
        QuietDevice device(tree);
        size_t before = 0;
        for (uint64_t frame = 0; frame < 8 * kRound; ++frame) {
            before = frame == 6 * kRound ? size_t{allocations} : before;
            const float up = frame % 2 == 0 ? 0.1f : 0.0f;
            for (size_t i = 0; i < objects.size(); ++i) {
                scene.move(
                    objects[i],
                    glm::translate(glm::mat4{1.0f}, boxes[i].box.min + glm::vec3{0.0f, up, 0.0f}));
            }
            const size_t before_refit = allocations;
            tree.refit(scene.item_bounds());
            before += OCCLUDE_ASSERTS ? allocations - before_refit : 0; // validation allocates
            (*culler)->cull(test::rough_walk(frame % kRound), device);
        }
        EXPECT_EQ(allocations - before, 0u) << name;
    }
}

// Objects without shapes need no memory for them, and many objects share one shape.
TEST(Memory, AShapeIsSharedAndCostsItsPlace)
{
    constexpr uint32_t kObjects = 20000;
    const auto bytes_of_scene = [](const std::shared_ptr<const Shape>& shape) {
        const size_t before = live_bytes;
        Scene scene;
        for (uint32_t i = 0; i < kObjects; ++i) {
            const ItemDesc item{{glm::vec3{-1.0f}, glm::vec3{1.0f}}, 3000, ItemFlags::none, shape};
            scene.add(glm::mat4{1.0f}, {&item, 1});
        }
        EXPECT_EQ(scene.shapes().empty(), shape == nullptr);
        return live_bytes - before;
    };
    const size_t plain = bytes_of_scene(nullptr);
    const auto shape =
        std::make_shared<const Shape>(Shape(16, Aabb{glm::vec3{0.0f}, glm::vec3{1.0f}}));
    const size_t shaped = bytes_of_scene(shape);
    // 4 of the index and 80 of the place, and what growing vectors hold in reserve.
    EXPECT_LT((shaped - plain) / kObjects, 2u * 128u);
    EXPECT_EQ(shape.use_count(), 1);
    EXPECT_EQ(ItemShapes{}.find(ItemId{0u}), nullptr);
}

std::vector<std::string> names()
{
    std::vector<std::string> names;
    for (const AlgorithmInfo& info : algorithms()) {
        if (!info.needs.visible_set) { // yardsticks
            names.push_back(info.name);
        }
    }
    return names;
}

INSTANTIATE_TEST_SUITE_P(Scale, Allocations, ::testing::ValuesIn(names()),
                         [](const auto& param) { return param.param; });

} // namespace
} // namespace occlude
