// Helpers for the tests of the devices: a camera, boxes in front of it, and calls in one line.
#pragma once

#include <occlude/core/query_device.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <array>
#include <initializer_list>
#include <vector>

namespace occlude::test {

/// 64x64 pixels from the origin along -z; the near plane is at z = -1.
inline View camera()
{
    return View::from_clip(glm::perspective(glm::radians(90.0f), 1.0f, 1.0f, 100.0f), {64, 64});
}

/// A unit cube around (0, 0, -10).
inline QueryBox box_of(uint32_t subject)
{
    const glm::vec3 center{0.0f, 0.0f, -10.0f};
    return {Aabb{center - 0.5f, center + 0.5f}, nullptr, NodeId{subject}};
}

inline Ticket ask(QueryDevice& device, std::span<const QueryBox> boxes)
{
    const std::array ends{static_cast<uint32_t>(boxes.size())};
    Ticket ticket;
    device.query({boxes, ends}, std::span{&ticket, 1});
    return ticket;
}

/// One test over the boxes of these subjects.
inline Ticket ask(QueryDevice& device, std::initializer_list<uint32_t> subjects)
{
    std::vector<QueryBox> boxes;
    for (const uint32_t subject : subjects) {
        boxes.push_back(box_of(subject));
    }
    return ask(device, boxes);
}

/// One batch: a test for each list of subjects.
inline std::vector<Ticket> ask_batch(QueryDevice& device,
                                     std::initializer_list<std::initializer_list<uint32_t>> tests)
{
    std::vector<QueryBox> boxes;
    std::vector<uint32_t> ends;
    for (const auto& subjects : tests) {
        for (const uint32_t subject : subjects) {
            boxes.push_back(box_of(subject));
        }
        ends.push_back(static_cast<uint32_t>(boxes.size()));
    }
    std::vector<Ticket> tickets(ends.size());
    device.query({boxes, ends}, tickets);
    return tickets;
}

inline std::vector<ItemId> items(std::initializer_list<uint32_t> values)
{
    std::vector<ItemId> ids;
    for (const uint32_t value : values) {
        ids.push_back(ItemId{value});
    }
    return ids;
}

inline void draw(QueryDevice& device, std::initializer_list<uint32_t> values,
                 DrawPass pass = DrawPass::shade)
{
    device.draw(items(values), pass);
}

} // namespace occlude::test
