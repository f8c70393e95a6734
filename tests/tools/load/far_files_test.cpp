// Files of formats that Assimp reads in single precision, whose coordinates lie far from the
// origin.
#include "generate/scene_source.h"
#include "load/assimp_files.h"
#include "model/focus.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstdio>
#include <string>

namespace occlude::tools {
namespace {

bool says_what_precision_is_left(const SceneModel& model)
{
    return std::any_of(model.load_notes.begin(), model.load_notes.end(), [](const auto& note) {
        return note.find("single precision") != std::string::npos;
    });
}

/// A town of houses and thin sills, moved by `offset`, as OBJ with 4 decimals.
std::string sills_obj(double x, double y, double z)
{
    std::string obj;
    int first = 1;
    const auto box = [&](double left, double low, double front, double w, double h, double d) {
        for (int i = 0; i < 8; ++i) {
            char line[128];
            std::snprintf(line, sizeof line, "v %.4f %.4f %.4f\n", x + left + (i & 4 ? w : 0.0),
                          y + low + (i & 2 ? h : 0.0), z + front + (i & 1 ? d : 0.0));
            obj += line;
        }
        constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                      {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
        for (const auto& face : kFaces) {
            obj += "f";
            for (const int corner : face) {
                obj += ' ' + std::to_string(first + corner);
            }
            obj += '\n';
        }
        first += 8;
    };
    for (int house = 0; house < 9; ++house) {
        const double left = 12.0 * (house % 3);
        const double front = 12.0 * (house / 3);
        obj += "o house" + std::to_string(house) + "\n";
        box(left, 0.0, front, 8.0, 9.0, 8.0);
        obj += "o sill" + std::to_string(house) + "\n";
        box(left, 2.0, front - 0.06, 1.0, 0.06, 0.06);
    }
    return obj;
}

TEST(FarFiles, NoTriangleOfAFarObjFileIsLost)
{
    const TempFolder folder;
    const auto near = load_scene(folder.write("near.obj", sills_obj(0.0, 0.0, 0.0)));
    const auto far = load_scene(folder.write("far.obj", sills_obj(442437.5, 723.8, 4481087.2)));
    ASSERT_TRUE(near && far);
    EXPECT_EQ(drawn_triangles(*near), 216u);
    EXPECT_EQ(drawn_triangles(*far), 216u);
    EXPECT_TRUE(far->load_losses.empty()) << far->load_losses.front();
    const glm::vec3 right = world_bounds(*near).extent();
    const glm::vec3 read = world_bounds(*far).extent();
    EXPECT_LT(glm::distance(right, read), 1e-3f);
    EXPECT_LT(glm::length(world_bounds(*far).center()), 64.0f);
}

TEST(FarFiles, AMarkerAtTheOriginOfAFarObjFileCostsNoTriangle)
{
    const TempFolder folder;
    const std::string marker = "o marker\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
    const auto far =
        load_scene(folder.write("marked.obj", sills_obj(442437.5, 723.8, 4481087.2) + marker));
    ASSERT_TRUE(far) << far.error().message;
    EXPECT_EQ(drawn_triangles(*far), 217u);
    EXPECT_TRUE(far->load_losses.empty()) << far->load_losses.front();
    EXPECT_EQ(find_focus(*far).left_out, 1u);
    EXPECT_FALSE(says_what_precision_is_left(*far));
}

TEST(FarFiles, AFarObjFileOfTinyUnitsIsMovedByFractionsOfThem)
{
    std::string tiny; // a sheet of points a millionth apart
    for (int i = 0; i < 100; ++i) {
        tiny += "v " + std::to_string(0.3 + 1e-6 * (i % 10)) + " 0 " +
                std::to_string(1e-6 * (i / 10)) + "\n";
    }
    EXPECT_NEAR(far_offset_of_obj(tiny).x, 0.3, 1e-4);
    EXPECT_EQ(far_offset_of_obj("v 1 0 0\nv 2 0 0\nv 3 0 1\nv 4 1 0\n"), glm::dvec3{0.0});
    EXPECT_EQ(far_offset_of_obj("v 1000 0 0\n"), glm::dvec3{0.0}) << "a point has no size";
}

TEST(FarFiles, OfOtherFormatsSayWhatPrecisionIsLeft)
{
    const auto quad_ply = [](double x) {
        std::string ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\n"
                          "property double y\nproperty double z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n";
        for (const int corner : {0, 1, 3, 2}) {
            ply += std::to_string(x + 8 * (corner & 1)) + " 0 " + std::to_string(4 * (corner & 2)) +
                   "\n";
        }
        return ply + "4 0 1 2 3\n";
    };
    const TempFolder folder;
    const auto near = load_scene(folder.write("near.ply", quad_ply(0.0)));
    const auto far = load_scene(folder.write("far.ply", quad_ply(4e6)));
    ASSERT_TRUE(near && far);
    EXPECT_FALSE(says_what_precision_is_left(*near));
    EXPECT_TRUE(says_what_precision_is_left(*far));
}

} // namespace
} // namespace occlude::tools
