#include "worlds/run_case.h"

#include "worlds/camera.h"
#include "worlds/rays.h"
#include "worlds/scene.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <algorithm>
#include <memory>
#include <set>
#include <tuple>

namespace occlude::worlds {

namespace {

constexpr uint32_t kFewTickets = 64;

/// A clock that runs at random, and sometimes stands still.
SecondsClock random_clock(uint64_t seed)
{
    return [rng = Rng{seed}, now = 0.0]() mutable {
        now += rng.below(5) == 0 ? 0.0 : 1e-6 * static_cast<double>(rng.below(3000));
        return now;
    };
}

using Fragment = std::tuple<size_t, uint32_t, uint32_t>;

/// Sorted: a culler may draw them in another order.
std::vector<Fragment> sorted_fragments(const CpuDevice& device)
{
    std::vector<Fragment> all;
    for (const auto& fragment : device.translucent_fragments()) {
        all.emplace_back(fragment.pixel, fragment.owner.item.value, fragment.owner.triangle);
    }
    std::sort(all.begin(), all.end());
    return all;
}

class Run {
public:
    Run(const Spec& spec, Counts& counts)
        : spec_(spec)
        , counts_(counts)
        , scene_(spec)
        , motion_(hash64(spec.seed, 0x307))
        , device_(scene_, {.max_outstanding = spec.faults.seed % 3 == 0 ? kFewTickets : 4096})
        , faulty_(device_, spec.faults)
        , validating_(faulty_, {.on_violation =
                                    [this](std::string_view rule, std::string_view message) {
                                        // Tests beyond the device's limit are lost, so visible. A
                                        // culler that shares a device cannot know the others'
                                        // tests, and some of these devices have hardly any tickets.
                                        if (rule != "C11") {
                                            fail(std::string{rule} + ": " + std::string{message});
                                        }
                                    }})
        , reference_(scene_)
    {
    }

    std::string run()
    {
        build();
        const bool usable = static_cast<bool>(device_.use_method(spec_.method));
        if (!usable || !make_cullers()) {
            return failure_.empty() ? "the device or the culler cannot be made" : failure_;
        }
        ++counts_.cases;
        for (frame_ = 0; frame_ < spec_.frames && failure_.empty(); ++frame_) {
            change_world();
            for (uint32_t view = 0; view < spec_.views && failure_.empty(); ++view) {
                cull(view);
            }
        }
        counts_.exact_cases += all_exact_ ? 1 : 0;
        counts_.representative += all_exact_ && seen_.owning >= seen_.in_frustum / 10 &&
                                          seen_.owning <= seen_.in_frustum - seen_.in_frustum / 10
                                      ? 1
                                      : 0;
        counts_.in_frustum += seen_.in_frustum;
        counts_.faults += faulty_.faults_injected();
        return failure_;
    }

private:
    void fail(const std::string& what)
    {
        if (failure_.empty()) {
            failure_ = "frame " + std::to_string(frame_) + ": " + what;
        }
    }

    void build()
    {
        tree_ = find_hierarchy_kind(spec_.hierarchy)->build(scene_.bounds(), spec_.leaf_triangles);
    }

    bool make_cullers()
    {
        for (uint32_t view = 0; view < spec_.views; ++view) {
            std::vector<OptionValue> options = spec_.options;
            auto culler = make_culler(spec_.algorithm, tree_, options,
                                      spec_.clock ? random_clock(spec_.seed + view) : nullptr);
            while (!culler && !options.empty()) { // a value out of range: without it
                options.pop_back();
                culler = make_culler(spec_.algorithm, tree_, options,
                                     spec_.clock ? random_clock(spec_.seed + view) : nullptr);
            }
            if (!culler) {
                fail(culler.error().message);
                return false;
            }
            cullers_.push_back(std::move(*culler));
            cameras_.emplace_back(spec_, scene_, view);
        }
        return true;
    }

    void change_world()
    {
        if (spec_.moves && frame_ > 0) {
            const std::vector<ItemId> moved = scene_.move(motion_);
            if (motion_.below(2) == 0) {
                tree_.refit(scene_.bounds());
            } else {
                tree_.refit(moved, scene_.bounds());
            }
            check(validate(tree_).empty(), "the refitted tree is broken: " + validate(tree_));
        }
        if (spec_.rebuilds && frame_ > 0 && motion_.below(3) == 0) {
            build();
        }
        if (spec_.resets && motion_.below(3) == 0) {
            cullers_[motion_.below(static_cast<uint32_t>(cullers_.size()))]->reset();
        }
    }

    void check(bool holds, const std::string& otherwise)
    {
        if (!holds) {
            fail(otherwise);
        }
    }

    /// Draws everything, without a tree, a frustum or a test.
    void draw_reference(const View& view)
    {
        std::vector<ItemId> opaque;
        std::vector<ItemId> translucent;
        for (size_t i = 0; i < scene_.bounds().size(); ++i) {
            const bool blends = has_flag(scene_.bounds()[i].flags, ItemFlags::translucent);
            (blends ? translucent : opaque).push_back(ItemId{i});
        }
        reference_.begin_frame(view);
        reference_.draw(opaque, DrawPass::shade);
        reference_.draw(translucent, DrawPass::shade);
        reference_.end_frame();
    }

    /// In one frame, or in all.
    void check_reference(const View& view)
    {
        if (spec_.ray_pixels == 0 ||
            (!spec_.rays_in_every_frame && frame_ != spec_.seed % spec_.frames)) {
            return;
        }
        const std::string difference = Rays{scene_}.disagrees(view, reference_, spec_.ray_pixels,
                                                              spec_.seed + frame_, counts_.rays);
        check(difference.empty(), difference);
    }

    std::set<ItemId> owners_of_reference() const
    {
        std::set<ItemId> owners;
        for (size_t pixel = 0; pixel < reference_.depth().size(); ++pixel) {
            if (reference_.depth()[pixel] < 1.0f) {
                owners.insert(reference_.owner(pixel).item);
            }
        }
        return owners;
    }

    void cull(uint32_t index)
    {
        const View view = cameras_[index].next(scene_);
        Culler& culler = *cullers_[index];
        draw_reference(view);
        check_reference(view);
        const std::set<ItemId> owners = owners_of_reference();
        seen_.owning += owners.size();
        if (auto* oracle = dynamic_cast<OracleCuller*>(&culler)) {
            oracle->record(view, validating_, std::vector<ItemId>(owners.begin(), owners.end()));
        }
        const FrameReport report = culler.cull(view, validating_);
        ++counts_.frames;
        counts_.tests += report.counters.queries;
        check(report.counters.items_drawn == culler.drawn_items().size(),
              "the report counts " + std::to_string(report.counters.items_drawn) + " of " +
                  std::to_string(culler.drawn_items().size()) + " drawn items");
        const bool exact = report.guarantee == Guarantee::exact();
        all_exact_ = all_exact_ && exact;
        if (exact) {
            compare(view, culler);
        }
    }

    void compare(const View& view, const Culler& culler)
    {
        counts_.pixels += reference_.depth().size();
        counts_.drawn += culler.drawn_items().size();
        for (const ItemBounds& item : scene_.bounds()) {
            seen_.in_frustum += view.frustum().classify(item.box) != Containment::outside ? 1 : 0;
        }
        if (device_.size_px() != reference_.size_px()) {
            fail("the culler drew into another target");
            return;
        }
        size_t missing = 0;
        ItemId first;
        for (size_t pixel = 0; pixel < reference_.depth().size(); ++pixel) {
            const bool drawn = reference_.depth()[pixel] < 1.0f;
            const bool same = device_.depth()[pixel] == reference_.depth()[pixel] &&
                              (!drawn || device_.owner(pixel) == reference_.owner(pixel));
            if (!same && missing++ == 0) {
                first = reference_.owner(pixel).item;
            }
        }
        check(missing == 0, std::to_string(missing) + " pixels differ; the first belongs to item " +
                                std::to_string(first.value));
        check(sorted_fragments(device_) == sorted_fragments(reference_),
              "translucent fragments are missing, or there are more");
    }

    Spec spec_;
    Counts& counts_;
    RandomScene scene_;
    Rng motion_;
    Hierarchy tree_;
    CpuDevice device_;
    FaultyDevice faulty_;
    ValidatingDevice validating_;
    CpuDevice reference_;
    std::vector<std::unique_ptr<Culler>> cullers_;
    std::vector<Camera> cameras_;
    uint32_t frame_ = 0;
    bool all_exact_ = true;
    struct {
        uint64_t owning = 0;     ///< items that own a pixel, over all frames and views
        uint64_t in_frustum = 0; ///< items in the frustum, in exact frames
    } seen_;
    std::string failure_;
};

} // namespace

Counts& Counts::operator+=(const Counts& other)
{
    cases += other.cases;
    exact_cases += other.exact_cases;
    frames += other.frames;
    pixels += other.pixels;
    tests += other.tests;
    faults += other.faults;
    drawn += other.drawn;
    in_frustum += other.in_frustum;
    rays += other.rays;
    representative += other.representative;
    return *this;
}

double Counts::hidden_share() const
{
    return in_frustum == 0 ? 0.0
                           : 1.0 - static_cast<double>(drawn) / static_cast<double>(in_frustum);
}

std::string run_case(const Spec& spec, Counts& counts)
{
    return Run{spec, counts}.run();
}

Spec shrink(const Spec& failing)
{
    Spec smallest = failing;
    for (bool smaller = true; smaller;) {
        smaller = false;
        for (const Spec& candidate : simpler(smallest)) {
            Counts ignored;
            if (!run_case(candidate, ignored).empty()) {
                smallest = candidate;
                smaller = true;
                break;
            }
        }
    }
    return smallest;
}

} // namespace occlude::worlds
