// Reads the depth of the bound framebuffer, with or without multisampling: single pixels, or the
// farthest of each tile, reduced on the device by fragment shaders (OpenGL 3.3).
//
//   the attachment --blit--> a texture of the same format --shader--> float texture --> read
//                                                          8x8 at most   again for larger tiles
//
// If the driver refuses a blit, the copy stays as it was cleared: all far, so that nothing is found
// hidden.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <glm/vec2.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

namespace occlude {

/// Which sample of a multisampled pixel is read, and which pixel of a tile.
enum class DepthSample : uint8_t { smallest, largest, first };

class GlDepthReader {
public:
    static constexpr int kLargestTile = 64; // pixels: two passes

    static Result<std::unique_ptr<GlDepthReader>> create();

    /// Reads raw values of `rect` of the framebuffer bound to GL_DRAW_FRAMEBUFFER, row by row from
    /// its lower edge. Blocks. Returns false and leaves `out` untouched if there is no depth
    /// attachment, if it is layered, or if the driver could not read. Changes no state.
    bool read(const PixelRect& rect, DepthSample sample, std::span<float> out);

    /// Reads the smallest or the largest value of each tile of tile_px x tile_px pixels (`sample`
    /// is not `first`). tile_px is a power of two up to kLargestTile. `from_above`: tiles and their
    /// rows are counted from the upper edge of `rect`. Otherwise like read().
    bool read_tiles(const PixelRect& rect, int tile_px, bool from_above, DepthSample sample,
                    std::span<float> out);

private:
    // A program that reduces texels, and the locations of its uniforms.
    struct Reduction {
        GlProgram program;
        GLint origin = -1;
        GLint extent = -1;
        GLint side = -1;
        GLint mode = -1;
        GLint sample_count = -1;
        GLint from_above = -1;

        Reduction() = default;
        explicit Reduction(GlProgram made);
    };
    // A texture of single floats to draw into.
    struct FloatTarget {
        GlTexture texture;
        GlFramebuffer framebuffer;
        glm::ivec2 size{0};

        bool prepare(glm::ivec2 needed);
    };
    struct Pass;

    GlDepthReader(GlProgram pixels, GlProgram samples);
    bool copy(const PixelRect& rect, int sample_count, DepthSample sample, GLuint source);
    bool prepare_copy(GLenum format, int sample_count, const PixelRect& rect);
    void reduce(const Reduction& reduction, const Pass& pass, DepthSample sample,
                FloatTarget& into);
    bool read_floats(GLuint framebuffer, const PixelRect& rect, GLenum format,
                     std::span<float> out) const;

    Reduction pixels_;  ///< of a texture with one sample per pixel
    Reduction samples_; ///< of a multisampled one
    GlVertexArray vertex_array_;
    GlSampler sampler_; ///< without comparison or filter
    GlTexture copy_;    ///< of the depth attachment
    GlFramebuffer copy_framebuffer_;
    GLenum copy_format_ = 0;
    int copy_samples_ = 0;
    glm::ivec2 copy_size_{0};
    std::array<FloatTarget, 2> reduced_;
};

} // namespace occlude
