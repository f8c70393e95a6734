#include "view_table.h"

#include <osg/State>

#include <algorithm>
#include <utility>

namespace occlude {

namespace {

// A view is forgotten after this many draws of other views of its context.
constexpr uint64_t kForgetAfterDraws = 1000;
constexpr size_t kMaxCameras = 1024; // counted at a time; stale ones are among them

} // namespace

ViewTable::ViewTable(OsgCullingOptions options)
    : options_(std::move(options))
{
}

ViewTable::Pass ViewTable::next_pass(const osg::Camera* camera, unsigned int frame_number)
{
    const std::scoped_lock lock(mutex_);
    if (passes_.size() > kMaxCameras) {
        passes_.clear();
    }
    Passes& passes = passes_[camera];
    if (passes.frame_number != frame_number) {
        passes.frame_number = frame_number;
        passes.count = 0;
    }
    const Pass pass{passes.count, passes.count == passes.most};
    passes.most = std::max(passes.most, ++passes.count);
    return pass;
}

void ViewTable::draw(const ViewKey& key, osg::RenderInfo& info, osgUtil::RenderLeaf& proxy,
                     const LeafFrame& frame)
{
    const std::shared_ptr<Entry> entry = find(key);
    entry->culler.draw(info, proxy, frame);
    const std::scoped_lock lock(mutex_);
    entry->stats = entry->culler.stats();
    last_report_ = entry->stats.report;
}

std::shared_ptr<ViewTable::Entry> ViewTable::find(const ViewKey& key)
{
    const std::scoped_lock lock(mutex_);
    const uint64_t now = ++draws_[key.context];
    std::erase_if(entries_, [&](const auto& item) {
        const auto& [other, entry] = item;
        return other.context == key.context &&
               (!entry->camera.valid() || entry->last_drawn + kForgetAfterDraws < now);
    });
    std::shared_ptr<Entry>& entry = entries_[key];
    if (entry == nullptr) {
        entry = std::make_shared<Entry>(options_, key.camera);
    }
    entry->last_drawn = now;
    return entry;
}

void ViewTable::release(const osg::State* state)
{
    const std::scoped_lock lock(mutex_);
    std::erase_if(entries_, [&](const auto& item) {
        return state == nullptr || item.first.context == state->getContextID();
    });
}

OsgCullingStats ViewTable::stats() const
{
    const std::scoped_lock lock(mutex_);
    OsgCullingStats sum;
    for (const auto& [key, entry] : entries_) {
        sum.leaves += entry->stats.leaves;
        sum.hidden_leaves += entry->stats.hidden_leaves;
        sum.unknown_leaves += entry->stats.unknown_leaves;
        sum.exempt_leaves += entry->stats.exempt_leaves;
        sum.moved_leaves += entry->stats.moved_leaves;
        sum.rebuilds += entry->stats.rebuilds;
    }
    sum.report = last_report_;
    return sum;
}

} // namespace occlude
