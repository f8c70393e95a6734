#include "viewer/loader.h"

#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <new>
#include <thread>

namespace occlude::tools::viewer {

// Shared with the thread, which may outlive the loader's interest in it.
struct Loader::Job {
    std::atomic<bool> cancelled{false};
    std::mutex mutex;
    std::string phase = "starting";                          ///< guarded by mutex
    double share = std::numeric_limits<double>::quiet_NaN(); ///< guarded by mutex
    std::optional<Loaded> result;                            ///< guarded by mutex

    void tell(const std::string& now, double done)
    {
        const std::lock_guard lock{mutex};
        phase = now;
        share = done;
    }
};

static Loader::Loaded load_and_build(const std::string& scene, const StageOptions& options,
                                     const LoadingCallback& tell,
                                     const std::atomic<bool>& cancelled)
{
    auto model = Session::load(scene, options, tell);
    if (!model) {
        return model.error();
    }
    if (cancelled) {
        return Error{ErrorCode::invalid_argument, "cancelled"};
    }
    return Session::prepare(std::move(*model), options, tell);
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
            loaded = load_and_build(
                scene, options,
                [&](const std::string& phase, double share) { job->tell(phase, share); },
                job->cancelled);
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
    if (!job_) {
        return {};
    }
    const std::lock_guard lock{job_->mutex};
    return job_->phase;
}

double Loader::share() const
{
    if (!job_) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    const std::lock_guard lock{job_->mutex};
    return job_->share;
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
