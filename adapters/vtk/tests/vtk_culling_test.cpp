// The same program with the adapter and without, frame by frame and pixel by pixel.
#include "random_world.h"

#include <occlude/vtk/vtk_culling.h>

#include <vtkCamera.h>
#include <vtkFloatArray.h>
#include <vtkHardwareSelector.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkProp3D.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSSAOPass.h>
#include <vtkSelection.h>
#include <vtkSelectionNode.h>
#include <vtkUnsignedCharArray.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <vector>

namespace occlude {
namespace {

// Colours and depths of a window.
struct Picture {
    std::vector<uint32_t> colors;
    std::vector<float> depths;
};

Picture picture_of(vtkRenderWindow& window)
{
    const int right = window.GetSize()[0] - 1;
    const int top = window.GetSize()[1] - 1;
    const vtkNew<vtkUnsignedCharArray> colors;
    const vtkNew<vtkFloatArray> depths;
    window.GetRGBACharPixelData(0, 0, right, top, 0, colors);
    window.GetZbufferData(0, 0, right, top, depths);
    Picture picture;
    picture.colors.resize(static_cast<size_t>(colors->GetNumberOfTuples()));
    std::memcpy(picture.colors.data(), colors->GetPointer(0),
                picture.colors.size() * sizeof(uint32_t));
    picture.depths.assign(depths->GetPointer(0),
                          depths->GetPointer(0) + depths->GetNumberOfTuples());
    return picture;
}

template <typename Value>
uint64_t different(const std::vector<Value>& a, const std::vector<Value>& b)
{
    uint64_t count = a.size() == b.size() && !a.empty() ? 0 : a.size() + b.size() + 1;
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        count += a[i] != b[i] ? 1 : 0;
    }
    return count;
}

// Strolls through a world in one window.
class Stroll {
public:
    explicit Stroll(const WorldOptions& options, int samples = 0,
                    const char* algorithm = "two_phase", uint32_t block_triangles = 500)
        : world_(options)
        , options_{.algorithm = algorithm, .min_items = 1, .block_triangles = block_triangles}
    {
        window_->SetOffScreenRendering(1);
        window_->SetMultiSamples(samples);
        window_->SetSize(320, 200);
        add_renderer(0.0, 1.0);
    }
    vtkRenderer& add_renderer(double left, double right)
    {
        const vtkNew<vtkRenderer> renderer;
        renderer->SetViewport(left, 0.0, right, 1.0);
        renderer->SetBackground(0.2, 0.3, 0.4);
        world_.add_to(*renderer);
        culling_.push_back(VtkCulling::attach(*renderer, options_));
        window_->AddRenderer(renderer);
        renderers_.emplace_back(renderer);
        return *renderer;
    }
    void walk(int frames)
    {
        for (int frame = 0; frame < frames; ++frame) {
            world_.advance();
            for (const auto& renderer : renderers_) {
                world_.look(*renderer->GetActiveCamera());
            }
            const Picture plain = draw(false);
            const Picture culled = draw(true);
            for (const auto& culling : culling_) {
                props_ += culling->stats().props;
                culled_props_ += culling->stats().culled_props;
                items_ += culling->stats().items;
                hidden_ += culling->stats().hidden_items;
            }
            const uint64_t count =
                different(plain.colors, culled.colors) + different(plain.depths, culled.depths);
            different_pixels_ += count;
            different_frames_ += count > 0 ? 1 : 0;
        }
    }
    /// Also forgets what was counted.
    void expect_no_difference(uint64_t seed, double least_hidden = 0.2)
    {
        EXPECT_EQ(different_pixels_, 0u) << "in " << different_frames_ << " frames, seed " << seed;
        const double share =
            static_cast<double>(hidden_) / static_cast<double>(std::max<uint64_t>(items_, 1));
        EXPECT_GT(share, least_hidden) << "the case is not representative";
        EXPECT_LT(share, 0.97) << "the case is not representative";
        last_items_ = items_;
        items_ = hidden_ = different_pixels_ = different_frames_ = 0;
    }
    Picture draw(bool culled)
    {
        for (const auto& culling : culling_) {
            culling->set_enabled(culled);
        }
        window_->Render();
        return picture_of(*window_);
    }

    RandomWorld& world() { return world_; }
    vtkRenderWindow& window() { return *window_; }
    vtkRenderer& renderer() { return *renderers_.front(); }
    uint64_t props() const { return props_; }
    uint64_t culled_props() const { return culled_props_; }
    uint64_t items() const { return last_items_; } ///< before expect_no_difference()
    VtkCulling& culling() { return *culling_.front(); }

private:
    RandomWorld world_;
    VtkCullingOptions options_;
    vtkNew<vtkRenderWindow> window_;
    std::vector<vtkSmartPointer<vtkRenderer>> renderers_;
    std::vector<vtkSmartPointer<VtkCulling>> culling_;
    uint64_t props_ = 0;
    uint64_t culled_props_ = 0;
    uint64_t items_ = 0;
    uint64_t last_items_ = 0;
    uint64_t hidden_ = 0;
    uint64_t different_pixels_ = 0;
    uint64_t different_frames_ = 0;
};

TEST(VtkCulling, ShowsTheSamePixelsWhileEverythingMovesComesAndGoes)
{
    Stroll stroll({.seed = 1});
    stroll.walk(200);
    stroll.expect_no_difference(1);
    EXPECT_LT(stroll.culled_props(), stroll.props());
    EXPECT_GT(stroll.items(), stroll.culled_props()) << "no actor was cut into blocks";
}

TEST(VtkCulling, ShowsTheSamePixelsInStillScenes)
{
    Stroll stroll({.seed = 2,
                   .moves = false,
                   .comes_and_goes = false,
                   .deforms = false,
                   .odd_actors = false});
    stroll.walk(60);
    stroll.expect_no_difference(2);
    EXPECT_EQ(stroll.culling().stats().unknown_items, 0u);
    EXPECT_EQ(stroll.culling().stats().rebuilds, 1u);
    EXPECT_EQ(stroll.culling().stats().culled_props, stroll.culling().stats().props);
}

TEST(VtkCulling, ShowsTheSamePixelsWithAlgorithmsThatTestInOtherWays)
{
    for (const char* algorithm : {"chc_plus_plus", "stop_and_wait", "adaptive"}) {
        SCOPED_TRACE(algorithm);
        Stroll stroll({.seed = 3}, 0, algorithm);
        stroll.walk(25);
        stroll.expect_no_difference(3, 0.01); // which ones hide how much is not the adapter's
    }
}

TEST(VtkCulling, ShowsTheSamePixelsWithSeveralSamplesPerPixel)
{
    Stroll stroll({.seed = 4}, 4);
    stroll.walk(50);
    stroll.expect_no_difference(4);
}

TEST(VtkCulling, FollowsAWindowThatChangesItsSize)
{
    Stroll stroll({.seed = 5});
    for (const int width : {320, 200, 311, 97}) {
        stroll.window().SetSize(width, width / 2);
        stroll.walk(10);
    }
    stroll.expect_no_difference(5);
}

TEST(VtkCulling, GoesOnInANewContext)
{
    Stroll stroll({.seed = 6});
    for (int i = 0; i < 3; ++i) {
        stroll.walk(12);
        stroll.expect_no_difference(6);
        stroll.window().Finalize();
    }
}

TEST(VtkCulling, CullsForTwoRenderersInOneWindow)
{
    Stroll stroll({.seed = 7});
    stroll.renderer().SetViewport(0.0, 0.0, 0.5, 0.8);
    stroll.add_renderer(0.5, 1.0);
    stroll.walk(50);
    stroll.expect_no_difference(7);
}

TEST(VtkCulling, LeavesTheWaysInWhichARendererDrawsAsTheyAre)
{
    const auto walk = [](const char* way, const auto& set_up, const WorldOptions& options) {
        SCOPED_TRACE(way);
        Stroll stroll(options);
        set_up(stroll.renderer());
        stroll.walk(20);
        stroll.expect_no_difference(options.seed);
    };
    walk("depth peeling", [](vtkRenderer& renderer) { renderer.UseDepthPeelingOn(); }, {.seed = 8});
    walk("hidden lines", [](vtkRenderer& renderer) { renderer.UseHiddenLineRemovalOn(); },
         {.seed = 9});
    walk("FXAA", [](vtkRenderer& renderer) { renderer.UseFXAAOn(); }, {.seed = 10});
    walk("steps of passes",
         [](vtkRenderer& renderer) { renderer.SetPass(vtkNew<vtkRenderStepsPass>()); },
         {.seed = 11});
    walk("ambient occlusion",
         [](vtkRenderer& renderer) {
             const vtkNew<vtkRenderStepsPass> steps;
             const vtkNew<vtkSSAOPass> occlusion;
             occlusion->SetDelegatePass(steps);
             occlusion->SetRadius(1.0);
             renderer.SetPass(occlusion);
         },
         {.seed = 12});
}

TEST(VtkCulling, PicksTheSameProps)
{
    Stroll stroll({.seed = 13});
    stroll.walk(5);
    size_t most = 0;
    for (int i = 0; i < 10; ++i) {
        std::array<std::set<vtkProp*>, 2> picked;
        stroll.world().look(*stroll.renderer().GetActiveCamera());
        for (size_t culled = 0; culled < 2; ++culled) {
            stroll.draw(culled == 1);
            const vtkNew<vtkHardwareSelector> selector;
            selector->SetRenderer(&stroll.renderer());
            selector->SetArea(0, 0, 319, 199);
            const auto selection = vtkSmartPointer<vtkSelection>::Take(selector->Select());
            for (unsigned int node = 0; node < selection->GetNumberOfNodes(); ++node) {
                vtkInformation& of_node = *selection->GetNode(node)->GetProperties();
                picked[culled].insert(vtkProp::SafeDownCast(of_node.Get(vtkSelectionNode::PROP())));
            }
        }
        EXPECT_EQ(picked[0], picked[1]);
        most = std::max(most, picked[0].size());
    }
    EXPECT_GT(most, 5u) << "the case is not representative";
}

TEST(VtkCulling, LeavesTheRendererAloneWhenDetachedOrSwitchedOff)
{
    Stroll stroll({.seed = 14});
    stroll.walk(3);
    EXPECT_GT(stroll.culling().stats().culled_props, 0u);
    stroll.draw(false);
    EXPECT_FALSE(stroll.culling().enabled());
    EXPECT_EQ(stroll.culling().stats().culled_props, 0u);
    stroll.draw(true);
    EXPECT_GT(stroll.culling().stats().culled_props, 0u);
    const vtkSmartPointer<VtkCulling> culling = &stroll.culling();
    const uint64_t props = culling->stats().props;
    culling->detach(stroll.renderer());
    stroll.world().look(*stroll.renderer().GetActiveCamera());
    stroll.renderer().GetActiveCamera()->SetClippingRange(0.5, 1.0);
    stroll.draw(true);
    EXPECT_EQ(culling->stats().props, props) << "it was asked again";
}

} // namespace
} // namespace occlude
