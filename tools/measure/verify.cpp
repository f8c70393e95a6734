#include "measure/verify.h"

#include "measure/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <map>
#include <ranges>
#include <set>
#include <unordered_map>

namespace occlude::tools {

namespace {

// One flag per pixel.
using Mask = std::vector<uint8_t>;

Mask difference(const Capture& a, const Capture& b)
{
    const size_t pixels = std::max(a.color.pixels.size(), b.color.pixels.size());
    if (a.color.pixels.size() != b.color.pixels.size() || a.depth.size() != b.depth.size()) {
        return Mask(pixels, 1);
    }
    Mask mask(pixels, 0);
    for (size_t i = 0; i < pixels; ++i) {
        const bool same_depth = i >= a.depth.size() || std::bit_cast<uint32_t>(a.depth[i]) ==
                                                           std::bit_cast<uint32_t>(b.depth[i]);
        mask[i] = a.color.pixels[i] == b.color.pixels[i] && same_depth ? 0 : 1;
    }
    return mask;
}

uint64_t count_set(const Mask& mask)
{
    return static_cast<uint64_t>(std::count(mask.begin(), mask.end(), uint8_t{1}));
}

Capture draw_and_capture(const Stage& stage, const View& view, std::span<const ItemId> items)
{
    stage.renderer.render(view, in_draw_order(view, stage.item_bounds, items));
    return stage.renderer.capture();
}

// Walks up from each item's node to the first node with a decision. O(items + nodes).
void blame(const Hierarchy& hierarchy, const DecisionLog& decisions,
           std::span<MissingItem> missing_items)
{
    std::unordered_map<uint32_t, Decision> decided;
    for (const DecisionLog::Entry& entry : decisions.entries()) {
        decided[entry.node.value] = entry.decision;
    }
    std::unordered_map<uint32_t, NodeId> node_of_item;
    for (size_t n = 0; n < hierarchy.nodes().size(); ++n) {
        for (const ItemId item : hierarchy.own_items(NodeId{n})) {
            node_of_item[item.value] = NodeId{n};
        }
    }
    for (MissingItem& missing : missing_items) {
        const auto home = node_of_item.find(missing.item.value);
        NodeId node = home != node_of_item.end() ? home->second : NodeId{};
        while (node.valid() && !decided.contains(node.value)) {
            node = hierarchy.node(node).parent;
        }
        missing.node = node;
        missing.decision = node.valid() ? decided[node.value] : Decision::undecided;
    }
}

std::vector<MissingItem> find_missing(const Stage& stage, const View& view, const Mask& differing,
                                      std::span<const ItemId> drawn_ascending)
{
    const std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
    const std::vector<uint32_t> ids = stage.renderer.render_ids(view, items);
    std::map<uint32_t, std::set<size_t>> pixels_of;
    for (size_t i = 0; i < (differing.empty() ? 0 : ids.size()); ++i) {
        const ItemId item{ids[i]};
        const size_t pixel = i % differing.size(); // one sample of every pixel after the other
        if (differing[pixel] != 0 && item.valid() &&
            !std::binary_search(drawn_ascending.begin(), drawn_ascending.end(), item)) {
            pixels_of[ids[i]].insert(pixel);
        }
    }
    std::vector<MissingItem> missing;
    for (const auto& [id, pixels] : pixels_of) {
        missing.push_back({ItemId{id}, pixels.size(), NodeId{}, Decision::undecided});
    }
    std::stable_sort(
        missing.begin(), missing.end(),
        [](const MissingItem& a, const MissingItem& b) { return a.pixels > b.pixels; });
    return missing;
}

// Finds the items with surfaces at the same depth in tied pixels: the items that show if the drawn
// ones are drawn in one order and in the other. Keeps the pairs with most pixels.
std::vector<CoincidentItems> find_coincident(const Stage& stage, const View& view, const Mask& tied,
                                             std::span<const ItemId> drawn_ascending)
{
    constexpr size_t kMaxPairs = 16;
    const std::vector<ItemId> descending{drawn_ascending.rbegin(), drawn_ascending.rend()};
    const std::vector<uint32_t> first = stage.renderer.render_ids(view, drawn_ascending);
    const std::vector<uint32_t> last = stage.renderer.render_ids(view, descending);
    std::map<std::pair<uint32_t, uint32_t>, std::set<size_t>> pixels_of;
    for (size_t i = 0; i < (tied.empty() ? 0 : first.size()); ++i) {
        const size_t pixel = i % tied.size(); // one sample of every pixel after the other
        if (tied[pixel] != 0 && first[i] != last[i]) {
            pixels_of[{first[i], last[i]}].insert(pixel);
        }
    }
    std::vector<CoincidentItems> pairs;
    for (const auto& [ids, pixels] : pixels_of) {
        pairs.push_back({ItemId{ids.first}, ItemId{ids.second}, pixels.size()});
    }
    std::ranges::stable_sort(pairs, std::greater{}, &CoincidentItems::pixels);
    pairs.resize(std::min(pairs.size(), kMaxPairs));
    return pairs;
}

glm::ivec2 first_set(const Mask& mask, glm::ivec2 size)
{
    const auto found = std::find(mask.begin(), mask.end(), uint8_t{1});
    if (found == mask.end() || size.x <= 0) {
        return glm::ivec2{-1};
    }
    const auto index = static_cast<int>(found - mask.begin());
    return {index % size.x, index / size.x};
}

std::string describe_missing(const MissingItem& missing)
{
    const std::string item =
        fmt::format("item {} ({} pixels) is missing", missing.item.value, missing.pixels);
    if (!missing.node.valid()) {
        return item + ", no node above it has a decision";
    }
    return fmt::format("{}, node {} was decided '{}'", item, missing.node.value,
                       to_string(missing.decision));
}

std::string describe_frame(const AlgorithmRun& run, size_t frame, const Verdict& verdict)
{
    constexpr size_t kMaxItems = 4;
    std::string line =
        fmt::format("{}: frame {}: {} differing pixels, the first at ({}, {}) from the lower left",
                    run_label(run, true), frame, verdict.differing_pixels, verdict.first_pixel.x,
                    verdict.first_pixel.y);
    if (verdict.missing.empty()) {
        return line + "; no item is missing: a test left a trace, or an item was drawn twice";
    }
    for (size_t i = 0; i < std::min(kMaxItems, verdict.missing.size()); ++i) {
        line += "; " + describe_missing(verdict.missing[i]);
    }
    if (verdict.missing.size() > kMaxItems) {
        line += fmt::format("; {} more items are missing", verdict.missing.size() - kMaxItems);
    }
    return line;
}

// True for an image of one colour and one depth: nothing, or a wall parallel to the image plane.
bool is_one_color(const Capture& capture)
{
    const auto all_alike = [](const auto& values) {
        return std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>{}) ==
               values.end();
    };
    return all_alike(capture.color.pixels) && all_alike(capture.depth);
}

// True if no item is visible when all are drawn.
bool shows_nothing(const Stage& stage, const View& view, std::span<const ItemId> items,
                   const Capture& reference)
{
    const bool any_blended = std::any_of(items.begin(), items.end(), [&](ItemId item) {
        return has_flag(stage.item_bounds[item.value].flags, ItemFlags::translucent);
    });
    return is_one_color(reference) && !any_blended &&
           owners_of_pixels(stage.renderer.render_ids(view, items)).empty();
}

// Culls one frame with one culler and compares it with the reference.
void verify_frame(const Stage& stage, const View& view, const Capture& reference, Culler& culler,
                  AlgorithmRun& run, size_t frame)
{
    const FrameReport report = culler.cull(view, stage.renderer.device());
    const Capture culled = stage.renderer.capture();
    run.guarantee = weaker(run.guarantee, report.guarantee);
    FrameFigures& figures = run.frames[frame];
    figures.frame = frame;
    figures.counters = report.counters;
    figures.decision_hash = culler.decisions().hash(culler.hierarchy(), frame);
    const Stage walked{culler.hierarchy(), stage.item_bounds, stage.renderer};
    figures.verdict =
        judge_frame(walked, view, reference, culled, culler.drawn_items(), culler.decisions());
}

// The pixels of the culled frame that differ when its own items are drawn again without tests.
Mask unexplained(const Stage& stage, const View& view, const Capture& culled,
                 std::span<const ItemId> drawn)
{
    Mask forward = difference(culled, draw_and_capture(stage, view, drawn));
    if (count_set(forward) == 0) {
        return forward;
    }
    // After a depth-only pass the last of equals shows, not the first, as if drawn backwards.
    const std::vector<ItemId> reversed{drawn.rbegin(), drawn.rend()};
    Mask backward = difference(culled, draw_and_capture(stage, view, reversed));
    return count_set(backward) == 0 ? backward : forward;
}

} // namespace

Capture reference_image(const Stage& stage, const View& view)
{
    return draw_and_capture(stage, view, items_in_frustum(view, stage.item_bounds));
}

Verdict judge_frame(const Stage& stage, const View& view, const Capture& reference,
                    const Capture& culled, std::span<const ItemId> drawn,
                    const DecisionLog& decisions)
{
    const Mask unlike_reference = difference(reference, culled);
    if (count_set(unlike_reference) == 0) {
        return {};
    }
    std::vector<ItemId> ascending{drawn.begin(), drawn.end()};
    std::sort(ascending.begin(), ascending.end());
    Mask differing = unexplained(stage, view, culled, drawn);
    const Mask incomplete = difference(reference, draw_and_capture(stage, view, ascending));
    for (size_t i = 0; i < std::min(differing.size(), incomplete.size()); ++i) {
        differing[i] |= incomplete[i];
    }

    Verdict verdict;
    verdict.differing_pixels = count_set(differing);
    Mask tied = unlike_reference;
    for (size_t i = 0; i < std::min(tied.size(), differing.size()); ++i) {
        tied[i] = tied[i] != 0 && differing[i] == 0 ? 1 : 0;
    }
    verdict.tied_pixels = count_set(tied);
    if (verdict.tied_pixels > 0) {
        verdict.coincident = find_coincident(stage, view, tied, ascending);
    }
    if (verdict.differing_pixels > 0) {
        verdict.first_pixel = first_set(differing, reference.color.size);
        verdict.missing = find_missing(stage, view, differing, ascending);
        blame(stage.hierarchy, decisions, verdict.missing);
    }
    return verdict;
}

Result<std::vector<AlgorithmRun>> verify(const Stage& stage, std::span<const Contender> contenders,
                                         std::span<const View> views,
                                         const ProgressCallback& progress)
{
    auto cullers = make_cullers(stage, contenders);
    if (!cullers) {
        return cullers.error();
    }
    std::vector<AlgorithmRun> runs;
    for (const Contender& contender : contenders) {
        runs.push_back(
            {contender.name, {}, std::vector<FrameFigures>(views.size()), contender.hierarchy});
    }
    stage.renderer.warm_up();
    const bool answer_needed =
        std::any_of(cullers->begin(), cullers->end(),
                    [](const std::unique_ptr<Culler>& culler) { return needs_answer(*culler); });
    for (size_t frame = 0; frame < views.size(); ++frame) {
        const View& view = views[frame];
        set_frame(stage, frame);
        const std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
        std::vector<ItemId> owners;
        if (answer_needed) {
            owners = owners_of_pixels(stage.renderer.render_ids(view, items));
        }
        const Capture reference = draw_and_capture(stage, view, items);
        const bool empty = shows_nothing(stage, view, items, reference);
        for (size_t i = 0; i < runs.size(); ++i) {
            runs[i].frames[frame].items_in_frustum = items.size();
            runs[i].frames[frame].shows_nothing = empty;
            Culler& culler = *(*cullers)[i];
            record_answer(culler, view, stage.renderer.device(), owners);
            verify_frame(stage, view, reference, culler, runs[i], frame);
            if (answer_needed) {
                runs[i].frames[frame].overdraw_items_vs_exact =
                    overdraw_items(culler.drawn_items(), owners);
            }
        }
        if (progress) {
            progress(static_cast<double>(frame + 1) / static_cast<double>(views.size()));
        }
    }
    return runs;
}

bool promises_kept(std::span<const AlgorithmRun> runs)
{
    return std::all_of(runs.begin(), runs.end(), [](const AlgorithmRun& run) {
        return run.guarantee.kind != Guarantee::Kind::exact || summarise(run).differing_pixels == 0;
    });
}

std::vector<std::string> describe_differences(const AlgorithmRun& run, size_t max_lines)
{
    std::vector<std::string> lines;
    size_t left_out = 0;
    for (size_t frame = 0; frame < run.frames.size(); ++frame) {
        const std::optional<Verdict>& verdict = run.frames[frame].verdict;
        if (!verdict || verdict->differing_pixels == 0) {
            continue;
        }
        if (lines.size() < max_lines) {
            lines.push_back(describe_frame(run, run.frames[frame].frame, *verdict));
        } else {
            ++left_out;
        }
    }
    if (left_out > 0) {
        lines.push_back(fmt::format("{}: {} more frames differ", run_label(run, true), left_out));
    }
    return lines;
}

} // namespace occlude::tools
