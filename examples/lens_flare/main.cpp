// Lens flares whose brightness follows the visible share of their lights: a sun and two lamps
// behind a row of columns, past which the camera moves. CHC++ culls every frame as usual. The same
// device measures the flares, in two small batches. Writes the last frame as a PNG file (the path
// is the only argument), and fails if a measured share is off by more than 2%.
#include "flare_scene.h"

#include "render/image.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/device/flare_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <cstdio>

using namespace occlude;
using namespace occlude::lens_flare;

static View camera(float t)
{
    const glm::vec3 eye{-6.0f + 7.0f * t, 2.0f, 12.0f};
    return View::from_clip(glm::perspective(0.9f, 16.0f / 9.0f, 0.1f, 500.0f) *
                               glm::lookAt(eye, {1.0f, 3.0f, -20.0f}, {0.0f, 1.0f, 0.0f}),
                           {640, 360});
}

int main(int argument_count, char** arguments)
{
    const Columns columns;
    const Hierarchy hierarchy = build_bvh(columns.bounds(), {.leaf_triangles = 12});
    CpuDevice device{columns};

    FlareVisibility flares;
    const std::vector<FlareLight> lights = {{{0.10f, 0.16f, -1.0f, 0.0f}, 14.0f}, // the sun
                                            {{-4.6f, 3.4f, -6.0f, 1.0f}, 9.0f},
                                            {{6.2f, 2.6f, -9.0f, 1.0f}, 9.0f}};
    flares.set_lights(lights);
    FlareDevice measured{device, flares}; // the culler draws through it, without knowing of flares

    ChcPlusPlus culler{hierarchy};
    constexpr int kFrames = 120;
    double worst = 0.0;
    std::vector<double> exact(lights.size(), 0.0); // of the last frame
    View view;
    for (int frame = 0; frame < kFrames; ++frame) {
        view = camera(static_cast<float>(frame) / kFrames);
        culler.cull(view, measured);
        for (size_t i = 0; i < lights.size(); ++i) {
            if (frame > 0) {
                worst = std::max(worst, std::abs(flares.fraction(i) - exact[i]));
            }
            exact[i] = exact_fraction(device, view, lights[i]);
        }
    }

    tools::Image image = shaded_image(device, columns);
    for (size_t i = 0; i < lights.size(); ++i) {
        add_flare(image, view, lights[i], flares.brightness(i));
        std::printf("light %zu: %5.1f%% of its disc is seen, brightness %.2f\n", i,
                    100.0 * flares.fraction(i), flares.brightness(i));
    }
    std::printf("the worst error in %d frames was %.2f%%\n", kFrames, 100.0 * worst);
    if (argument_count > 1) {
        const auto written = tools::write_png(arguments[1], image);
        if (!written) {
            std::fprintf(stderr, "%s\n", written.error().message.c_str());
            return 2;
        }
    }
    return worst <= 0.02 ? 0 : 1;
}
