// The answers of one batch of the test method `raster`: a buffer of flags, one per test, and the
// fence behind the draw that sets them.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace occlude {

class GlFlagBatch {
public:
    GlFlagBatch()
        : buffer_(GlBuffer::make())
    {
    }
    ~GlFlagBatch() { forget_fence(); }
    GlFlagBatch(const GlFlagBatch&) = delete;
    GlFlagBatch& operator=(const GlFlagBatch&) = delete;

    /// Allocates `tests` flags, all 0, and binds them to `binding` of GL_SHADER_STORAGE_BUFFER. The
    /// former flags are lost. Returns false if the driver has no memory; then every test counts as
    /// seen.
    bool begin(size_t tests, GLuint binding);

    /// Replaces the draw: every test counts as seen.
    void give_up() { flags_.assign(flags_.size(), 1); }

    /// Must be called after the draw that sets the flags.
    void end();

    /// True if the flags can be read without waiting. Never blocks, but a driver may flush here.
    bool available();

    /// True if `test` set its flag. Waits for the draw and reads all flags at the first call. If
    /// the driver fails, every test counts as seen.
    bool seen(size_t test);

private:
    void forget_fence();

    GlBuffer buffer_;
    GLsync fence_ = nullptr; ///< null once the flags were read
    std::vector<uint32_t> flags_;
};

/// Batches that are reused in turn. A batch is not begun again while somebody holds it, which ends
/// when all its answers were read or given up.
class GlFlagBatches {
public:
    std::shared_ptr<GlFlagBatch> take();

private:
    std::vector<std::shared_ptr<GlFlagBatch>> batches_;
    size_t next_ = 0;
};

} // namespace occlude
