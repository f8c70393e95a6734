#include "leaf_scene.h"

#include <osg/State>
#include <osgUtil/StateGraph>

#include <algorithm>
#include <bit>

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
    batch_.resize(std::max(batch_.size(), leaves.size() / 64 + 1));
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
            batch_[place / 64] |= uint64_t{1} << (place % 64);
        }
    }
    for (size_t word = 0; word < batch_.size(); ++word) {
        for (uint64_t bits = batch_[word]; bits != 0; bits &= bits - 1) {
            renderer_->render(*leaves_[word * 64 + static_cast<size_t>(std::countr_zero(bits))]);
        }
        batch_[word] = 0;
    }
}

void LeafScene::prepare_tests()
{
    osg::State& state = *renderer_->info().getState();
    saved_.read(state);
    saved_.set_for_tests(state, viewport_);
}

void LeafScene::restore_state()
{
    saved_.put_back(*renderer_->info().getState());
}

} // namespace occlude
