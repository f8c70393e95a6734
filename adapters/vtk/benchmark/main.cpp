// VTK with the adapter and without, frame by frame in turn. Prints a line of a table in Markdown.
//
//   vtk_bench [--frames N] [--size W H] [--algorithm NAME] [--merged] [SCENE]
//
// SCENE: city (10,000 boxes along streets, the default), heap (the same seen from above, nothing is
// hidden), or a glTF file, walked along the streets or around its middle. One actor per mesh;
// --merged: all meshes of a scene in one actor, which is culled by blocks.
#include "virtual_display.h"

#include <occlude/vtk/vtk_culling.h>

#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkAppendPolyData.h>
#include <vtkCamera.h>
#include <vtkCubeSource.h>
#include <vtkGLTFImporter.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSide = 100; // of the city, in blocks
constexpr double kBlock = 12.0;

struct Options {
    int frames = 40;
    std::array<int, 2> size{1280, 720};
    std::string algorithm = "adaptive";
    bool merged = false;
    std::string scene = "city";

    bool has_file() const { return scene != "city" && scene != "heap"; }
};

void add_city(vtkRenderer& renderer)
{
    const vtkNew<vtkCubeSource> cube;
    cube->Update();
    for (int x = 0; x < kSide; ++x) {
        for (int y = 0; y < kSide; ++y) {
            const vtkNew<vtkPolyDataMapper> mapper;
            const vtkNew<vtkActor> actor;
            const double height = 6.0 + 2.5 * ((x * 31 + y * 17) % 16);
            mapper->SetInputData(cube->GetOutput());
            actor->SetMapper(mapper);
            actor->SetScale(8.0, 8.0, height);
            actor->SetPosition(x * kBlock, y * kBlock, 0.5 * height);
            actor->GetProperty()->SetColor(0.3 + 0.1 * (x % 7), 0.3 + 0.1 * (y % 7), 0.5);
            renderer.AddActor(actor);
        }
    }
}

// One actor instead of all.
void merge_actors(vtkRenderer& renderer)
{
    const vtkNew<vtkAppendPolyData> append;
    vtkActorCollection& actors = *renderer.GetActors();
    actors.InitTraversal();
    while (vtkActor* actor = actors.GetNextActor()) {
        const vtkNew<vtkTransformPolyDataFilter> place;
        const vtkNew<vtkTransform> transform;
        transform->SetMatrix(actor->GetMatrix());
        place->SetTransform(transform);
        actor->GetMapper()->Update();
        place->SetInputData(actor->GetMapper()->GetInputDataObject(0, 0));
        place->Update();
        append->AddInputData(place->GetOutput());
    }
    append->Update();
    const vtkNew<vtkPolyDataMapper> mapper;
    const vtkNew<vtkActor> merged;
    mapper->SetInputData(append->GetOutput());
    mapper->ScalarVisibilityOff();
    merged->SetMapper(mapper);
    renderer.RemoveAllViewProps();
    renderer.AddActor(merged);
}

void look(vtkRenderer& renderer, const Options& options, int frame)
{
    vtkCamera& camera = *renderer.GetActiveCamera();
    const double part = static_cast<double>(frame) / options.frames;
    camera.SetViewAngle(60.0);
    if (options.scene == "city") {
        const double street = (kSide / 2 + 0.5) * kBlock;
        const double along = (kSide * 0.1 + part * kSide * 0.3) * kBlock;
        const double turn = 0.7 * std::sin(frame * 0.2);
        camera.SetViewUp(0, 0, 1);
        camera.SetPosition(street, along, 2.0);
        camera.SetFocalPoint(street + std::sin(turn), along + std::cos(turn), 2.0);
    } else if (options.scene == "heap") {
        const double middle = 0.5 * kSide * kBlock;
        camera.SetViewUp(std::cos(part), std::sin(part), 0);
        camera.SetPosition(middle, middle, 1.2 * kSide * kBlock);
        camera.SetFocalPoint(middle, middle, 0.0);
    } else {
        std::array<double, 6> bounds{};
        renderer.ComputeVisiblePropBounds(bounds.data());
        const std::array<double, 3> middle{0.5 * (bounds[0] + bounds[1]),
                                           0.5 * (bounds[2] + bounds[3]),
                                           0.5 * (bounds[4] + bounds[5])};
        const double reach = 0.3 * (bounds[1] - bounds[0]);
        const double depth = 0.3 * (bounds[5] - bounds[4]);
        const double angle = 6.283 * part;
        camera.SetViewUp(0, 1, 0);
        camera.SetPosition(middle[0] + reach * std::cos(angle), middle[1],
                           middle[2] + depth * std::sin(angle));
        camera.SetFocalPoint(middle[0], middle[1], middle[2]);
    }
    renderer.ResetCameraClippingRange();
}

struct Contestant {
    std::vector<double> ms;
    vtkNew<vtkUnsignedCharArray> pixels;

    void draw(vtkRenderWindow& window)
    {
        const Clock::time_point begin = Clock::now();
        window.Render();
        window.WaitForCompletion();
        ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        window.GetRGBACharPixelData(0, 0, window.GetSize()[0] - 1, window.GetSize()[1] - 1, 0,
                                    pixels);
    }
    // Without the frames in which shaders and blocks are made.
    double median() const
    {
        std::vector<double> sorted(ms.begin() + static_cast<ptrdiff_t>(ms.size() / 5), ms.end());
        std::ranges::sort(sorted);
        return sorted[sorted.size() / 2];
    }
};

uint64_t different(vtkUnsignedCharArray& a, vtkUnsignedCharArray& b)
{
    uint64_t count = 0;
    for (vtkIdType i = 0; i < a.GetNumberOfValues(); i += 4) {
        count += std::equal(a.GetPointer(i), a.GetPointer(i) + 4, b.GetPointer(i)) ? 0 : 1;
    }
    return count;
}

Options read_options(int argc, char** argv)
{
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--frames" && i + 1 < argc) {
            options.frames = std::atoi(argv[++i]);
        } else if (argument == "--size" && i + 2 < argc) {
            options.size = {std::atoi(argv[i + 1]), std::atoi(argv[i + 2])};
            i += 2;
        } else if (argument == "--algorithm" && i + 1 < argc) {
            options.algorithm = argv[++i];
        } else if (argument == "--merged") {
            options.merged = true;
        } else {
            options.scene = argument;
        }
    }
    return options;
}

void add_scene(vtkRenderWindow& window, vtkRenderer& renderer, const Options& options)
{
    if (options.has_file()) {
        const vtkNew<vtkGLTFImporter> importer;
        importer->SetFileName(options.scene.c_str());
        importer->SetRenderWindow(&window);
        importer->Update();
    } else {
        add_city(renderer);
    }
    if (options.merged) {
        merge_actors(renderer);
    }
}

} // namespace

int main(int argc, char** argv)
{
    const Options options = read_options(argc, argv);
    if (std::getenv("DISPLAY") == nullptr && !occlude::start_virtual_display()) {
        std::fputs("there is no display, and no Xvfb to make one\n", stderr);
        return EXIT_FAILURE;
    }
    const vtkNew<vtkRenderWindow> window;
    const vtkNew<vtkRenderer> renderer;
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetSize(options.size[0], options.size[1]);
    window->AddRenderer(renderer);
    add_scene(*window, *renderer, options);
    if (renderer->GetActors()->GetNumberOfItems() == 0) {
        std::fprintf(stderr, "%s: no model that VTK can read\n", options.scene.c_str());
        return EXIT_FAILURE;
    }
    const auto culling = occlude::VtkCulling::attach(*renderer, {.algorithm = options.algorithm});

    std::array<Contestant, 2> all; // plain, this adapter
    uint64_t wrong = 0;
    uint64_t items = 0;
    uint64_t hidden = 0;
    for (int frame = 0; frame < options.frames; ++frame) {
        look(*renderer, options, frame);
        for (size_t i = 0; i < all.size(); ++i) {
            const size_t which = (i + static_cast<size_t>(frame)) % all.size();
            culling->set_enabled(which == 1);
            all[which].draw(*window);
            items += culling->stats().items;
            hidden += culling->stats().hidden_items;
        }
        wrong += different(*all[0].pixels, *all[1].pixels);
    }
    std::printf(
        "| %s%s | %d | %d | %.0f | %.2f ms | %.2f ms, %.2f times | %llu | %.1f %% |\n",
        options.has_file() ? options.scene.substr(options.scene.find_last_of('/') + 1).c_str()
                           : options.scene.c_str(),
        options.merged ? ", merged" : "", renderer->GetActors()->GetNumberOfItems(), options.frames,
        static_cast<double>(items) / options.frames, all[0].median(), all[1].median(),
        all[0].median() / all[1].median(), static_cast<unsigned long long>(wrong),
        100.0 * static_cast<double>(hidden) / static_cast<double>(std::max<uint64_t>(items, 1)));
    return EXIT_SUCCESS;
}
