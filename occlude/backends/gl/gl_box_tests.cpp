#include <occlude/backends/gl/detail/gl_box_tests.h>

#include <occlude/core/assert.h>

#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace occlude {

namespace {

constexpr size_t kFirstCapacity = 4096; // boxes, 320 KiB

// The engine's vertices and the vertices of a box are both off by at most View::clip_rounding(), in
// x, y, z and w. Rule R1 leaves w at least eight times as large as its error. So window depth is
// off by at most 8 / 7 of (z's error + w's error) / w in each stream.
constexpr float kRoundingOfTwoStreams = 2.0f * 8.0f / 7.0f;

// Corner i of the cube is at (i & 1, i >> 1 & 1, i >> 2). The winding does not matter, because both
// sides are drawn.
constexpr std::array<uint16_t, 36> kCubeIndices{0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6,
                                                0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6,
                                                0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};

// Positions relative to the view's origin first, then clip space. Both methods share these lines,
// so that they reach the same depth to the bit.
constexpr const char* kVertexShader = R"(
layout(location = 0) in vec3 box_min;
layout(location = 1) in vec3 box_max;
layout(location = 2) in vec4 relative_row_0;
layout(location = 3) in vec4 relative_row_1;
layout(location = 4) in vec4 relative_row_2;
layout(location = 5) in float toward_viewer; // added to z of clip space
#ifdef RASTER
layout(location = 6) in uint box_test;
flat out uint test;
#endif
uniform mat4 clip_from_relative;
uniform float toward_viewer_per_w; // added to normalised depth
invariant gl_Position;

void main()
{
    bvec3 upper = bvec3((gl_VertexID & 1) != 0, (gl_VertexID & 2) != 0, (gl_VertexID & 4) != 0);
    vec4 corner = vec4(mix(box_min, box_max, upper), 1.0);
    vec3 relative = vec3(dot(relative_row_0, corner), dot(relative_row_1, corner),
                         dot(relative_row_2, corner));
    gl_Position = clip_from_relative * vec4(relative, 1.0);
    gl_Position.z += toward_viewer_per_w * gl_Position.w + toward_viewer;
#ifdef RASTER
    test = box_test;
#endif
}
)";

constexpr const char* kQueriesHeader = "#version 330 core\n";
constexpr const char* kQueriesFragmentShader = R"(
void main() {}
)";

// Reads before it stores: many fragments of a box are visible, and one store is enough.
constexpr const char* kRasterHeader = "#version 430 core\n#define RASTER\n";
constexpr const char* kRasterFragmentShader = R"(
layout(early_fragment_tests) in;
layout(std430, binding = 7) buffer Flags { uint seen[]; };
flat in uint test;

void main()
{
    if (seen[test] == 0u) {
        seen[test] = 1u;
    }
}
)";

Result<GlProgram> make_box_program(std::string_view name, const std::string& version,
                                   std::string_view fragment_shader)
{
    return make_program(name, version + kVertexShader, version + std::string{fragment_shader});
}

bool can_be_tested(std::span<const QueryBox> boxes)
{
    return !boxes.empty() && std::all_of(boxes.begin(), boxes.end(),
                                         [](const QueryBox& box) { return box.box.is_bounded(); });
}

} // namespace

GlBoxTests::Program::Program(GlProgram made)
    : program(std::move(made))
    , clip_from_relative(glGetUniformLocation(program.name(), "clip_from_relative"))
    , toward_viewer_per_w(glGetUniformLocation(program.name(), "toward_viewer_per_w"))
{
}

Result<std::unique_ptr<GlBoxTests>> GlBoxTests::create(int gl_version, float depth_bias)
{
    auto queries = make_box_program("occlude box tests", kQueriesHeader, kQueriesFragmentShader);
    if (!queries) {
        return queries.error();
    }
    Program raster;
    if (gl_version >= GlBoxTests::kRasterVersion) {
        auto made = make_box_program("occlude box flags", kRasterHeader, kRasterFragmentShader);
        if (!made) {
            return made.error();
        }
        raster = Program(std::move(*made));
    }
    return std::unique_ptr<GlBoxTests>(
        new GlBoxTests(Program(std::move(*queries)), std::move(raster),
                       gl_version >= kBaseInstanceVersion, depth_bias));
}

GlBoxTests::GlBoxTests(Program queries, Program raster, bool base_instance, float depth_bias)
    : queries_(std::move(queries))
    , raster_(std::move(raster))
    , vertex_array_(GlVertexArray::make())
    , indices_(GlBuffer::make())
    , stream_(sizeof(BoxRow), kFirstCapacity)
    , depth_bias_(depth_bias)
    , base_instance_(base_instance)
{
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof(kCubeIndices), kCubeIndices.data(),
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, stream_.name());
    point_attributes_at(0);
    for (GLuint location = 0; location < 7; ++location) {
        glEnableVertexAttribArray(location);
        glVertexAttribDivisor(location, 1);
    }
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
}

// Binds the box rows from byte `offset` of the stream on. Precondition: vertex array and stream are
// bound.
void GlBoxTests::point_attributes_at(size_t offset)
{
    const auto point = [offset](GLuint location, GLint size, size_t member) {
        glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(BoxRow),
                              reinterpret_cast<const void*>(offset + member));
    };
    point(0, 3, offsetof(BoxRow, min));
    point(1, 3, offsetof(BoxRow, max));
    for (GLuint row = 0; row < 3; ++row) {
        point(2 + row, 4, offsetof(BoxRow, relative_from_box) + row * sizeof(glm::vec4));
    }
    point(5, 1, offsetof(BoxRow, toward_viewer));
    glVertexAttribIPointer(6, 1, GL_UNSIGNED_INT, sizeof(BoxRow),
                           reinterpret_cast<const void*>(offset + offsetof(BoxRow, test)));
}

void GlBoxTests::set_view(const View& view, const GlTargetState& target)
{
    view_ = view;
    target_ = target;
    queries_.view_changed = true;
    raster_.view_changed = true;
}

void GlBoxTests::enter(TestMethod method)
{
    Program& program = method == TestMethod::raster ? raster_ : queries_;
    const ClipConvention convention = view_.convention();
    glUseProgram(program.program.name());
    if (program.view_changed) {
        const float range = convention.range == DepthRange::minus_one_to_one ? 2.0f : 1.0f;
        const glm::mat4 clip_from_relative{view_.clip_from_relative()};
        glUniformMatrix4fv(program.clip_from_relative, 1, GL_FALSE,
                           glm::value_ptr(clip_from_relative));
        // Our bias is in values of the depth buffer, of which the view may use a part; the view's
        // bias is in its own depth.
        const float bias = depth_bias_ / target_.depth_extent() + view_.inflation().depth_bias;
        glUniform1f(program.toward_viewer_per_w, toward_viewer_sign() * range * bias);
        program.view_changed = false;
    }
    glBindVertexArray(vertex_array_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(target_.near_is_large(convention.order) ? GL_GEQUAL : GL_LEQUAL);
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
}

float GlBoxTests::toward_viewer_sign() const
{
    return view_.convention().order == DepthOrder::near_is_large ? 1.0f : -1.0f;
}

// The origin is subtracted in double, so that the difference rounds by a share of the distance from
// it.
void GlBoxTests::add_row(const QueryBox& box, size_t test)
{
    const glm::dvec3& origin = view_.origin();
    BoxRow row{box.box.min, box.box.max, {}, 0.0f, static_cast<uint32_t>(test)};
    glm::vec3 reach;
    if (box.world_from_box == nullptr) {
        row.min = glm::vec3{glm::dvec3{box.box.min} - origin};
        row.max = glm::vec3{glm::dvec3{box.box.max} - origin};
        row.relative_from_box = {
            {{1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f, 0.0f}}};
        reach = glm::max(glm::abs(row.min), glm::abs(row.max));
    } else {
        glm::mat4 relative = *box.world_from_box;
        relative[3] = glm::vec4{glm::vec3{glm::dvec3{relative[3]} - origin}, 1.0f};
        row.relative_from_box = {glm::row(relative, 0), glm::row(relative, 1),
                                 glm::row(relative, 2)};
        const glm::vec4 own{glm::max(glm::abs(row.min), glm::abs(row.max)), 1.0f};
        for (int axis = 0; axis < 3; ++axis) {
            reach[axis] = glm::dot(glm::abs(row.relative_from_box[static_cast<size_t>(axis)]), own);
        }
    }
    const glm::vec4 rounding = view_.clip_rounding(reach);
    row.toward_viewer = toward_viewer_sign() * kRoundingOfTwoStreams * (rounding.z + rounding.w);
    rows_.push_back(row);
}

// Where the rows are in the stream.
std::optional<size_t> GlBoxTests::write_rows()
{
    return stream_.write(std::as_bytes(std::span<const BoxRow>(rows_)));
}

bool GlBoxTests::queries(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets)
{
    rows_.clear();
    for (const QueryBox& box : batch.boxes) {
        add_row(box, 0);
    }
    const std::optional<size_t> offset = write_rows();
    if (!offset) {
        std::ranges::fill(tickets, Ticket{});
        return false;
    }

    uint32_t begin = 0;
    for (size_t test = 0; test < batch.test_ends.size(); ++test) {
        const uint32_t end = batch.test_ends[test];
        OCCLUDE_ASSERT(begin < end && end <= batch.boxes.size(), "C6: a test has no box");
        tickets[test] = Ticket{};
        if (can_be_tested(batch.boxes.subspan(begin, end - begin))) {
            tickets[test] = pool.begin();
        }
        if (tickets[test].valid()) {
            draw(*offset, begin, end - begin);
            pool.end();
        }
        begin = end;
    }
    return true;
}

bool GlBoxTests::raster(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets)
{
    const std::shared_ptr<GlFlagBatch> flags = flags_.take();
    rows_.clear();
    uint32_t begin = 0;
    for (size_t test = 0; test < batch.test_ends.size(); ++test) {
        const uint32_t end = batch.test_ends[test];
        OCCLUDE_ASSERT(begin < end && end <= batch.boxes.size(), "C6: a test has no box");
        const auto boxes = batch.boxes.subspan(begin, end - begin);
        tickets[test] = can_be_tested(boxes) ? pool.promise(flags, test) : Ticket{};
        for (const QueryBox& box : boxes) {
            if (tickets[test].valid()) {
                add_row(box, test);
            }
        }
        begin = end;
    }
    if (rows_.empty()) {
        return true;
    }
    // Tickets were already handed out: flags that could not be allocated answer "seen".
    const bool ready = flags->begin(batch.test_ends.size(), kFlagBinding);
    const std::optional<size_t> offset = write_rows();
    if (!ready || !offset) {
        flags->give_up();
        return false;
    }
    draw(*offset, 0, static_cast<uint32_t>(rows_.size()));
    flags->end();
    return true;
}

// Draws boxes [first, first + count) of the rows at byte `first_offset` of the stream.
void GlBoxTests::draw(size_t first_offset, uint32_t first, uint32_t count)
{
    constexpr GLsizei kIndexCount = static_cast<GLsizei>(kCubeIndices.size());
    if (base_instance_) {
        const auto base = static_cast<GLuint>(first_offset / sizeof(BoxRow)) + first;
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, kIndexCount, GL_UNSIGNED_SHORT, nullptr,
                                            static_cast<GLsizei>(count), base);
        return;
    }
    point_attributes_at(first_offset + first * sizeof(BoxRow));
    glDrawElementsInstanced(GL_TRIANGLES, kIndexCount, GL_UNSIGNED_SHORT, nullptr,
                            static_cast<GLsizei>(count));
}

} // namespace occlude
