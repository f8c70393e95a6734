// The program's renderer for --device cpu_fast: another renderer draws, and the CPU answers the
// tests.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/backends/cpu_fast/cpu_fast_device.h>

#include <memory>
#include <span>

namespace occlude::tools {

/// `renderer` draws `items` of `model`, which must outlive it, unchanged; its device() is a
/// CpuFastDevice around the device of `renderer`. Prepares the meshes of all opaque items.
std::unique_ptr<SceneRenderer> make_cpu_fast_renderer(std::unique_ptr<SceneRenderer> renderer,
                                                      const SceneModel& model,
                                                      std::span<const SceneModel::Item> items,
                                                      const CpuFastDeviceOptions& options = {});

} // namespace occlude::tools
