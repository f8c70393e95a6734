// C6: tests over several boxes, boxes with transforms, and the order of tickets.
#include <occlude/conformance/detail/checker.h>

#include <occlude/core/rng.h>

#include <glm/ext/matrix_transform.hpp>

#include <array>

namespace occlude::conformance {

namespace {

const Aabb kWall{{-60.0f, -60.0f, -21.0f}, {60.0f, 60.0f, -20.0f}};
const Aabb kBehind{{-2.0f, -2.0f, -42.0f}, {2.0f, 2.0f, -38.0f}};
const Aabb kFarBehind{{3.0f, -2.0f, -62.0f}, {9.0f, 2.0f, -58.0f}};
const Aabb kInFront{{-1.0f, -1.0f, -11.0f}, {1.0f, 1.0f, -9.0f}};
const Aabb kBeside{{2.0f, -1.0f, -11.0f}, {4.0f, 1.0f, -9.0f}};

void check_union(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({0});
    const Ticket mixed = checker.ask({kBehind, kInFront, kFarBehind});
    const Ticket repeated = checker.ask({kInFront, kInFront, kInFront});
    const Ticket both_hidden = checker.ask({kBehind, kFarBehind});
    const Ticket two = checker.ask({kBeside, kInFront});
    checker.end();
    checker.expect("C6", mixed, Expect::visible, "a visible box between two hidden ones");
    checker.expect("C6", repeated, Expect::visible, "the same visible box three times");
    checker.expect("C6", both_hidden, Expect::hidden, "two hidden boxes");
    checker.expect("C6", two, Expect::visible, "two visible boxes");
}

// Tests of a batch differ in their number of boxes; each answer must reach its own ticket.
void check_tickets_of_batch(Checker& checker)
{
    constexpr uint32_t kTests = 60;
    Rng rng{checker.options().seed};
    checker.begin(checker.view());
    checker.draw({0});
    std::vector<QueryBox> boxes;
    std::vector<uint32_t> ends;
    std::vector<Expect> expected;
    for (uint32_t test = 0; test < kTests; ++test) {
        const bool visible = rng.below(2) == 0;
        const uint32_t count = 1 + rng.below(4);
        for (uint32_t i = 0; i < count; ++i) {
            const bool shows = visible && i == count - 1;
            boxes.push_back({checker.grown(shows ? kInFront : kBehind), nullptr, NodeId{test}});
        }
        ends.push_back(static_cast<uint32_t>(boxes.size()));
        expected.push_back(visible ? Expect::visible : Expect::hidden);
    }
    const std::vector<Ticket> tickets = checker.ask(boxes, ends);
    checker.end();
    for (uint32_t test = 0; test < kTests; ++test) {
        checker.expect("C6", tickets[test], expected[test],
                       "test " + std::to_string(test) + " of a batch of 60");
    }
}

void check_transforms(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({0});
    const Aabb unit{glm::vec3{-1.0f}, glm::vec3{1.0f}};
    const glm::mat4 one{1.0f};
    const glm::vec3 axis{0.6f, 0.0f, 0.8f};
    const std::array world_from_box{
        glm::rotate(glm::translate(one, {0.0f, 0.0f, -10.0f}), 0.7f, axis),
        glm::scale(glm::translate(one, {0.0f, 0.0f, -10.0f}), {-1.5f, 1.0f, 0.5f}), // mirrored
        glm::rotate(glm::translate(one, {0.0f, 0.0f, -40.0f}), 0.7f, axis),
        glm::scale(glm::translate(one, {0.0f, 0.0f, -40.0f}), {1.0f, -2.0f, 1.0f}),
    };
    std::vector<QueryBox> boxes;
    std::vector<uint32_t> ends;
    for (const glm::mat4& matrix : world_from_box) {
        boxes.push_back({unit, &matrix, NodeId{boxes.size()}});
        ends.push_back(static_cast<uint32_t>(boxes.size()));
    }
    const std::vector<Ticket> tickets = checker.ask(boxes, ends);
    checker.end();
    for (size_t i = 0; i < tickets.size(); ++i) {
        checker.expect("C6", tickets[i], i < 2 ? Expect::visible : Expect::hidden,
                       std::string{"a box with a "} + (i % 2 == 0 ? "rotating" : "mirroring") +
                           " transform " + (i < 2 ? "before" : "behind") + " the wall");
    }
}

void check_empty_calls(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({});
    checker.ask(std::span<const QueryBox>{}, std::span<const uint32_t>{});
    checker.draw({0});
    const Ticket ticket = checker.ask({kInFront});
    checker.end();
    checker.expect("C6", ticket, Expect::visible, "a box tested after a batch without tests");
}

} // namespace

void check_unions(Checker& checker)
{
    checker.host().set_items(std::array{kWall});
    check_union(checker);
    check_tickets_of_batch(checker);
    check_transforms(checker);
    check_empty_calls(checker);
}

} // namespace occlude::conformance
