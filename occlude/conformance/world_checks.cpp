// C3, read_depth and read_depth_tiles over random worlds, against rays.
#include <occlude/conformance/detail/checker.h>
#include <occlude/conformance/detail/ray_world.h>

#include <occlude/core/rng.h>
#include <occlude/screen/depth_tiles.h>

#include <glm/geometric.hpp>

#include <algorithm>

namespace occlude::conformance {

namespace {

constexpr size_t kBoxes = 24;
// As a share of the depth range: rounding in a device, and the slope of a face within a pixel
// beyond the span of the probes.
constexpr double kDepthSlop = 2e-4;

glm::vec3 random_point(Rng& rng, float extent)
{
    const float x = rng.range(-extent, extent);
    const float y = rng.range(-extent, extent);
    const float z = rng.range(-extent, extent);
    return {x, y, z};
}

/// Blocks, plates and needles around the origin.
std::vector<Aabb> random_world(Rng& rng)
{
    std::vector<Aabb> boxes;
    for (size_t i = 0; i < kBoxes; ++i) {
        const glm::vec3 center = random_point(rng, 18.0f);
        glm::vec3 half{rng.range(0.5f, 6.0f), rng.range(0.5f, 6.0f), rng.range(0.5f, 6.0f)};
        if (rng.below(3) == 0) {
            half[static_cast<int>(rng.below(3))] *= 0.02f;
        }
        boxes.push_back({center - half, center + half});
    }
    return boxes;
}

View random_view(Checker& checker, Rng& rng)
{
    glm::vec3 eye = random_point(rng, 1.0f);
    eye = 26.0f * glm::normalize(eye + glm::vec3{0.01f, 0.02f, 0.03f});
    const glm::vec3 target = random_point(rng, 6.0f);
    return checker.view(eye, glm::normalize(target - eye));
}

// Compares tiles with the pixels that were read: a tile is never nearer than one of its pixels, and
// at most one step of a coarse depth buffer farther.
void check_tiles(Checker& checker, const std::vector<float>& depth, glm::ivec2 size,
                 const std::string& world)
{
    for (const DepthReadCost& cost : checker.device().caps().depth_reads) {
        if (cost.tile_px <= 1) {
            continue;
        }
        std::vector<float> tiles(pixel_count(tiles_in(size, cost.tile_px)));
        std::vector<float> farthest(tiles.size());
        farthest_of_tiles(depth, size, cost.tile_px, farthest);
        const std::string where = world + ": tiles of " + std::to_string(cost.tile_px) + " pixels";
        if (!checker.device().read_depth_tiles(cost.tile_px, tiles)) {
            checker.check("read_depth_tiles", checker.options().may_lose_answers,
                          where + ": caps list them, and reading them failed");
            continue;
        }
        for (size_t i = 0; i < tiles.size(); ++i) {
            const auto tile = double{tiles[i]};
            const auto pixels = double{farthest[i]};
            checker.check("read_depth_tiles", tile >= pixels && tile <= pixels + kDepthSlop,
                          where + ": tile " + std::to_string(i) + " has depth " +
                              std::to_string(tile) + ", the farthest of its pixels " +
                              std::to_string(pixels));
        }
    }
}

void check_depth(Checker& checker, const RayCamera& camera, std::span<const Aabb> boxes,
                 std::span<const size_t> drawn, const std::string& world)
{
    const glm::ivec2 size = camera.size_px();
    std::vector<float> depth(static_cast<size_t>(size.x * size.y), -1.0f);
    if (!checker.device().caps().read_depth) {
        return;
    }
    if (!checker.device().read_depth({0, 0, size.x, size.y}, depth)) {
        const bool untouched =
            std::all_of(depth.begin(), depth.end(), [](float d) { return d == -1.0f; });
        checker.check("read_depth", untouched, world + ": it failed and changed its output");
        checker.check("useful", checker.options().may_lose_answers, world + ": read_depth failed");
        return;
    }
    check_tiles(checker, depth, size, world);
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            double nearest = 1.0;
            double farthest = 0.0;
            size_t item = 0;
            bool agree = true;
            const auto points = probes(x, y);
            for (size_t i = 0; i < points.size(); ++i) {
                const Ray ray = camera.through(points[i]);
                const Hit hit = first_hit(ray, boxes, drawn);
                const double d = hit.item == kNothing
                                     ? 1.0
                                     : camera.depth01(ray.origin + hit.at * ray.direction);
                nearest = std::min(nearest, d);
                farthest = std::max(farthest, d);
                agree = agree && (i == 0 || hit.item == item);
                item = hit.item;
            }
            if (!agree) {
                continue;
            }
            const double read = static_cast<double>(depth[static_cast<size_t>(y * size.x + x)]);
            ++checker.report().depths_compared;
            checker.check("read_depth",
                          read >= nearest - kDepthSlop && (checker.options().depth_may_be_farther ||
                                                           read <= farthest + kDepthSlop),
                          world + ": pixel " + std::to_string(x) + ", " + std::to_string(y) +
                              " has depth " + std::to_string(read) + ", rays say " +
                              std::to_string(nearest) + " to " + std::to_string(farthest));
        }
    }
}

void check_world(Checker& checker, uint64_t seed)
{
    const std::string world = "world " + std::to_string(seed);
    Rng rng{seed};
    const std::vector<Aabb> boxes = random_world(rng);
    const View view = random_view(checker, rng);
    const RayCamera camera{view};
    checker.host().set_items(boxes);

    // Draws half of the world in two calls, and tests everything after each.
    std::vector<size_t> drawn;
    std::vector<Ticket> tickets;
    std::vector<Expect> expected;
    checker.begin(view);
    for (int round = 0; round < 2; ++round) {
        std::vector<ItemId> now;
        for (size_t i = 0; i < kBoxes / 4; ++i) {
            const size_t item = drawn.size() * 2 + rng.below(2);
            drawn.push_back(item);
            now.push_back(ItemId{item});
        }
        checker.device().draw(now, DrawPass::shade);
        std::vector<Aabb> tested;
        for (const Aabb& box : boxes) {
            const bool may_be_tested = view.frustum().classify(box) != Containment::outside &&
                                       !view.touches_near(checker.grown(box));
            if (may_be_tested) {
                tested.push_back(box);
                expected.push_back(surely_visible(camera, box, boxes, drawn) ? Expect::visible
                                                                             : Expect::nothing);
            }
        }
        const std::vector<Ticket> more = checker.ask_each(tested);
        tickets.insert(tickets.end(), more.begin(), more.end());
    }
    check_depth(checker, camera, boxes, drawn, world);
    checker.device().flush();
    checker.end();
    for (size_t i = 0; i < tickets.size(); ++i) {
        checker.expect("C3", tickets[i], expected[i], world + ", test " + std::to_string(i));
    }
}

} // namespace

void check_worlds(Checker& checker)
{
    for (uint32_t i = 0; i < checker.options().worlds; ++i) {
        check_world(checker, hash64(checker.options().seed, i) % 1000000);
    }
}

} // namespace occlude::conformance
