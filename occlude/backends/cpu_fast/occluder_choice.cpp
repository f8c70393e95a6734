#include <occlude/backends/cpu_fast/detail/occluder_choice.h>

#include <occlude/screen/projection.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace occlude::cpu_fast {

namespace {

// Work is counted in triangles; an instance by itself costs about as much as this many.
constexpr uint32_t kWorkPerInstance = 12;
// ... and so do this many pixels of its rectangle for one triangle.
constexpr float kPixelsPerWork = 2048.0f;
// Work of one chunk: enough to fill many bins at once, little enough for the next chunk to find out
// what this one hides.
constexpr uint64_t kWorkPerChunk = 4096;
// Of the budget that is left, a chunk may use this much: its cost is known only from others.
constexpr double kShareOfBudget = 0.5;
// Chunks of less work than this are not worth starting.
constexpr uint64_t kLeastWork = 64;
// Frames for which an occluder that hid nothing comes after all others.
constexpr uint32_t kUselessFrames = 30;
constexpr float kLearningRate = 0.25f;
constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();

double steady_us()
{
    return std::chrono::duration<double, std::micro>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace

void OccluderChoice::begin_frame()
{
    ++frame_;
    waiting_.clear();
    used_.clear();
    left_out_ = false;
    triangles_ = 0;
    spent_us_ = 0.0f;
}

void OccluderChoice::add(ItemId id, const CpuFastItem& item)
{
    if (item.mesh == nullptr || item.mesh->empty() || !id.valid()) {
        return;
    }
    if (id.value >= history_.size()) {
        history_.resize(size_t{id.value} + 1);
    }
    History& history = history_[id.value];
    if (history.added_in == frame_) {
        return;
    }
    history.added_in = frame_;
    waiting_.push_back({.item = item, .id = id});
}

// Values of all that waits, best first; without those that hide too little for what they cost.
void OccluderChoice::rate(const OccluderBuffer& buffer, const OccluderLimits& limits)
{
    const glm::ivec2 size = buffer.view().size_px();
    for (Candidate& c : waiting_) {
        const ScreenBounds bounds =
            project(buffer.view(), transformed(c.item.world_from_mesh, c.item.mesh->box()));
        // A box at the eye may be anywhere, and is not hidden.
        c.rect = bounds.valid ? bounds.rect : PixelRect{0, 0, size.x, size.y};
        c.nearest = bounds.valid ? bounds.near_depth : 0.0f;
        const float pixels = static_cast<float>(c.rect.width) * static_cast<float>(c.rect.height);
        const auto triangles = static_cast<uint32_t>(c.item.mesh->triangles().size());
        c.work = triangles + kWorkPerInstance + static_cast<uint32_t>(pixels / kPixelsPerWork);
        c.value = pixels / static_cast<float>(triangles);
    }
    std::erase_if(waiting_, [&](const Candidate& c) {
        return c.value <= 0.0f || !(c.value >= limits.min_px_per_triangle);
    });
    const auto useless = [&](const Candidate& c) {
        const uint32_t in = history_[c.id.value].useless_in;
        return in != 0 && frame_ - in <= kUselessFrames;
    };
    std::ranges::sort(waiting_, [&](const Candidate& a, const Candidate& b) {
        const bool a_last = useless(a);
        const bool b_last = useless(b);
        return a_last != b_last ? b_last : a.value != b.value ? a.value > b.value : a.id < b.id;
    });
}

// Moves candidates to the buffer, as many as make a chunk and fit; returns their work.
uint64_t OccluderChoice::add_chunk(OccluderBuffer& buffer, uint64_t most_work,
                                   uint64_t most_triangles)
{
    uint64_t work = 0;
    size_t kept = 0;
    size_t i = 0;
    for (; i < waiting_.size() && work < kWorkPerChunk; ++i) {
        Candidate& c = waiting_[i];
        const uint64_t triangles = c.item.mesh->triangles().size();
        if (buffer.test(c.rect, c.nearest) == Visibility::hidden) {
            history_[c.id.value].useless_in = frame_;
        } else if (work + c.work <= most_work && triangles_ + triangles <= most_triangles) {
            buffer.add(*c.item.mesh, c.item.world_from_mesh);
            triangles_ += triangles;
            work += c.work;
            used_.push_back(c);
        } else {
            waiting_[kept++] = c;
        }
    }
    waiting_.erase(waiting_.begin() + static_cast<ptrdiff_t>(kept),
                   waiting_.begin() + static_cast<ptrdiff_t>(i));
    return work;
}

// The work that the budget leaves for the next chunk.
uint64_t OccluderChoice::work_left(const OccluderLimits& limits, double spent_us) const
{
    if (limits.budget_us <= 0.0f) {
        return kUnlimited;
    }
    const double left = std::max(static_cast<double>(limits.budget_us) - spent_us, 0.0);
    return static_cast<uint64_t>(left * kShareOfBudget / static_cast<double>(us_per_work_));
}

void OccluderChoice::rasterize(OccluderBuffer& buffer, const OccluderLimits& limits)
{
    if (waiting_.empty()) {
        return;
    }
    const bool timed = limits.budget_us > 0.0f;
    const auto now = [&] {
        return !timed ? 0.0 : limits.clock_us != nullptr ? limits.clock_us() : steady_us();
    };
    const double begin = now() - static_cast<double>(spent_us_);
    rate(buffer, limits);
    while (!waiting_.empty()) {
        const double started = now();
        const uint64_t most_work = work_left(limits, started - begin);
        if (most_work < kLeastWork) {
            break;
        }
        const uint64_t work = add_chunk(
            buffer, most_work, limits.max_triangles == 0 ? kUnlimited : limits.max_triangles);
        if (work == 0) {
            break;
        }
        buffer.rasterize();
        if (timed) {
            const float us_per_work =
                static_cast<float>(now() - started) / static_cast<float>(work);
            us_per_work_ += kLearningRate * (us_per_work - us_per_work_);
        }
    }
    left_out_ = left_out_ || !waiting_.empty();
    waiting_.clear();
    spent_us_ = static_cast<float>(now() - begin);
}

void OccluderChoice::end_frame(const OccluderBuffer& buffer)
{
    if (!left_out_) {
        return;
    }
    for (const Candidate& c : used_) {
        if (buffer.test(c.rect, c.nearest) == Visibility::hidden) {
            history_[c.id.value].useless_in = frame_;
        }
    }
}

} // namespace occlude::cpu_fast
