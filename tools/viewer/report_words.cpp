#include "viewer/report_words.h"

#include "report/table.h"

#include <fmt/format.h>

#include <array>

namespace occlude::tools::viewer {

namespace {

// "1 test", "1,234 tests".
std::string counted(uint64_t count, const char* singular, const char* plural)
{
    return grouped(count) + " " + (count == 1 ? singular : plural);
}

std::string milliseconds(float us)
{
    constexpr float kUsPerMs = 1000.0f;
    return fmt::format("{:.2f} ms", us / kUsPerMs);
}

const char* reason_in_words(FramePlan::Reason reason)
{
    static constexpr std::array kReasons = {
        "",
        "Nothing is known yet: it draws from near to far and tests what is behind.",
        "What tests find hidden costs more to draw than to test.",
        "Tests cost more than drawing what they find hidden.",
        "Tests did not pay lately: at the end of this frame it looked whether they would.",
        "The device cannot test.",
        "An option says so."};
    return kReasons[static_cast<size_t>(reason)];
}

} // namespace

std::string guarantee_in_words(const Guarantee& guarantee)
{
    switch (guarantee.kind) {
    case Guarantee::Kind::exact:
        return "Exact: every pixel is as if nothing was culled.";
    case Guarantee::Kind::latent:
        return fmt::format("Latent: what appears may be drawn {} late.",
                           counted(guarantee.frames, "frame", "frames"));
    case Guarantee::Kind::approximate:
        break;
    }
    return guarantee.threshold == Guarantee::kAnySamples
               ? "Approximate: objects of any size may be missing."
               : fmt::format("Approximate: objects of up to {} may be missing.",
                             counted(guarantee.threshold, "sample", "samples"));
}

std::vector<std::string> report_in_words(const FrameReport& report)
{
    const FrameCounters& c = report.counters;
    std::vector<std::string> words{guarantee_in_words(report.guarantee)};
    words.push_back(fmt::format("It drew {} with {} in {}.",
                                counted(c.items_drawn, "item", "items"),
                                counted(c.triangles_drawn, "triangle", "triangles"),
                                counted(c.draw_calls, "call", "calls")));
    words.push_back(
        fmt::format("It visited {} of the tree.", counted(c.nodes_visited, "node", "nodes")));
    if (c.queries > 0) {
        words.push_back(fmt::format("It made {} of {} in {}.", counted(c.queries, "test", "tests"),
                                    counted(c.boxes, "box", "boxes"),
                                    counted(c.batches, "batch", "batches")));
    }
    if (c.multiqueries > 0) {
        words.push_back(fmt::format("{} covered several nodes; {} came back visible.",
                                    counted(c.multiqueries, "test", "tests"),
                                    grouped(c.multiqueries_failed)));
    }
    if (c.queries > 0) {
        words.push_back(
            c.waits == 0 ? "It never waited for an answer."
                         : fmt::format("It waited for {}.", counted(c.waits, "answer", "answers")));
        words.push_back(fmt::format("It switched between drawing and testing {}.",
                                    counted(c.state_changes, "time", "times")));
    }
    if (c.lost_answers > 0) {
        words.push_back(fmt::format("{} lost: taken as visible.",
                                    counted(c.lost_answers, "answer was", "answers were")));
    }
    if (c.depth_reads > 0) {
        words.push_back(fmt::format("It read {} of depth in {}.",
                                    counted(c.pixels_read, "pixel", "pixels"),
                                    counted(c.depth_reads, "read-back", "read-backs")));
    }
    if (c.cells_asked > 0) {
        words.push_back(
            fmt::format("It looked at {} of its grid.", counted(c.cells_asked, "cell", "cells")));
    }
    return words;
}

std::vector<std::string> plan_in_words(const FramePlan& plan)
{
    if (plan.kind == FramePlan::Kind::fixed) {
        return {};
    }
    const std::string how = plan.kind == FramePlan::Kind::draw_all
                                ? std::string{"Plan: draw everything in the frustum."}
                                : fmt::format("Plan: test by {}.", name(plan.kind));
    std::vector<std::string> words{how};
    if (plan.reason != FramePlan::Reason::none) {
        words.emplace_back(reason_in_words(plan.reason));
    }
    words.push_back(fmt::format("Drawing what was drawn: {}.", milliseconds(plan.drawn_us)));
    words.push_back(
        fmt::format("Drawing what was found hidden would cost: {}.", milliseconds(plan.saved_us)));
    words.push_back(fmt::format("Testing cost: {}.", milliseconds(plan.spent_us)));
    return words;
}

} // namespace occlude::tools::viewer
