// The test method `pyramid`: tests answered at once, on the CPU, from depth that was read back.
//
// For devices. A test is hidden if all of its boxes are, by their screen rectangles and nearest
// depths, down to single pixels: rectangles are larger than outlines, so fewer tests are hidden
// than with queries, and never one that queries see.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/screen/depth_pyramid.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class PyramidTests {
public:
    /// Makes room for the depth of a target of this size, to be filled as DepthPyramid::resize
    /// says; then call build().
    std::span<float> resize(glm::ivec2 size_px) { return pyramid_.resize(size_px); }
    void build();

    /// Draws came, or a new frame: the depth is not that of the target any more.
    void forget() { fresh_ = false; }
    bool fresh() const { return fresh_; }

    /// Answers test i of the batch in answers[i]: 0 samples or 1, or lost where it has no box or an
    /// unbounded one. Everything is lost without fresh depth. Precondition: as many answers as
    /// tests.
    void answer(const View& view, const QueryBatch& batch, std::vector<Answer>& answers);

private:
    DepthPyramid pyramid_;
    bool fresh_ = false;
    std::vector<ScreenBounds> bounds_;
    std::vector<uint8_t> hidden_;
};

} // namespace occlude
