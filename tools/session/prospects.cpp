#include "session/prospects.h"

#include "model/focus.h"
#include "report/table.h"
#include "walk/paths.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::tools {
namespace {

/// Views from a quarter to three quarters of the way through a box, looking ahead.
std::vector<View> flight(const Session& session, const glm::vec3& begin, const glm::vec3& way,
                         size_t frames)
{
    std::vector<Camera> cameras;
    for (size_t i = 0; i < frames; ++i) {
        const float along =
            0.25f + 0.5f * (static_cast<float>(i) + 0.5f) / static_cast<float>(frames);
        Camera camera;
        camera.eye = begin + along * way;
        camera.target = begin + (along + 0.25f) * way;
        camera.up = session.model().up;
        cameras.push_back(camera);
    }
    choose_depth_range(cameras, session.model());
    return session.views(cameras);
}

/// The flight through the middle on which most is visible, of the two level axes and two heights:
/// it does not run inside a wall.
std::vector<View> views_inside(Session& session, size_t frames)
{
    constexpr size_t kProbes = 2;
    const Aabb box = find_focus(session.model()).box;
    const glm::vec3 up = glm::abs(session.model().up);
    const int up_axis = up.x > 0.5f ? 0 : up.y > 0.5f ? 1 : 2;
    std::vector<View> best;
    uint64_t most_seen = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float height : {0.3f, 0.6f}) {
            glm::vec3 begin = box.center();
            begin[up_axis] = box.min[up_axis] + height * box.extent()[up_axis];
            begin[axis] = box.min[axis];
            glm::vec3 way{0.0f};
            way[axis] = box.extent()[axis];
            if (axis == up_axis || !(way[axis] > 0.0f)) {
                continue;
            }
            const std::vector<View> probes = flight(session, begin, way, kProbes);
            const uint64_t seen = sample_occlusion(session, probes, {}).owners;
            if (seen > most_seen) {
                most_seen = seen;
                best = flight(session, begin, way, frames);
            }
        }
    }
    return best;
}

std::vector<View> views_of(const Session& session, const std::string& path, size_t frames)
{
    const auto cameras = session.cameras(path, frames);
    return cameras ? session.views(*cameras) : std::vector<View>{};
}

std::string kinds_that(std::span<const Prospect> prospects, Pays pays)
{
    std::string names;
    for (const Prospect& prospect : prospects) {
        if (prospect.pays == pays) {
            names += (names.empty() ? "" : ", ") + prospect.kind;
        }
    }
    return names;
}

} // namespace

double Occlusion::limit() const
{
    return owner_triangles == 0
               ? 1.0
               : static_cast<double>(triangles) / static_cast<double>(owner_triangles);
}

double Occlusion::triangles_per_frame() const
{
    return static_cast<double>(triangles) / static_cast<double>(std::max<size_t>(frames, 1));
}

double Occlusion::items_per_frame() const
{
    return static_cast<double>(items) / static_cast<double>(std::max<size_t>(frames, 1));
}

Occlusion sample_occlusion(Session& session, std::span<const View> views,
                           const ProgressCallback& progress)
{
    Occlusion sum{.frames = views.size()};
    const Stage stage = session.stage();
    for (size_t frame = 0; frame < views.size(); ++frame) {
        set_frame(stage, frame);
        const std::vector<ItemId> items = items_in_frustum(views[frame], stage.item_bounds);
        const std::vector<ItemId> owners =
            owners_of_pixels(stage.renderer.render_ids(views[frame], items));
        sum.items += items.size();
        sum.owners += owners.size();
        for (const ItemId item : items) {
            sum.triangles += stage.item_bounds[item.value].triangles;
        }
        for (const ItemId item : owners) {
            sum.owner_triangles += stage.item_bounds[item.value].triangles;
        }
        if (progress) {
            progress(static_cast<double>(frame + 1) / static_cast<double>(views.size()));
        }
    }
    return sum;
}

const char* to_string(Pays pays)
{
    switch (pays) {
    case Pays::yes:
        return "yes";
    case Pays::perhaps:
        return "perhaps";
    case Pays::no:
        return "no";
    case Pays::small:
        return "too small";
    case Pays::nothing:
        return "nothing in view";
    case Pays::no_such_path:
        return "no such path";
    }
    return "";
}

Pays judge(const Occlusion& occlusion)
{
    // Below both limits, a whole frame costs less than the tests that could make it cheaper.
    constexpr double kSmallFrame = 50000.0; // triangles
    constexpr double kFewDraws = 1000.0;
    constexpr double kWorthIt = 2.0;
    constexpr double kMaybe = 1.25;
    if (occlusion.owner_triangles == 0) {
        return Pays::nothing;
    }
    if (occlusion.triangles_per_frame() < kSmallFrame && occlusion.items_per_frame() < kFewDraws) {
        return Pays::small;
    }
    return occlusion.limit() >= kWorthIt ? Pays::yes
           : occlusion.limit() >= kMaybe ? Pays::perhaps
                                         : Pays::no;
}

std::string Prospect::sentence() const
{
    if (pays == Pays::no_such_path) {
        return "the scene has no floors or streets to walk on";
    }
    if (pays == Pays::nothing) {
        return "nothing of the scene is in view";
    }
    const auto per_frame = [&](uint64_t count) {
        const uint64_t frames = std::max<uint64_t>(seen.frames, 1);
        return grouped((count + frames / 2) / frames);
    };
    const std::string counts =
        fmt::format("of {} draws and {} triangles in the frustum, {} and {} are seen: at best "
                    "{:.1f} times fewer "
                    "triangles",
                    per_frame(seen.items), per_frame(seen.triangles), per_frame(seen.owners),
                    per_frame(seen.owner_triangles), seen.limit());
    return pays == Pays::small ? counts + ", but so small a frame costs no more than its tests"
                               : counts;
}

std::vector<Prospect> prospects(Session& session, size_t frames, const ProgressCallback& progress)
{
    std::vector<Prospect> all;
    all.push_back({"inside", "flies through the middle of the scene"});
    all.push_back({"street", "walks at eye height"});
    all.push_back({"outside", "circles the scene and looks at it"});
    for (size_t i = 0; i < all.size(); ++i) {
        const std::vector<View> views = i == 0   ? views_inside(session, frames)
                                        : i == 1 ? views_of(session, "walk", frames)
                                                 : views_of(session, "orbit", frames);
        if (!views.empty()) {
            all[i].seen = sample_occlusion(session, views, {});
            all[i].pays = judge(all[i].seen);
        } else if (i != 1) {
            all[i].pays = Pays::nothing;
        }
        if (progress) {
            progress(static_cast<double>(i + 1) / static_cast<double>(all.size()));
        }
    }
    return all;
}

std::string conclusion(std::span<const Prospect> prospects)
{
    const std::string yes = kinds_that(prospects, Pays::yes);
    const std::string perhaps = kinds_that(prospects, Pays::perhaps);
    const std::string no = kinds_that(prospects, Pays::no);
    if (yes.empty() && perhaps.empty() && no.empty() &&
        kinds_that(prospects, Pays::small).empty()) {
        return "Nothing is proven: none of these cameras has anything of the scene in view.";
    }
    if (yes.empty() && perhaps.empty()) {
        return kinds_that(prospects, Pays::small).empty()
                   ? "Use frustum culling alone: such cameras see nearly everything in the frustum."
                   : "Use frustum culling alone: the scene is too small for occlusion culling to "
                     "pay.";
    }
    if (yes.empty()) {
        return fmt::format("Measure before you integrate: 'occlude bench' shows whether the little "
                           "that is hidden ({}) pays for its tests.",
                           perhaps);
    }
    if (no.empty() && perhaps.empty()) {
        return fmt::format("Culling pays ({}). 'occlude bench --algorithms all' shows how much.",
                           yes);
    }
    return fmt::format(
        "Culling pays for some cameras ({}), and less or not at all for others ({}). "
        "The algorithm 'adaptive' decides frame by frame; measure it with 'occlude "
        "bench'.",
        yes,
        perhaps.empty() ? no
        : no.empty()    ? perhaps
                        : perhaps + ", " + no);
}

} // namespace occlude::tools
