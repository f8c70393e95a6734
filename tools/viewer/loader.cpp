#include "viewer/loader.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <thread>

namespace occlude::tools::viewer {

enum class Phase : uint8_t { reading, building };

// Shared with the thread, which may outlive the loader's interest in it.
struct Loader::Job {
    std::atomic<Phase> phase{Phase::reading};
    std::atomic<bool> cancelled{false};
    std::mutex mutex;
    std::optional<Loaded> result; ///< guarded by mutex
};

static Loader::Loaded load_and_build(const std::string& scene, const StageOptions& options,
                                     std::atomic<Phase>& phase, const std::atomic<bool>& cancelled)
{
    auto model = Session::load(scene, options);
    if (!model) {
        return model.error();
    }
    if (cancelled) {
        return Error{ErrorCode::invalid_argument, "cancelled"};
    }
    phase = Phase::building;
    return Session::prepare(std::move(*model), options);
}

void Loader::start(const std::string& scene, const StageOptions& options)
{
    cancel();
    scene_ = scene;
    started_s_ = clock_();
    job_ = std::make_shared<Job>();
    std::thread{[job = job_, scene, options] {
        Loaded loaded = Error{ErrorCode::bad_data, "out of memory; choose a smaller scene"};
        try {
            loaded = load_and_build(scene, options, job->phase, job->cancelled);
        } catch (const std::bad_alloc&) { // the message is there already
        } catch (const std::exception& error) {
            loaded = Error{ErrorCode::bad_data, std::string{"unexpected failure: "} + error.what()};
        }
        const std::lock_guard lock{job->mutex};
        job->result.emplace(std::move(loaded));
    }}.detach();
}

void Loader::cancel()
{
    if (job_) {
        job_->cancelled = true;
        job_.reset();
    }
}

std::string Loader::phase() const
{
    return job_ && job_->phase == Phase::building ? "building the hierarchy" : "reading the scene";
}

double Loader::seconds() const
{
    return clock_() - started_s_;
}

std::optional<Loader::Loaded> Loader::poll()
{
    if (!job_) {
        return std::nullopt;
    }
    std::optional<Loaded> loaded;
    {
        const std::lock_guard lock{job_->mutex};
        loaded = std::move(job_->result);
        job_->result.reset();
    }
    if (loaded) {
        job_.reset();
    }
    return loaded;
}

} // namespace occlude::tools::viewer
