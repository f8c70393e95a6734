// A decorator that measures lens flares at both ends of each frame, for a culler that draws the
// whole frame and knows nothing of flares.
#pragma once

#include <occlude/device/forwarding_device.h>
#include <occlude/effects/flare_visibility.h>

namespace occlude {

class FlareDevice final : public ForwardingDevice {
public:
    /// Keeps references: `inner` and `flares` must outlive this device.
    FlareDevice(QueryDevice& inner, FlareVisibility& flares)
        : ForwardingDevice(inner)
        , flares_(flares)
    {
    }

    void begin_frame(const View& view) override
    {
        inner().begin_frame(view);
        flares_.begin_frame(view, inner());
    }
    void end_frame() override
    {
        flares_.end_frame(inner());
        inner().end_frame();
    }

private:
    FlareVisibility& flares_;
};

} // namespace occlude
