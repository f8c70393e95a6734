#include <occlude/cull/batch_and_wait.h>

#include <algorithm>

namespace occlude {

// 29.3.2: an occluder is large on the screen, "a tall wall or a big building".
bool BatchAndWait::is_occluder(const CullFrame& frame, NodeId node) const
{
    return options_.occluder_share <= 1.0f &&
           screen_share(frame.view(), hierarchy().node(node).box) >= options_.occluder_share;
}

void BatchAndWait::test_batch(CullFrame& frame, std::span<const ObjectTests::Object> objects)
{
    batch_.clear();
    for (const ObjectTests::Object& object : objects) {
        tests_.add_test(frame, object.node, batch_);
    }
    frame.query(batch_, tickets_);
}

void BatchAndWait::handle_results(CullFrame& frame, std::span<const ObjectTests::Object> objects)
{
    for (size_t i = 0; i < objects.size(); ++i) {
        if (is_visible(frame.wait(tickets_[i]), options_.threshold)) {
            frame.draw_leaf(objects[i].node, objects[i].mask, Decision::drawn_revealed);
        } else {
            frame.decide(objects[i].node, Decision::hidden);
        }
    }
}

void BatchAndWait::cull_frame(CullFrame& frame)
{
    if (options_.depth_only_pass) {
        frame.use_depth_only_pass();
    }
    // Untested objects are drawn first, because they hide others.
    tested_.clear();
    for (const ObjectTests::Object& object : tests_.collect_near_to_far(frame)) {
        if (frame.near(object.node)) {
            frame.draw_leaf(object.node, object.mask, Decision::drawn_near);
        } else if (!tests_.worth_testing(frame, object.node) || is_occluder(frame, object.node)) {
            frame.draw_leaf(object.node, object.mask, Decision::drawn);
        } else {
            tested_.push_back(object);
        }
    }

    const uint32_t most = std::max(frame.caps().max_outstanding, 1u);
    const size_t n = options_.batch_size > 0 ? std::min(options_.batch_size, most) : most;
    for (std::span<const ObjectTests::Object> left{tested_}; !left.empty();) {
        const auto objects = left.first(std::min(n, left.size()));
        frame.flush_draws();
        test_batch(frame, objects);
        handle_results(frame, objects);
        left = left.subspan(objects.size());
    }
}

} // namespace occlude
