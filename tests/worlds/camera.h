// Difficult cameras: cuts, spins, eyes that graze walls or are inside boxes.
#pragma once

#include "worlds/scene.h"
#include "worlds/spec.h"

#include <occlude/core/rng.h>
#include <occlude/core/view.h>

namespace occlude::worlds {

class Camera {
public:
    /// The `index`-th of the cameras of this world.
    Camera(const Spec& spec, const RandomScene& scene, uint32_t index);

    /// The view of the next frame.
    View next(const RandomScene& scene);

private:
    void choose_place(const RandomScene& scene);

    Spec spec_;
    Rng rng_;
    glm::dvec3 eye_{0.0};
    glm::dvec3 target_{0.0};
    glm::dmat4 clip_from_eye_{1.0};
};

} // namespace occlude::worlds
