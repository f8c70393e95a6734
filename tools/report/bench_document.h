// Everything one report is about: one scene, one path, all algorithms.
#pragma once

#include "measure/run.h"

#include <glm/vec2.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace occlude::tools {

struct BenchDocument {
    std::string scene;
    uint64_t objects = 0;
    uint64_t items = 0;
    uint64_t triangles = 0;
    std::string device;    ///< "gl" or "cpu"
    std::string api;       ///< the API and its version
    std::string renderer;  ///< the driver's own name
    std::string hierarchy; ///< all kinds, between commas
    std::string test;
    std::string path;
    glm::ivec2 size{0};
    int samples = 1;
    size_t frames = 0;
    size_t repeat = 1;
    std::vector<AlgorithmRun> runs;
};

} // namespace occlude::tools
