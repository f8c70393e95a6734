#include <occlude/backends/gl/gl_device.h>

#include <occlude/backends/gl/detail/gl_box_tests.h>
#include <occlude/backends/gl/detail/gl_depth_reader.h>
#include <occlude/backends/gl/detail/gl_faults.h>
#include <occlude/backends/gl/detail/gl_query_pool.h>
#include <occlude/backends/gl/detail/gl_state_check.h>
#include <occlude/backends/gl/detail/gl_target_state.h>
#include <occlude/core/assert.h>
#include <occlude/screen/pyramid_tests.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <string>

namespace occlude {

namespace {

constexpr int kOldestVersion = 33;

// Rough estimates for llvmpipe on two cores. The cost of a batch includes flush and resume.
constexpr TestCost kQueriesCost{TestMethod::queries, 60.0f, 18.0f, 4.0f};
constexpr TestCost kRasterCost{TestMethod::raster, 150.0f, 1.0f, 4.0f, false};
constexpr TestCost kPyramidCost{TestMethod::pyramid, 1000.0f, 0.1f, 0.1f, false};

// Rough estimates for read-backs.
constexpr DepthReadCost kPixelsCost{1, 200.0f, 0.0f, 0.0004f};
constexpr DepthReadCost kTilesCost{2, 250.0f, 0.004f, 0.0004f};

bool checks_state(GlStateChecks checks)
{
    return checks == GlStateChecks::after_draws ||
           (checks == GlStateChecks::debug_builds && OCCLUDE_ASSERTS != 0);
}

// Some implementations have query objects that count nothing.
bool can_count_samples()
{
    GLint bits = 0;
    glGetQueryiv(GL_SAMPLES_PASSED, GL_QUERY_COUNTER_BITS, &bits);
    return bits > 0;
}

} // namespace

// Reverses the order of the rows.
static void reverse_rows(std::span<float> depths, size_t width)
{
    for (size_t low = 0, high = depths.size() - width; low < high; low += width, high -= width) {
        std::swap_ranges(depths.begin() + static_cast<ptrdiff_t>(low),
                         depths.begin() + static_cast<ptrdiff_t>(low + width),
                         depths.begin() + static_cast<ptrdiff_t>(high));
    }
}

struct GlDevice::Parts {
    std::unique_ptr<GlBoxTests> tests;
    std::unique_ptr<GlDepthReader> depth;
    GlQueryPool pool;
    GlFaults faults;
    GlDeviceOptions options;
    int gl_version = 0;
    GlTargetState target = {};
    PyramidTests pyramid = {};
    std::vector<Answer> answers = {}; ///< of one batch
};

Result<std::unique_ptr<GlDevice>> GlDevice::create(GlScene& scene, const GlDeviceOptions& options)
{
    const GlContextWatch watch;
    if ((watch.known() && watch.current() == nullptr) || glGetString(GL_VERSION) == nullptr) {
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
        Parts{.tests = std::move(*tests),
              .depth = std::move(*depth),
              .pool = GlQueryPool{options.max_outstanding, options.wait_budget_ms},
              .faults = GlFaults{options.on_message, version},
              .options = options,
              .gl_version = version});
    std::unique_ptr<GlDevice> device(new GlDevice(scene, std::move(parts)));
    DeviceCaps& caps = device->caps_;
    caps.name = "gl";
    caps.draw_and_query = can_count_samples();
    caps.read_depth = true;
    caps.depth_reads = {kPixelsCost};
    for (int tile_px = 2; tile_px <= GlDepthReader::kLargestTile; tile_px *= 2) {
        caps.depth_reads.push_back(kTilesCost);
        caps.depth_reads.back().tile_px = tile_px;
    }
    caps.max_outstanding = options.max_outstanding;
    if (caps.draw_and_query) {
        caps.methods.push_back(kQueriesCost);
    }
    caps.methods.push_back(kPyramidCost);
    if (device->parts_->tests->can_raster()) {
        caps.methods.push_back(kRasterCost);
    }
    caps.exact_counts = caps.methods.front().exact_counts;
    return device;
}

GlDevice::GlDevice(GlScene& scene, std::unique_ptr<Parts> parts)
    : scene_(scene)
    , parts_(std::move(parts))
{
}

GlDevice::~GlDevice()
{
    if (parts_->faults.look_at_context() == GlFaults::Context::other) {
        const GlNamesAreForeign foreign;
        parts_.reset();
    }
}

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
    mode_ = Mode::drawing;
    parts_->pyramid.forget();
    scene_.begin_frame(view);
    find_faults(view);
    if (frame_ == Frame::foreign) {
        return;
    }
    parts_->pool.begin_frame();
    parts_->tests->set_view(view, parts_->target);
    caps_.samples_at_pixel_centers = parts_->target.samples <= 1;
}

// Called after the engine has bound its target, and maybe made its context current.
void GlDevice::find_faults(const View& view)
{
    const GlFaults::Context context = parts_->faults.look_at_context();
    if (context != GlFaults::Context::own) {
        frame_ = Frame::foreign;
        parts_->pool.give_up();
        return;
    }
    parts_->pool.resume();
    parts_->target = GlTargetState::read(parts_->gl_version);
    frame_ = parts_->faults.can_test(view, parts_->target) ? Frame::good : Frame::untestable;
}

// Sets the state of a method, once for all batches between two draws. False if the engine has a
// query open, so that the device cannot begin one.
bool GlDevice::enter_tests(Mode mode, TestMethod method)
{
    if (mode_ == mode) {
        return !query_is_open_;
    }
    if (mode_ == Mode::drawing) {
        scene_.prepare_tests();
        if (checks_state(parts_->options.state_checks)) {
            check_gl_state(view_, parts_->target, parts_->gl_version, parts_->faults.messages());
        }
    }
    parts_->tests->enter(method);
    mode_ = mode;
    query_is_open_ = mode == Mode::queries && parts_->faults.query_is_open();
    return !query_is_open_;
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
    if (frame_ != Frame::good) {
        std::ranges::fill(tickets, Ticket{});
        return;
    }
    const TestMethod method = method_of(batch);
    if (method == TestMethod::pyramid) {
        test_with_pyramid(batch, tickets);
        return;
    }
    const Mode mode = method == TestMethod::raster ? Mode::raster : Mode::queries;
    if (!enter_tests(mode, method)) {
        std::ranges::fill(tickets, Ticket{});
        return;
    }
    const bool asked = method == TestMethod::raster
                           ? parts_->tests->raster(batch, parts_->pool, tickets)
                           : parts_->tests->queries(batch, parts_->pool, tickets);
    if (!asked) {
        parts_->faults.report_no_memory();
    }
}

void GlDevice::test_with_pyramid(const QueryBatch& batch, std::span<Ticket> tickets)
{
    const glm::ivec2 size = view_.size_px();
    if (!parts_->pyramid.fresh()) {
        const std::span<float> room = parts_->pyramid.resize(size); // none if the size is not valid
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
    const bool can_count =
        frame_ == Frame::good && caps_.draw_and_query && !parts_->faults.query_is_open();
    const Ticket ticket = can_count ? parts_->pool.begin() : Ticket{};
    scene_.draw(items, pass);
    if (ticket.valid()) {
        parts_->pool.end();
    }
    return ticket;
}

void GlDevice::flush()
{
    if (frame_ != Frame::foreign) {
        glFlush();
    }
}

Answer GlDevice::poll(Ticket ticket)
{
    return parts_->pool.poll(ticket);
}

Answer GlDevice::wait(Ticket ticket)
{
    const Answer answer = parts_->pool.wait(ticket);
    if (answer.state == AnswerState::lost) {
        report_pool();
    }
    return answer;
}

bool GlDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    OCCLUDE_ASSERT(is_inside(rect, view_.size_px()),
                   "read_depth(): the rectangle is not inside the target");
    OCCLUDE_ASSERT(out.size() == pixel_count(rect), "read_depth(): one float per pixel");
    if (frame_ != Frame::good) {
        return false;
    }
    const GlTargetState& target = parts_->target;
    const DepthOrder order = view_.convention().order;
    const DepthSample sample =
        target.near_is_large(order) ? DepthSample::smallest : DepthSample::largest;
    if (!parts_->depth->read(target.in_framebuffer(rect), sample, out)) {
        parts_->faults.report_no_depth();
        return false;
    }
    if (target.y_down) {
        reverse_rows(out, static_cast<size_t>(rect.width));
    }
    target.to_view_depth(order, out);
    return true;
}

bool GlDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    const bool legal = tile_px > 1 && caps_.find_depth_read(tile_px) != nullptr;
    OCCLUDE_ASSERT(legal, "read_depth_tiles(): caps().depth_reads lists the sizes of tiles");
    const glm::ivec2 size = view_.size_px();
    if (!legal || frame_ != Frame::good || size.x <= 0 || size.y <= 0 ||
        out.size() != pixel_count(tiles_in(size, tile_px))) {
        return false;
    }
    const GlTargetState& target = parts_->target;
    const DepthOrder order = view_.convention().order;
    const DepthSample sample =
        target.near_is_large(order) ? DepthSample::smallest : DepthSample::largest;
    if (!parts_->depth->read_tiles(target.in_framebuffer({0, 0, size.x, size.y}), tile_px,
                                   target.y_down, sample, out)) {
        parts_->faults.report_no_depth();
        return false;
    }
    target.to_view_depth(order, out);
    return true;
}

void GlDevice::report_pool()
{
    parts_->faults.report_pool(parts_->pool.take_faults(), parts_->options.max_outstanding,
                               parts_->options.wait_budget_ms);
}

void GlDevice::end_frame()
{
    leave_tests();
    scene_.end_frame();
    report_pool();
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
    std::vector<float> depths(pixel_count(tiles_in(view_.size_px(), GlDepthReader::kLargestTile)));
    read_depth_tiles(GlDepthReader::kLargestTile, depths);
}

} // namespace occlude
