#include <occlude/hierarchy/builders/bvh_builder.h>

#include <occlude/core/assert.h>
#include <occlude/hierarchy/builders/detail/parallel.h>
#include <occlude/hierarchy/builders/detail/sah_split.h>
#include <occlude/hierarchy/detail/huge_pages.h>
#include <occlude/hierarchy/detail/node_sums.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace occlude {

namespace {

using detail::Extent;
using detail::Parts;
using detail::Primitive;
using Primitives = std::span<Primitive>;

// Deeper nodes are halved, so that no input makes the tree or the recursion deeper than
// kMaxSahDepth + 32.
constexpr uint32_t kMaxSahDepth = 64;
constexpr size_t kParallelBuild = 4096; // items; smaller subtrees are built by one thread
constexpr size_t kParallelFor = 16384;  // items per task of simple loops

// Memory that was not written yet: clearing it first would cost as much as filling it.
struct Buffer {
    explicit Buffer(size_t size)
        : data(new Primitive[size])
        , all(data.get(), size)
    {
        detail::prefer_huge_pages(data.get(), all.size_bytes());
    }
    std::unique_ptr<Primitive[]> data;
    Primitives all;
};

// A subtree under construction. Its nodes are numbered within it, in the order of the finished
// tree: the root first, then a pair of children, all below the left one, all below the right one.
struct Subtree {
    std::vector<Node> nodes;            // the nodes of a small subtree ...
    std::unique_ptr<Subtree> left = {}; // ... or the two halves of a large one
    std::unique_ptr<Subtree> right = {};
};

// The items in three groups, in the order of their ids: bounded, unbounded, empty.
constexpr size_t kKinds = 3;

size_t kind_of(const Aabb& box)
{
    return box.is_bounded() ? 0 : box.is_empty() ? 2 : 1;
}

struct Census {
    std::array<size_t, kKinds> sizes{};
    bool flags = false; // some item has one
};

Census count(std::span<const ItemBounds> items, TaskRunner& tasks)
{
    return detail::map_and_join<Census>(
        tasks, 0, items.size(), kParallelFor,
        [&](size_t begin, size_t end) {
            Census census;
            for (const ItemBounds& item : items.subspan(begin, end - begin)) {
                ++census.sizes[kind_of(item.box)];
                census.flags = census.flags || item.flags != ItemFlags::none;
            }
            return census;
        },
        [](Census a, const Census& b) {
            for (size_t kind = 0; kind < kKinds; ++kind) {
                a.sizes[kind] += b.sizes[kind];
            }
            a.flags = a.flags || b.flags;
            return a;
        });
}

void group(std::span<const ItemBounds> items, const Census& census, Primitives out,
           TaskRunner& tasks)
{
    const auto primitive = [&](size_t i) {
        return Primitive::of(static_cast<uint32_t>(i), items[i].box, items[i].triangles);
    };
    if (census.sizes[0] == items.size()) {
        detail::for_ranges(tasks, 0, items.size(), kParallelFor, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                out[i] = primitive(i);
            }
        });
        return;
    }
    std::array<size_t, kKinds> next{0, census.sizes[0], census.sizes[0] + census.sizes[1]};
    for (size_t i = 0; i < items.size(); ++i) {
        out[next[kind_of(items[i].box)]++] = primitive(i);
    }
}

Extent all_centers(Primitives primitives, TaskRunner& tasks)
{
    return detail::map_and_join<Extent>(
        tasks, 0, primitives.size(), kParallelFor,
        [&](size_t begin, size_t end) {
            return detail::centers_of(primitives.subspan(begin, end - begin));
        },
        [](Extent a, const Extent& b) {
            a.add(b);
            return a;
        });
}

class Builder {
public:
    Builder(std::span<const ItemBounds> items, bool flags, const BvhOptions& options,
            TaskRunner& tasks)
        : tasks_(tasks)
        , items_(items)
        , flags_(flags)
        , max_leaf_items_(std::max(options.max_leaf_items, 1u))
        , max_leaf_triangles_(options.max_leaf_triangles)
        , virtual_leaf_triangles_(options.leaf_triangles)
        , bins_(std::clamp(options.bins, 2u, detail::kMaxBins))
    {
        detail::reserve_huge(order_, items.size());
        detail::reserve_huge(bounds_, items.size());
        order_.resize(items.size());
        bounds_.resize(items.size());
    }

    // Builds a subtree over `from`, which begins at `first_item` of the whole; `to` is scratch of
    // the same length.
    Subtree build(Primitives from, Primitives to, size_t first_item, const Extent& centers,
                  uint32_t depth)
    {
        Subtree tree;
        if (from.size() < kParallelBuild) {
            tree.nodes.reserve(2 * from.size());
            tree.nodes.emplace_back();
            build_small(tree.nodes, 0, from, to, first_item, centers, depth);
            return tree;
        }
        const Parts parts = detail::part(from, to, centers, bins_, depth >= kMaxSahDepth, tasks_);
        const auto build_part = [&](size_t first, size_t count, const Extent& part_centers) {
            return std::make_unique<Subtree>(build(to.subspan(first, count),
                                                   from.subspan(first, count), first_item + first,
                                                   part_centers, depth + 1));
        };
        detail::run_both(
            tasks_, [&] { tree.left = build_part(0, parts.left, parts.left_centers); },
            [&] {
                tree.right = build_part(parts.left, from.size() - parts.left, parts.right_centers);
            });
        return tree;
    }

    // Makes `node` a leaf of items whose places begin at `first_item`.
    void make_leaf(Node& node, Primitives own, size_t first_item)
    {
        std::sort(own.begin(), own.end(),
                  [](const Primitive& a, const Primitive& b) { return a.item() < b.item(); });
        node.first_item = static_cast<uint32_t>(first_item);
        node.own_items = static_cast<uint32_t>(own.size());
        for (size_t i = 0; i < own.size(); ++i) {
            order_[first_item + i] = ItemId{own[i].item()};
            const ItemFlags flags = flags_ ? items_[own[i].item()].flags : ItemFlags::none;
            bounds_[first_item + i] = {sanitized(own[i].box()), own[i].triangles(), flags};
        }
        node.leaf = 1;
        detail::sum_up(node, {}, bounds_);
    }

    // Moves a subtree to its place: its root to nodes[root], which knows its parent, and all other
    // nodes to the end, in order.
    void place(Subtree& tree, size_t root, std::vector<Node>& nodes) const
    {
        const NodeId parent = nodes[root].parent;
        if (tree.left == nullptr) {
            const size_t base = nodes.size() - 1; // node 1 of the subtree comes next
            nodes.insert(nodes.end(), tree.nodes.begin() + 1, tree.nodes.end());
            nodes[root] = tree.nodes[0];
            nodes[root].parent = parent;
            const auto move_links = [&](Node& node) {
                if (node.child_count > 0) {
                    node.first_child = NodeId{node.first_child.value + base};
                }
            };
            move_links(nodes[root]);
            for (Node& node : std::span{nodes}.subspan(base + 1)) {
                move_links(node);
                node.parent = NodeId{node.parent.value == 0 ? root : node.parent.value + base};
            }
            tree.nodes = {};
            return;
        }
        const size_t child = nodes.size();
        nodes.resize(child + 2);
        nodes[root].first_child = NodeId{child};
        nodes[root].child_count = 2;
        nodes[child].parent = nodes[child + 1].parent = NodeId{root};
        place(*tree.left, child, nodes);
        place(*tree.right, child + 1, nodes);
        nodes[root].first_item = nodes[child].first_item;
        close(nodes, root);
    }

    // Makes a node a virtual leaf if it may be one.
    void mark_if_small(Node& node) const
    {
        if (virtual_leaf_triangles_ > 0 && node.subtree_triangles <= virtual_leaf_triangles_) {
            node.leaf = 1;
        }
    }

    Hierarchy finish(std::vector<Node> nodes)
    {
        return Hierarchy::from_finished_arrays(std::move(nodes), std::move(order_),
                                               std::move(bounds_));
    }

    std::span<const ItemBounds> bounds() const { return bounds_; }

private:
    // `node` is an id within the subtree. Its nodes may move in memory while it grows.
    void build_small(std::vector<Node>& nodes, size_t node, Primitives from, Primitives to,
                     size_t first_item, const Extent& centers, uint32_t depth)
    {
        if (is_leaf(from)) {
            make_leaf(nodes[node], from, first_item);
            return;
        }
        const Parts parts = detail::part(from, to, centers, bins_, depth >= kMaxSahDepth, tasks_);
        const size_t child = nodes.size();
        nodes.resize(child + 2);
        nodes[node].first_item = static_cast<uint32_t>(first_item);
        nodes[node].first_child = NodeId{child};
        nodes[node].child_count = 2;
        nodes[child].parent = nodes[child + 1].parent = NodeId{node};
        build_small(nodes, child, to.first(parts.left), from.first(parts.left), first_item,
                    parts.left_centers, depth + 1);
        build_small(nodes, child + 1, to.subspan(parts.left), from.subspan(parts.left),
                    first_item + parts.left, parts.right_centers, depth + 1);
        close(nodes, node);
    }

    // Finishes a node with two finished children. If it is too large for a virtual leaf, those of
    // its children that are small enough become virtual leaves.
    void close(std::vector<Node>& nodes, size_t node) const
    {
        detail::sum_up(nodes[node], nodes, bounds_);
        if (nodes[node].subtree_triangles > virtual_leaf_triangles_) {
            for (uint32_t c = 0; c < 2; ++c) {
                mark_if_small(nodes[nodes[node].first_child.value + c]);
            }
        }
    }

    bool is_leaf(std::span<const Primitive> primitives) const
    {
        if (primitives.size() == 1 || primitives.size() > max_leaf_items_) {
            return primitives.size() == 1;
        }
        uint64_t triangles = 0;
        for (const Primitive& p : primitives) {
            triangles += p.triangles();
        }
        return triangles <= max_leaf_triangles_;
    }

    TaskRunner& tasks_;
    std::span<const ItemBounds> items_;
    bool flags_;
    uint32_t max_leaf_items_;
    uint32_t max_leaf_triangles_;
    uint32_t virtual_leaf_triangles_;
    uint32_t bins_;
    std::vector<ItemId> order_; // of the finished tree
    std::vector<ItemBounds> bounds_;
};

size_t node_count(const Subtree& tree)
{
    return tree.left == nullptr ? tree.nodes.size()
                                : 1 + node_count(*tree.left) + node_count(*tree.right);
}

} // namespace

Hierarchy build_bvh(std::span<const ItemBounds> items, const BvhOptions& options)
{
    OCCLUDE_ASSERT(items.size() < ItemId::kInvalid / 2, "too many items for 32-bit node ids");
    if (items.empty()) {
        return Hierarchy::from_arrays({}, {}, {});
    }
    TaskRunner& tasks = options.tasks != nullptr ? *options.tasks : default_task_runner();
    const Census census = count(items, tasks);
    Buffer primitives(items.size());
    Buffer scratch(items.size());
    group(items, census, primitives.all, tasks);

    // If all boxes are of one kind, the root holds them. Otherwise each kind gets a child of the
    // root.
    const auto kinds = static_cast<size_t>(
        std::count_if(census.sizes.begin(), census.sizes.end(), [](size_t n) { return n > 0; }));
    Builder builder(items, census.flags, options, tasks);
    const Primitives bounded = primitives.all.first(census.sizes[0]);
    Subtree tree;
    if (!bounded.empty()) {
        tree = builder.build(bounded, scratch.all.first(bounded.size()), 0,
                             all_centers(bounded, tasks), 0);
    }

    std::vector<Node> nodes;
    detail::reserve_huge(nodes, 1 + kinds + (bounded.empty() ? 0 : node_count(tree)));
    nodes.resize(kinds > 1 ? 1 + kinds : 1);
    for (size_t i = 1; i < nodes.size(); ++i) {
        nodes[i].parent = NodeId{0u};
    }
    size_t node = kinds > 1 ? 1 : 0;
    if (!bounded.empty()) {
        builder.place(tree, node, nodes);
        builder.mark_if_small(nodes[node++]);
    }
    size_t first_item = bounded.size();
    for (const size_t size : {census.sizes[1], census.sizes[2]}) {
        if (size > 0) {
            builder.make_leaf(nodes[node++], primitives.all.subspan(first_item, size), first_item);
            first_item += size;
        }
    }
    if (kinds > 1) {
        nodes[0].first_child = NodeId{1u};
        nodes[0].child_count = static_cast<uint32_t>(kinds);
        detail::sum_up(nodes[0], nodes, builder.bounds());
    }
    return builder.finish(std::move(nodes));
}

} // namespace occlude
