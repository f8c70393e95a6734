// The conformance suite finds defects: devices that break one rule each are reported by that rule.
#include <occlude/conformance/conformance.h>
#include <occlude/core/ticket_table.h>
#include <occlude/device/forwarding_device.h>

#include "conformance/cpu_host.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

namespace occlude {
namespace {

using conformance::check_device;
using test::CpuHost;

/// Passes every call on. Each broken device overrides the calls that it breaks.
class Forwarding : public ForwardingDevice {
public:
    explicit Forwarding(QueryDevice& inner)
        : ForwardingDevice(inner)
    {
    }
    void begin_frame(const View& view) override
    {
        view_ = view;
        inner().begin_frame(view);
    }

protected:
    View view_;
};

template <class Broken>
void expect_named(std::string_view rule, const conformance::Options& options = {})
{
    CpuHost host{[](QueryDevice& inner) { return std::make_unique<Broken>(inner); }};
    const conformance::Report report = check_device(host, options);
    const auto is_it = [&](const conformance::Violation& v) { return v.rule == rule; };
    EXPECT_TRUE(std::any_of(report.violations.begin(), report.violations.end(), is_it))
        << "not named: " << rule << '\n'
        << to_string(report);
}

// Reduces tiles to their nearest depth, which would suit bounds for occluders.
class NearestTiles final : public Forwarding {
public:
    using Forwarding::Forwarding;
    bool read_depth_tiles(int tile_px, std::span<float> out) override
    {
        std::fill(out.begin(), out.end(), 0.0f);
        return tile_px > 0;
    }
};

// Draws everything at the end of the frame, as a renderer that sorts across tests would.
class DrawsLate final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void draw(std::span<const ItemId> items, DrawPass pass) override
    {
        late_.emplace_back(std::vector<ItemId>(items.begin(), items.end()), pass);
    }
    void end_frame() override
    {
        for (const auto& [items, pass] : late_) {
            inner().draw(items, pass);
        }
        late_.clear();
        inner().end_frame();
    }

private:
    std::vector<std::pair<std::vector<ItemId>, DrawPass>> late_;
};

TEST(BrokenDevices, TilesThatAreNearerThanTheirPixelsAreNamed)
{
    expect_named<NearestTiles>("read_depth_tiles");
}

TEST(BrokenDevices, ATestThatMissesTheDrawsBeforeItIsUseless)
{
    expect_named<DrawsLate>("useful");
}

// Runs tests when their answers are requested, so that tests see draws that came after them.
class TestsLate final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        uint32_t begin = 0;
        for (size_t i = 0; i < tickets.size(); ++i) {
            const uint32_t end = batch.test_ends[i];
            tickets[i] = tests_.add({{batch.boxes.begin() + begin, batch.boxes.begin() + end}, {}});
            begin = end;
            open_.push_back(tickets[i]);
        }
    }
    void end_frame() override
    {
        for (const Ticket ticket : open_) {
            if (auto* test = tests_.find(ticket)) {
                const uint32_t end = static_cast<uint32_t>(test->boxes.size());
                for (QueryBox& box : test->boxes) {
                    box.world_from_box = nullptr;
                }
                inner().query({test->boxes, std::span{&end, 1}}, std::span{&test->inner, 1});
            }
        }
        open_.clear();
        inner().end_frame();
    }
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override
    {
        const auto* test = tests_.find(ticket);
        if (test == nullptr) {
            return Answer::lost();
        }
        const Answer answer = inner().wait(test->inner);
        tests_.release(ticket);
        return answer;
    }

private:
    struct Test {
        std::vector<QueryBox> boxes;
        Ticket inner;
    };
    TicketTable<Test> tests_;
    std::vector<Ticket> open_;
};

TEST(BrokenDevices, ATestThatSeesLaterDrawsBreaksC2)
{
    expect_named<TestsLate>("C2");
}

// Every n-th answer is 0, whatever the true one is.
class CallsVisibleHidden final : public Forwarding {
public:
    using Forwarding::Forwarding;
    Answer wait(Ticket ticket) override
    {
        const Answer answer = inner().wait(ticket);
        return answer.state == AnswerState::ready && ++count_ % 9 == 0 ? Answer::ready(0) : answer;
    }

private:
    uint64_t count_ = 0;
};

TEST(BrokenDevices, AVisibleBoxThatIsCalledHiddenBreaksC3)
{
    expect_named<CallsVisibleHidden>("C3");
}

// Draws the boxes of a test like geometry, so that they stay in the image.
class TestsWriteDepth final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        inner().query(batch, tickets);
        const bool wall = std::any_of(batch.boxes.begin(), batch.boxes.end(), [](const auto& box) {
            return box.box.extent().x > 100.0f && box.box.max.z > -10.0f;
        });
        if (wall) {
            const ItemId near_wall{1u};
            inner().draw(std::span{&near_wall, 1}, DrawPass::shade);
        }
    }
};

TEST(BrokenDevices, ATestThatWritesDepthBreaksC4)
{
    expect_named<TestsWriteDepth>("C4");
}

// Tests only the first box of each test.
class ForgetsBoxes final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        std::vector<QueryBox> firsts;
        std::vector<uint32_t> ends;
        uint32_t begin = 0;
        for (const uint32_t end : batch.test_ends) {
            firsts.push_back(batch.boxes[begin]);
            ends.push_back(static_cast<uint32_t>(firsts.size()));
            begin = end;
        }
        inner().query({firsts, ends, batch.method}, tickets);
    }
};

TEST(BrokenDevices, ATestOfOneBoxOutOfSeveralBreaksC6)
{
    expect_named<ForgetsBoxes>("C6");
}

class IgnoresTransforms final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        std::vector<QueryBox> boxes(batch.boxes.begin(), batch.boxes.end());
        for (QueryBox& box : boxes) {
            if (box.world_from_box != nullptr) { // somewhere behind the wall
                box = {{{-1.0f, -1.0f, -45.0f}, {1.0f, 1.0f, -44.0f}}, nullptr, box.subject};
            }
        }
        inner().query({boxes, batch.test_ends, batch.method}, tickets);
    }
};

TEST(BrokenDevices, IgnoredTransformsBreakC6)
{
    expect_named<IgnoresTransforms>("C6");
}

// Gives the last answer again for a spent ticket, as a recycled query object does.
class RemembersSpentTickets final : public Forwarding {
public:
    using Forwarding::Forwarding;
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override
    {
        const Answer answer = inner().wait(ticket);
        if (answer.state == AnswerState::ready) {
            last_ = answer;
            return answer;
        }
        return ticket.valid() ? last_ : answer;
    }

private:
    Answer last_;
};

TEST(BrokenDevices, ASpentTicketThatAnswersAgainBreaksC7)
{
    expect_named<RemembersSpentTickets>("C7");
}

class LostReadsAsHidden final : public Forwarding {
public:
    using Forwarding::Forwarding;
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override
    {
        Answer answer = inner().wait(ticket);
        if (answer.state == AnswerState::lost) {
            answer.samples = 0;
        }
        return answer;
    }
};

TEST(BrokenDevices, ALostAnswerThatReadsAsHiddenBreaksC8)
{
    expect_named<LostReadsAsHidden>("C8");
}

class WaitsWithoutPatience final : public Forwarding {
public:
    using Forwarding::Forwarding;
    Answer wait(Ticket ticket) override
    {
        return ++count_ % 5 == 0 ? Answer::pending() : inner().wait(ticket);
    }

private:
    uint64_t count_ = 0;
};

TEST(BrokenDevices, AWaitThatAnswersPendingBreaksC9)
{
    expect_named<WaitsWithoutPatience>("C9");
}

// Reports fewer tickets than it gives out.
class GivesOutTooManyTickets final : public Forwarding {
public:
    explicit GivesOutTooManyTickets(QueryDevice& inner)
        : Forwarding(inner)
        , caps_(inner.caps())
    {
        caps_.max_outstanding = 100;
    }
    const DeviceCaps& caps() const override { return caps_; }

private:
    DeviceCaps caps_;
};

TEST(BrokenDevices, ATestBeyondTheLimitThatIsAnsweredBreaksC11)
{
    expect_named<GivesOutTooManyTickets>("C11");
}

// Forgets all tickets at the start of a frame, and answers for them with 0.
class ForgetsTicketsOfEarlierFrames final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void begin_frame(const View& view) override
    {
        ++frame_;
        inner().begin_frame(view);
    }
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        inner().query(batch, tickets);
        for (const Ticket ticket : tickets) {
            asked_.emplace_back(ticket, frame_);
        }
    }
    Answer wait(Ticket ticket) override
    {
        const Answer answer = inner().wait(ticket);
        const auto asked = std::find_if(asked_.rbegin(), asked_.rend(),
                                        [&](const auto& a) { return a.first == ticket; });
        const bool old = asked != asked_.rend() && asked->second < frame_;
        return old && answer.state == AnswerState::ready ? Answer::ready(0) : answer;
    }

private:
    uint64_t frame_ = 0;
    std::deque<std::pair<Ticket, uint64_t>> asked_;
};

TEST(BrokenDevices, TicketsThatDieWithTheirFrameBreakC12)
{
    expect_named<ForgetsTicketsOfEarlierFrames>("C12");
}

class ReadsDepthUpsideDown final : public Forwarding {
public:
    using Forwarding::Forwarding;
    bool read_depth(const PixelRect& rect, std::span<float> out) override
    {
        const bool done = inner().read_depth(rect, out);
        for (int y = 0; done && y < rect.height / 2; ++y) {
            const auto row = [&](int at) { return out.begin() + at * rect.width; };
            std::swap_ranges(row(y), row(y) + rect.width, row(rect.height - 1 - y));
        }
        return done;
    }
};

TEST(BrokenDevices, DepthFromTheTopRowDownBreaksReadDepth)
{
    expect_named<ReadsDepthUpsideDown>("read_depth");
}

class DepthOnlyDrawsNothing final : public Forwarding {
public:
    using Forwarding::Forwarding;
    void draw(std::span<const ItemId> items, DrawPass pass) override
    {
        if (pass != DrawPass::depth_only) {
            inner().draw(items, pass);
        }
    }
};

TEST(BrokenDevices, ADepthPassThatWritesNoDepthIsUseless)
{
    expect_named<DepthOnlyDrawsNothing>("useful");
}

class CallsEverythingVisible final : public Forwarding {
public:
    using Forwarding::Forwarding;
    Answer wait(Ticket ticket) override
    {
        const Answer answer = inner().wait(ticket);
        return answer.state == AnswerState::ready ? Answer::ready(1) : answer;
    }
};

TEST(BrokenDevices, ADeviceThatFindsNothingHiddenConformsButIsUseless)
{
    expect_named<CallsEverythingVisible>("useful");
    CpuHost host{
        [](QueryDevice& inner) { return std::make_unique<CallsEverythingVisible>(inner); }};
    EXPECT_TRUE(check_device(host, {.must_find_hidden = false}).passed());
}

} // namespace
} // namespace occlude
