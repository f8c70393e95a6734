// The verbs of a QueryDevice that change or ask something, for devices that keep a list of calls.
#pragma once

#include <cstdint>

namespace occlude {

enum class DeviceVerb : uint8_t {
    begin_frame,
    draw,
    query,
    draw_and_query,
    flush,
    poll,
    wait,
    read_depth,
    end_frame,
    read_depth_tiles, ///< recordings store the numbers, so that new verbs must come last
};

/// "begin_frame", "draw", ...
constexpr const char* name(DeviceVerb verb)
{
    switch (verb) {
    case DeviceVerb::begin_frame:
        return "begin_frame";
    case DeviceVerb::draw:
        return "draw";
    case DeviceVerb::query:
        return "query";
    case DeviceVerb::draw_and_query:
        return "draw_and_query";
    case DeviceVerb::flush:
        return "flush";
    case DeviceVerb::poll:
        return "poll";
    case DeviceVerb::wait:
        return "wait";
    case DeviceVerb::read_depth:
        return "read_depth";
    case DeviceVerb::read_depth_tiles:
        return "read_depth_tiles";
    case DeviceVerb::end_frame:
        break;
    }
    return "end_frame";
}

} // namespace occlude
