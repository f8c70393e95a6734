#include <occlude/integration/verify_frame.h>

#include <algorithm>
#include <unordered_set>

namespace occlude {

namespace {

struct LeftOut {
    float distance = 0.0f;
    uint32_t place = 0; ///< in Hierarchy::items()
};

// Near to far, so that an item behind another missing item is not reported.
std::vector<LeftOut> left_out_items(const Culler& culler, const View& view)
{
    const Hierarchy& hierarchy = culler.hierarchy();
    std::unordered_set<uint32_t> drawn;
    for (const ItemId item : culler.drawn_items()) {
        drawn.insert(item.value);
    }
    std::vector<LeftOut> left_out;
    for (uint32_t place = 0; place < hierarchy.items().size(); ++place) {
        const Aabb& box = hierarchy.item_bounds()[place].box;
        if (!box.is_empty() && !drawn.contains(hierarchy.items()[place].value)) {
            left_out.push_back({view.distance_key(box), place});
        }
    }
    std::ranges::stable_sort(left_out, {}, &LeftOut::distance);
    return left_out;
}

// The smallest node around the item with a decision that applies to the item.
MissedItem blame(const Culler& culler, uint32_t place, uint64_t samples)
{
    const Hierarchy& hierarchy = culler.hierarchy();
    MissedItem missed{hierarchy.items()[place], samples, {}, Decision::undecided, {}};
    uint32_t smallest = ~0u;
    for (const DecisionLog::Entry& entry : culler.decisions().entries()) {
        const Node& node = hierarchy.node(entry.node);
        const bool one_item = entry.scope == DecisionLog::Scope::one_item;
        const uint32_t count = entry.scope == DecisionLog::Scope::own_items ? node.own_items
                               : one_item                                   ? 1
                                                                            : node.subtree_items;
        const bool around = one_item ? entry.item == missed.item
                                     : place >= node.first_item && place - node.first_item < count;
        if (around && count <= smallest) {
            smallest = count;
            missed.node = entry.node;
            missed.decision = entry.decision;
        }
    }
    missed.text = "item " + std::to_string(missed.item.value) + " is missing with " +
                  std::to_string(samples) + " samples; ";
    missed.text += missed.node.valid()
                       ? "node " + std::to_string(missed.node.value) + " was decided '" +
                             std::string(to_string(missed.decision)) + "'"
                       : std::string("there was no decision about a node around it");
    return missed;
}

// Counts the samples that single draws add to the image of a frame.
class DrawCounter {
public:
    DrawCounter(const View& view, QueryDevice& device)
        : view_(view)
        , device_(device)
        , by_queries_(device.caps().draw_and_query)
    {
    }

    /// False if the device lost the answer.
    bool count(ItemId item, uint64_t& samples)
    {
        if (by_queries_) {
            const Answer answer = device_.wait(device_.draw_and_query({&item, 1}, DrawPass::shade));
            samples = answer.samples;
            return answer.state == AnswerState::ready;
        }
        if (before_.empty() && !read(before_)) {
            return false;
        }
        device_.draw({&item, 1}, DrawPass::shade);
        if (!read(after_)) {
            return false;
        }
        samples = 0;
        for (size_t i = 0; i < after_.size(); ++i) {
            samples += after_[i] < before_[i] ? 1 : 0;
        }
        std::swap(before_, after_);
        return true;
    }

private:
    bool read(std::vector<float>& depths)
    {
        const glm::ivec2 size = view_.size_px();
        depths.resize(pixel_count(size));
        return device_.read_depth({0, 0, size.x, size.y}, depths);
    }

    const View& view_;
    QueryDevice& device_;
    bool by_queries_;
    std::vector<float> before_;
    std::vector<float> after_;
};

} // namespace

Result<FrameCheck> verify_frame(Culler& culler, const View& view, QueryDevice& device)
{
    if (!device.caps().draw_and_query && !device.caps().read_depth) {
        return Error{ErrorCode::unsupported,
                     "verify_frame() needs a device that can draw_and_query or read depth; this "
                     "one can do neither"};
    }
    FrameCheck check;
    check.report = culler.cull(view, device);
    const std::vector<LeftOut> left_out = left_out_items(culler, view);
    check.items_checked = left_out.size();
    device.begin_frame(view);
    device.draw(culler.drawn_items(), DrawPass::shade);
    DrawCounter counter(view, device);
    bool answered = view.size_px().x > 0 && view.size_px().y > 0;
    for (size_t i = 0; i < left_out.size() && answered; ++i) {
        uint64_t samples = 0;
        const uint32_t place = left_out[i].place;
        answered = counter.count(culler.hierarchy().items()[place], samples);
        if (answered && samples > 0) {
            check.missing.push_back(blame(culler, place, samples));
        }
    }
    device.end_frame();
    if (!answered) {
        return Error{ErrorCode::device_failed,
                     "verify_frame(): the device lost an answer, or the view has no pixel"};
    }
    return check;
}

} // namespace occlude
