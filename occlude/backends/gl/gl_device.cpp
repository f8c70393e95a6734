#include <occlude/backends/gl/gl_device.h>

#include <occlude/backends/gl/detail/gl_box_tests.h>
#include <occlude/backends/gl/detail/gl_depth_reader.h>
#include <occlude/backends/gl/detail/gl_query_pool.h>
#include <occlude/core/assert.h>
#include <occlude/screen/pyramid_tests.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <string>

namespace occlude::gl {

namespace {

constexpr int kOldestVersion = 33;

// Rough guesses for llvmpipe on two cores, flush and resume included in the batch.
constexpr TestCost kQueriesCost{TestMethod::queries, 60.0f, 18.0f, 4.0f};
constexpr TestCost kRasterCost{TestMethod::raster, 150.0f, 1.0f, 4.0f, false};
constexpr TestCost kPyramidCost{TestMethod::pyramid, 1000.0f, 0.1f, 0.1f, false};

} // namespace

struct GlDevice::Parts {
    std::unique_ptr<GlBoxTests> tests;
    std::unique_ptr<GlDepthReader> depth;
    GlQueryPool pool;
    PyramidTests pyramid;
    std::vector<Answer> answers; ///< of one batch
};

Result<std::unique_ptr<GlDevice>> GlDevice::create(GlScene& scene, const GlDeviceOptions& options)
{
    if (glGetString(GL_VERSION) == nullptr) {
        return Error{ErrorCode::unsupported,
                     "no OpenGL context is current in this thread; make one current before "
                     "creating a GlDevice"};
    }
    const int version = std::min(epoxy_gl_version(), options.max_gl_version);
    if (!epoxy_is_desktop_gl() || version < kOldestVersion) {
        return Error{ErrorCode::unsupported,
                     "the current context has " +
                         std::string(epoxy_is_desktop_gl() ? "OpenGL " : "OpenGL ES ") +
                         std::to_string(version / 10) + "." + std::to_string(version % 10) +
                         ", but a GlDevice needs OpenGL 3.3 core or newer"};
    }
    auto tests = GlBoxTests::create(version, options.depth_bias);
    if (!tests) {
        return tests.error();
    }
    auto depth = GlDepthReader::create();
    if (!depth) {
        return depth.error();
    }
    auto parts = std::make_unique<Parts>(
        Parts{std::move(*tests), std::move(*depth), GlQueryPool{options.max_outstanding}, {}, {}});
    std::unique_ptr<GlDevice> device(new GlDevice(scene, std::move(parts)));
    device->caps_.name = "gl";
    device->caps_.draw_and_query = true;
    device->caps_.read_depth = true;
    device->caps_.max_outstanding = options.max_outstanding;
    device->caps_.methods = {kQueriesCost, kPyramidCost};
    if (device->parts_->tests->can_raster()) {
        device->caps_.methods.push_back(kRasterCost);
    }
    return device;
}

GlDevice::GlDevice(GlScene& scene, std::unique_ptr<Parts> parts)
    : scene_(scene)
    , parts_(std::move(parts))
{
}

GlDevice::~GlDevice() = default;

const DeviceCaps& GlDevice::caps() const
{
    return caps_;
}

Result<bool> GlDevice::use_method(TestMethod method)
{
    if (!caps_.make_default(method)) {
        std::string there;
        for (const TestCost& cost : caps_.methods) {
            there += (there.empty() ? "" : ", ") + std::string(name(cost.method));
        }
        return Error{
            ErrorCode::unsupported,
            "the test method '" + std::string(name(method)) +
                "' needs OpenGL 4.3, which this context does not have; choose one of: " + there};
    }
    return true;
}

void GlDevice::begin_frame(const View& view)
{
    view_ = view;
    parts_->pyramid.forget();
    parts_->pool.begin_frame();
    parts_->tests->set_view(view);
    mode_ = Mode::drawing;
    scene_.begin_frame(view);
    GLint samples = 0;
    glGetIntegerv(GL_SAMPLES, &samples);
    caps_.samples_at_pixel_centers = samples <= 1;
}

// Gives the state back to the engine.
void GlDevice::leave_tests()
{
    if (mode_ != Mode::drawing) {
        scene_.restore_state();
        mode_ = Mode::drawing;
    }
}

void GlDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    leave_tests();
    parts_->pyramid.forget();
    scene_.draw(items, pass);
}

TestMethod GlDevice::method_of(const QueryBatch& batch) const
{
    return caps_.find_method(batch.method) != nullptr ? batch.method : caps_.methods.front().method;
}

void GlDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(), "query(): one ticket per test");
    const TestMethod method = method_of(batch);
    if (method == TestMethod::pyramid) {
        test_with_pyramid(batch, tickets);
        return;
    }
    const Mode mode = method == TestMethod::raster ? Mode::raster : Mode::queries;
    if (mode_ != mode) {
        parts_->tests->enter(method);
        mode_ = mode;
    }
    if (method == TestMethod::raster) {
        parts_->tests->raster(batch, parts_->pool, tickets);
    } else {
        parts_->tests->queries(batch, parts_->pool, tickets);
    }
}

void GlDevice::test_with_pyramid(const QueryBatch& batch, std::span<Ticket> tickets)
{
    const glm::ivec2 size = view_.size_px();
    if (!parts_->pyramid.fresh()) {
        const std::span<float> room =
            parts_->pyramid.resize(size); // none if the size makes no sense
        if (!room.empty() && read_depth({0, 0, size.x, size.y}, room)) {
            parts_->pyramid.build();
        }
    }
    parts_->pyramid.answer(view_, batch, parts_->answers);
    for (size_t test = 0; test < tickets.size(); ++test) {
        const Answer& answer = parts_->answers[test];
        tickets[test] =
            answer.state == AnswerState::ready ? parts_->pool.answered(answer.samples) : Ticket{};
    }
}

Ticket GlDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    if (items.empty()) {
        return parts_->pool.answered(0); // some drivers mishandle a query without a draw
    }
    leave_tests();
    parts_->pyramid.forget();
    const Ticket ticket = parts_->pool.begin();
    scene_.draw(items, pass);
    if (ticket.valid()) {
        parts_->pool.end();
    }
    return ticket;
}

void GlDevice::flush()
{
    glFlush();
}

Answer GlDevice::poll(Ticket ticket)
{
    return parts_->pool.poll(ticket);
}

Answer GlDevice::wait(Ticket ticket)
{
    return parts_->pool.wait(ticket);
}

bool GlDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    OCCLUDE_ASSERT(rect.x >= 0 && rect.y >= 0 && rect.x + rect.width <= view_.size_px().x &&
                       rect.y + rect.height <= view_.size_px().y,
                   "read_depth(): the rectangle is not inside the target");
    OCCLUDE_ASSERT(out.size() == static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height),
                   "read_depth(): one float per pixel");
    const bool reversed = view_.convention().order == DepthOrder::near_is_large;
    mode_ = Mode::unknown;
    if (!parts_->depth->read(rect, reversed ? DepthSample::smallest : DepthSample::largest, out)) {
        return false;
    }
    if (reversed) {
        std::transform(out.begin(), out.end(), out.begin(), [](float d) { return 1.0f - d; });
    }
    return true;
}

void GlDevice::end_frame()
{
    leave_tests();
    scene_.end_frame();
}

void GlDevice::warm_up()
{
    // Drivers compile per target format and per kind of query, wherever the box is.
    const QueryBox box{{glm::vec3{-1.0f}, glm::vec3{1.0f}}, nullptr, {}};
    const std::array<uint32_t, 1> ends{1};
    std::array<Ticket, 1> tickets;
    for (const TestCost& cost : caps_.methods) {
        query({{&box, 1}, ends, cost.method}, tickets);
        wait(tickets[0]);
    }
    float depth = 0.0f;
    read_depth({0, 0, 1, 1}, {&depth, 1});
}

} // namespace occlude::gl
