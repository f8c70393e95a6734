#include "view_culler.h"

#include <osg/Camera>

#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <utility>

namespace occlude {

namespace {

glm::dmat4 to_glm(const osg::Matrixd& matrix)
{
    return glm::make_mat4(matrix.ptr()); // row vectors in rows: the same sixteen numbers
}

} // namespace

ViewCuller::ViewCuller(const OsgCullingOptions& options)
    : options_(options)
    , culler_(scene_, items_.hierarchy(), options.algorithm, options.on_message, "osg.no_culling")
{
}

void ViewCuller::draw(osg::RenderInfo& info, osgUtil::RenderLeaf& proxy, const LeafFrame& frame)
{
    renderer_.start(info, proxy);
    collect(frame);
    choose_segment();
    place_items(frame, proxy._projection.get());
    stats_.leaves = frame_.leaves.size();
    stats_.exempt_leaves = frame_.leaves.size() - frame_.testable.size();
    stats_.hidden_leaves = 0;
    stats_.unknown_leaves = 0;
    draw_plain(0, frame_.segment_begin);
    if (frame_.testable.size() >= options_.min_leaves && culler_.prepare()) {
        cull(frame, info);
    } else {
        stats_.report = {};
        draw_plain(frame_.segment_begin, frame_.segment_end);
    }
    draw_plain(frame_.segment_end, frame_.leaves.size());
    renderer_.finish(proxy);
}

// Lists all leaves in the order in which the engine would draw them.
void ViewCuller::collect(const LeafFrame& frame)
{
    frame_.leaves.clear();
    frame_.kinds.clear();
    state_kinds_.begin_frame(*frame.viewport);
    for (const osgUtil::StateGraph* graph : frame.graphs) {
        const LeafKind of_state = state_kinds_.kind_of(*graph);
        for (const osg::ref_ptr<osgUtil::RenderLeaf>& leaf : graph->_leaves) {
            leaf->_dynamic = false; // the proxy counts for all of them
            frame_.leaves.push_back(leaf.get());
            frame_.kinds.push_back(of_state == LeafKind::ordered
                                       ? of_state
                                       : stricter(of_state, kind_of(*leaf->_drawable)));
        }
    }
}

// Leaves that depend on the order part the others into segments; the longest one is culled.
void ViewCuller::choose_segment()
{
    frame_.segment_begin = frame_.segment_end = 0;
    size_t begin = 0;
    for (size_t place = 0; place <= frame_.kinds.size(); ++place) {
        if (place < frame_.kinds.size() && frame_.kinds[place] != LeafKind::ordered) {
            continue;
        }
        if (place - begin > frame_.segment_end - frame_.segment_begin) {
            frame_.segment_begin = begin;
            frame_.segment_end = place;
        }
        begin = place + 1;
    }
}

// Lists the leaves that can be tested, and where they are in the world.
void ViewCuller::place_items(const LeafFrame& frame, const osg::RefMatrix* projection)
{
    frame_.testable.clear();
    frame_.poses.clear();
    const glm::dmat4 world_from_eye = glm::inverse(to_glm(frame.eye_from_world));
    const osg::RefMatrix* last = nullptr;
    glm::dmat4 world_from_model{1.0};
    for (size_t place = frame_.segment_begin; place < frame_.segment_end; ++place) {
        const osgUtil::RenderLeaf& leaf = *frame_.leaves[place];
        // Another projection: another camera than the view's.
        if (frame_.kinds[place] != LeafKind::testable || leaf._projection != projection) {
            continue;
        }
        if (leaf._modelview.get() != last) {
            last = leaf._modelview.get();
            world_from_model = world_from_eye * to_glm(*last);
        }
        frame_.testable.push_back(static_cast<uint32_t>(place));
        frame_.poses.push_back({leaf._drawable.get(), world_from_model});
    }
}

void ViewCuller::draw_plain(size_t begin, size_t end)
{
    for (size_t place = begin; place < end; ++place) {
        renderer_.render(*frame_.leaves[place]);
    }
}

void ViewCuller::cull(const LeafFrame& frame, osg::RenderInfo& info)
{
    items_.expect(frame.expected);
    items_.update(frame_.poses, frame_.ids);
    frame_.place_of_item.assign(items_.size(), LeafScene::kNotThere);
    frame_.first.clear();
    size_t next = 0;
    for (size_t place = frame_.segment_begin; place < frame_.segment_end; ++place) {
        const bool testable = next < frame_.testable.size() && frame_.testable[next] == place;
        const ItemId item = testable ? frame_.ids[next++] : ItemId{};
        if (item.valid() && items_.in_hierarchy(item)) {
            frame_.place_of_item[item.value] = static_cast<uint32_t>(place);
        } else {
            frame_.first.push_back(static_cast<uint32_t>(place));
            stats_.unknown_leaves += testable ? 1 : 0;
        }
    }
    scene_.set_frame(renderer_, frame_.leaves, frame_.first, frame_.place_of_item);

    const osg::RefMatrix& projection = *frame_.leaves[frame_.testable.front()]->_projection;
    const glm::dmat4 clip_from_world = to_glm(projection) * to_glm(frame.eye_from_world);
    const osg::Viewport& viewport = *frame.viewport;
    ViewOptions options;
    options.viewport_origin_px = {static_cast<int>(viewport.x()), static_cast<int>(viewport.y())};
    const glm::ivec2 size{static_cast<int>(viewport.width()), static_cast<int>(viewport.height())};
    const View view = View::from_clip(glm::mat4{clip_from_world}, size, {}, options);

    stats_.report = culler_.cull(view);
    const std::span<const ItemId> drawn = culler_.drawn_items();
    const auto here = std::ranges::count_if(drawn, [&](ItemId item) {
        return frame_.place_of_item[item.value] != LeafScene::kNotThere;
    });
    stats_.hidden_leaves =
        frame_.testable.size() - stats_.unknown_leaves - static_cast<size_t>(here);
    stats_.moved_leaves = items_.moved();
    stats_.rebuilds = items_.rebuilds();
    if (info.getState()->getAbortRendering()) {
        culler_.forget();
    }
}

} // namespace occlude
