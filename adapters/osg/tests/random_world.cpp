#include "random_world.h"

#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/LineWidth>
#include <osg/Material>
#include <osg/PolygonOffset>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

// Things stand in cells of a grid and walls between them, so that no two surfaces touch: where they
// do, a pixel shows what was drawn first.
constexpr float kCell = 5.0f;
constexpr int kCells = 24; // along a side
constexpr float kHalfWorld = 0.5f * kCells * kCell;
constexpr int kThings = 400;
constexpr int kOddThings = 24;
constexpr int kStates = 12;

// A box from (-1, -1, 0) to (1, 1, 1) before it is stretched; quads, with normals.
osg::ref_ptr<osg::Geometry> stretched_box(const osg::Vec3& half, float height)
{
    const auto vertices = osg::ref_ptr(new osg::Vec3Array);
    const auto normals = osg::ref_ptr(new osg::Vec3Array(osg::Array::BIND_PER_VERTEX));
    const auto face = [&](const osg::Vec3& normal, std::initializer_list<osg::Vec3> corners) {
        for (const osg::Vec3& corner : corners) {
            vertices->push_back(
                {corner.x() * half.x(), corner.y() * half.y(), corner.z() * height});
            normals->push_back(normal);
        }
    };
    face({0, 0, 1}, {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}});
    face({0, 0, -1}, {{-1, 1, 0}, {1, 1, 0}, {1, -1, 0}, {-1, -1, 0}});
    face({0, -1, 0}, {{-1, -1, 0}, {1, -1, 0}, {1, -1, 1}, {-1, -1, 1}});
    face({0, 1, 0}, {{1, 1, 0}, {-1, 1, 0}, {-1, 1, 1}, {1, 1, 1}});
    face({-1, 0, 0}, {{-1, 1, 0}, {-1, -1, 0}, {-1, -1, 1}, {-1, 1, 1}});
    face({1, 0, 0}, {{1, -1, 0}, {1, 1, 0}, {1, 1, 1}, {1, -1, 1}});
    osg::ref_ptr<osg::Geometry> box = new osg::Geometry;
    box->setUseDisplayList(false);
    box->setUseVertexBufferObjects(true);
    box->setVertexArray(vertices.get());
    box->setNormalArray(normals.get());
    box->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, 24));
    return box;
}

} // namespace

RandomWorld::RandomWorld(const WorldOptions& options)
    : options_(options)
    , rng_(options.seed)
    , root_(new osg::Group)
    , things_(new osg::Group)
    , shared_(make_box(1.0f))
{
    root_->addChild(things_.get());
    for (int i = 0; i < kStates; ++i) {
        osg::ref_ptr<osg::Material> material = new osg::Material;
        material->setDiffuse(
            osg::Material::FRONT_AND_BACK,
            {rng_.range(0.1f, 1.0f), rng_.range(0.1f, 1.0f), rng_.range(0.1f, 1.0f), 1.0f});
        states_.emplace_back(new osg::StateSet);
        states_.back()->setAttributeAndModes(material.get());
        if (i % 3 == 0) {
            states_.back()->setAttributeAndModes(new osg::CullFace);
        }
    }
    for (int i = 0; i < kCells * kCells; ++i) {
        free_places_.emplace_back((static_cast<float>(i / kCells) + 0.5f) * kCell - kHalfWorld,
                                  (static_cast<float>(i % kCells) + 0.5f) * kCell - kHalfWorld,
                                  rng_.range(0.1f, 0.4f));
    }
    add_walls();
    for (int i = 0; i < kThings; ++i) {
        things_->addChild(random_thing().get());
    }
    if (options_.odd_states) {
        add_odd_things();
    }
    eye_ = free_places_.front() + osg::Vec3(0, 0, 1.7f);
}

osg::ref_ptr<osg::Geometry> RandomWorld::make_box(float half_size)
{
    return stretched_box({half_size, half_size * rng_.range(0.3f, 1.0f), 0.0f},
                         half_size * rng_.range(0.5f, 3.0f));
}

osg::ref_ptr<osg::StateSet> RandomWorld::random_state()
{
    return states_[rng_.below(kStates)];
}

// The middle of a free cell, a little above the ground.
osg::Vec3 RandomWorld::take_place()
{
    const size_t index = rng_.below(static_cast<uint32_t>(free_places_.size()));
    const osg::Vec3 place = free_places_[index];
    free_places_[index] = free_places_.back();
    free_places_.pop_back();
    return place;
}

osg::Matrix RandomWorld::turned_at(const osg::Vec3& place)
{
    return osg::Matrix::rotate(rng_.range(0.0f, 6.3f), osg::Vec3(0, 0, 1)) *
           osg::Matrix::translate(place);
}

// One wall to a row of cells, as thin as the room that things leave.
void RandomWorld::add_walls()
{
    const auto ground = stretched_box({2 * kHalfWorld, 2 * kHalfWorld, 0.0f}, -1.0f);
    ground->setStateSet(states_[0].get());
    root_->addChild(ground.get());
    for (int row = 1; row < kCells; ++row) {
        const osg::Vec3 middle(rng_.range(-kHalfWorld, kHalfWorld),
                               static_cast<float>(row) * kCell - kHalfWorld, 0.05f);
        osg::ref_ptr<osg::MatrixTransform> at =
            new osg::MatrixTransform(osg::Matrix::translate(middle));
        at->addChild(stretched_box({rng_.range(5.0f, 25.0f), 0.2f, 0.0f}, 8.0f));
        at->setStateSet(random_state().get());
        root_->addChild(at.get());
    }
}

osg::ref_ptr<osg::Node> RandomWorld::random_thing()
{
    osg::ref_ptr<osg::MatrixTransform> at = new osg::MatrixTransform(turned_at(take_place()));
    at->setStateSet(random_state().get());
    const uint32_t kind = rng_.below(10);
    osg::ref_ptr<osg::Geometry> box = kind < 3 ? shared_ : make_box(rng_.range(0.2f, 1.5f));
    if (kind == 4 && options_.levels) {
        osg::ref_ptr<osg::LOD> levels = new osg::LOD;
        levels->addChild(box.get(), 0.0f, 20.0f);
        levels->addChild(make_box(1.0f).get(), 20.0f, 1e6f);
        at->addChild(levels.get());
    } else if (kind == 5 && options_.comes_and_goes) {
        switches_.emplace_back(new osg::Switch);
        switches_.back()->addChild(box.get());
        at->addChild(switches_.back().get());
    } else {
        at->addChild(box.get());
    }
    if ((kind == 2 || kind == 6) && options_.moves) {
        at->setDataVariance(osg::Object::DYNAMIC);
        movers_.push_back(at);
    }
    if (kind == 7 && options_.deforms) {
        box->setDataVariance(osg::Object::DYNAMIC);
        deformers_.push_back(box);
    }
    return at;
}

// Drawn in the opaque bin, though their state is not that of opaque things; and a bin of its own.
void RandomWorld::add_odd_things()
{
    for (int i = 0; i < kOddThings; ++i) {
        osg::ref_ptr<osg::MatrixTransform> at =
            new osg::MatrixTransform(osg::Matrix::translate(take_place()));
        osg::ref_ptr<osg::Geometry> box = make_box(1.0f);
        at->addChild(box.get());
        osg::StateSet& state = *at->getOrCreateStateSet();
        state.setAttribute(
            states_[static_cast<size_t>(i) % kStates]->getAttribute(osg::StateAttribute::MATERIAL));
        switch (i % 6) {
        case 0:
            state.setAttributeAndModes(new osg::BlendFunc(GL_ONE, GL_ONE));
            state.setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
            break;
        case 1:
            state.setAttributeAndModes(new osg::PolygonOffset(-2.0f, -2.0f));
            break;
        case 2:
            box->setPrimitiveSet(0, new osg::DrawArrays(GL_LINES, 0, 24));
            state.setAttributeAndModes(new osg::LineWidth(3.0f));
            break;
        case 3:
            box->setCullingActive(false);
            break;
        case 4:
            state.setRenderBinDetails(-1, "RenderBin");
            break;
        default:
            // One of these alone: each parts the others in two.
            if (i == 5) {
                state.setAttributeAndModes(new osg::BlendFunc(GL_SRC_COLOR, GL_ONE));
            } else if (i == 11) {
                state.setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0.0, 1.0, false));
            }
            break;
        }
        root_->addChild(at.get());
    }
}

void RandomWorld::advance()
{
    for (const auto& mover : movers_) {
        osg::Vec3 place = mover->getMatrix().getTrans();
        if (rng_.below(10) == 0) { // to another cell; else it only turns
            free_places_.push_back(place);
            place = take_place();
        }
        mover->setMatrix(turned_at(place));
    }
    for (const auto& one : switches_) {
        if (rng_.below(8) == 0) {
            one->setValue(0, !one->getValue(0));
        }
    }
    for (const auto& box : deformers_) {
        const float stretch = rng_.range(0.8f, 1.25f);
        auto& vertices = static_cast<osg::Vec3Array&>(*box->getVertexArray());
        for (osg::Vec3& vertex : vertices) {
            vertex.z() *= stretch;
        }
        vertices.dirty();
        box->dirtyBound();
    }
    if (options_.comes_and_goes && rng_.below(2) == 0) {
        const uint32_t gone = rng_.below(things_->getNumChildren());
        const auto& at = static_cast<osg::MatrixTransform&>(*things_->getChild(gone));
        std::erase(movers_, &at);
        free_places_.push_back(at.getMatrix().getTrans());
        things_->removeChild(gone);
        things_->addChild(random_thing().get());
    }
}

osg::Matrixd RandomWorld::next_view()
{
    if (rng_.below(25) == 0) {
        eye_ = free_places_[rng_.below(static_cast<uint32_t>(free_places_.size()))] +
               osg::Vec3(0, 0, 1.7f);
    }
    heading_ += rng_.range(-0.2f, 0.2f);
    const osg::Vec3 ahead(std::cos(heading_), std::sin(heading_), rng_.range(-0.05f, 0.05f));
    eye_ += osg::Vec3(ahead.x(), ahead.y(), 0.0f) * 0.6f;
    return osg::Matrixd::lookAt(eye_, eye_ + ahead, osg::Vec3(0, 0, 1));
}

} // namespace occlude
