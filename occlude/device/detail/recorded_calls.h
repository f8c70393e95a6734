// The byte form of calls, for recording and comparing them. Internal.
#pragma once

#include <occlude/device/recording.h>

#include <span>
#include <string>

namespace occlude::detail {

/// The input of a call, and caps, as bytes: equal exactly if the calls or the caps are equal.
std::string question_bytes(const RecordedCall& call);
std::string caps_bytes(const DeviceCaps& caps);

inline RecordedCall call_of(DeviceVerb verb)
{
    RecordedCall call;
    call.verb = verb;
    return call;
}

inline RecordedCall frame_call(const View& view)
{
    RecordedCall call = call_of(DeviceVerb::begin_frame);
    call.clip_from_world = view.clip_from_world();
    call.clip_from_relative = view.clip_from_relative();
    call.origin = view.origin();
    call.size_px = view.size_px();
    call.convention = view.convention();
    call.view_options = view.options();
    return call;
}

inline RecordedCall draw_call(DeviceVerb verb, std::span<const ItemId> items, DrawPass pass)
{
    RecordedCall call = call_of(verb);
    call.items.assign(items.begin(), items.end());
    call.pass = pass;
    return call;
}

inline RecordedCall query_call(const QueryBatch& batch)
{
    RecordedCall call = call_of(DeviceVerb::query);
    call.method = batch.method;
    for (const QueryBox& box : batch.boxes) {
        RecordedBox& recorded = call.boxes.emplace_back();
        recorded.box = box.box;
        recorded.subject = box.subject;
        if (box.world_from_box) {
            recorded.world_from_box = *box.world_from_box;
        }
    }
    call.test_ends.assign(batch.test_ends.begin(), batch.test_ends.end());
    return call;
}

inline RecordedCall depth_call(const PixelRect& rect)
{
    RecordedCall call = call_of(DeviceVerb::read_depth);
    call.rect = rect;
    return call;
}

inline RecordedCall tiles_call(int tile_px)
{
    RecordedCall call = call_of(DeviceVerb::read_depth_tiles);
    call.tile_px = tile_px;
    return call;
}

} // namespace occlude::detail
