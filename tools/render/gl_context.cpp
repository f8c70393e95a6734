#include "render/gl_context.h"

#include <occlude/backends/gl/headless_context.h>

#include <utility>

namespace occlude::tools {

namespace {

class SurfacelessContext final : public GlContext {
public:
    explicit SurfacelessContext(std::unique_ptr<HeadlessContext> context)
        : context_(std::move(context))
    {
    }
    void make_current() override { context_->make_current(); }

private:
    std::unique_ptr<HeadlessContext> context_;
};

} // namespace

Result<std::shared_ptr<GlContext>> make_headless_gl_context()
{
    auto context = HeadlessContext::create();
    if (!context) {
        return context.error();
    }
    return std::shared_ptr<GlContext>{std::make_shared<SurfacelessContext>(std::move(*context))};
}

} // namespace occlude::tools
