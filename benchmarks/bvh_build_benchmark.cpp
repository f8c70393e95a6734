// How long it takes to build a tree over random boxes, and the quality of the tree: its cost by the
// surface area heuristic, beside Embree's trees over the same boxes on as many threads.
#include <occlude/core/rng.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#ifdef OCCLUDE_HAS_EMBREE
#include <embree3/rtcore.h>
#endif

namespace occlude {
namespace {

constexpr int kThreads = 2;

std::vector<ItemBounds> random_items(size_t count)
{
    Rng rng(1);
    std::vector<ItemBounds> items(count);
    for (ItemBounds& item : items) {
        for (int axis = 0; axis < 3; ++axis) {
            item.box.min[axis] = rng.range(0.0f, 1000.0f);
            item.box.max[axis] = item.box.min[axis] + rng.range(0.0f, 4.0f);
        }
        item.triangles = 1; // so that both builders minimise the same cost
    }
    return items;
}

void build_ours(benchmark::State& state)
{
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kThreads);
    const std::vector<ItemBounds> items = random_items(static_cast<size_t>(state.range(0)));
    Hierarchy tree;
    for (auto _ : state) {
        tree = build_bvh(items, {.max_leaf_items = static_cast<uint32_t>(state.range(1))});
    }
    state.counters["sah_cost"] = sah_cost(tree);
    if (const std::string problem = validate(tree); !problem.empty()) {
        state.SkipWithError(problem.c_str());
    }
}

#ifdef OCCLUDE_HAS_EMBREE

// The tree that Embree's callbacks build: it holds only what its cost needs.
struct EmbreeNode {
    RTCBounds child_bounds[2];
    EmbreeNode* children[2] = {nullptr, nullptr}; // both null: a leaf
    size_t boxes = 0;                             // in a leaf
};

double area(const RTCBounds& b)
{
    const double x = double{b.upper_x} - b.lower_x;
    const double y = double{b.upper_y} - b.lower_y;
    const double z = double{b.upper_z} - b.lower_z;
    return 2.0 * (x * y + y * z + z * x);
}

// As sah_cost(): the areas of the nodes below the root, an inner node once, a leaf once per box.
double area_below(const EmbreeNode& node)
{
    double sum = 0.0;
    for (int i = 0; i < 2; ++i) {
        if (node.children[i] != nullptr) {
            const auto boxes = static_cast<double>(std::max<size_t>(node.children[i]->boxes, 1));
            sum += area(node.child_bounds[i]) * boxes + area_below(*node.children[i]);
        }
    }
    return sum;
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*)
{
    return new (rtcThreadLocalAlloc(allocator, sizeof(EmbreeNode), 16)) EmbreeNode;
}

void set_children(void* node, void** children, unsigned count, void*)
{
    for (unsigned i = 0; i < count; ++i) {
        static_cast<EmbreeNode*>(node)->children[i] = static_cast<EmbreeNode*>(children[i]);
    }
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*)
{
    for (unsigned i = 0; i < count; ++i) {
        static_cast<EmbreeNode*>(node)->child_bounds[i] = *bounds[i];
    }
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive*, size_t count, void*)
{
    void* leaf = create_node(allocator, 0, nullptr);
    static_cast<EmbreeNode*>(leaf)->boxes = count;
    return leaf;
}

void split_box(const RTCBuildPrimitive* box, unsigned axis, float at, RTCBounds* left,
               RTCBounds* right, void*)
{
    *left = *right = {box->lower_x, box->lower_y, box->lower_z, 0,
                      box->upper_x, box->upper_y, box->upper_z, 0};
    (&left->upper_x)[axis] = at;
    (&right->lower_x)[axis] = at;
}

std::vector<RTCBuildPrimitive> embree_primitives(std::span<const ItemBounds> items)
{
    std::vector<RTCBuildPrimitive> result(items.size());
    for (size_t i = 0; i < items.size(); ++i) {
        const Aabb& b = items[i].box;
        result[i] = {b.min.x, b.min.y, b.min.z, 0,
                     b.max.x, b.max.y, b.max.z, static_cast<unsigned>(i)};
    }
    return result;
}

void build_embree(benchmark::State& state)
{
    const std::vector<ItemBounds> items = random_items(static_cast<size_t>(state.range(0)));
    const std::string config = "threads=" + std::to_string(kThreads);
    const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(
        rtcNewDevice(config.c_str()), rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()),
                                                                  rtcReleaseBVH);
    const std::vector<RTCBuildPrimitive> primitives = embree_primitives(items);
    std::vector<RTCBuildPrimitive> scratch;

    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.byteSize = sizeof(arguments);
    arguments.buildQuality = static_cast<RTCBuildQuality>(state.range(1));
    arguments.maxBranchingFactor = 2;
    arguments.minLeafSize = static_cast<unsigned>(state.range(2)); // smaller leaves are not divided
    arguments.maxLeafSize = static_cast<unsigned>(state.range(2));
    if (arguments.buildQuality ==
        RTC_BUILD_QUALITY_HIGH) { // spatial splits need room, and a callback
        arguments.primitiveArrayCapacity = 2 * primitives.size();
        arguments.splitPrimitive = split_box;
    }
    arguments.bvh = bvh.get();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    const EmbreeNode* root = nullptr;
    for (auto _ : state) {
        scratch.reserve(arguments.primitiveArrayCapacity);
        scratch = primitives; // the build reorders them; our builder copies them too
        arguments.primitives = scratch.data();
        root = static_cast<const EmbreeNode*>(rtcBuildBVH(&arguments));
    }
    if (root == nullptr) {
        state.SkipWithError("Embree built no tree");
        return;
    }
    Aabb scene;
    for (const ItemBounds& item : items) {
        scene = merge(scene, item.box);
    }
    state.counters["sah_cost"] = 1.0 + area_below(*root) / double{surface_area(scene)};
}

BENCHMARK(build_embree)
    ->ArgNames({"boxes", "quality", "leaf"})
    ->ArgsProduct({{10000, 100000, 1000000},
                   {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH},
                   {1, 4}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

#endif

BENCHMARK(build_ours)
    ->ArgNames({"boxes", "leaf"})
    ->ArgsProduct({{10000, 100000, 1000000}, {1, 4}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
} // namespace
} // namespace occlude
