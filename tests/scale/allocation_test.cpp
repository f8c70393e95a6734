// What the library takes of memory, and how often it asks for some: this program replaces the global
// operator new and counts.
#include "support/walks.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/bvh_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<size_t> allocations{0};

} // namespace

void* operator new(size_t size)
{
    ++allocations;
    if (void* memory = std::malloc(size > 0 ? size : 1)) {
        return memory;
    }
    throw std::bad_alloc{};
}
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, size_t) noexcept
{
    std::free(memory);
}

namespace occlude {
namespace {

// Answers by what is visible of a made-up third of the nodes; allocates nothing after its first frames.
class QuietDevice final : public QueryDevice {
public:
    QuietDevice()
    {
        caps_.name = "quiet";
        caps_.read_depth = true;
        caps_.draw_and_query = true;
        caps_.max_outstanding = ~0u;
        answers_.resize(1 << 16);
    }
    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View&) override {}
    void draw(std::span<const ItemId>, DrawPass) override {}
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        for (size_t i = 0; i < tickets.size(); ++i) {
            const QueryBox& first = batch.boxes[i == 0 ? 0 : batch.test_ends[i - 1]];
            tickets[i] = answer(hash64(first.subject.value, std::uint64_t{7}) % 3 == 0);
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
    Ticket answer(bool visible)
    {
        next_ = (next_ + 1) % static_cast<uint32_t>(answers_.size());
        answers_[next_] = visible ? 1 : 0;
        return Ticket{next_, 1};
    }

    DeviceCaps caps_;
    std::vector<uint8_t> answers_;
    uint32_t next_ = 0;
};

class Allocations : public ::testing::TestWithParam<std::string> {};

TEST_P(Allocations, ThereAreNoneInAFrameAfterTheFirstRounds)
{
    constexpr uint64_t kRound = 16; // of the walk
    const Hierarchy tree = test::random_bvh(3000, 21);
    auto culler = make_culler(GetParam(), tree);
    ASSERT_TRUE(culler);
    QuietDevice device;
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
