#include "host_culler.h"

#include "saved_gl_state.h"

#include <occlude/core/clock.h>
#include <occlude/cull/registry.h>

#include <utility>

namespace occlude {

HostCuller::HostCuller(GlScene& scene, const Hierarchy& hierarchy, std::string algorithm,
                       MessageHandler on_message, const char* refusal)
    : scene_(scene)
    , hierarchy_(hierarchy)
    , algorithm_(std::move(algorithm))
    , on_message_(std::move(on_message))
    , refusal_(refusal)
{
}

HostCuller::~HostCuller()
{
    closing_ = true;
}

bool HostCuller::prepare()
{
    if (device_is_stale_) {
        culler_.reset();
        device_.reset(); // leaves the objects of the former context alone
        device_is_stale_ = false;
    }
    if (device_ != nullptr || gave_up_) {
        return device_ != nullptr;
    }
    GlDeviceOptions options;
    options.on_message = [this](const Message& message) {
        device_is_stale_ |= message.name == "gl.other_context" || message.name == "gl.context_lost";
        if (on_message_ && !closing_) {
            on_message_(message);
        }
    };
    SavedGlState saved;
    saved.read();
    auto device = GlDevice::create(scene_, options);
    saved.put_back();
    auto culler = make_culler(algorithm_, hierarchy_, {}, steady_seconds_clock());
    if (!device || !culler) {
        gave_up_ = true;
        if (on_message_) {
            const Error& error = device ? culler.error() : device.error();
            on_message_({Severity::warning, refusal_, error.message});
        }
        return false;
    }
    device_ = std::move(*device);
    culler_ = std::move(*culler);
    return true;
}

} // namespace occlude
