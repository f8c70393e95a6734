#include <occlude/device/scripted_device.h>

#include <occlude/core/assert.h>

#include <algorithm>

namespace occlude {

namespace {

constexpr uint64_t kSamplesPerItem = 1000;

template <class Ids>
std::string joined(const Ids& ids)
{
    std::string text;
    for (const auto id : ids) {
        text += text.empty() ? "" : " ";
        text += id.valid() ? std::to_string(id.value) : "?";
    }
    return text;
}

std::string with_space(std::string text)
{
    return text.empty() ? text : " " + text;
}

const char* prefix(DrawPass pass)
{
    switch (pass) {
    case DrawPass::depth_only:
        return " depth_only";
    case DrawPass::shade_equal:
        return " shade_equal";
    case DrawPass::shade:
        break;
    }
    return "";
}

const char* prefix(TestMethod method)
{
    switch (method) {
    case TestMethod::queries:
        return " queries";
    case TestMethod::raster:
        return " raster";
    case TestMethod::pyramid:
        return " pyramid";
    case TestMethod::automatic:
        break;
    }
    return "";
}

std::string tests_text(const ScriptedDevice::Event& event)
{
    std::string text;
    uint32_t begin = 0;
    for (const uint32_t end : event.test_ends) {
        text += " [";
        text += joined(std::span{event.subjects}.subspan(begin, end - begin));
        text += "]";
        begin = end;
    }
    return text;
}

std::string test_name(const ScriptedDevice::Event& event)
{
    if (!event.items.empty()) {
        return "item " + joined(event.items);
    }
    return event.subjects.empty() ? std::string("?") : joined(event.subjects);
}

std::string answer_text(const ScriptedDevice::Event& event)
{
    const std::string name = test_name(event);
    switch (event.answer.state) {
    case AnswerState::pending:
        return name + " pending";
    case AnswerState::ready:
        return name + " -> " + std::to_string(event.answer.samples);
    case AnswerState::lost:
        break;
    }
    return name + " -> lost";
}

} // namespace

std::string to_string(const ScriptedDevice::Event& event)
{
    using Verb = ScriptedDevice::Verb;
    switch (event.verb) {
    case Verb::begin_frame:
        return "frame " + std::to_string(event.frame);
    case Verb::draw:
        return std::string("draw") + prefix(event.pass) + with_space(joined(event.items));
    case Verb::query:
        return std::string("query") + prefix(event.method) + tests_text(event);
    case Verb::draw_and_query:
        return std::string("draw_and_query") + prefix(event.pass) + with_space(joined(event.items));
    case Verb::flush:
        return "flush";
    case Verb::poll:
        return "poll " + answer_text(event);
    case Verb::wait:
        return "wait " + answer_text(event);
    case Verb::read_depth_tiles:
        return "read_depth_tiles " + std::to_string(event.tile_px);
    case Verb::read_depth:
        return "read_depth " + std::to_string(event.rect.x) + " " + std::to_string(event.rect.y) +
               " " + std::to_string(event.rect.width) + "x" + std::to_string(event.rect.height);
    case Verb::end_frame:
        break;
    }
    return "end";
}

BoxScript visible_subjects(std::vector<NodeId> visible, uint64_t samples)
{
    std::sort(visible.begin(), visible.end());
    return [visible = std::move(visible), samples](std::span<const QueryBox> boxes) -> uint64_t {
        const bool any = std::any_of(boxes.begin(), boxes.end(), [&](const QueryBox& box) {
            return std::binary_search(visible.begin(), visible.end(), box.subject);
        });
        return any ? samples : 0;
    };
}

ScriptedDevice::Event& ScriptedDevice::record(Verb verb)
{
    Event& event = trace_.emplace_back();
    event.frame = frames_begun_ == 0 ? 0 : frames_begun_ - 1;
    event.verb = verb;
    return event;
}

Ticket ScriptedDevice::issue(Test test)
{
    const Latency latency = script_.latency ? script_.latency(tests_issued_) : Latency{};
    ++tests_issued_;
    if (tests_.size() >= script_.caps.max_outstanding) {
        return Ticket{};
    }
    test.ready_at_poll = polls_ + latency.polls;
    test.ready_at_frame = frames_ended_ + latency.frames;
    if (!script_.caps.same_frame_results) {
        test.ready_at_frame = std::max(test.ready_at_frame, frames_ended_ + 1);
    }
    test.issued_in_frame = frames_ended_;
    test.fate = latency.fate;
    return tests_.add(std::move(test));
}

void ScriptedDevice::begin_frame(const View&)
{
    ++frames_begun_;
    drawn_.clear();
    record(Verb::begin_frame);
}

void ScriptedDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    drawn_.insert(drawn_.end(), items.begin(), items.end());
    Event& event = record(Verb::draw);
    event.pass = pass;
    event.items.assign(items.begin(), items.end());
}

void ScriptedDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(), "query needs one ticket per test");
    std::fill(tickets.begin(), tickets.end(), Ticket{});
    uint32_t begin = 0;
    for (size_t i = 0; i < std::min(tickets.size(), batch.test_ends.size()); ++i) {
        const uint32_t end = batch.test_ends[i];
        OCCLUDE_ASSERT(end >= begin && end <= batch.boxes.size(),
                       "the ends of the tests of a batch ascend, up to the number of boxes");
        if (end < begin || end > batch.boxes.size()) {
            continue; // C6 is broken: the ticket stays invalid, so it answers lost
        }
        const auto boxes = batch.boxes.subspan(begin, end - begin);
        begin = end;
        Test test;
        test.samples = script_.boxes ? script_.boxes(boxes) : kSamplesPerItem;
        for (const QueryBox& box : boxes) {
            test.subjects.push_back(box.subject);
        }
        tickets[i] = issue(std::move(test));
    }
    Event& event = record(Verb::query);
    event.method = batch.method;
    for (const QueryBox& box : batch.boxes) {
        event.subjects.push_back(box.subject);
    }
    event.test_ends.assign(batch.test_ends.begin(), batch.test_ends.end());
    event.tickets.assign(tickets.begin(), tickets.end());
}

Ticket ScriptedDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    if (!script_.caps.draw_and_query) {
        return QueryDevice::draw_and_query(items, pass);
    }
    Test test;
    test.samples = script_.items ? script_.items(items) : kSamplesPerItem * items.size();
    test.items.assign(items.begin(), items.end());
    drawn_.insert(drawn_.end(), items.begin(), items.end());
    const Ticket ticket = issue(std::move(test));
    Event& event = record(Verb::draw_and_query);
    event.pass = pass;
    event.items.assign(items.begin(), items.end());
    event.tickets = {ticket};
    return ticket;
}

void ScriptedDevice::flush()
{
    record(Verb::flush);
}

Answer ScriptedDevice::record_answer(Verb verb, Ticket ticket, Answer answer, const Test* test)
{
    Event& event = record(verb);
    event.tickets = {ticket};
    event.answer = answer;
    if (test) {
        event.subjects = test->subjects;
        event.items = test->items;
    }
    return answer;
}

Answer ScriptedDevice::spend(Ticket ticket, const Test& test)
{
    const bool lost = test.fate == Latency::Fate::lost;
    const Answer answer = lost ? Answer::lost() : Answer::ready(test.samples);
    tests_.release(ticket);
    return answer;
}

Answer ScriptedDevice::poll(Ticket ticket)
{
    const uint64_t polls_before = polls_++;
    const Test* found = tests_.find(ticket);
    if (!found) {
        return record_answer(Verb::poll, ticket, Answer::lost(), nullptr);
    }
    const Test test = *found;
    if (test.fate == Latency::Fate::never || polls_before < test.ready_at_poll ||
        frames_ended_ < test.ready_at_frame) {
        return record_answer(Verb::poll, ticket, Answer::pending(), &test);
    }
    return record_answer(Verb::poll, ticket, spend(ticket, test), &test);
}

Answer ScriptedDevice::wait(Ticket ticket)
{
    const Test* found = tests_.find(ticket);
    if (!found) {
        return record_answer(Verb::wait, ticket, Answer::lost(), nullptr);
    }
    Test test = *found;
    if (!script_.caps.same_frame_results && frames_ended_ == test.issued_in_frame) {
        test.fate = Latency::Fate::lost;
    }
    return record_answer(Verb::wait, ticket, spend(ticket, test), &test);
}

bool ScriptedDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    record(Verb::read_depth).rect = rect;
    if (!script_.caps.read_depth) {
        return false;
    }
    if (script_.depth) {
        return script_.depth(rect, out);
    }
    std::fill(out.begin(), out.end(), 1.0f);
    return true;
}

bool ScriptedDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    record(Verb::read_depth_tiles).tile_px = tile_px;
    if (script_.caps.find_depth_read(tile_px) == nullptr) {
        return false;
    }
    if (script_.depth_tiles) {
        return script_.depth_tiles(tile_px, out);
    }
    std::fill(out.begin(), out.end(), 1.0f);
    return true;
}

void ScriptedDevice::end_frame()
{
    record(Verb::end_frame);
    ++frames_ended_;
}

std::string ScriptedDevice::trace_text() const
{
    std::string text;
    for (const Event& event : trace_) {
        text += to_string(event) + "\n";
    }
    return text;
}

std::string ScriptedDevice::frame_text(uint64_t frame) const
{
    std::string text;
    for (const Event& event : trace_) {
        const bool boundary = event.verb == Verb::begin_frame || event.verb == Verb::end_frame;
        if (event.frame == frame && !boundary) {
            text += to_string(event) + "\n";
        }
    }
    return text;
}

} // namespace occlude
