#include "render/gl_renderer.h"

#include "render/gl_lines.h"
#include "render/gl_programs.h"

#include <occlude/core/assert.h>

#include <algorithm>

namespace occlude::tools {

namespace {

constexpr glm::vec4 kBackground{0.55f, 0.68f, 0.82f, 1.0f};
constexpr int kClipControlVersion = 45;

class GlRenderer final : public SceneRenderer, public GlPictureSource, private GlScene {
public:
    static Result<std::unique_ptr<SceneRenderer>> create(const SceneModel& model,
                                                         std::span<const SceneModel::Item> items,
                                                         glm::ivec2 size, int samples,
                                                         const GlRendererOptions& options);
    ~GlRenderer() override { context_->make_current(); }

    std::string api() const override;
    std::string renderer_name() const override;
    QueryDevice& device() override { return *device_; }
    Result<bool> use_test_method(TestMethod method) override { return device_->use_method(method); }
    Result<bool> resize(glm::ivec2 size, int samples) override;
    void finish() override;
    void warm_up() override;
    void render(const View& view, std::span<const ItemId> items) override;
    Capture capture() override;
    std::vector<uint32_t> render_ids(const View& view, std::span<const ItemId> items) override;
    void set_item_colors(std::span<const glm::vec4> colors) override;
    void draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                    bool on_top) override;
    void update_transforms(std::span<const glm::mat4> world_from_mesh) override;
    void update_items(std::span<const SceneModel::Item> items) override;
    void copy_color_to(unsigned framebuffer) override;

private:
    GlRenderer(std::shared_ptr<GlContext> context, const SceneModel& model,
               std::span<const SceneModel::Item> items, int gl_version);
    void find_translucent(std::span<const SceneModel::Item> items);
    Result<bool> make_parts(glm::ivec2 size, int samples, const GlRendererOptions& options);

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void restore_state() override;

    void draw_opaque(std::span<const ItemId> items, DrawPass pass);
    void draw_translucent(std::span<const ItemId> items, DrawPass pass);
    void warm_up_with(ItemId item);
    bool translucent(ItemId item) const
    {
        return !translucent_.empty() && translucent_[item.value];
    }

    void set_view(const View& view);

    std::shared_ptr<GlContext> context_; // first, so that everything below is destroyed while it
                                         // lives
    const SceneModel& model_;
    int gl_version_ = 0;
    size_t item_count_ = 0;
    std::vector<bool> translucent_; ///< by ItemId; empty if no item is
    GlGeometry geometry_;
    GlTarget target_;
    GlPrograms programs_;
    GlLines lines_;
    std::unique_ptr<GlDepthReader> depth_reader_;
    std::unique_ptr<GlDevice> device_;
    View view_;
    GlGeometry::Rows rows_ = GlGeometry::Rows::instance;
};

GlRenderer::GlRenderer(std::shared_ptr<GlContext> context, const SceneModel& model,
                       std::span<const SceneModel::Item> items, int gl_version)
    : context_(std::move(context))
    , model_(model)
    , gl_version_(gl_version)
    , item_count_(items.size())
    , geometry_(model, items, gl_version)
{
    find_translucent(items);
}

void GlRenderer::find_translucent(std::span<const SceneModel::Item> items)
{
    const auto blended = [&](const SceneModel::Item& item) {
        return model_.instances[item.instance].translucent();
    };
    translucent_.clear();
    if (std::any_of(items.begin(), items.end(), blended)) {
        for (const SceneModel::Item& item : items) {
            translucent_.push_back(blended(item));
        }
    }
}

Result<bool> GlRenderer::make_parts(glm::ivec2 size, int samples, const GlRendererOptions& options)
{
    Result<GlPrograms> programs = make_programs(model_.up);
    if (!programs) {
        return programs.error();
    }
    programs_ = std::move(*programs);
    Result<bool> target = target_.resize(size, samples);
    if (!target) {
        return target.error();
    }
    auto reader = GlDepthReader::create();
    if (!reader) {
        return reader.error();
    }
    depth_reader_ = std::move(*reader);
    auto device = GlDevice::create(*this, {.max_gl_version = options.max_gl_version});
    if (!device) {
        return device.error();
    }
    device_ = std::move(*device);
    return true;
}

Result<std::unique_ptr<SceneRenderer>> GlRenderer::create(const SceneModel& model,
                                                          std::span<const SceneModel::Item> items,
                                                          glm::ivec2 size, int samples,
                                                          const GlRendererOptions& options)
{
    std::shared_ptr<GlContext> context = options.context;
    if (context == nullptr) {
        auto made = make_headless_gl_context();
        if (!made) {
            return made.error();
        }
        context = std::move(*made);
    }
    context->make_current();
    const int version = std::min(epoxy_gl_version(), options.max_gl_version);
    std::unique_ptr<GlRenderer> renderer(new GlRenderer(std::move(context), model, items, version));
    Result<bool> made = renderer->make_parts(size, samples, options);
    if (!made) {
        return made.error();
    }
    return std::unique_ptr<SceneRenderer>(std::move(renderer));
}

std::string GlRenderer::api() const
{
    return "gl " + std::to_string(gl_version_ / 10) + "." + std::to_string(gl_version_ % 10);
}

std::string GlRenderer::renderer_name() const
{
    context_->make_current();
    return reinterpret_cast<const char*>(glGetString(GL_RENDERER));
}

Result<bool> GlRenderer::resize(glm::ivec2 size, int samples)
{
    context_->make_current();
    return target_.resize(size, samples);
}

void GlRenderer::finish()
{
    context_->make_current();
    glFinish();
}

// Sets the camera of the next draws, with the depth convention of its view. The target is bound.
void GlRenderer::set_view(const View& view)
{
    view_ = view;
    const ClipConvention convention = view.convention();
    if (gl_version_ >= kClipControlVersion) {
        glClipControl(GL_LOWER_LEFT, convention.range == DepthRange::zero_to_one
                                         ? GL_ZERO_TO_ONE
                                         : GL_NEGATIVE_ONE_TO_ONE);
    }
    glClearDepth(convention.order == DepthOrder::near_is_large ? 0.0 : 1.0);
}

void GlRenderer::begin_frame(const View& view)
{
    context_->make_current();
    target_.bind();
    set_view(view);
    use_camera(programs_.depth, view_);
    use_camera(programs_.shade, view_);
    restore_state();
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearColor(kBackground.r, kBackground.g, kBackground.b, kBackground.a);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

// Sets the state that a pass does not set in draw().
void GlRenderer::restore_state()
{
    glEnable(GL_DEPTH_TEST);
    if (view_.ignores_near_plane()) {
        glEnable(GL_DEPTH_CLAMP);
    } else {
        glDisable(GL_DEPTH_CLAMP);
    }
    glDisable(GL_CULL_FACE);
}

// Draws runs of opaque and of translucent items, one after the other.
void GlRenderer::draw(std::span<const ItemId> items, DrawPass pass)
{
    if (translucent_.empty()) {
        draw_opaque(items, pass);
        return;
    }
    while (!items.empty()) {
        const bool blended = translucent(items.front());
        const auto run_end = std::find_if(
            items.begin(), items.end(), [&](ItemId item) { return translucent(item) != blended; });
        const auto run = items.first(static_cast<size_t>(run_end - items.begin()));
        if (blended) {
            draw_translucent(run, pass);
        } else {
            draw_opaque(run, pass);
        }
        items = items.subspan(run.size());
    }
}

// They write no depth, so that only the shade pass draws them.
void GlRenderer::draw_translucent(std::span<const ItemId> items, DrawPass pass)
{
    if (pass != DrawPass::shade) {
        return;
    }
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glDepthFunc(view_.convention().order == DepthOrder::near_is_large ? GL_GREATER : GL_LESS);
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    glUseProgram(programs_.shade.name());
    geometry_.draw(items, rows_);
    glDisable(GL_BLEND);
}

void GlRenderer::draw_opaque(std::span<const ItemId> items, DrawPass pass)
{
    const bool depth_only = pass == DrawPass::depth_only;
    const bool equal = pass == DrawPass::shade_equal;
    const bool reversed = view_.convention().order == DepthOrder::near_is_large;
    const GLboolean colors = depth_only ? GL_FALSE : GL_TRUE;
    glColorMask(colors, colors, colors, colors);
    glDepthMask(equal ? GL_FALSE : GL_TRUE);
    glDepthFunc(equal ? GL_EQUAL : reversed ? GL_GREATER : GL_LESS);
    glUseProgram(depth_only ? programs_.depth.name() : programs_.shade.name());
    geometry_.draw(items, rows_);
}

void GlRenderer::render(const View& view, std::span<const ItemId> items)
{
    context_->make_current();
    device_->begin_frame(view);
    device_->draw(items, DrawPass::shade);
    device_->end_frame();
}

void GlRenderer::warm_up_with(ItemId item)
{
    const std::span<const ItemId> items{&item, 1};
    for (const DrawPass pass : {DrawPass::shade, DrawPass::depth_only, DrawPass::shade_equal}) {
        device_->draw(items, pass);
        device_->wait(device_->draw_and_query(items, pass));
    }
}

// Drivers compile a shader per combination of state: every pass, inside and outside a query.
void GlRenderer::warm_up()
{
    context_->make_current();
    device_->begin_frame(View::from_clip(glm::mat4{1.0f}, target_.size()));
    if (item_count_ > 0) {
        warm_up_with(ItemId{0u});
    }
    // The other kind of item, if there is one.
    for (uint32_t i = 1; i < translucent_.size(); ++i) {
        if (translucent_[i] != translucent_[0]) {
            warm_up_with(ItemId{i});
            break;
        }
    }
    device_->warm_up();
    device_->end_frame();
    glFinish();
}

Capture GlRenderer::capture()
{
    context_->make_current();
    return target_.capture(*depth_reader_);
}

std::vector<uint32_t> GlRenderer::render_ids(const View& view, std::span<const ItemId> items)
{
    context_->make_current();
    if (!target_.bind_ids()) {
        target_.bind();
        return {};
    }
    set_view(view);
    restore_state();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glDepthFunc(view.convention().order == DepthOrder::near_is_large ? GL_GREATER : GL_LESS);
    glClearColor(1.0f, 1.0f, 1.0f, 1.0f); // the bytes of the invalid id
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    use_camera(programs_.ids, view_);
    std::vector<ItemId> owning;
    if (!translucent_.empty()) {
        std::copy_if(items.begin(), items.end(), std::back_inserter(owning),
                     [&](ItemId item) { return !translucent(item); });
        items = owning;
    }
    geometry_.draw(items, GlGeometry::Rows::item);
    std::vector<uint32_t> ids = target_.read_ids();
    target_.bind();
    return ids;
}

void GlRenderer::set_item_colors(std::span<const glm::vec4> colors)
{
    context_->make_current();
    geometry_.set_item_colors(colors);
    rows_ = colors.empty() ? GlGeometry::Rows::instance : GlGeometry::Rows::item;
}

void GlRenderer::draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                            bool on_top)
{
    if (points.empty()) {
        return;
    }
    context_->make_current();
    target_.bind();
    set_view(view);
    restore_state();
    if (on_top) {
        glDisable(GL_DEPTH_TEST);
    }
    glDepthFunc(view.convention().order == DepthOrder::near_is_large ? GL_GEQUAL : GL_LEQUAL);
    glDepthMask(GL_FALSE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    use_camera(programs_.lines, view_);
    lines_.draw(programs_.lines, points, color);
}

void GlRenderer::copy_color_to(unsigned framebuffer)
{
    context_->make_current();
    target_.copy_color_to(framebuffer);
}

void GlRenderer::update_transforms(std::span<const glm::mat4> world_from_mesh)
{
    context_->make_current();
    geometry_.update_transforms(world_from_mesh);
}

void GlRenderer::update_items(std::span<const SceneModel::Item> items)
{
    OCCLUDE_ASSERT(items.size() == item_count_, "update_items(): the number of items is fixed");
    context_->make_current();
    geometry_.update_items(model_, items);
    find_translucent(items);
}

} // namespace

Result<std::unique_ptr<SceneRenderer>> make_gl_renderer(const SceneModel& model,
                                                        std::span<const SceneModel::Item> items,
                                                        glm::ivec2 size, int samples)
{
    return GlRenderer::create(model, items, size, samples, {});
}

Result<std::unique_ptr<SceneRenderer>> make_gl_renderer(const SceneModel& model,
                                                        std::span<const SceneModel::Item> items,
                                                        glm::ivec2 size, int samples,
                                                        const GlRendererOptions& options)
{
    return GlRenderer::create(model, items, size, samples, options);
}

} // namespace occlude::tools
