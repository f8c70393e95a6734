// The test method `pyramid`: tests answered at once, on the CPU, against depth that was read back.
//
// For devices. A test is hidden if all its boxes are hidden by their screen rectangles and nearest
// depths, down to single pixels. Rectangles are larger than outlines, so fewer tests are hidden
// than with queries, and every hidden test would be hidden with queries, too.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/screen/depth_pyramid.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class PyramidTests {
public:
    /// Allocates a pyramid for a target of this size and returns the depth to be filled, as
    /// DepthPyramid::resize does. Then call build().
    std::span<float> resize(glm::ivec2 size_px) { return pyramid_.resize(size_px); }
    void build();

    /// Tells that draws or a new frame made the depth stale.
    void forget() { fresh_ = false; }
    bool fresh() const { return fresh_; }

    /// Answers test i of the batch in answers[i]: 0 samples or 1, or lost if the test has no box or
    /// an unbounded one. All answers are lost if the depth is stale. Precondition: as many answers
    /// as tests.
    void answer(const View& view, const QueryBatch& batch, std::vector<Answer>& answers);

private:
    DepthPyramid pyramid_;
    bool fresh_ = false;
    std::vector<ScreenBounds> bounds_;
    std::vector<uint8_t> hidden_;
};

} // namespace occlude
