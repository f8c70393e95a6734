// The colours with a meaning in pictures: the same in `render`, the viewer, reports and docs.
//
// The colours of M. Okabe and K. Ito, "Color Universal Design", 2008, which people with any kind of
// colour blindness can tell apart, and greys.
#pragma once

#include <occlude/cull/parts/decision_log.h>

#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace occlude::tools {

/// A colour as displays show it, and its name in texts.
struct NamedColor {
    std::string_view name;
    glm::vec4 color{0.0f};
};

namespace palette {
inline constexpr NamedColor kOrange{"orange", {0.902f, 0.624f, 0.000f, 1.0f}};
inline constexpr NamedColor kSkyBlue{"sky blue", {0.337f, 0.706f, 0.914f, 1.0f}};
inline constexpr NamedColor kGreen{"green", {0.000f, 0.620f, 0.451f, 1.0f}};
inline constexpr NamedColor kYellow{"yellow", {0.941f, 0.894f, 0.259f, 1.0f}};
inline constexpr NamedColor kBlue{"blue", {0.000f, 0.447f, 0.698f, 1.0f}};
inline constexpr NamedColor kVermilion{"vermilion", {0.835f, 0.369f, 0.000f, 1.0f}};
inline constexpr NamedColor kPurple{"purple", {0.800f, 0.475f, 0.655f, 1.0f}};
inline constexpr NamedColor kLightGrey{"light grey", {0.78f, 0.78f, 0.78f, 1.0f}};
inline constexpr NamedColor kDarkGrey{"dark grey", {0.30f, 0.30f, 0.32f, 1.0f}};
inline constexpr NamedColor kWhite{"white", {1.0f, 1.0f, 1.0f, 1.0f}};

/// The selected thing, and the thing that hides it.
inline constexpr NamedColor kSelected = kWhite;
inline constexpr NamedColor kOccluder = kBlue;
} // namespace palette

/// One line of the legend.
struct StateColor {
    Decision decision;
    NamedColor color;
    std::string_view meaning;
};

inline constexpr std::array<StateColor, 8> kStateColors = {{
    {Decision::undecided, palette::kLightGrey, "nobody asked"},
    {Decision::outside, palette::kDarkGrey, "outside the frustum"},
    {Decision::hidden, palette::kVermilion, "hidden: its own test found no sample"},
    {Decision::hidden_group, palette::kPurple, "hidden: a test of several nodes found no sample"},
    {Decision::drawn, palette::kGreen, "drawn without a test"},
    {Decision::drawn_near, palette::kYellow, "drawn: the near plane may cut its box"},
    {Decision::drawn_tested, palette::kSkyBlue, "drawn, and tested for later frames"},
    {Decision::drawn_revealed, palette::kOrange, "drawn: a test of this frame found samples"},
}};

/// Every decision with its colour, in the order of the enum.
constexpr std::span<const StateColor> state_colors()
{
    return kStateColors;
}

constexpr const StateColor& state_color(Decision decision)
{
    return kStateColors[static_cast<size_t>(decision)];
}

/// The linear colour that a renderer must use so that `display` shows where a surface faces the
/// light. Renderers shade in linear light and take the square root.
constexpr glm::vec4 linear_color(const glm::vec4& display)
{
    return {display.x * display.x, display.y * display.y, display.z * display.z, display.w};
}

} // namespace occlude::tools
