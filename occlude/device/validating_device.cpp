#include <occlude/device/validating_device.h>

#include <occlude/core/assert.h>
#include <occlude/device/detail/sure_pixels.h>

#include <algorithm>

namespace occlude {

namespace {

uint8_t bit(DrawPass pass)
{
    return static_cast<uint8_t>(1u << static_cast<unsigned>(pass));
}

const char* name(DrawPass pass)
{
    switch (pass) {
    case DrawPass::depth_only:
        return "depth_only";
    case DrawPass::shade_equal:
        return "shade_equal";
    case DrawPass::shade:
        break;
    }
    return "shade";
}

std::string text(Ticket ticket)
{
    return "ticket " + std::to_string(ticket.index) + "/" + std::to_string(ticket.generation);
}

std::string text(ItemId item)
{
    return item.valid() ? "item " + std::to_string(item.value) : std::string("an invalid item");
}

std::string text(const QueryBox& box, size_t index)
{
    std::string words = "box " + std::to_string(index) + " of the batch";
    if (box.subject.valid()) {
        words += ", of node " + std::to_string(box.subject.value) + ",";
    }
    return words;
}

bool touches_near(const QueryBox& box, const View& view)
{
    if (!box.world_from_box) {
        return view.touches_near(box.box);
    }
    const glm::mat4& world_from_box = *box.world_from_box;
    return view.touches_near(transformed(world_from_box, box.box)) &&
           view.in_object(world_from_box).touches_near(box.box);
}

} // namespace

ValidatingDevice::ValidatingDevice(QueryDevice& inner, Options options)
    : ForwardingDevice(inner)
    , options_(std::move(options))
{
}

void ValidatingDevice::report(std::string_view rule, const std::string& message) const
{
    if (options_.on_violation) {
        options_.on_violation(rule, message);
    } else {
        detail::assert_failed(rule, message, __FILE__, __LINE__);
    }
}

void ValidatingDevice::require_frame(const char* verb) const
{
    if (!in_frame_) {
        report("C1", std::string(verb) + " outside of a frame: call begin_frame first");
    }
}

void ValidatingDevice::begin_frame(const View& view)
{
    if (in_frame_) {
        report("C1", "begin_frame inside a frame: call end_frame first");
    }
    in_frame_ = true;
    ++frame_;
    view_ = view;
    passes_.clear();
    inner().begin_frame(view);
}

void ValidatingDevice::end_frame()
{
    require_frame("end_frame");
    // Sorted, so that the reports come in the same order everywhere.
    std::vector<ItemId> unshaded;
    for (const auto& [item, passes] : passes_) {
        if ((passes & bit(DrawPass::depth_only)) && !(passes & bit(DrawPass::shade_equal))) {
            unshaded.push_back(item);
        }
    }
    std::sort(unshaded.begin(), unshaded.end());
    for (const ItemId item : unshaded) {
        report("passes", text(item) + " was drawn depth_only and never shaded with shade_equal");
    }
    in_frame_ = false;
    inner().end_frame();
}

void ValidatingDevice::check_items(std::span<const ItemId> items, DrawPass pass)
{
    for (const ItemId item : items) {
        if (!item.valid()) {
            report("precondition", "an invalid item was handed to a draw");
            continue;
        }
        uint8_t& passes = passes_[item];
        if (passes & bit(pass)) {
            report("C10", text(item) + " is drawn twice in the " + name(pass) + " pass of a frame");
        }
        if (pass == DrawPass::shade_equal && !(passes & bit(DrawPass::depth_only))) {
            report("passes", text(item) + " is shaded with shade_equal before its depth_only draw");
        }
        passes |= bit(pass);
    }
}

void ValidatingDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    require_frame("draw");
    check_items(items, pass);
    ++draws_;
    inner().draw(items, pass);
}

void ValidatingDevice::check_method(TestMethod method) const
{
    const DeviceCaps& caps = inner().caps();
    const bool there = method == TestMethod::automatic || caps.methods.empty() ||
                       caps.find_method(method) != nullptr;
    if (!there) {
        report("methods",
               "the batch names test method " + std::to_string(static_cast<int>(method)) +
                   ", which caps.methods does not list: name one of those, or automatic");
    }
}

bool ValidatingDevice::check_batch(const QueryBatch& batch, size_t ticket_count) const
{
    if (ticket_count != batch.test_ends.size()) {
        report("precondition", "query of " + std::to_string(batch.test_ends.size()) +
                                   " tests was given room for " + std::to_string(ticket_count) +
                                   " tickets");
        return false;
    }
    uint32_t begin = 0;
    for (size_t i = 0; i < batch.test_ends.size(); ++i) {
        const uint32_t end = batch.test_ends[i];
        if (end == begin) {
            report("C6", "test " + std::to_string(i) + " of the batch has no box");
            return false;
        }
        if (end < begin || end > batch.boxes.size()) {
            report("C6", "test " + std::to_string(i) + " of the batch ends at box " +
                             std::to_string(end) + ": ends must ascend and stay within the " +
                             std::to_string(batch.boxes.size()) + " boxes");
            return false;
        }
        begin = end;
    }
    if (begin != batch.boxes.size()) {
        report("C6", "the tests of the batch end at box " + std::to_string(begin) + " of " +
                         std::to_string(batch.boxes.size()) + ": the rest belongs to no test");
        return false;
    }
    return true;
}

void ValidatingDevice::check_box(const QueryBox& box, size_t index) const
{
    if (!box.box.is_bounded()) {
        report("C5", text(box, index) + " is empty, unbounded or NaN: count it as visible instead");
    } else if (touches_near(box, view_)) {
        report("C5", text(box, index) + " touches the near plane: count it as visible instead");
    }
}

void ValidatingDevice::check_outstanding(size_t new_tests) const
{
    const size_t unspent = unspent_.size() + new_tests;
    if (unspent > inner().caps().max_outstanding) {
        report("C11", std::to_string(unspent) + " tests would be unspent, but the device keeps " +
                          std::to_string(inner().caps().max_outstanding));
    }
}

void ValidatingDevice::adopt(Ticket ticket, int sure_pixels)
{
    if (!ticket.valid()) {
        return; // lost from the start
    }
    const auto unspent = unspent_.find(ticket);
    if (unspent != unspent_.end()) {
        const bool earlier = unspent->second.frame != frame_;
        report(earlier ? "C12" : "C7", "the device gave out " + text(ticket) +
                                           (earlier ? " of an earlier frame" : "") +
                                           " again while it is unspent");
    } else if (last_generation_[ticket.index] == ticket.generation) {
        report("C7", "the device gave out the spent " + text(ticket) +
                         " again: its former owner could read another test's answer");
    }
    last_generation_[ticket.index] = ticket.generation;
    unspent_[ticket] = {frame_, draws_, sure_pixels};
}

void ValidatingDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    require_frame("query");
    std::fill(tickets.begin(), tickets.end(), Ticket{});
    if (!check_batch(batch, tickets.size())) {
        return;
    }
    for (size_t i = 0; i < batch.boxes.size(); ++i) {
        check_box(batch.boxes[i], i);
    }
    check_method(batch.method);
    check_outstanding(tickets.size());
    const std::vector<float> before = depth();
    inner().query(batch, tickets);
    const std::vector<float> after = depth();
    const bool both_read = !before.empty() && !after.empty();
    if (both_read && before != after) {
        report("C4", "a batch of tests changed the depth buffer");
    }
    uint32_t begin = 0;
    for (size_t i = 0; i < tickets.size(); ++i) {
        int pixels = 0;
        for (; begin < batch.test_ends[i]; ++begin) {
            const QueryBox& box = batch.boxes[begin];
            const bool testable = box.box.is_bounded() && !touches_near(box, view_);
            pixels += testable ? detail::sure_pixels(box, view_, before) : 0;
        }
        adopt(tickets[i], pixels);
    }
}

Ticket ValidatingDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    require_frame("draw_and_query");
    check_items(items, pass);
    if (inner().caps().draw_and_query) {
        check_outstanding(1);
    }
    ++draws_;
    const Ticket ticket = inner().draw_and_query(items, pass);
    adopt(ticket, 0);
    return ticket;
}

void ValidatingDevice::flush()
{
    require_frame("flush");
    inner().flush();
}

void ValidatingDevice::check_count(const Test& test, const Answer& answer) const
{
    if (answer.state != AnswerState::ready || answer.samples > 0 || test.sure_pixels == 0) {
        return;
    }
    const std::string seen = "a test counts no sample, but " + std::to_string(test.sure_pixels) +
                             " pixels would have shown its boxes when it was issued";
    if (draws_ != test.draws_before) {
        report("C2", seen + "; it may have seen draws that came after it");
    } else {
        report("C3", seen);
    }
}

Answer ValidatingDevice::check_answer(const char* verb, Ticket ticket, Answer answer)
{
    const std::string what = std::string(verb) + " of " + text(ticket);
    const auto unspent = unspent_.find(ticket);
    if (unspent == unspent_.end()) {
        if (ticket.valid()) {
            report("C7", what + ": it is spent or foreign; ask each ticket until it is answered");
        }
        if (answer.state != AnswerState::lost) {
            report("C7", what + " was answered although it is spent, foreign or invalid");
        }
    }
    if (answer.state == AnswerState::ready) {
        if (answer.samples == Answer::kUnknownSamples) {
            report("C8", what + " is ready with an unknown count: that is a lost test");
        }
    } else if (answer.samples != Answer::kUnknownSamples) {
        report("C8", what + " is not ready but counts " + std::to_string(answer.samples) +
                         " samples: it must read as visible");
    }
    if (unspent != unspent_.end() && answer.state != AnswerState::pending) {
        check_count(unspent->second, answer);
        unspent_.erase(unspent);
    }
    return answer;
}

Answer ValidatingDevice::poll(Ticket ticket)
{
    return check_answer("poll", ticket, inner().poll(ticket));
}

Answer ValidatingDevice::wait(Ticket ticket)
{
    const Answer answer = inner().wait(ticket);
    if (answer.state == AnswerState::pending) {
        report("C9", "wait of " + text(ticket) + " answered pending");
    }
    return check_answer("wait", ticket, answer);
}

} // namespace occlude
