// The OpenGL state that tests of a GlDevice need or change, behind the back of an engine that keeps
// a record of its own: read before, put back after.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace occlude {

class SavedGlState {
public:
    /// Reads the state of the context that is current. Some thirty questions to the driver.
    void read();

    /// Sets what tests need and the engine may have set otherwise (docs/devices.md), and what the
    /// fixed pipeline of a compatibility context adds: alpha test, polygon stipple.
    void set_for_tests(const std::array<int, 4>& viewport) const;

    /// Sets everything again as it was read.
    void put_back() const;

private:
    static constexpr size_t kModes = 18;

    std::array<bool, kModes> modes_{};
    std::array<int, 2> polygon_mode_{};
    std::array<int, 4> scissor_{};
    std::array<int, 4> viewport_{};
    std::array<float, 2> depth_range_{};
    std::array<uint8_t, 4> color_mask_{};
    uint8_t depth_mask_ = 1;
    int depth_function_ = 0;
    int program_ = 0;
    int vertex_array_ = 0;
    int array_buffer_ = 0;
    int storage_buffer_ = 0;
    bool has_storage_buffers_ = false;
};

} // namespace occlude
