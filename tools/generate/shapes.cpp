#include "generate/shapes.h"

#include <glm/geometric.hpp>

#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

std::vector<glm::vec3> circle_around(const glm::vec3& middle, const Across& plane, float radius,
                                     std::span<const glm::vec2> circle)
{
    std::vector<glm::vec3> points;
    points.reserve(circle.size());
    for (const glm::vec2& c : circle) {
        points.push_back(middle + radius * (c.x * plane.first + c.y * plane.second));
    }
    return points;
}

} // namespace

Across across(const glm::vec3& axis)
{
    const glm::vec3 along = glm::normalize(axis);
    const glm::vec3 helper =
        std::abs(along.y) < 0.7f ? glm::vec3{0.0f, 1.0f, 0.0f} : glm::vec3{1.0f, 0.0f, 0.0f};
    const glm::vec3 first = glm::normalize(glm::cross(helper, along));
    return {first, glm::cross(along, first)};
}

void tube(MeshBuilder& builder, std::span<const glm::vec3> line, float radius, uint32_t segments)
{
    std::vector<glm::vec3> points; // rounded lines say some of them twice
    for (const glm::vec3& point : line) {
        if (points.empty() || glm::distance(points.back(), point) > 1e-3f * radius) {
            points.push_back(point);
        }
    }
    const std::vector<glm::vec2> circle = unit_circle(segments);
    Across plane = across(points[1] - points[0]);
    std::vector<glm::vec3> ring = circle_around(points[0], plane, radius, circle);
    for (size_t i = 1; i < points.size(); ++i) {
        const glm::vec3 way = glm::normalize(points[i] - points[i - 1]);
        // The ring is pushed along the piece onto the plane that halves the corner at its end.
        const glm::vec3 next_way =
            i + 1 < points.size() ? glm::normalize(points[i + 1] - points[i]) : way;
        const glm::vec3 halving = way + next_way;
        std::vector<glm::vec3> end(ring.size());
        for (size_t k = 0; k < ring.size(); ++k) {
            const float far = glm::dot(points[i] - ring[k], halving) / glm::dot(way, halving);
            end[k] = ring[k] + far * way;
        }
        for (size_t k = 0; k < ring.size(); ++k) {
            const size_t next = (k + 1) % ring.size();
            builder.quad(ring[k], ring[next], end[next], end[k]);
        }
        ring = std::move(end);
    }
}

void rod(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to, float radius,
         uint32_t segments)
{
    const std::array<glm::vec3, 2> ends{from, to};
    tube(builder, ends, radius, segments);
    const std::vector<glm::vec2> circle = unit_circle(segments);
    const Across plane = across(to - from);
    const std::vector<glm::vec3> low = circle_around(from, plane, radius, circle);
    const std::vector<glm::vec3> high = circle_around(to, plane, radius, circle);
    for (size_t k = 1; k + 1 < circle.size(); ++k) {
        builder.triangle(low[0], low[k + 1], low[k]);
        builder.triangle(high[0], high[k], high[k + 1]);
    }
}

void turned(MeshBuilder& builder, const glm::vec3& base, std::span<const glm::vec2> profile,
            uint32_t segments)
{
    const std::vector<glm::vec2> circle = unit_circle(segments);
    const auto at = [&](const glm::vec2& point, size_t k) {
        const glm::vec2& c = circle[k % circle.size()];
        return base + glm::vec3{point.x * c.x, point.y, -point.x * c.y};
    };
    for (size_t i = 1; i < profile.size(); ++i) {
        const glm::vec2& low = profile[i - 1];
        const glm::vec2& high = profile[i];
        for (size_t k = 0; k < circle.size(); ++k) {
            if (low.x == 0.0f) {
                builder.triangle(at(low, k), at(high, k + 1), at(high, k));
            } else if (high.x == 0.0f) {
                builder.triangle(at(low, k), at(low, k + 1), at(high, k));
            } else {
                builder.quad(at(low, k), at(low, k + 1), at(high, k + 1), at(high, k));
            }
        }
    }
}

void block(MeshBuilder& builder, const glm::vec3& middle, const glm::vec3& size, uint32_t faces)
{
    builder.box(middle - 0.5f * size, middle + 0.5f * size, faces);
}

glm::mat4 turned_about_y(float sine, float cosine, const glm::vec3& at)
{
    glm::mat4 m{1.0f};
    m[0] = {cosine, 0.0f, -sine, 0.0f};
    m[2] = {sine, 0.0f, cosine, 0.0f};
    m[3] = {at, 1.0f};
    return m;
}

glm::mat4 quarter_turned(uint32_t quarters, const glm::vec3& at)
{
    constexpr std::array<float, 4> kSine{0.0f, 1.0f, 0.0f, -1.0f};
    return turned_about_y(kSine[quarters % 4], kSine[(quarters + 1) % 4], at);
}

} // namespace occlude::tools
