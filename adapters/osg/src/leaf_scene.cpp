#include "leaf_scene.h"

#include <osg/State>
#include <osgUtil/StateGraph>

namespace occlude {

void LeafRenderer::start(osg::RenderInfo& info, osgUtil::RenderLeaf& previous)
{
    info_ = &info;
    previous_ = &previous;
}

void LeafRenderer::render(osgUtil::RenderLeaf& leaf)
{
    leaf.render(*info_, previous_);
    previous_ = &leaf;
}

void LeafRenderer::finish(osgUtil::RenderLeaf& leaf)
{
    if (!info_->getState()->getAbortRendering()) {
        osgUtil::StateGraph::moveStateGraph(*info_->getState(), previous_->_parent->_parent,
                                            leaf._parent->_parent);
    }
    previous_ = &leaf;
}

void LeafScene::set_frame(LeafRenderer& renderer, std::span<osgUtil::RenderLeaf* const> leaves,
                          std::span<const uint32_t> first, std::span<const uint32_t> place_of_item)
{
    renderer_ = &renderer;
    leaves_ = leaves;
    first_ = first;
    place_of_item_ = place_of_item;
    batch_.make_room(leaves.size());
}

void LeafScene::begin_frame(const View& view)
{
    viewport_ = {view.viewport_origin_px().x, view.viewport_origin_px().y, view.size_px().x,
                 view.size_px().y};
    for (const uint32_t place : first_) {
        renderer_->render(*leaves_[place]);
    }
    // A leaf may have set others; osg::State sets them again when a leaf needs them.
    osg::State& state = *renderer_->info().getState();
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glDepthRange(0.0, 1.0);
    state.haveAppliedAttribute(osg::StateAttribute::VIEWPORT);
    state.haveAppliedAttribute(osg::StateAttribute::DEPTH);
}

// Passes are alike here: the algorithms that draw depth first are not offered (view_culler.cpp).
void LeafScene::draw(std::span<const ItemId> items, DrawPass)
{
    for (const ItemId item : items) {
        const uint32_t place = place_of_item_[item.value];
        if (place != kNotThere) {
            batch_.insert(place);
        }
    }
    batch_.take_all([this](uint32_t place) { renderer_->render(*leaves_[place]); });
}

void LeafScene::prepare_tests()
{
    saved_.read();
    saved_.set_for_tests(viewport_);
}

void LeafScene::restore_state()
{
    saved_.put_back();
}

} // namespace occlude
