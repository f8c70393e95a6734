// The renderer's shaders. Every pass computes positions by the same text, with `invariant`, so that
// depth is bit-identical between passes: relative to the camera first, as box tests do.
#pragma once

#include <string>

namespace occlude::tools::shaders {

/// Ends inside main(), which the passes continue.
///
/// Vertices are snapped to the grid of 1/256 pixel that rasterisers use. A triangle seen edge-on
/// covers samples only because it is snapped. llvmpipe takes depths from the plane through the
/// unsnapped vertices, which is steep and extrapolated: a sample ended up far nearer than the
/// triangle and every box around it. On the grid both planes are the same.
inline const std::string kPosition = R"(#version 330 core
layout(location = 0) in vec3 position_mesh;
layout(location = 1) in vec3 normal_mesh;
layout(location = 2) in vec4 world_row_0;
layout(location = 3) in vec4 world_row_1;
layout(location = 4) in vec4 world_row_2;
layout(location = 5) in vec4 base_color; // alpha: opacity
layout(location = 6) in uint id;
uniform mat4 clip_from_relative;
uniform vec3 origin;       // of the view, in the world: rounded to float ...
uniform vec3 origin_below; // ... and the rest
uniform vec2 snaps; // from the middle of the target to its right and upper edge
invariant gl_Position;
out vec3 normal;
flat out vec4 color;
flat out uint item;

void main()
{
    vec3 place = vec3(world_row_0.w, world_row_1.w, world_row_2.w) - origin;
    vec3 turned = vec3(dot(world_row_0.xyz, position_mesh), dot(world_row_1.xyz, position_mesh),
                       dot(world_row_2.xyz, position_mesh));
    vec3 relative = (turned + place) - origin_below;
    gl_Position = clip_from_relative * vec4(relative, 1.0);
    if (gl_Position.w > 0.0) {
        gl_Position.xy = round(gl_Position.xy / gl_Position.w * snaps) * (gl_Position.w / snaps);
    }
)";

inline const std::string kDepthVertex = kPosition + "}\n";
inline const std::string kIdVertex = kPosition + "    item = id;\n}\n";

// Normals go through the cofactors: right for any scale, without an inverse; their sign under
// mirrored transforms does not matter, since both sides are lit alike. The rows are scaled first,
// by a power of two that changes no bit of them: products of three would leave the range of float.
inline const std::string kShadeVertex = kPosition + R"(
    vec3 largest = max(max(abs(world_row_0.xyz), abs(world_row_1.xyz)), abs(world_row_2.xyz));
    float scale = exp2(-floor(log2(max(max(largest.x, largest.y), largest.z))));
    vec3 a = world_row_0.xyz * scale;
    vec3 b = world_row_1.xyz * scale;
    vec3 c = world_row_2.xyz * scale;
    normal = vec3(dot(cross(b, c), normal_mesh), dot(cross(c, a), normal_mesh),
                  dot(cross(a, b), normal_mesh));
    color = base_color;
}
)";

inline const std::string kDepthFragment = R"(#version 330 core
void main() {}
)";

inline const std::string kIdFragment = R"(#version 330 core
flat in uint item;
layout(location = 0) out vec4 owner; // the id's bytes
void main()
{
    owner = vec4(item & 255u, (item >> 8) & 255u, (item >> 16) & 255u, item >> 24) / 255.0;
}
)";

// Colours are linear; the square root stands in for the gamma of displays.
inline const std::string kShadeFragment = R"(#version 330 core
in vec3 normal;
flat in vec4 color;
uniform vec3 toward_light;
layout(location = 0) out vec4 shaded;

void main()
{
    float facing = abs(dot(normal, toward_light)) * inversesqrt(max(dot(normal, normal), 1e-30));
    shaded = vec4(sqrt(color.rgb * (0.25 + 0.75 * facing)), color.a);
}
)";

inline const std::string kLineVertex = R"(#version 330 core
layout(location = 0) in vec3 point_world;
uniform mat4 clip_from_relative;
uniform vec3 origin;
uniform vec3 origin_below;
void main()
{
    gl_Position = clip_from_relative * vec4((point_world - origin) - origin_below, 1.0);
}
)";

inline const std::string kLineFragment = R"(#version 330 core
uniform vec4 line_color;
layout(location = 0) out vec4 shaded;
void main() { shaded = line_color; }
)";

} // namespace occlude::tools::shaders
