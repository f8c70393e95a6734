// A device without any cost: it draws nothing, and answers each test from visible sets that were
// computed before. The time of a frame on it is the culler's own.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/hierarchy/hierarchy.h>

#include "city_boxes.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <span>
#include <vector>

namespace occlude::bench {

/// Up to eight views, each with its visible set. A test of a node is answered at once: is anything
/// in its subtree visible? Depth is that of the whole scene, so that it is right after any draw.
class OracleDevice final : public QueryDevice {
public:
    OracleDevice(const Hierarchy& hierarchy, std::span<const Truth> truths)
        : truths_(truths)
        , visible_in_(hierarchy.nodes().size(), 0)
    {
        caps_.name = "oracle";
        caps_.read_depth = true;
        caps_.samples_at_pixel_centers = true;
        caps_.max_outstanding = ~0u;
        for (size_t i = 0; i < truths.size(); ++i) {
            const std::vector<uint32_t>& visible = truths[i].visible;
            for (size_t n = 0; n < visible_in_.size(); ++n) {
                const Node& node = hierarchy.nodes()[n];
                const auto first =
                    std::lower_bound(visible.begin(), visible.end(), node.first_item);
                if (first != visible.end() && *first < node.first_item + node.subtree_items) {
                    visible_in_[n] = static_cast<uint8_t>(visible_in_[n] | 1u << i);
                }
            }
        }
    }

    /// Sets the view whose visible set answers the next frames.
    void look(size_t truth) { now_ = truth; }

    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View&) override { answers_.clear(); }
    void draw(std::span<const ItemId>, DrawPass) override {}
    void flush() override {}
    void end_frame() override {}

    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        uint32_t box = 0;
        for (size_t test = 0; test < tickets.size(); ++test) {
            bool visible = false;
            for (; box < batch.test_ends[test]; ++box) {
                visible =
                    visible || (visible_in_[batch.boxes[box].subject.value] >> now_ & 1u) != 0;
            }
            tickets[test] = Ticket{static_cast<uint32_t>(answers_.size()), 1};
            answers_.push_back(visible ? 1 : 0);
        }
    }
    Answer poll(Ticket ticket) override { return Answer::ready(answers_[ticket.index]); }
    Answer wait(Ticket ticket) override { return poll(ticket); }

    bool read_depth(const PixelRect&, std::span<float> out) override
    {
        const std::clock_t from = std::clock();
        const std::vector<float>& depth = truths_[now_].depth;
        std::memcpy(out.data(), depth.data(), out.size() * sizeof(float));
        reading_ += std::clock() - from;
        return true;
    }

    /// Processor time that copies of depth have taken so far. It does not count as the culler's.
    std::clock_t reading() const { return reading_; }

private:
    DeviceCaps caps_;
    std::span<const Truth> truths_;
    std::vector<uint8_t> visible_in_; // per node: bit i if something below is visible in truth i
    std::vector<uint8_t> answers_;
    std::clock_t reading_ = 0;
    size_t now_ = 0;
};

} // namespace occlude::bench
