// What an OccluderBuffer says of boxes and rectangles, and what its meshes make of what they get.
#include "cpu_fast/occluder_worlds.h"

#include <gtest/gtest.h>

#include <cstring>

namespace occlude {
namespace {

constexpr glm::ivec2 kSize{160, 90};

// Looks along -z from (0, 0, 10); the plane z = 0 is 20 x 11.25 units.
View front_view(glm::ivec2 size = kSize)
{
    const glm::mat4 clip =
        glm::perspective(2.0f * std::atan(0.5625f), 16.0f / 9.0f, 0.1f, 100.0f) *
        glm::lookAt(glm::vec3{0.0f, 0.0f, 10.0f}, glm::vec3{0.0f}, glm::vec3{0.0f, 1.0f, 0.0f});
    return View::from_clip(clip, size);
}

test::OccluderSource wall(float half_width, float half_height, int squares = 1)
{
    test::OccluderSource source;
    const auto at = [&](int x, int y) {
        const auto n = static_cast<float>(squares);
        return glm::vec3{half_width * (2.0f * static_cast<float>(x) / n - 1.0f),
                         half_height * (2.0f * static_cast<float>(y) / n - 1.0f), 0.0f};
    };
    for (int y = 0; y < squares; ++y) {
        for (int x = 0; x < squares; ++x) {
            source.quad({at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    }
    return source;
}

OccluderMesh prepared(const test::OccluderSource& source, const OccluderMeshOptions& options = {})
{
    return OccluderMesh::prepare(PositionStream(source.positions), source.indices, options);
}

std::vector<float> depth_of(const OccluderMesh& mesh, const View& view, int cell_px = 1)
{
    OccluderBuffer buffer({.cell_px = cell_px});
    buffer.begin(view);
    buffer.add(mesh, glm::mat4{1.0f});
    buffer.rasterize();
    return {buffer.depth().begin(), buffer.depth().end()};
}

size_t covered(const std::vector<float>& depth)
{
    return static_cast<size_t>(std::ranges::count_if(depth, [](float z) { return z < 1.0f; }));
}

TEST(OccluderBuffer, ABoxIsHiddenBehindAWallVisibleBeforeItAndOutsideBesideTheView)
{
    const OccluderMesh mesh = prepared(wall(4.0f, 4.0f));
    OccluderBuffer buffer;
    buffer.begin(front_view());
    buffer.add(mesh, glm::mat4{1.0f});
    const Aabb behind{{-1.0f, -1.0f, -3.0f}, {1.0f, 1.0f, -1.0f}};
    EXPECT_EQ(buffer.test(behind), Visibility::visible) << "before rasterize()";
    buffer.rasterize();
    EXPECT_EQ(buffer.test(behind), Visibility::hidden);
    EXPECT_EQ(buffer.test(Aabb{{-1.0f, -1.0f, 1.0f}, {1.0f, 1.0f, 3.0f}}), Visibility::visible);
    EXPECT_EQ(buffer.test(Aabb{{50.0f, -1.0f, -3.0f}, {52.0f, 1.0f, -1.0f}}), Visibility::outside);
    EXPECT_EQ(buffer.test(Aabb::everything()), Visibility::visible);
    buffer.begin(front_view());
    EXPECT_EQ(buffer.test(behind), Visibility::visible) << "a new frame hides nothing";
}

TEST(OccluderBuffer, ABoxThatLooksOutBesideTheWallByAPixelIsVisible)
{
    const OccluderMesh mesh = prepared(wall(4.0f, 4.0f)); // 64 pixels wide, 8 of them a unit
    OccluderBuffer buffer({.cell_px = 1});
    buffer.begin(front_view());
    buffer.add(mesh, glm::mat4{1.0f});
    buffer.rasterize();
    // The wall covers pixels 49 to 110. At z = -0.1 a unit is 7.92 pixels.
    EXPECT_EQ(buffer.test(Aabb{{2.0f, -1.0f, -0.1f}, {3.85f, 1.0f, -0.1f}}), Visibility::hidden);
    EXPECT_EQ(buffer.test(Aabb{{2.0f, -1.0f, -0.1f}, {3.95f, 1.0f, -0.1f}}), Visibility::visible);
}

TEST(OccluderBuffer, RectanglesAreTestedAtTheirDepth)
{
    const OccluderMesh mesh = prepared(wall(4.0f, 4.0f));
    OccluderBuffer buffer;
    buffer.begin(front_view());
    buffer.add(mesh, glm::mat4{1.0f});
    buffer.rasterize();
    const float wall_depth = buffer.depth()[static_cast<size_t>(22 * 80 + 40)];
    EXPECT_EQ(buffer.test(PixelRect{70, 40, 20, 10}, wall_depth + 1e-6f), Visibility::hidden);
    EXPECT_EQ(buffer.test(PixelRect{70, 40, 20, 10}, wall_depth), Visibility::visible);
    EXPECT_EQ(buffer.test(PixelRect{20, 40, 60, 10}, wall_depth + 1e-6f), Visibility::visible);
    EXPECT_EQ(buffer.test(PixelRect{-30, 0, 20, 90}, 0.9f), Visibility::outside);
    EXPECT_EQ(buffer.test(PixelRect{0, 0, INT32_MAX, INT32_MAX}, 0.9f), Visibility::visible);
}

TEST(OccluderBuffer, SharedEdgesLetNothingThrough)
{
    const std::vector<float> one = depth_of(prepared(wall(4.03f, 4.01f)), front_view());
    const std::vector<float> many = depth_of(prepared(wall(4.03f, 4.01f, 23)), front_view());
    EXPECT_GT(covered(one), 3600u);
    EXPECT_EQ(covered(one), covered(many));
}

TEST(OccluderBuffer, TrianglesThatShareNoEdgeAreCoveredOneByOne)
{
    test::OccluderSource apart = wall(4.0f, 4.0f, 8);
    for (size_t i = 0; i < apart.positions.size(); ++i) { // too little for the eye
        apart.positions[i].x += 1e-5f * static_cast<float>(i / 4);
    }
    const size_t whole = covered(depth_of(prepared(wall(4.0f, 4.0f, 8)), front_view()));
    const size_t pieces = covered(depth_of(prepared(apart), front_view()));
    EXPECT_LT(pieces, whole * 9 / 10);
    EXPECT_GT(pieces, whole / 2);
}

TEST(OccluderBuffer, CellsThatAnOccluderEndsInAreNotCovered)
{
    // The wall is exactly 64 x 64 pixels: its border cells touch open edges.
    EXPECT_EQ(covered(depth_of(prepared(wall(4.0f, 4.0f)), front_view())), 62u * 62u);
    EXPECT_EQ(covered(depth_of(prepared(wall(4.02f, 4.02f)), front_view())), 64u * 64u);
}

TEST(OccluderBuffer, ViewsThatAreNotUsableHideNothing)
{
    const OccluderMesh mesh = prepared(wall(400.0f, 400.0f));
    for (const View& view : {View{}, View::from_clip(glm::mat4{0.0f}, kSize), front_view({0, 7}),
                             front_view({100000, 10})}) {
        OccluderBuffer buffer;
        buffer.begin(view);
        buffer.add(mesh, glm::mat4{1.0f});
        buffer.rasterize();
        EXPECT_EQ(buffer.test(Aabb{{-1.0f, -1.0f, -3.0f}, {1.0f, 1.0f, -1.0f}}),
                  Visibility::visible);
        EXPECT_EQ(buffer.test(PixelRect{0, 0, 4, 4}, 1.0f), Visibility::visible);
        float one = 0.5f;
        EXPECT_FALSE(buffer.read_depth({0, 0, 1, 1}, std::span{&one, 1}));
    }
}

TEST(OccluderBuffer, TransformsThatAreNotFiniteOrSingularHideNothing)
{
    const OccluderMesh mesh = prepared(wall(4.0f, 4.0f));
    for (const float scale :
         {0.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        OccluderBuffer buffer;
        buffer.begin(front_view());
        buffer.add(mesh, glm::mat4{scale});
        buffer.rasterize();
        EXPECT_EQ(std::ranges::count(buffer.depth(), 1.0f), 80 * 45);
    }
}

TEST(OccluderBuffer, ReadsTheDepthOfTheCellThatAPixelLiesIn)
{
    const OccluderMesh mesh = prepared(wall(3.0f, 2.0f));
    OccluderBuffer buffer({.cell_px = 3});
    const glm::ivec2 size{161, 91};
    buffer.begin(front_view(size));
    buffer.add(mesh, glm::mat4{1.0f});
    buffer.rasterize();
    EXPECT_EQ(buffer.size_cells(), (glm::ivec2{54, 31}));
    const PixelRect rect{50, 20, 61, 47};
    std::vector<float> pixels(static_cast<size_t>(rect.width * rect.height));
    ASSERT_TRUE(buffer.read_depth(rect, pixels));
    for (int y = 0; y < rect.height; ++y) {
        for (int x = 0; x < rect.width; ++x) {
            ASSERT_EQ(pixels[static_cast<size_t>(y * rect.width + x)],
                      buffer.depth()[static_cast<size_t>((y + 20) / 3 * 54 + (x + 50) / 3)]);
        }
    }
    EXPECT_GT(covered(pixels), 100u);
    EXPECT_FALSE(buffer.read_depth({150, 20, 61, 47}, pixels));
}

TEST(OccluderMesh, IndicesOf16BitsAndStridesMeanTheSame)
{
    const test::OccluderSource source = wall(4.0f, 3.0f, 3);
    std::vector<uint16_t> narrow;
    for (const uint32_t index : source.indices) {
        narrow.push_back(static_cast<uint16_t>(index));
    }
    constexpr size_t kStride = 23; // not even aligned
    std::vector<std::byte> bytes(source.positions.size() * kStride);
    for (size_t i = 0; i < source.positions.size(); ++i) {
        std::memcpy(bytes.data() + i * kStride + 5, &source.positions[i], sizeof(glm::vec3));
    }
    const OccluderMesh mesh = OccluderMesh::prepare(
        PositionStream(bytes.data() + 5, source.positions.size(), kStride), narrow);
    EXPECT_EQ(depth_of(mesh, front_view()), depth_of(prepared(source), front_view()));
}

TEST(OccluderMesh, OnlySidesThatTheEngineDrawsHideAnything)
{
    test::OccluderSource source = wall(4.0f, 3.0f);
    const auto cells = [&](MeshFaces faces) {
        return covered(depth_of(prepared(source, {.faces = faces}), front_view()));
    };
    EXPECT_GT(cells(MeshFaces::both), 1000u);
    EXPECT_EQ(cells(MeshFaces::counterclockwise), cells(MeshFaces::both));
    EXPECT_EQ(cells(MeshFaces::clockwise), 0u);
    std::ranges::reverse(source.indices);
    EXPECT_GT(cells(MeshFaces::both), 1000u);
    EXPECT_EQ(cells(MeshFaces::counterclockwise), 0u);
    EXPECT_EQ(cells(MeshFaces::clockwise), cells(MeshFaces::both));
}

TEST(OccluderMesh, AMirroredInstanceShowsTheSideThatFacesTheEyeInTheMesh)
{
    const OccluderMesh mesh = prepared(wall(4.0f, 3.0f), {.faces = MeshFaces::counterclockwise});
    const auto cells = [&](glm::vec3 scale) {
        OccluderBuffer buffer;
        buffer.begin(front_view());
        buffer.add(mesh, glm::scale(glm::mat4{1.0f}, scale));
        buffer.rasterize();
        return covered({buffer.depth().begin(), buffer.depth().end()});
    };
    EXPECT_GT(cells({-1.0f, 1.0f, 1.0f}), 400u) << "the eye is still before the front";
    EXPECT_EQ(cells({1.0f, 1.0f, -1.0f}), 0u) << "now it is behind it";
}

TEST(OccluderMesh, ABallIsOneClosedPieceHoweverItsTrianglesAreWound)
{
    for (const bool mixed : {false, true}) {
        Rng rng(3);
        const OccluderMesh mesh = prepared(test::ball(rng, 8, 3.0f, mixed));
        ASSERT_EQ(mesh.pieces().size(), 1u);
        EXPECT_TRUE(mesh.pieces()[0].closed);
        EXPECT_EQ(mesh.positions().size(), 2u + 7u * 16u) << "equal positions are one vertex";
        EXPECT_GT(covered(depth_of(mesh, front_view())), 1500u);
    }
}

TEST(OccluderMesh, LeavesOutTrianglesThatAreNone)
{
    const std::vector<glm::vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, NAN, 0}};
    const std::vector<uint32_t> indices{0, 1, 2, 0, 1, 3, 0, 1, 9, 0, 0, 1, 2};
    const OccluderMesh mesh = OccluderMesh::prepare(PositionStream(positions), indices);
    EXPECT_EQ(mesh.triangles().size(), 1u);
    EXPECT_TRUE(OccluderMesh{}.empty());
}

TEST(OccluderMesh, PositionsMayChangeWhereVerticesAreWeldedByIndex)
{
    const test::OccluderSource here = wall(2.0f, 2.0f);
    const test::OccluderSource there = wall(4.0f, 3.0f);
    OccluderMesh mesh = prepared(here, {.welding = MeshWelding::by_index});
    ASSERT_TRUE(mesh.set_positions(PositionStream(there.positions)));
    EXPECT_EQ(depth_of(mesh, front_view()), depth_of(prepared(there), front_view()));
    EXPECT_FALSE(mesh.set_positions(PositionStream(std::span{there.positions}.first(2))));
    OccluderMesh rigid = prepared(here);
    EXPECT_FALSE(rigid.set_positions(PositionStream(there.positions)));
}

} // namespace
} // namespace occlude
