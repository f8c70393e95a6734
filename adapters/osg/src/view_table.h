// The views of an OsgCulling: one for each camera, context and traversal within a frame.
#pragma once

#include "view_culler.h"

#include <osg/Camera>
#include <osg/observer_ptr>

#include <atomic>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

namespace occlude {

struct ViewKey {
    const osg::Camera* camera = nullptr;
    uint32_t pass = 0; ///< counts the traversals of one frame: two eyes, a node with two parents
    uint32_t context = 0;

    auto operator<=>(const ViewKey&) const = default;
};

/// Thread-safe; each view is used by the thread of its context only.
class ViewTable {
public:
    explicit ViewTable(OsgCullingOptions options);

    struct Pass {
        uint32_t index = 0;
        bool is_new = false; ///< no earlier frame had as many passes
    };
    /// Counts a traversal of `camera`.
    Pass next_pass(const osg::Camera* camera, unsigned int frame_number);

    /// Draws the frame in the view of that key, which is made if there is none.
    void draw(const ViewKey& key, osg::RenderInfo& info, osgUtil::RenderLeaf& proxy,
              const LeafFrame& frame);

    /// Gives up the views of a context, or all of them. What they hold in OpenGL is deleted if
    /// their context is current.
    void release(const osg::State* state);

    OsgCullingStats stats() const;

    void set_enabled(bool enabled) { enabled_ = enabled; }
    bool enabled() const { return enabled_; }

private:
    struct Entry {
        Entry(const OsgCullingOptions& options, const osg::Camera* of_camera)
            : culler(options)
            , camera(of_camera)
        {
        }

        ViewCuller culler;
        osg::observer_ptr<const osg::Camera> camera;
        uint64_t last_drawn = 0;
        OsgCullingStats stats; ///< a copy, for other threads
    };
    struct Passes {
        unsigned int frame_number = 0;
        uint32_t count = 0;
        uint32_t most = 0;
    };

    std::shared_ptr<Entry> find(const ViewKey& key);

    const OsgCullingOptions options_;
    std::atomic<bool> enabled_ = true;
    mutable std::mutex mutex_;
    std::map<ViewKey, std::shared_ptr<Entry>> entries_;
    std::map<const osg::Camera*, Passes> passes_;
    std::map<uint32_t, uint64_t> draws_; ///< by context
    FrameReport last_report_;
};

} // namespace occlude
