#include "generate/library_generator.h"

#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

constexpr float kEyeHeight = 1.6f; // metres
constexpr float kHall = 3.4f;      // its height
constexpr float kRowPitch = 1.6f;  // shelf and aisle
constexpr float kShelfDepth = 0.3f;
constexpr float kShelfHeight = 2.25f;
constexpr float kBoard = 0.02f;
constexpr uint32_t kLevels = 6;
constexpr float kLevelPitch = 0.36f;
constexpr uint32_t kSlots = 28; // on one board; two of them stay empty
constexpr uint32_t kBooksPerBoard = kSlots - 2;
constexpr float kShelfWidth = 1.0f;
constexpr float kHalfAisle = 1.0f; // in the middle of the hall, across the rows
constexpr float kSideAisle = 1.8f;
constexpr float kReading = 7.0f; // depth of the part with the reading places
constexpr uint32_t kBooks = 8;   // different ones

/// The detail of a book: the spine's arc and the bands on it.
struct BookDetail {
    uint32_t segments = 4;
    uint32_t bands = 0;
    uint64_t triangles() const
    {
        return 24 + 6 + 4 * uint64_t{segments} + 6 * uint64_t{segments} * bands;
    }
};

BookDetail detail_for(uint64_t triangles)
{
    const auto off = [&](const BookDetail& detail) {
        const uint64_t has = detail.triangles();
        return has > triangles ? has - triangles : triangles - has;
    };
    BookDetail best;
    for (const uint32_t segments : {4u, 8u, 16u}) {
        for (uint32_t bands = 0; bands <= 7; ++bands) {
            const BookDetail detail{segments, bands};
            if (off(detail) < off(best)) {
                best = detail;
            }
        }
    }
    return best;
}

/// A book on its lower edge, its spine towards +z, centred in x: two boards, pages a little inside
/// of them, and a round spine with bands.
Mesh make_book(const glm::vec3& size, const BookDetail& detail, std::string name,
               uint32_t item_triangles)
{
    constexpr float kCover = 0.0025f;
    constexpr float kInset = 0.004f;
    MeshBuilder builder;
    const float x = 0.5f * size.x;
    const float round = 0.3f * size.x; // how far the spine stands out
    const float z = size.z - round;
    builder.box({-x, 0.0f, 0.0f}, {-x + kCover, size.y, z});
    builder.box({x - kCover, 0.0f, 0.0f}, {x, size.y, z});
    builder.box({-x + kCover, kInset, kInset}, {x - kCover, size.y - kInset, z},
                MeshBuilder::kNegY | MeshBuilder::kPosY | MeshBuilder::kNegZ);
    // The upper half of a circle of twice as many segments, pressed flat.
    const std::vector<glm::vec2> circle = unit_circle(2 * detail.segments);
    const auto on_spine = [&](uint32_t i, float y, float out) {
        return glm::vec3{(x + out) * circle[i].x, y, z + (round + out) * circle[i].y};
    };
    const auto strip = [&](float low, float low_out, float high, float high_out) {
        for (uint32_t i = 0; i < detail.segments; ++i) {
            builder.quad(on_spine(i + 1, low, low_out), on_spine(i, low, low_out),
                         on_spine(i, high, high_out), on_spine(i + 1, high, high_out));
        }
    };
    strip(0.0f, 0.0f, size.y, 0.0f);
    for (uint32_t i = 0; i < detail.segments; ++i) {
        const glm::vec3 low{0.0f, 0.0f, z};
        const glm::vec3 high{0.0f, size.y, z};
        builder.triangle(high, on_spine(i + 1, size.y, 0.0f), on_spine(i, size.y, 0.0f));
        builder.triangle(low, on_spine(i, 0.0f, 0.0f), on_spine(i + 1, 0.0f, 0.0f));
    }
    for (uint32_t band = 0; band < detail.bands; ++band) {
        constexpr float kOut = 0.0012f;
        const float middle =
            size.y * (static_cast<float>(band) + 0.7f) / (static_cast<float>(detail.bands) + 0.4f);
        strip(middle - 0.005f, 0.0f, middle - 0.004f, kOut);
        strip(middle - 0.004f, kOut, middle + 0.004f, kOut);
        strip(middle + 0.004f, kOut, middle + 0.005f, 0.0f);
    }
    return builder.take(std::move(name), item_triangles);
}

Mesh make_shelf(uint32_t item_triangles)
{
    MeshBuilder builder;
    const float half = 0.5f * kShelfDepth;
    for (const float x : {0.0f, kShelfWidth - kBoard}) {
        builder.box({x, 0.0f, -half}, {x + kBoard, kShelfHeight, half});
    }
    for (uint32_t level = 0; level <= kLevels; ++level) {
        const float y = 0.06f + kLevelPitch * static_cast<float>(level);
        builder.box({kBoard, y, -half}, {kShelfWidth - kBoard, y + kBoard, half});
    }
    return builder.take("shelf", item_triangles);
}

Mesh make_table(uint32_t item_triangles)
{
    MeshBuilder builder;
    builder.box({-0.9f, 0.72f, -0.5f}, {0.9f, 0.76f, 0.5f});
    for (const float x : {-0.85f, 0.8f}) {
        for (const float z : {-0.45f, 0.4f}) {
            builder.box({x, 0.0f, z}, {x + 0.05f, 0.72f, z + 0.05f});
        }
    }
    const std::array<glm::vec2, 6> lamp{{{0.0f, 0.0f},
                                         {0.08f, 0.0f},
                                         {0.015f, 0.03f},
                                         {0.015f, 0.3f},
                                         {0.14f, 0.3f},
                                         {0.05f, 0.42f}}};
    turned(builder, {0.0f, 0.761f, 0.0f}, lamp, 16);
    return builder.take("table", item_triangles);
}

Mesh make_chair(uint32_t item_triangles)
{
    MeshBuilder builder;
    builder.box({-0.22f, 0.43f, -0.22f}, {0.22f, 0.46f, 0.22f});
    for (const float x : {-0.22f, 0.18f}) {
        builder.box({x, 0.0f, 0.18f}, {x + 0.04f, 0.43f, 0.22f});
        builder.box({x, 0.0f, -0.22f}, {x + 0.04f, 0.43f, -0.18f});
        builder.box({x, 0.46f, -0.22f}, {x + 0.04f, 0.9f, -0.19f});
    }
    for (const float y : {0.6f, 0.72f, 0.84f}) {
        builder.box({-0.18f, y, -0.215f}, {0.18f, y + 0.06f, -0.195f});
    }
    return builder.take("chair", item_triangles);
}

class Library {
public:
    Library(const LibraryOptions& options, uint32_t item_triangles, SceneModel& model)
        : options_(options)
        , model_(model)
        , item_triangles_(item_triangles)
    {
        constexpr uint64_t kPerShelf = uint64_t{kLevels} * kBooksPerBoard;
        shelves_ = (options.books + kPerShelf - 1) / kPerShelf;
        // About as wide as it is deep.
        while (4 * half_row_ * half_row_ * 10 < shelves_ * 16) {
            ++half_row_;
        }
        rows_ = (shelves_ + 2 * half_row_ - 1) / (2 * half_row_);
    }

    void fill()
    {
        make_meshes();
        add_hall();
        uint64_t books_left = options_.books;
        for (uint64_t i = 0; i < shelves_; ++i) {
            const uint64_t place = i % (2 * half_row_);
            // From the middle aisle outward, left and right in turn.
            const auto step = static_cast<float>(place / 2);
            const float x = place % 2 == 0 ? kHalfAisle + step * kShelfWidth
                                           : -kHalfAisle - (step + 1.0f) * kShelfWidth;
            const glm::vec3 at{x, 0.0f, row_z(i / (2 * half_row_))};
            add(shelf_, quarter_turned(0, at), {0.45f, 0.31f, 0.2f}, "shelf");
            fill_shelf(at, i, books_left);
        }
        add_reading_places();
    }

    std::vector<SceneModel::NamedPath> paths() const
    {
        const WalkStyle style{.look_ahead = 3.0f, .key_distance = 0.5f};
        return {{"walk", walk_along(rounded(corners(), 0.7f), style)}};
    }

private:
    float row_z(uint64_t row) const
    {
        return kRowPitch * (static_cast<float>(row) - 0.5f * static_cast<float>(rows_ - 1));
    }
    float half_width() const
    {
        return kHalfAisle + kShelfWidth * static_cast<float>(half_row_) + kSideAisle;
    }
    float back_z() const { return row_z(0) - 1.5f; }
    float rows_end_z() const { return row_z(rows_ - 1) + 1.5f; }
    float front_z() const { return rows_end_z() + kReading; }

    uint32_t keep(Mesh mesh)
    {
        model_.meshes.push_back(std::move(mesh));
        return static_cast<uint32_t>(model_.meshes.size() - 1);
    }

    void add(uint32_t mesh, const glm::mat4& world, const glm::vec3& color, std::string name)
    {
        model_.instances.push_back({std::move(name), mesh, world, color});
    }

    void make_meshes()
    {
        const BookDetail detail = detail_for(options_.triangles);
        for (uint32_t i = 0; i < kBooks; ++i) {
            const auto share = static_cast<float>(i) / static_cast<float>(kBooks - 1);
            const glm::vec3 size{0.018f + 0.014f * share, 0.19f + 0.1f * share,
                                 0.14f + 0.08f * share};
            keep(make_book(size, detail, fmt::format("book {}", i), item_triangles_));
        }
        shelf_ = keep(make_shelf(item_triangles_));
        table_ = keep(make_table(item_triangles_));
        chair_ = keep(make_chair(item_triangles_));
    }

    void fill_shelf(const glm::vec3& at, uint64_t shelf, uint64_t& books_left)
    {
        constexpr float kSlot = (kShelfWidth - 2.0f * kBoard) / static_cast<float>(kSlots);
        Rng rng(hash64(options_.seed, shelf, 31));
        const bool faces_away = rng.below(2) == 0;
        for (uint32_t level = 0; level < kLevels; ++level) {
            const uint32_t gap = rng.below(kSlots - 1);
            for (uint32_t slot = 0; slot < kSlots && books_left > 0; ++slot) {
                if (slot == gap || slot == gap + 1) {
                    continue;
                }
                const uint32_t book = rng.below(kBooks);
                const float y = 0.06f + kBoard + kLevelPitch * static_cast<float>(level);
                const float x = kBoard + kSlot * (static_cast<float>(slot) + 0.5f);
                // Spines in a line, more or less, a hand's width inside of the shelf's edge.
                const float back = rng.range(-0.14f, -0.11f);
                const glm::vec3 place{at.x + x, y, at.z + (faces_away ? -back : back)};
                glm::mat4 world = quarter_turned(faces_away ? 2 : 0, place);
                world[1] *= rng.range(0.92f, 1.08f);
                const float light = rng.range(0.5f, 1.0f);
                const glm::vec3 color =
                    light *
                    glm::vec3{rng.range(0.2f, 0.8f), rng.range(0.15f, 0.6f), rng.range(0.1f, 0.6f)};
                add(book, world, color, "book");
                --books_left;
            }
        }
    }

    void add_box(const glm::vec3& low, const glm::vec3& high, const glm::vec3& color,
                 const std::string& name)
    {
        MeshBuilder builder;
        builder.box(low, high);
        add(keep(builder.take(name, item_triangles_)), glm::mat4{1.0f}, color, name);
    }

    void add_hall()
    {
        constexpr float kWall = 0.3f;
        const float x = half_width();
        const float back = back_z();
        const float front = front_z();
        add_box({-x, -0.2f, back}, {x, 0.0f, front}, {0.5f, 0.42f, 0.35f}, "floor");
        add_box({-x, kHall, back}, {x, kHall + 0.2f, front}, {0.8f, 0.8f, 0.78f}, "ceiling");
        const glm::vec3 plaster{0.75f, 0.73f, 0.66f};
        add_box({-x - kWall, -0.2f, back}, {-x, kHall, front}, plaster, "wall");
        add_box({x, -0.2f, back}, {x + kWall, kHall, front}, plaster, "wall");
        add_box({-x, -0.2f, back - kWall}, {x, kHall, back}, plaster, "wall");
        add_box({-x, -0.2f, front}, {x, kHall, front + kWall}, plaster, "wall");
        MeshBuilder builder;
        builder.box({-0.6f, kHall - 0.12f, -0.1f}, {0.6f, kHall - 0.02f, 0.1f});
        const uint32_t light = keep(builder.take("light", item_triangles_));
        for (uint64_t row = 0; row + 1 < rows_; ++row) {
            for (const float side : {-1.0f, 1.0f}) {
                const glm::vec3 at{0.5f * side * x, 0.0f, row_z(row) + 0.5f * kRowPitch};
                add(light, quarter_turned(0, at), {0.95f, 0.95f, 0.9f}, "light");
            }
        }
    }

    void add_reading_places()
    {
        for (float x = 2.6f; x < half_width() - 1.2f; x += 2.4f) {
            for (const float side : {-1.0f, 1.0f}) {
                for (const float z : {rows_end_z() + 1.5f, rows_end_z() + 4.5f}) {
                    const glm::vec3 at{side * x, 0.0f, z};
                    add(table_, quarter_turned(0, at), {0.5f, 0.34f, 0.2f}, "table");
                    for (uint32_t seat = 0; seat < 4; ++seat) {
                        const float across_x = seat % 2 == 0 ? -0.45f : 0.45f;
                        const float along_z = seat < 2 ? -0.75f : 0.75f;
                        add(chair_,
                            quarter_turned(seat < 2 ? 0 : 2,
                                           at + glm::vec3{across_x, 0.0f, along_z}),
                            {0.35f, 0.25f, 0.18f}, "chair");
                    }
                }
            }
        }
    }

    /// Up and down between the rows, starting in the middle of them.
    std::vector<glm::vec3> corners() const
    {
        const float end = half_width() - 0.5f * kSideAisle;
        const auto at = [&](float x, uint64_t row) {
            return glm::vec3{x, kEyeHeight, row_z(row) + 0.5f * kRowPitch};
        };
        uint64_t row = rows_ - 1; // the aisle before the reading places
        float x = end;
        std::vector<glm::vec3> points{{0.0f, kEyeHeight, rows_end_z() + 3.0f}, at(0.0f, row)};
        if (row > 0) {
            points.push_back(at(0.0f, --row));
        }
        for (;;) {
            points.push_back(at(x, row));
            if (row == 0) {
                return points;
            }
            row -= std::min<uint64_t>(row, 2);
            points.push_back(at(x, row));
            x = -x;
        }
    }

    const LibraryOptions& options_;
    SceneModel& model_;
    uint32_t item_triangles_;
    uint64_t shelves_ = 1;
    uint64_t half_row_ = 2; ///< shelves on one side of the middle aisle
    uint64_t rows_ = 1;
    uint32_t shelf_ = 0;
    uint32_t table_ = 0;
    uint32_t chair_ = 0;
};

} // namespace

SceneModel generate_library(const LibraryOptions& options, const SceneOptions& scene_options)
{
    SceneModel model;
    model.name = fmt::format("library:books={},triangles={},seed={}", options.books,
                             options.triangles, options.seed);
    Library library(options, std::max(scene_options.item_triangles, 1u), model);
    library.fill();
    model.paths = library.paths();
    return model;
}

} // namespace occlude::tools
