// A scene of the engine with everything that the adapter must cope with, which changes by chance
// from frame to frame.
#pragma once

#include <occlude/core/rng.h>

#include <osg/Geometry>
#include <osg/Group>
#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osg/Switch>
#include <osg/ref_ptr>

#include <cstdint>
#include <vector>

namespace occlude {

/// Which things a world has besides boxes and walls that stand still.
struct WorldOptions {
    uint64_t seed = 1;
    bool moves = true;          ///< moving transforms, some of which share a drawable
    bool comes_and_goes = true; ///< nodes added and removed, and switches
    bool levels = true;         ///< levels of detail
    bool deforms = true;        ///< vertices that change
    bool odd_states = true;     ///< blending in the opaque bin, decals, lines, depth switched off
};

class RandomWorld {
public:
    explicit RandomWorld(const WorldOptions& options);

    osg::Group& root() { return *root_; }
    /// Changes the scene for the next frame.
    void advance();
    /// An eye somewhere among the boxes, which strolls; now and then it jumps.
    osg::Matrixd next_view();

private:
    osg::ref_ptr<osg::Geometry> make_box(float half_size);
    osg::ref_ptr<osg::StateSet> random_state();
    osg::Vec3 take_place();
    osg::Matrix turned_at(const osg::Vec3& place);
    osg::ref_ptr<osg::Node> random_thing();
    void add_walls();
    void add_odd_things();

    WorldOptions options_;
    Rng rng_;
    osg::ref_ptr<osg::Group> root_;
    osg::ref_ptr<osg::Group> things_;
    std::vector<osg::ref_ptr<osg::StateSet>> states_;
    std::vector<osg::ref_ptr<osg::MatrixTransform>> movers_;
    std::vector<osg::ref_ptr<osg::Switch>> switches_;
    std::vector<osg::ref_ptr<osg::Geometry>> deformers_;
    std::vector<osg::Vec3> free_places_; ///< the middles of cells in which nothing stands
    osg::ref_ptr<osg::Geometry> shared_;
    osg::Vec3 eye_;
    float heading_ = 0.0f;
};

} // namespace occlude
