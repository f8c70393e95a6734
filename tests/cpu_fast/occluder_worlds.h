// Random occluders of every kind, and what a renderer that is not our rasteriser sees of them: rays
// in double through any point of the target, with vertices moved as a device may move them.
#pragma once

#include <occlude/backends/cpu_fast/occluder_buffer.h>
#include <occlude/core/rng.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace occlude::test {

struct OccluderSource {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    glm::mat4 world_from_mesh{1.0f};

    void quad(const std::array<glm::vec3, 4>& corners)
    {
        const auto first = static_cast<uint32_t>(positions.size());
        positions.insert(positions.end(), corners.begin(), corners.end());
        for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) {
            indices.push_back(first + i);
        }
    }
};

inline glm::vec3 random_point(Rng& rng, float size)
{
    const auto coordinate = [&] { return (uniform01(rng.next()) - 0.5f) * size; };
    const float x = coordinate();
    const float y = coordinate();
    return {x, y, coordinate()};
}

/// Triangles that have nothing to do with each other.
inline OccluderSource random_soup(Rng& rng, uint32_t triangles, float size)
{
    OccluderSource source;
    for (uint32_t i = 0; i < triangles; ++i) {
        const glm::vec3 middle = random_point(rng, size);
        for (int corner = 0; corner < 3; ++corner) {
            source.indices.push_back(static_cast<uint32_t>(source.positions.size()));
            source.positions.push_back(middle + random_point(rng, 0.7f * size));
        }
    }
    return source;
}

/// A sheet of n x n squares, bent at random; every square has its own vertices, as where normals
/// differ.
inline OccluderSource random_sheet(Rng& rng, int n, float size, float bend)
{
    std::vector<float> heights;
    for (int i = 0; i < (n + 1) * (n + 1); ++i) {
        heights.push_back((uniform01(rng.next()) - 0.5f) * bend);
    }
    OccluderSource source;
    const auto at = [&](int x, int y) {
        return glm::vec3{size * (static_cast<float>(x) / static_cast<float>(n) - 0.5f),
                         size * (static_cast<float>(y) / static_cast<float>(n) - 0.5f),
                         heights[static_cast<size_t>(y * (n + 1) + x)]};
    };
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            source.quad({at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    }
    return source;
}

/// A closed ball of triangles; half of them turned around if `mixed`.
inline OccluderSource ball(Rng& rng, int rings, float radius, bool mixed)
{
    OccluderSource source;
    const int around = 2 * rings;
    const auto at = [&](int ring, int i) {
        const double polar = 3.14159265358979 * ring / rings;
        const double angle = 2.0 * 3.14159265358979 * (i % around) / around;
        if (ring == 0 || ring == rings) {
            return glm::vec3{0.0f, 0.0f, ring == 0 ? radius : -radius};
        }
        return radius * glm::vec3{glm::dvec3{std::sin(polar) * std::cos(angle),
                                             std::sin(polar) * std::sin(angle), std::cos(polar)}};
    };
    const auto triangle = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c) {
        if (mixed && rng.below(2) == 0) {
            std::swap(b, c);
        }
        for (const glm::vec3& p : {a, b, c}) {
            source.indices.push_back(static_cast<uint32_t>(source.positions.size()));
            source.positions.push_back(p);
        }
    };
    for (int ring = 0; ring < rings; ++ring) {
        for (int i = 0; i < around; ++i) {
            if (ring + 1 < rings) {
                triangle(at(ring, i), at(ring + 1, i), at(ring + 1, i + 1));
            }
            if (ring > 0) {
                triangle(at(ring, i), at(ring + 1, i + 1), at(ring, i + 1));
            }
        }
    }
    return source;
}

inline OccluderSource random_source(Rng& rng)
{
    OccluderSource source;
    switch (rng.below(4)) {
    case 0:
        source = random_soup(rng, 1 + rng.below(12), 6.0f);
        break;
    case 1:
        source = random_sheet(rng, 1 + static_cast<int>(rng.below(7)), 6.0f,
                              2.0f * uniform01(rng.next()));
        break;
    case 2:
        source = ball(rng, 3 + static_cast<int>(rng.below(5)), 2.5f, rng.below(2) == 0);
        break;
    default:
        source = random_sheet(rng, 1, 40.0f, 0.0f); // reaches behind the eye
        break;
    }
    const float angle = 6.3f * uniform01(rng.next());
    source.world_from_mesh =
        glm::rotate(glm::translate(glm::mat4{1.0f}, random_point(rng, 9.0f)), angle,
                    glm::normalize(random_point(rng, 2.0f) + glm::vec3{0.01f, 0.0f, 0.0f}));
    if (rng.below(3) == 0) {
        source.world_from_mesh = glm::scale(source.world_from_mesh, glm::vec3{-1.0f, 0.6f, 1.4f});
    }
    return source;
}

struct OccluderWorld {
    View view;
    std::vector<OccluderSource> sources;
};

inline OccluderWorld random_occluder_world(uint64_t seed, glm::ivec2 size_px, uint32_t sources)
{
    Rng rng(seed);
    OccluderWorld world;
    // Far from zero, transforms in float are off by more.
    const float away = rng.below(3) == 0 ? 3000.0f * uniform01(rng.next()) : 0.0f;
    const glm::vec3 zero{away, -0.3f * away, 0.7f * away};
    const glm::vec3 eye = zero + random_point(rng, 14.0f);
    const glm::mat4 clip_from_world =
        (rng.below(4) == 0
             ? glm::ortho(-6.0f, 6.0f, -4.0f, 4.0f, 0.05f, 40.0f)
             : glm::perspective(1.1f, static_cast<float>(size_px.x) / static_cast<float>(size_px.y),
                                0.05f, 40.0f)) *
        glm::lookAt(eye, zero + random_point(rng, 3.0f), glm::vec3{0.0f, 1.0f, 0.0f});
    world.view = View::from_clip(clip_from_world, size_px);
    for (uint32_t i = 0; i < sources; ++i) {
        world.sources.push_back(random_source(rng));
        glm::mat4& place = world.sources.back().world_from_mesh;
        place = glm::translate(glm::mat4{1.0f}, zero) * place;
    }
    return world;
}

/// The triangles of a world as a device with its own rounding sees them.
class MovedTriangles {
public:
    /// Every vertex is moved by up to `most_px` on the screen, equal ones alike.
    MovedTriangles(const OccluderWorld& world, double most_px, uint64_t seed)
        : size_px_(world.view.size_px())
    {
        const glm::dmat4 clip_from_world{world.view.clip_from_world()};
        for (size_t s = 0; s < world.sources.size(); ++s) {
            const OccluderSource& source = world.sources[s];
            const glm::dmat4 clip = clip_from_world * glm::dmat4{source.world_from_mesh};
            const View own = world.view.in_object(source.world_from_mesh);
            for (size_t i = 0; i + 2 < source.indices.size(); i += 3) {
                Triangle triangle;
                for (size_t k = 0; k < 3; ++k) {
                    const glm::vec3 p = source.positions[source.indices[i + k]];
                    glm::dvec4 c = clip * glm::dvec4{glm::dvec3{p}, 1.0};
                    const uint64_t hash = hash64(seed, s, bits(p.x), bits(p.y), bits(p.z));
                    // What float transforms may be off by, and then what snapping may.
                    const glm::dvec4 error{
                        own.clip_rounding(glm::abs(glm::vec3{glm::dvec3{p} - own.origin()}))};
                    for (int axis = 0; axis < 4; ++axis) {
                        const auto k = static_cast<uint64_t>(axis);
                        c[axis] += move(hash64(hash, k), error[axis]);
                    }
                    c.x += move(hash, most_px) * 2.0 / size_px_.x * c.w;
                    c.y += move(mix64(hash), most_px) * 2.0 / size_px_.y * c.w;
                    c.z = 0.5 * (c.z + c.w);
                    triangle[k] = c;
                }
                triangles_.push_back(triangle);
            }
        }
    }

    /// The nearest window depth at a point of the target, in pixels; 1 where there is nothing.
    double depth_at(double x_px, double y_px) const
    {
        const double u = 2.0 * x_px / size_px_.x - 1.0;
        const double v = 2.0 * y_px / size_px_.y - 1.0;
        double nearest = 1.0;
        for (const Triangle& t : triangles_) {
            const glm::dvec3 x{t[0].x - u * t[0].w, t[1].x - u * t[1].w, t[2].x - u * t[2].w};
            const glm::dvec3 y{t[0].y - v * t[0].w, t[1].y - v * t[1].w, t[2].y - v * t[2].w};
            glm::dvec3 weight = glm::cross(x, y);
            const double w = glm::dot(weight, glm::dvec3{t[0].w, t[1].w, t[2].w});
            if (w == 0.0) {
                continue;
            }
            weight /= w; // now w > 0 exactly where all weights are of one sign, before the eye
            // A device covers a sample on a shared edge by one of the two.
            constexpr double kOnEdge = -1e-12;
            if (weight.x < kOnEdge || weight.y < kOnEdge || weight.z < kOnEdge) {
                continue;
            }
            const double z = glm::dot(weight, glm::dvec3{t[0].z, t[1].z, t[2].z});
            if (z >= 0.0 && z < nearest) {
                nearest = z;
            }
        }
        return nearest;
    }

private:
    using Triangle = std::array<glm::dvec4, 3>;

    static uint64_t bits(float x)
    {
        return static_cast<uint64_t>(std::bit_cast<uint32_t>(x + 0.0f));
    }
    static double move(uint64_t hash, double most)
    {
        return (2.0 * double{uniform01(hash)} - 1.0) * most;
    }

    glm::dvec2 size_px_;
    std::vector<Triangle> triangles_;
};

/// The meshes of a world, prepared.
struct PreparedWorld {
    explicit PreparedWorld(const OccluderWorld& world)
    {
        for (const OccluderSource& source : world.sources) {
            meshes.push_back(
                OccluderMesh::prepare(PositionStream(source.positions), source.indices));
        }
    }
    std::vector<OccluderMesh> meshes;
};

inline void rasterize(OccluderBuffer& buffer, const OccluderWorld& world,
                      const PreparedWorld& prepared)
{
    buffer.begin(world.view);
    for (size_t i = 0; i < world.sources.size(); ++i) {
        buffer.add(prepared.meshes[i], world.sources[i].world_from_mesh);
    }
    buffer.rasterize();
}

} // namespace occlude::test
