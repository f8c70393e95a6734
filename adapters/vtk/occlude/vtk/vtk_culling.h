// Occlusion culling inside VTK 9: actors that lie hidden behind others are not drawn.
//
//   vtkSmartPointer<occlude::VtkCulling> culling = occlude::VtkCulling::attach(*renderer);
//
// It is a vtkCuller, the last one of its renderer. The renderer's way of drawing stays as it is:
// its passes, depth peeling, hidden lines, ambient occlusion, several layers and render windows. In
// the list of props, one prop stands for the actors that were taken out of it, and draws those of
// them that may be seen, in the renderer's order within each batch.
//
// Which props  Actors drawn as opaque surfaces: a vtkActor with a vtkPolyDataMapper or a
//              vtkCompositePolyDataMapper2 over polygons. Everything else stays in the list: lines,
//              points, wireframes, translucent actors, volumes, annotations, classes of your own.
// Blocks       An actor with many triangles, and a composite data set, are cut into blocks that are
//              culled one by one, where their colours do not depend on the cutting.
// Boxes        vtkProp::GetBounds(), as for the renderer's own frustum culling.
// Image        The same as without the adapter, pixel by pixel, with one exception that
//              docs/adapters/vtk.md explains: llvmpipe's needles.
// Picking      Selections by hardware, and shadows (vtkRenderer::UseShadows), draw everything.
// State        vtkOpenGLState never notices: what tests change in OpenGL is put back exactly.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/messages.h>

#include <vtkCuller.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <memory>
#include <string>

class vtkRenderer;

namespace occlude {

struct VtkCullingOptions {
    /// The algorithm, by the name that the registry knows (cull/registry.h). `adaptive` measures
    /// what drawing and testing cost, and draws everything where culling does not pay.
    std::string algorithm = "adaptive";
    /// Fewer items than this in a frame are drawn without culling.
    uint32_t min_items = 8;
    /// Actors with more than twice as many triangles are cut into blocks of about this many; 0: no
    /// actor is cut.
    uint32_t block_triangles = 4096;
    /// Hears of faults, in the thread that draws.
    MessageHandler on_message = {};
};

/// What the last frame came to.
struct VtkCullingStats {
    uint64_t props = 0;         ///< in the renderer's list: those in the frustum
    uint64_t culled_props = 0;  ///< of these, the actors that were taken out of the list
    uint64_t items = 0;         ///< such actors, and blocks of them
    uint64_t hidden_items = 0;  ///< found hidden, and not drawn
    uint64_t unknown_items = 0; ///< not in the hierarchy yet, and drawn first
    uint64_t redrawn_items = 0; ///< drawn again, so that they win at equal depth as they should
    uint64_t moved_items = 0;   ///< whose box has changed since the last frame
    uint64_t rebuilds = 0;      ///< hierarchies built since the first frame
    FrameReport report;
};

/// Culls for the renderer that it is a culler of. Change it between frames, in the renderer's
/// thread.
class VtkCulling final : public vtkCuller {
public:
    static VtkCulling* New();
    vtkTypeMacro(VtkCulling, vtkCuller);

    /// Adds a new VtkCulling to the cullers of `renderer`, behind those that are there. Cullers
    /// that are added later see one prop where there were many.
    static vtkSmartPointer<VtkCulling> attach(vtkRenderer& renderer,
                                              const VtkCullingOptions& options = {});
    /// Takes it out of the cullers again.
    void detach(vtkRenderer& renderer);

    /// Before the first frame.
    void set_options(const VtkCullingOptions& options);

    /// When false, the frames from the next on are drawn by the renderer alone.
    void set_enabled(bool enabled) { enabled_ = enabled; }
    bool enabled() const { return enabled_; }

    const VtkCullingStats& stats() const;

    double Cull(vtkRenderer* renderer, vtkProp** props, int& count, int& initialized) override;
    void PrintSelf(std::ostream& out, vtkIndent indent) override;

    VtkCulling(const VtkCulling&) = delete;
    VtkCulling& operator=(const VtkCulling&) = delete;

private:
    VtkCulling();
    ~VtkCulling() override;

    struct Parts;
    std::unique_ptr<Parts> parts_;
    bool enabled_ = true;
};

} // namespace occlude
