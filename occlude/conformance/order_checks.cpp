// C2 and C4, the passes, draw_and_query: what a test sees, and what it must not change.
#include <occlude/conformance/detail/checker.h>

#include <array>

namespace occlude::conformance {

namespace {

// Item 0 is a wall over the whole image, item 1 a nearer one; both hide everything behind them.
const Aabb kWall{{-60.0f, -60.0f, -21.0f}, {60.0f, 60.0f, -20.0f}};
const Aabb kNearWall{{-60.0f, -60.0f, -5.0f}, {60.0f, 60.0f, -4.0f}};
const Aabb kBehind{{-2.0f, -2.0f, -42.0f}, {2.0f, 2.0f, -38.0f}}; // behind both walls
const Aabb kBetween{{-1.0f, -1.0f, -11.0f}, {1.0f, 1.0f, -9.0f}}; // between the walls
const Aabb kInFront{{-0.5f, -0.5f, -2.5f}, {0.5f, 0.5f, -1.5f}};  // before both

void check_draw_order(Checker& checker)
{
    checker.begin(checker.view());
    const Ticket before = checker.ask({kBehind});
    checker.draw({0});
    const Ticket behind = checker.ask({kBehind});
    const Ticket between = checker.ask({kBetween});
    checker.draw({1});
    const Ticket between_walls = checker.ask({kBetween});
    const Ticket in_front = checker.ask({kInFront});
    checker.device().flush();
    checker.end();
    checker.expect("C2", before, Expect::visible, "a box tested before anything was drawn");
    checker.expect("C2", behind, Expect::hidden, "a box tested after the wall before it was drawn");
    checker.expect("C2", between, Expect::visible,
                   "a box tested before the wall in front of it was drawn");
    checker.expect("C2", between_walls, Expect::hidden, "the same box after that wall was drawn");
    checker.expect("C2", in_front, Expect::visible, "a box in front of everything");
}

void check_cleared(Checker& checker)
{
    checker.begin(checker.view());
    const Ticket ticket = checker.ask({kBehind});
    checker.end();
    checker.expect("C2", ticket, Expect::visible,
                   "a box tested in a frame that draws nothing, after one that drew a wall");
}

// A test of the near wall's box must not affect later tests.
void check_nothing_written(Checker& checker)
{
    const glm::ivec2 size = checker.host().size_px();
    const PixelRect all{0, 0, size.x, size.y};
    std::vector<float> before(static_cast<size_t>(size.x * size.y));
    std::vector<float> after = before;
    checker.begin(checker.view());
    checker.draw({0});
    const bool reads = checker.device().caps().read_depth;
    const bool read_before = reads && checker.device().read_depth(all, before);
    const Ticket tested = checker.ask({kNearWall});
    const bool read_after = reads && checker.device().read_depth(all, after);
    checker.check("C4", !read_before || !read_after || before == after, "a test changed depth");
    const Ticket between = checker.ask({kBetween});
    checker.end();
    checker.expect("C4", tested, Expect::visible, "a box over the whole image, in front");
    checker.expect("C4", between, Expect::visible, "a box behind another box that was only tested");
}

void check_passes(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({0}, DrawPass::depth_only);
    const Ticket behind = checker.ask({kBehind});
    const Ticket between = checker.ask({kBetween});
    checker.draw({0}, DrawPass::shade_equal);
    const Ticket behind_shaded = checker.ask({kBehind});
    checker.end();
    checker.expect("passes", behind, Expect::hidden, "a box behind a wall drawn depth_only");
    checker.expect("passes", between, Expect::visible, "a box before a wall drawn depth_only");
    checker.expect("passes", behind_shaded, Expect::hidden,
                   "a box behind a wall drawn depth_only and shade_equal");
}

void check_draw_and_query(Checker& checker)
{
    const std::array wall{ItemId{0u}};
    const std::array near_wall{ItemId{1u}};
    checker.begin(checker.view());
    const Ticket near = checker.device().draw_and_query(near_wall, DrawPass::shade);
    const Ticket hidden = checker.device().draw_and_query(wall, DrawPass::shade);
    const Ticket between = checker.ask({kBetween});
    checker.end();
    if (checker.device().caps().draw_and_query) {
        checker.expect("draw_and_query", near, Expect::visible, "a wall drawn with draw_and_query");
        checker.expect("draw_and_query", hidden, Expect::hidden,
                       "a wall drawn with draw_and_query behind another");
    } else {
        checker.expect_lost("draw_and_query", checker.resolve(near),
                            "draw_and_query of a device without that verb");
        checker.resolve(hidden);
    }
    checker.expect("draw_and_query", between, Expect::hidden,
                   "a box behind a wall drawn with draw_and_query");
}

} // namespace

void check_order(Checker& checker)
{
    checker.host().set_items(std::array{kWall, kNearWall});
    check_draw_order(checker);
    check_cleared(checker);
    check_nothing_written(checker);
    check_passes(checker);
    check_draw_and_query(checker);
}

} // namespace occlude::conformance
