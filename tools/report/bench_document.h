// Everything one report is about: one scene, one path, all algorithms.
#pragma once

#include "measure/run.h"

#include <glm/vec2.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace occlude::tools {

/// What happened before the first frame, and between frames where things move.
struct Preparation {
    double load_seconds = kNotMeasured;      ///< the scene, cutting of meshes included
    double hierarchy_seconds = kNotMeasured; ///< building the tree
    double tree_update_ms = kNotMeasured;    ///< the tree per frame; only where things move
    uint64_t uncut_triangles = 0;            ///< of the scene before meshes were cut
};

/// Pictures of one frame, for the report.
struct FramePicture {
    size_t frame = 0;      ///< of the path
    std::string algorithm; ///< the one that culled it
    std::string caption;
    std::string png; ///< the bytes of a PNG file
};

/// Two objects with surfaces at exactly the same depth.
struct CoincidentObjects {
    std::string first; ///< names; equal if two items of one object coincide
    std::string second;
    uint64_t pixels = 0; ///< tied pixels in the frame that has most of them
};

struct BenchDocument {
    std::string scene;
    uint64_t objects = 0;
    uint64_t items = 0;
    uint64_t triangles = 0;
    std::vector<std::string> load_notes = {};  ///< what the loader assumed
    std::vector<std::string> load_losses = {}; ///< what the file holds and the scene does not
    std::string device;                        ///< "gl", "cpu" or "cpu_fast"
    std::string api;                           ///< the API and its version
    std::string renderer;                      ///< the driver's own name
    std::string hierarchy;                     ///< all kinds, between commas
    std::string test;
    std::string path;
    glm::ivec2 size{0};
    int samples = 1;
    size_t frames = 0; ///< of the path
    size_t repeat = 1;
    size_t sample_every = 1; ///< MeasureOptions::sample_every
    uint32_t leaf_triangles = 0;
    uint32_t item_triangles = 0;
    std::string split;
    std::vector<std::string> sets; ///< options of algorithms that are not the default
    Preparation preparation;
    std::string entry; ///< of a suite; empty: of none
    std::string date;  ///< of a suite's run, YYYY-MM-DD
    std::vector<AlgorithmRun> runs;
    std::vector<FramePicture> pictures = {};        ///< of the worst frames; only in HTML
    std::vector<CoincidentObjects> coincident = {}; ///< most pixels first

    /// True if answers come at once, so that what is decided depends on nothing but the frames.
    bool deterministic() const { return device == "cpu"; }
};

} // namespace occlude::tools
