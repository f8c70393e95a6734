// A model, or a town of its own, in a window of VTK, culled.
//
//   vtk_town [FILE]                       opens a window; c switches culling
//   vtk_town --frames N [FILE]            walks N frames, prints what was hidden, and ends
//   ... --picture FILE.png                ... and writes the last frame
//
// FILE: glTF (.gltf, .glb) as one actor per mesh, or .vtp, .obj, .ply, .stl as one actor.
#include <occlude/vtk/vtk_culling.h>

#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCubeSource.h>
#include <vtkGLTFImporter.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSTLReader.h>
#include <vtkWindowToImageFilter.h>
#include <vtkXMLPolyDataReader.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr int kBlocks = 60;     // a side of the town
constexpr double kBlock = 24.0; // street included
constexpr double kHouse = 16.0;

struct Options {
    int frames = 0;
    std::string picture;
    std::string file;
};

void add_house(vtkRenderer& renderer, vtkMapper& unit_cube, int x, int y)
{
    const vtkNew<vtkActor> house;
    const double height = 8.0 + 7.0 * ((x * 7 + y * 13) % 5);
    const double shade = 0.45 + 0.1 * ((x + 2 * y) % 5);
    house->SetMapper(&unit_cube);
    house->SetScale(kHouse, kHouse, height);
    house->SetPosition(x * kBlock, y * kBlock, 0.5 * height);
    house->GetProperty()->SetColor(shade, 0.9 * shade, 0.75 * shade);
    renderer.AddActor(house);
}

void add_town(vtkRenderer& renderer)
{
    const vtkNew<vtkCubeSource> cube;
    const vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(cube->GetOutputPort());
    for (int x = 0; x < kBlocks; ++x) {
        for (int y = 0; y < kBlocks; ++y) {
            add_house(renderer, *mapper, x, y);
        }
    }
    const vtkNew<vtkActor> ground;
    const double side = kBlocks * kBlock;
    ground->SetMapper(mapper);
    ground->SetScale(side, side, 1.0);
    ground->SetPosition(0.5 * side, 0.5 * side, -0.5);
    ground->GetProperty()->SetColor(0.35, 0.4, 0.33);
    renderer.AddActor(ground);
}

// A sun, and a weaker light at the camera.
void add_lights(vtkRenderer& renderer)
{
    const vtkNew<vtkLight> sun;
    sun->SetLightTypeToSceneLight();
    sun->SetPosition(-0.5, -1.0, 2.0);
    sun->SetFocalPoint(0.0, 0.0, 0.0);
    sun->SetIntensity(0.8);
    renderer.AddLight(sun);
    const vtkNew<vtkLight> lamp;
    lamp->SetLightTypeToHeadlight();
    lamp->SetIntensity(0.5);
    renderer.AddLight(lamp);
}

template <typename Reader>
void add_surface(vtkRenderer& renderer, const std::string& file)
{
    const vtkNew<Reader> reader;
    const vtkNew<vtkPolyDataMapper> mapper;
    const vtkNew<vtkActor> actor;
    reader->SetFileName(file.c_str());
    mapper->SetInputConnection(reader->GetOutputPort());
    actor->SetMapper(mapper);
    renderer.AddActor(actor);
}

// False if the kind of the file is unknown.
bool add_file(vtkRenderWindow& window, vtkRenderer& renderer, const std::string& file)
{
    const std::string kind = file.substr(file.find_last_of('.') + 1);
    if (kind == "gltf" || kind == "glb") {
        const vtkNew<vtkGLTFImporter> importer;
        importer->SetFileName(file.c_str());
        importer->SetRenderWindow(&window);
        importer->Update();
    } else if (kind == "vtp") {
        add_surface<vtkXMLPolyDataReader>(renderer, file);
    } else if (kind == "obj") {
        add_surface<vtkOBJReader>(renderer, file);
    } else if (kind == "ply") {
        add_surface<vtkPLYReader>(renderer, file);
    } else if (kind == "stl") {
        add_surface<vtkSTLReader>(renderer, file);
    } else {
        return false;
    }
    return true;
}

// Down a street, looking a little to both sides.
void look_down_the_street(vtkCamera& camera, int frame, int frames)
{
    const double along = 2.0 * kBlock + frame * kBlock * 20.0 / frames;
    const double turn = 0.6 * std::sin(frame * 0.15);
    camera.SetPosition(20.5 * kBlock, along, 6.0);
    camera.SetFocalPoint(20.5 * kBlock + std::sin(turn), along + std::cos(turn), 6.0);
    camera.SetViewUp(0.0, 0.0, 1.0);
    camera.SetViewAngle(60.0);
}

void walk(vtkRenderWindow& window, vtkRenderer& renderer, const occlude::VtkCulling& culling,
          const Options& options)
{
    uint64_t items = 0;
    uint64_t hidden = 0;
    for (int frame = 0; frame < options.frames; ++frame) {
        if (options.file.empty()) {
            look_down_the_street(*renderer.GetActiveCamera(), frame, options.frames);
        } else {
            renderer.GetActiveCamera()->Azimuth(360.0 / options.frames);
        }
        renderer.ResetCameraClippingRange();
        window.Render();
        items += culling.stats().items;
        hidden += culling.stats().hidden_items;
    }
    std::printf("%d frames: %.0f items in the frustum, %.0f of them hidden and not drawn\n",
                options.frames, static_cast<double>(items) / options.frames,
                static_cast<double>(hidden) / options.frames);
}

bool write_picture(vtkRenderWindow& window, const std::string& file)
{
    const vtkNew<vtkWindowToImageFilter> picture;
    const vtkNew<vtkPNGWriter> writer;
    picture->SetInput(&window);
    picture->ReadFrontBufferOff();
    writer->SetInputConnection(picture->GetOutputPort());
    writer->SetFileName(file.c_str());
    writer->Write();
    return writer->GetErrorCode() == 0;
}

void switch_culling(vtkObject* caller, unsigned long, void* data, void*)
{
    auto* interactor = static_cast<vtkRenderWindowInteractor*>(caller);
    auto* culling = static_cast<occlude::VtkCulling*>(data);
    if (interactor->GetKeyCode() == 'c') {
        culling->set_enabled(!culling->enabled());
        std::printf("culling is %s\n", culling->enabled() ? "on" : "off");
        interactor->Render();
    }
}

void open_window(vtkRenderWindow& window, occlude::VtkCulling& culling)
{
    const vtkNew<vtkRenderWindowInteractor> interactor;
    const vtkNew<vtkInteractorStyleTrackballCamera> style;
    const vtkNew<vtkCallbackCommand> keys;
    keys->SetCallback(switch_culling);
    keys->SetClientData(&culling);
    interactor->SetInteractorStyle(style);
    interactor->SetRenderWindow(&window);
    interactor->AddObserver("KeyPressEvent", keys);
    interactor->Initialize();
    interactor->Start();
}

Options read_options(int argc, char** argv)
{
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--frames" && i + 1 < argc) {
            options.frames = std::atoi(argv[++i]);
        } else if (argument == "--picture" && i + 1 < argc) {
            options.picture = argv[++i];
        } else {
            options.file = argument;
        }
    }
    return options;
}

} // namespace

int main(int argc, char** argv)
{
    const Options options = read_options(argc, argv);
    const vtkNew<vtkRenderWindow> window;
    const vtkNew<vtkRenderer> renderer;
    window->SetSize(960, 540);
    window->SetWindowName("vtk_town");
    window->AddRenderer(renderer);
    renderer->SetBackground(0.55, 0.65, 0.8);
    if (options.file.empty()) {
        add_town(*renderer);
        add_lights(*renderer);
        look_down_the_street(*renderer->GetActiveCamera(), 0, 1);
    } else if (!add_file(*window, *renderer, options.file)) {
        std::fprintf(stderr, "%s: not one of .gltf .glb .vtp .obj .ply .stl\n",
                     options.file.c_str());
        return EXIT_FAILURE;
    } else {
        renderer->ResetCamera();
    }

    // This is all that culling needs.
    occlude::VtkCullingOptions culling_options;
    culling_options.on_message = [](const occlude::Message& message) {
        std::fprintf(stderr, "%s: %s\n", std::string(message.name).c_str(),
                     std::string(message.text).c_str());
    };
    const vtkSmartPointer<occlude::VtkCulling> culling =
        occlude::VtkCulling::attach(*renderer, culling_options);

    if (options.frames <= 0) {
        open_window(*window, *culling);
        return EXIT_SUCCESS;
    }
    window->SetOffScreenRendering(options.picture.empty() ? 0 : 1);
    walk(*window, *renderer, *culling, options);
    return options.picture.empty() || write_picture(*window, options.picture) ? EXIT_SUCCESS
                                                                              : EXIT_FAILURE;
}
