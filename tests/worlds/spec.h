// One random world: everything that decides a case, as plain values, so that a failure can be
// printed, repeated and made smaller.
#pragma once

#include <occlude/core/option_text.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>
#include <occlude/device/faulty_device.h>

#include <cstdint>
#include <string>
#include <vector>

namespace occlude::worlds {

enum class Lens : uint8_t { perspective, orthographic, infinite, off_centre, oblique };

struct Spec {
    uint64_t seed = 1;
    // The scene.
    uint32_t items = 40;
    float unit = 1.0f;     ///< 0.001: a world of millimetres; 1000: of kilometres
    float offset = 0.0f;   ///< from the origin, in sizes of the world
    bool flags = false;    ///< some items never cull, never occlude, or are translucent
    bool moves = false;    ///< items move, vanish, and their ids are given to others
    bool rebuilds = false; ///< the tree is replaced in place now and then
    // The camera.
    uint32_t frames = 8;
    glm::ivec2 size_px{48, 36};
    ClipConvention convention;
    Lens lens = Lens::perspective;
    float near_plane = 0.1f;      ///< in units
    bool mirrored = false;        ///< along x, as in a mirror
    bool depth_clamp = false;     ///< the view ignores the near plane
    bool camera_relative = false; ///< positions are drawn relative to the eye
    bool resets = false;          ///< the culler is reset now and then
    // The culler.
    std::string hierarchy = "bvh";
    uint32_t leaf_triangles = 0;
    std::string algorithm = "chc";
    std::vector<OptionValue> options;
    bool clock = false; ///< options that count in time have a clock, which runs at random
    uint32_t views = 1; ///< cullers of other cameras that take turns on the same device
    // The device.
    TestMethod method = TestMethod::queries;
    Faults faults;
    uint32_t ray_pixels = 0;          ///< pixels that are compared with Embree's rays, too
    bool rays_in_every_frame = false; ///< else in one
};

/// The spec of a seed, the same on every machine. An empty `algorithm` allows any.
Spec random_spec(uint64_t seed, const std::string& algorithm = {});

/// All values that differ from the default, in one line.
std::string to_text(const Spec& spec);

/// Smaller and simpler specs to try when `spec` fails, the simplest first.
std::vector<Spec> simpler(const Spec& spec);

} // namespace occlude::worlds
