// Strong ids. An Id is a dense index that is valid as long as the structure it indexes; a Handle
// also carries a generation, so that a recycled slot never answers for its former owner.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace occlude {

template <class Tag>
struct Id {
    static constexpr uint32_t kInvalid = 0xffffffffu;

    uint32_t value = kInvalid;

    constexpr Id() = default;
    constexpr explicit Id(uint32_t index)
        : value(index)
    {
    }
    constexpr explicit Id(size_t index)
        : value(static_cast<uint32_t>(index))
    {
    }

    constexpr bool valid() const { return value != kInvalid; }
    constexpr auto operator<=>(const Id&) const = default;
};

template <class Tag>
struct Handle {
    uint32_t index = 0xffffffffu;
    uint32_t generation = 0; ///< 0 is never given out

    constexpr bool valid() const { return generation != 0; }
    constexpr auto operator<=>(const Handle&) const = default;
};

/// One draw: an index into the scene's items, and into the engine's own table of draws.
using ItemId = Id<struct ItemTag>;
/// A node of a Hierarchy: an index that is valid until the hierarchy's structure changes.
using NodeId = Id<struct NodeTag>;
/// A position in Hierarchy::items(), the order of draws: not an ItemId. Valid until the hierarchy's
/// structure changes.
using ItemPosition = Id<struct ItemPositionTag>;
/// An object of a Scene. Stale handles are recognised: the slot's generation has moved on.
using ObjectId = Handle<struct ObjectTag>;
/// An outstanding test on a QueryDevice. It is spent when its result is read.
using Ticket = Handle<struct TicketTag>;

} // namespace occlude

template <class Tag>
struct std::hash<occlude::Id<Tag>> {
    size_t operator()(occlude::Id<Tag> id) const noexcept { return id.value; }
};
