#include <occlude/cull/parts/decision_log.h>

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude {

std::string_view to_string(Decision decision)
{
    switch (decision) {
    case Decision::undecided:
        return "undecided";
    case Decision::outside:
        return "outside";
    case Decision::hidden:
        return "hidden";
    case Decision::hidden_group:
        return "hidden_group";
    case Decision::drawn:
        return "drawn";
    case Decision::drawn_near:
        return "drawn_near";
    case Decision::drawn_tested:
        return "drawn_tested";
    case Decision::drawn_revealed:
        return "drawn_revealed";
    }
    return "undecided";
}

uint64_t walk_hash(uint64_t walk_so_far, uint64_t next_frame)
{
    return hash64(walk_so_far, next_frame);
}

// The items that an entry stands for.
static std::span<const ItemId> items_of(const Hierarchy& hierarchy, const DecisionLog::Entry& entry)
{
    switch (entry.scope) {
    case DecisionLog::Scope::one_item:
        return {&entry.item, 1};
    case DecisionLog::Scope::own_items:
        return hierarchy.own_items(entry.node);
    case DecisionLog::Scope::subtree:
        break;
    }
    return hierarchy.subtree_items(entry.node);
}

std::vector<Decision> DecisionLog::by_item(const Hierarchy& hierarchy) const
{
    uint32_t item_slots = 0;
    for (const ItemId item : hierarchy.items()) {
        item_slots = std::max(item_slots, item.value + 1);
    }
    std::vector<Decision> decisions(item_slots, Decision::undecided);
    for (const Entry& entry : entries_) {
        for (const ItemId item : items_of(hierarchy, entry)) {
            decisions[item.value] = entry.decision;
        }
    }
    return decisions;
}

uint64_t DecisionLog::hash(const Hierarchy& hierarchy, uint64_t frame) const
{
    enum Verb : uint64_t { draw = 1, hide = 2, leave_outside = 3 };
    uint64_t sum = 0;
    for (const Entry& entry : entries_) {
        const Verb verb = is_drawn(entry.decision)              ? draw
                          : entry.decision == Decision::outside ? leave_outside
                                                                : hide;
        for (const ItemId item : items_of(hierarchy, entry)) {
            sum += hash64(frame, static_cast<uint64_t>(verb), item.value);
        }
    }
    return sum;
}

} // namespace occlude
