// The CPU device as a subject of the conformance suite, with and without decorators.
#pragma once

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/conformance/conformance.h>
#include <occlude/core/query_device.h>

#include "support/box_scene.h"

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace occlude::test {

/// Boxes that can be replaced.
class ChangingBoxes final : public CpuScene {
public:
    void set(std::span<const Aabb> boxes)
    {
        std::vector<ItemBounds> bounds;
        for (const Aabb& box : boxes) {
            bounds.push_back({box, 12});
        }
        scene_ = BoxCpuScene(bounds);
    }
    CpuItem item(ItemId item) const override { return scene_.item(item); }

private:
    BoxCpuScene scene_{std::span<const ItemBounds>{}};
};

class CpuHost : public conformance::Host {
public:
    /// `wrap` puts a decorator around the CPU device.
    using Wrap = std::function<std::unique_ptr<QueryDevice>(QueryDevice&)>;

    explicit CpuHost(Wrap wrap = {}, ClipConvention convention = {})
        : convention_(convention)
        , decorator_(wrap ? wrap(device_) : nullptr)
    {
    }

    QueryDevice& device() override { return decorator_ ? *decorator_ : device_; }
    void set_items(std::span<const Aabb> boxes) override { scene_.set(boxes); }
    ClipConvention convention() const override { return convention_; }

private:
    ClipConvention convention_;
    ChangingBoxes scene_;
    CpuDevice device_{scene_, {.max_outstanding = 200}};
    std::unique_ptr<QueryDevice> decorator_;
};

} // namespace occlude::test
