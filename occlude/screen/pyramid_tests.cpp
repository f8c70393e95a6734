#include <occlude/screen/pyramid_tests.h>

#include <occlude/screen/projection.h>

#include <algorithm>

namespace occlude {

void PyramidTests::build()
{
    pyramid_.build();
    fresh_ = true;
}

void PyramidTests::answer(const View& view, const QueryBatch& batch, std::vector<Answer>& answers)
{
    answers.assign(batch.test_ends.size(), Answer::lost());
    if (!fresh_ || view.size_px() != pyramid_.size_px()) {
        return;
    }
    bounds_.resize(batch.boxes.size());
    hidden_.resize(batch.boxes.size());
    project_query_boxes(view, batch.boxes, bounds_);
    pyramid_.hides(bounds_, DepthPyramid::Refinement::pixels, hidden_);

    size_t begin = 0;
    for (size_t test = 0; test < answers.size(); ++test) {
        const size_t end = std::min<size_t>(batch.test_ends[test], batch.boxes.size());
        bool known = begin < end;
        bool seen = false;
        for (; begin < end; ++begin) {
            known = known && batch.boxes[begin].box.is_bounded();
            seen = seen || hidden_[begin] == 0;
        }
        if (known) {
            answers[test] = Answer::ready(seen ? 1 : 0);
        }
    }
}

} // namespace occlude
