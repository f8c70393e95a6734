// Faults that make tests impossible in a frame, and their messages to the engine. Looks once per
// frame: all tests of a frame with a fault are lost, which reads as visible.
#pragma once

#include <occlude/backends/gl/detail/gl_context.h>
#include <occlude/backends/gl/detail/gl_query_pool.h>
#include <occlude/backends/gl/detail/gl_target_state.h>
#include <occlude/core/messages.h>
#include <occlude/core/view.h>

#include <cstdint>

namespace occlude {

class GlFaults {
public:
    enum class Context : uint8_t {
        own,
        other, ///< another context is current, or none: OpenGL must not be called
        lost,  ///< it was reset: OpenGL answers nothing any more
    };

    /// Faults in the context that is current now. `gl_version` is 10 * major + minor.
    GlFaults(MessageHandler on_message, int gl_version);

    /// True if the context of the device is current and alive. Reports if it is not.
    Context look_at_context();

    /// True if tests in this target answer for this view. Reports the reason if they do not.
    bool can_test(const View& view, const GlTargetState& target);

    /// Reports the faults of the pool since the last call.
    void report_pool(GlQueryPool::Faults faults, uint32_t capacity, double wait_budget_ms);
    void report_no_memory();
    void report_no_depth();

    /// True if a query of the engine is active, so that the device cannot begin one. Reports it.
    bool query_is_open();

    Messages& messages() { return messages_; }

private:
    Messages messages_;
    GlContextWatch watch_;
    void* own_context_ = nullptr;
    int gl_version_ = 0;
    bool lost_ = false;
};

} // namespace occlude
