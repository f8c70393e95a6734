#include "viewer/explain.h"

#include <algorithm>
#include <map>

namespace occlude::tools::viewer {

namespace {

std::vector<NodeId> path_to(const Hierarchy& hierarchy, NodeId leaf)
{
    std::vector<NodeId> path;
    for (NodeId node = leaf; node.valid(); node = hierarchy.node(node).parent) {
        path.push_back(node);
    }
    std::reverse(path.begin(), path.end());
    return path;
}

// `path` ascends: parents come before their children. The entry that speaks for an item: the last
// one on the way from the root, as by_item() has it.
const DecisionLog::Entry* entry_of(std::span<const DecisionLog::Entry> entries, ItemId item,
                                   std::span<const NodeId> path)
{
    const DecisionLog::Entry* found = nullptr;
    for (const DecisionLog::Entry& entry : entries) {
        if (entry.scope == DecisionLog::Scope::one_item) {
            if (entry.item == item) {
                found = &entry;
            }
            continue;
        }
        const bool above = entry.scope == DecisionLog::Scope::subtree
                               ? std::binary_search(path.begin(), path.end(), entry.node)
                               : !path.empty() && entry.node == path.back();
        if (above) {
            found = &entry;
        }
    }
    return found;
}

std::optional<LastTest> test_in(const FrameTrace& trace, std::span<const NodeId> path)
{
    for (auto test = trace.tests.rbegin(); test != trace.tests.rend(); ++test) {
        const auto subject = std::find_first_of(path.rbegin(), path.rend(), test->subjects.begin(),
                                                test->subjects.end());
        if (subject == path.rend()) {
            continue;
        }
        LastTest last{.node = *subject,
                      .method = test->method,
                      .state = test->state,
                      .samples = test->samples};
        for (const NodeId partner : test->subjects) {
            if (partner != *subject && std::find(last.partners.begin(), last.partners.end(),
                                                 partner) == last.partners.end()) {
                last.partners.push_back(partner);
            }
        }
        return last;
    }
    return std::nullopt;
}

} // namespace

NodeId leaf_of(const Hierarchy& hierarchy, ItemId item)
{
    const auto items = hierarchy.items();
    const auto found = std::find(items.begin(), items.end(), item);
    if (found == items.end() || hierarchy.empty()) {
        return {};
    }
    const auto place = static_cast<uint32_t>(found - items.begin());
    NodeId node = hierarchy.root();
    while (hierarchy.node(node).child_count > 0 &&
           place >= hierarchy.node(node).first_item + hierarchy.node(node).own_items) {
        NodeId child = hierarchy.node(node).first_child;
        while (place >= hierarchy.node(child).first_item + hierarchy.node(child).subtree_items) {
            ++child.value;
        }
        node = child;
    }
    return node;
}

std::string rule_of(Decision decision, DecisionLog::Scope scope, bool own_node)
{
    const std::string box = scope == DecisionLog::Scope::one_item ? "its own box"
                            : own_node                            ? "the box of its node"
                                                                  : "the box of a node above it";
    switch (decision) {
    case Decision::undecided:
        return "The algorithm did not get as far as this object.";
    case Decision::outside:
        return "Outside: " + box + " does not touch the view frustum, so nothing was tested.";
    case Decision::hidden:
        return "Hidden: " + box + " was tested in this frame and no sample of it could be seen.";
    case Decision::hidden_group:
        return "Hidden: one test covered " + box +
               " and those of other nodes, and no sample of any could be seen.";
    case Decision::drawn:
        return "Drawn without a test: known to be visible, or the algorithm does not test it.";
    case Decision::drawn_near:
        return "Drawn: the near plane may cut " + box + ", so a test could miss it (rule R1).";
    case Decision::drawn_tested:
        return "Drawn because it was visible, and " + box + " was tested for the next frames.";
    case Decision::drawn_revealed:
        return "Drawn: " + box + " was tested in this frame and samples of it could be seen.";
    }
    return {};
}

ItemExplanation explain(const Pane& pane, ItemId item)
{
    const Hierarchy& hierarchy = pane.culler()->hierarchy();
    ItemExplanation explanation{.item = item};
    const NodeId leaf = leaf_of(hierarchy, item);
    const std::vector<NodeId> path =
        leaf.valid() ? path_to(hierarchy, leaf) : std::vector<NodeId>{};
    for (const FrameMemory& memory : pane.memory()) {
        const DecisionLog::Entry* entry = entry_of(memory.decisions, item, path);
        explanation.recent.push_back(entry != nullptr ? entry->decision : Decision::undecided);
    }
    const auto newest = pane.memory().rbegin();
    if (newest == pane.memory().rend()) {
        explanation.rule = rule_of(Decision::undecided, DecisionLog::Scope::subtree, false);
        return explanation;
    }
    const DecisionLog::Entry* entry = entry_of(newest->decisions, item, path);
    const auto drawn = pane.culler()->drawn_items();
    if (entry != nullptr) {
        explanation.decision = entry->decision;
        explanation.decided_at = entry->node;
    }
    if (!is_drawn(explanation.decision) &&
        std::find(drawn.begin(), drawn.end(), item) != drawn.end()) {
        explanation.decision = Decision::drawn; // decided for items, not for nodes
    }
    explanation.rule =
        rule_of(explanation.decision, entry != nullptr ? entry->scope : DecisionLog::Scope::subtree,
                entry != nullptr && entry->node == leaf);
    for (size_t depth = 0; depth < path.size(); ++depth) {
        const Node& node = hierarchy.node(path[depth]);
        ChainLink link{.node = path[depth],
                       .depth = static_cast<int>(depth),
                       .items = node.subtree_items,
                       .triangles = node.subtree_triangles};
        for (const DecisionLog::Entry& made : newest->decisions) {
            if (made.node == path[depth] && made.scope != DecisionLog::Scope::one_item) {
                link.decision = made.decision;
            }
        }
        explanation.chain.push_back(link);
    }
    for (auto memory = newest; memory != pane.memory().rend(); ++memory) {
        explanation.last_test = test_in(memory->trace, path);
        if (explanation.last_test) {
            explanation.last_test->frames_ago = newest->frame - memory->frame;
            break;
        }
    }
    return explanation;
}

Coverage coverage(std::span<const uint32_t> alone, std::span<const uint32_t> all,
                  std::span<const uint32_t> instance_of, uint32_t instance)
{
    Coverage found;
    std::map<uint32_t, uint64_t> pixels;
    for (size_t i = 0; i < alone.size() && i < all.size(); ++i) {
        if (!ItemId{alone[i]}.valid()) {
            continue;
        }
        ++found.pixels;
        if (!ItemId{all[i]}.valid()) {
            continue;
        }
        const uint32_t owner = instance_of[all[i]];
        if (owner == instance) {
            ++found.visible_pixels;
        } else {
            ++pixels[owner];
        }
    }
    for (const auto& [owner, count] : pixels) {
        found.occluders.push_back({owner, count});
    }
    std::sort(found.occluders.begin(), found.occluders.end(),
              [](const Occluder& a, const Occluder& b) { return a.pixels > b.pixels; });
    return found;
}

} // namespace occlude::tools::viewer
