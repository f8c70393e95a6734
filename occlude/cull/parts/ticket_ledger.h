// The tickets that a culler has not spent yet, so that none is lost. An unspent ticket counts
// against DeviceCaps::max_outstanding for ever, for every culler on that device (contract C11).
//
// A culler that drops a test (after a reset, a new tree or a draw callback that throws) abandons
// its ticket. At the start of each frame, the ledger polls the abandoned tickets until they are
// answered, and ignores the answers.
#pragma once

#include <occlude/core/query_device.h>

#include <span>
#include <vector>

namespace occlude {

class TicketLedger {
public:
    void issued(std::span<const Ticket> tickets)
    {
        issued_.insert(issued_.end(), tickets.begin(), tickets.end());
    }
    void issued(Ticket ticket) { issued_.push_back(ticket); }
    /// Records that the device answered: the ticket is spent.
    void answered(Ticket ticket) { answered_.push_back(ticket); }

    /// Records that nobody will ask for this ticket.
    void abandon(Ticket ticket);
    /// Records that nobody will ask for any unspent ticket.
    void abandon_all();

    /// Starts a frame on `device`: polls the abandoned tickets. Tickets of another device are
    /// forgotten, because they mean nothing to this one.
    void start_frame(QueryDevice& device);

    /// Waits for the answers of all abandoned tickets. Precondition: they belong to `device`.
    void wait_for_abandoned(QueryDevice& device);

    size_t abandoned_count() const { return abandoned_.size(); }

    /// Tickets that are neither answered nor abandoned. O(n log n) in the tickets of the frame
    /// unless all are answered.
    std::span<const Ticket> unspent();

private:
    void settle();

    const QueryDevice* device_ = nullptr; ///< of the last frame
    std::vector<Ticket> issued_;          ///< may hold tickets that are already answered
    std::vector<Ticket> answered_;
    std::vector<Ticket> abandoned_;
};

} // namespace occlude
