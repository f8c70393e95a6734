// A scene of VTK with everything that the adapter must cope with, which changes by chance from
// frame to frame.
#pragma once

#include <occlude/core/rng.h>

#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

class vtkCamera;
class vtkRenderer;

namespace occlude {

/// Which things a world has besides boxes and walls that stand still.
struct WorldOptions {
    uint64_t seed = 1;
    bool moves = true;          ///< actors that move, some of which share a mapper
    bool comes_and_goes = true; ///< actors added and removed, and switched invisible
    bool deforms = true;        ///< points that change
    bool odd_actors = true;     ///< translucent, masked, wireframe, line, composite and forced ones
    bool translucent = true;    ///< of the odd ones
    int things = 300;
};

class RandomWorld {
public:
    explicit RandomWorld(const WorldOptions& options);

    /// Adds everything to another renderer, too.
    void add_to(vtkRenderer& renderer);
    /// Changes the scene for the next frame.
    void advance();
    /// An eye somewhere among the boxes, which strolls; now and then it jumps.
    void look(vtkCamera& camera);

private:
    vtkSmartPointer<vtkPolyData> make_box(float half_size);
    vtkSmartPointer<vtkActor> make_actor(vtkPolyData& box, const glm::dvec3& place);
    glm::dvec3 take_place();
    vtkSmartPointer<vtkActor> random_thing();
    void add_walls();
    void add_odd_actor(int number);
    void add(vtkActor* actor);

    WorldOptions options_;
    Rng rng_;
    std::vector<vtkSmartPointer<vtkRenderer>> renderers_;
    std::vector<vtkSmartPointer<vtkActor>> actors_; ///< all of them, in order
    std::vector<vtkSmartPointer<vtkActor>> things_; ///< that may go
    std::vector<vtkSmartPointer<vtkActor>> movers_;
    std::vector<vtkSmartPointer<vtkActor>> switched_;
    std::vector<vtkSmartPointer<vtkPolyData>> deformers_;
    std::vector<glm::dvec3> free_places_; ///< the middles of cells in which nothing stands
    vtkSmartPointer<vtkMapper> shared_;
    glm::dvec3 eye_{0.0};
    double heading_ = 0.0;
};

} // namespace occlude
