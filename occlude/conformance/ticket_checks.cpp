// C7, C8, C9, C11 and C12: the meaning and the lifetime of a ticket.
#include <occlude/conformance/detail/checker.h>

#include <algorithm>
#include <array>

namespace occlude::conformance {

namespace {

const Aabb kWall{{-60.0f, -60.0f, -21.0f}, {60.0f, 60.0f, -20.0f}};
const Aabb kBehind{{-2.0f, -2.0f, -42.0f}, {2.0f, 2.0f, -38.0f}};
const Aabb kInFront{{-1.0f, -1.0f, -11.0f}, {1.0f, 1.0f, -9.0f}};

// C11 is checked only for devices with fewer tickets than this, which can run out.
constexpr uint32_t kMostTickets = 20000;
constexpr size_t kBatch = 64;

void check_spent(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({0});
    const Ticket first = checker.ask({kBehind});
    const Ticket second = checker.ask({kBehind});
    checker.end();
    checker.check("C7", !(first == second) || !first.valid(), "two tests share a ticket");
    checker.expect("C7", first, Expect::hidden, "a box behind a wall");
    checker.expect_lost("C7", checker.device().poll(first), "a spent ticket, polled");
    checker.expect_lost("C7", checker.device().wait(first), "a spent ticket, waited for");
    checker.expect("C7", second, Expect::hidden, "a test beside a spent one");

    // A new owner of the slot must neither answer for the old one nor be spent by a request for it.
    checker.begin(checker.view());
    checker.draw({0});
    const Ticket reused = checker.ask({kBehind});
    checker.end();
    checker.expect_lost("C7", checker.device().poll(first), "a spent ticket whose slot is reused");
    checker.expect_lost("C7", checker.device().wait(second), "another spent ticket");
    checker.expect("C7", reused, Expect::hidden, "the new owner of a slot");
}

void check_foreign(Checker& checker)
{
    constexpr std::array kForeign{Ticket{}, Ticket{0, 0xfffffff0u}, Ticket{0x00ffffffu, 1},
                                  Ticket{0xfffffffeu, 3}};
    for (const Ticket& ticket : kForeign) {
        checker.expect_lost("C7", checker.device().poll(ticket), "an invented ticket, polled");
        checker.expect_lost("C7", checker.device().wait(ticket), "an invented ticket, waited for");
    }
}

// A frame ends; others with another camera and without draws follow; and only then the answers are
// collected, the last first.
void check_later_frames(Checker& checker)
{
    checker.begin(checker.view());
    checker.draw({0});
    const Ticket behind = checker.ask({kBehind});
    const Ticket in_front = checker.ask({kInFront});
    checker.device().flush();
    checker.end();
    for (int frame = 0; frame < 3; ++frame) {
        checker.begin(checker.view({0.0f, 3.0f, 0.0f}, {1.0f, 0.0f, 0.0f}));
        checker.end();
    }
    checker.expect("C12", in_front, Expect::visible, "a box that was visible three frames ago");
    checker.expect("C12", behind, Expect::hidden, "a box that was hidden three frames ago");
}

// Takes all tickets and one more, and then some again after collecting the answers.
void check_most_outstanding(Checker& checker)
{
    const uint32_t most = checker.device().caps().max_outstanding;
    if (most == 0 || most > kMostTickets) {
        return;
    }
    std::vector<Ticket> tickets;
    checker.begin(checker.view());
    checker.draw({0});
    while (tickets.size() < most) {
        const std::vector<Aabb> boxes(std::min<size_t>(kBatch, most - tickets.size()), kInFront);
        const std::vector<Ticket> more = checker.ask_each(boxes);
        tickets.insert(tickets.end(), more.begin(), more.end());
    }
    const Ticket beyond = checker.ask({kBehind});
    checker.device().flush();
    checker.expect_lost("C11", checker.device().poll(beyond), "a test beyond max_outstanding");
    checker.end();
    for (const Ticket& ticket : tickets) {
        checker.expect("C11", ticket, Expect::visible, "one of max_outstanding tests");
    }
    checker.begin(checker.view());
    checker.draw({0});
    const Ticket after = checker.ask({kBehind});
    checker.end();
    checker.expect("C11", after, Expect::hidden, "a test after all tickets were collected");
}

} // namespace

void check_tickets(Checker& checker)
{
    checker.host().set_items(std::array{kWall});
    check_spent(checker);
    check_foreign(checker);
    check_later_frames(checker);
    check_most_outstanding(checker);
}

} // namespace occlude::conformance
