#include "session/session.h"
#include "walk/paths.h"

#include <fmt/core.h>

namespace occlude::tools {

Result<std::vector<Camera>> Session::cameras(const std::string& path) const
{
    return cameras(path, options_.frames);
}

Result<std::vector<Camera>> Session::cameras(const std::string& path, size_t frames) const
{
    auto cameras = load_path(path, model_, frames);
    if (!cameras) {
        return cameras.error();
    }
    if (cameras->empty()) {
        return Error{ErrorCode::bad_data,
                     fmt::format("path '{}' has no frames; give it at least one, or choose a path "
                                 "of 'occlude list paths'",
                                 path)};
    }
    choose_depth_range(*cameras, model_);
    return cameras;
}

Result<std::vector<View>> Session::views(const std::string& path) const
{
    const auto path_cameras = cameras(path);
    if (!path_cameras) {
        return path_cameras.error();
    }
    return views(*path_cameras);
}

std::vector<View> Session::views(std::span<const Camera> cameras) const
{
    std::vector<View> views;
    views.reserve(cameras.size());
    for (const Camera& camera : cameras) {
        views.push_back(make_view(camera, options_.size));
    }
    return views;
}

} // namespace occlude::tools
