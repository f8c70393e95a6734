// The engine's side of a GlDevice: draws leaves of the engine as items.
#pragma once

#include "place_set.h"
#include "saved_gl_state.h"

#include <occlude/backends/gl/gl_scene.h>
#include <occlude/core/ids.h>

#include <osg/RenderInfo>
#include <osgUtil/RenderLeaf>

#include <array>
#include <cstdint>
#include <span>

namespace occlude {

/// Renders leaves one after the other, as RenderBin does.
class LeafRenderer {
public:
    /// Starts after `previous`, whose state is set.
    void start(osg::RenderInfo& info, osgUtil::RenderLeaf& previous);
    void render(osgUtil::RenderLeaf& leaf);
    /// Goes back to the state graph of `leaf`, so that the engine can go on after it.
    void finish(osgUtil::RenderLeaf& leaf);

    osg::RenderInfo& info() const { return *info_; }

private:
    osg::RenderInfo* info_ = nullptr;
    osgUtil::RenderLeaf* previous_ = nullptr;
};

/// Leaves are known by their *place* in the engine's order. Each batch is drawn in that order.
class LeafScene final : public GlScene {
public:
    static constexpr uint32_t kNotThere = 0xffffffffu;

    /// What the next frame draws, all of it the caller's until the frame is over: by place the
    /// leaves; the places that are drawn before all tests, ascending; by ItemId the place, or
    /// kNotThere.
    void set_frame(LeafRenderer& renderer, std::span<osgUtil::RenderLeaf* const> leaves,
                   std::span<const uint32_t> first, std::span<const uint32_t> place_of_item);

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void prepare_tests() override;
    void restore_state() override;

private:
    LeafRenderer* renderer_ = nullptr;
    std::span<osgUtil::RenderLeaf* const> leaves_;
    std::span<const uint32_t> first_;
    std::span<const uint32_t> place_of_item_;
    PlaceSet batch_; ///< empty between calls
    std::array<int, 4> viewport_{};
    SavedGlState saved_;
};

} // namespace occlude
