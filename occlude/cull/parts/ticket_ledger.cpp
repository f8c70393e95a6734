#include <occlude/cull/parts/ticket_ledger.h>

#include <algorithm>

namespace occlude {

// Takes the answered tickets out of the issued ones.
void TicketLedger::settle()
{
    if (issued_.size() == answered_.size()) { // the usual case: each is answered once
        issued_.clear();
    } else if (!answered_.empty()) {
        std::sort(answered_.begin(), answered_.end());
        std::erase_if(issued_, [&](Ticket ticket) {
            return std::binary_search(answered_.begin(), answered_.end(), ticket);
        });
    }
    answered_.clear();
}

void TicketLedger::abandon(Ticket ticket)
{
    settle();
    const auto found = std::find(issued_.begin(), issued_.end(), ticket);
    if (found != issued_.end()) { // otherwise it is spent already
        issued_.erase(found);
        abandoned_.push_back(ticket);
    }
}

void TicketLedger::abandon_all()
{
    settle();
    abandoned_.insert(abandoned_.end(), issued_.begin(), issued_.end());
    issued_.clear();
}

void TicketLedger::start_frame(QueryDevice& device)
{
    settle();
    if (device_ != &device) {
        device_ = &device;
        abandoned_.clear();
    }
    std::erase_if(abandoned_,
                  [&](Ticket ticket) { return device.poll(ticket).state != AnswerState::pending; });
}

void TicketLedger::wait_for_abandoned(QueryDevice& device)
{
    for (const Ticket ticket : abandoned_) {
        device.wait(ticket);
    }
    abandoned_.clear();
}

std::span<const Ticket> TicketLedger::unspent()
{
    settle();
    return issued_;
}

} // namespace occlude
