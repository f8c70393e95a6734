#include "flare_scene.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>

namespace occlude::lens_flare {

namespace {

const glm::vec3 kTowardSun = glm::normalize(glm::vec3{0.10f, 0.16f, -1.0f});

// Corner i of a box has the maximum on axis a where bit a of i is set. Two triangles per face.
const std::vector<uint32_t> kBoxIndices{0, 4, 2, 2, 4, 6, 1, 3, 5, 5, 3, 7, 0, 1, 4, 4, 1, 5,
                                        2, 6, 3, 3, 6, 7, 0, 2, 1, 1, 2, 3, 4, 5, 6, 6, 5, 7};
constexpr std::array<glm::vec3, 6> kFaceNormals{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

glm::dvec4 clip_of(const View& view, const glm::vec4& position)
{
    return glm::dmat4{view.clip_from_world()} * glm::dvec4{position};
}

glm::dvec2 pixel_of(const View& view, const glm::dvec4& clip)
{
    return (glm::dvec2{clip} / clip.w * 0.5 + 0.5) * glm::dvec2{view.size_px()};
}

void add_light(uint32_t& pixel, const glm::vec3& light)
{
    uint32_t result = 0xff000000u;
    for (int channel = 0; channel < 3; ++channel) {
        const int shift = 8 * channel;
        const float value = static_cast<float>((pixel >> shift) & 0xffu) + 255.0f * light[channel];
        result |= static_cast<uint32_t>(glm::clamp(value, 0.0f, 255.0f)) << shift;
    }
    pixel = result;
}

// A round spot that falls off toward its rim as (1 - r^2)^power.
void add_spot(tools::Image& image, const glm::dvec2& center, double radius, double power,
              const glm::vec3& color)
{
    for (int y = 0; y < image.size.y; ++y) {
        for (int x = 0; x < image.size.x; ++x) {
            const double r = glm::length(glm::dvec2{x + 0.5, y + 0.5} - center) / radius;
            if (r < 1.0) {
                const auto share = static_cast<float>(std::pow(1.0 - r * r, power));
                add_light(image.pixels[static_cast<size_t>(y * image.size.x + x)], share * color);
            }
        }
    }
}

} // namespace

Columns::Columns()
{
    add({-60.0f, -1.0f, -80.0f}, {60.0f, 0.0f, 30.0f});
    for (const float z : {0.0f, -4.0f, -12.0f}) {
        for (int i = -8; i <= 8; ++i) {
            const float x = 2.4f * static_cast<float>(i) + 0.15f * z;
            add({x - 0.35f, 0.0f, z - 0.35f}, {x + 0.35f, 4.6f, z + 0.35f});
        }
        add({-21.0f + 0.15f * z, 4.6f, z - 0.5f}, {21.0f + 0.15f * z, 5.3f, z + 0.5f});
    }
}

void Columns::add(const glm::vec3& low, const glm::vec3& high)
{
    std::vector<glm::vec3>& corners = corners_.emplace_back();
    for (int c = 0; c < 8; ++c) {
        corners.push_back({(c & 1) != 0 ? high.x : low.x, (c & 2) != 0 ? high.y : low.y,
                           (c & 4) != 0 ? high.z : low.z});
    }
    bounds_.push_back({{low, high}, 12});
}

CpuItem Columns::item(ItemId item) const
{
    return {.positions = corners_[item.value], .indices = kBoxIndices};
}

glm::vec3 Columns::normal(uint32_t triangle)
{
    return kFaceNormals[triangle / 2];
}

double exact_fraction(const CpuDevice& device, const View& view, const FlareLight& light)
{
    const glm::dvec4 clip = clip_of(view, light.position_world);
    if (clip.w <= 0.0) {
        return 0.0;
    }
    const bool infinitely_far = light.position_world.w == 0.0f;
    const double depth01 = infinitely_far ? 1.0 - 1e-6 : 0.5 * clip.z / clip.w + 0.5;
    const glm::dvec2 center = pixel_of(view, clip);
    const glm::ivec2 size = view.size_px();
    int all = 0;
    int seen = 0;
    const glm::ivec2 low{glm::floor(center - double{light.radius_px} - 1.0)};
    const glm::ivec2 high{glm::ceil(center + double{light.radius_px} + 1.0)};
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            if (glm::length(glm::dvec2{x + 0.5, y + 0.5} - center) > double{light.radius_px}) {
                continue;
            }
            ++all;
            const bool on_screen = x >= 0 && y >= 0 && x < size.x && y < size.y;
            seen +=
                on_screen && double{device.depth()[static_cast<size_t>(y * size.x + x)]} >= depth01
                    ? 1
                    : 0;
        }
    }
    return static_cast<double>(seen) / all;
}

tools::Image shaded_image(const CpuDevice& device, const Columns&)
{
    tools::Image image{device.size_px(), {}};
    const auto width = static_cast<size_t>(image.size.x);
    for (size_t pixel = 0; pixel < device.depth().size(); ++pixel) {
        const CpuDevice::Owner owner = device.owner(pixel);
        const float height = static_cast<float>(pixel / width) / static_cast<float>(image.size.y);
        glm::vec3 color = glm::mix(glm::vec3{0.86f, 0.55f, 0.34f}, glm::vec3{0.22f, 0.28f, 0.46f},
                                   glm::smoothstep(0.35f, 1.0f, height));
        if (owner.item.valid()) {
            const glm::vec3 normal = Columns::normal(owner.triangle);
            const float lit = glm::max(glm::dot(normal, kTowardSun), 0.0f);
            const glm::vec3 base = owner.item.value == 0 ? glm::vec3{0.30f, 0.26f, 0.24f}
                                                         : glm::vec3{0.36f, 0.31f, 0.30f};
            color = base * (0.45f + 0.18f * normal.y - 0.10f * normal.x + 0.9f * lit);
        }
        uint32_t packed = 0xff000000u;
        add_light(packed, color);
        image.pixels.push_back(packed);
    }
    return image;
}

void add_flare(tools::Image& image, const View& view, const FlareLight& light, double brightness)
{
    const glm::dvec4 clip = clip_of(view, light.position_world);
    if (brightness <= 0.0 || clip.w <= 0.0) {
        return;
    }
    const auto strength = static_cast<float>(brightness);
    const glm::dvec2 place = pixel_of(view, clip);
    const glm::dvec2 middle = 0.5 * glm::dvec2{image.size};
    const double radius = double{light.radius_px};
    add_spot(image, place, 12.0 * radius, 3.0, strength * glm::vec3{0.55f, 0.36f, 0.18f});
    add_spot(image, place, 2.2 * radius, 2.0, strength * glm::vec3{1.0f, 0.9f, 0.7f});

    struct Ghost {
        double along; ///< the line from the light through the middle: 1 is the middle
        double size;
        glm::vec3 color;
    };
    constexpr std::array<Ghost, 4> kGhosts{{{0.55, 1.6, {0.10f, 0.16f, 0.10f}},
                                            {1.35, 2.6, {0.07f, 0.09f, 0.16f}},
                                            {1.65, 1.2, {0.16f, 0.10f, 0.06f}},
                                            {2.10, 4.2, {0.06f, 0.05f, 0.09f}}}};
    for (const Ghost& ghost : kGhosts) {
        add_spot(image, place + (middle - place) * ghost.along, ghost.size * radius, 0.35,
                 strength * ghost.color);
    }
}

} // namespace occlude::lens_flare
