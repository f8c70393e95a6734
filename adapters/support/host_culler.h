// A culler and its device in the context of an engine, which may go and be replaced by another.
#pragma once

#include <occlude/backends/gl/gl_device.h>
#include <occlude/core/messages.h>
#include <occlude/core/view.h>
#include <occlude/cull/culler.h>

#include <memory>
#include <span>
#include <string>

namespace occlude {

class HostCuller {
public:
    /// `scene` and `hierarchy` outlive the culler. `refusal` names the message that there can be no
    /// device or culler: a literal.
    HostCuller(GlScene& scene, const Hierarchy& hierarchy, std::string algorithm,
               MessageHandler on_message, const char* refusal);
    ~HostCuller();
    HostCuller(const HostCuller&) = delete;
    HostCuller& operator=(const HostCuller&) = delete;

    /// Makes what is missing, in the context that is current, whose state it leaves as it was.
    /// False if this context can have no device: draw everything.
    bool prepare();

    /// One frame. prepare() has returned true.
    FrameReport cull(const View& view) { return culler_->cull(view, *device_); }
    std::span<const ItemId> drawn_items() const { return culler_->drawn_items(); }
    void forget() { culler_->reset(); }

    /// The context is another one than before.
    void context_is_gone() { device_is_stale_ = true; }

private:
    GlScene& scene_;
    const Hierarchy& hierarchy_;
    std::string algorithm_;
    MessageHandler on_message_;
    const char* refusal_;
    bool closing_ = false; ///< that the context is gone is no fault then
    std::unique_ptr<GlDevice> device_;
    std::unique_ptr<Culler> culler_;
    bool device_is_stale_ = false; ///< made in a context that is gone
    bool gave_up_ = false;         ///< there can be no device or culler; it was reported
};

} // namespace occlude
