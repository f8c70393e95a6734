// One pass over the opaque props of a renderer: its culler and device, and how actors are drawn.
#pragma once

#include "host_culler.h"
#include "item_tree.h"
#include "place_set.h"
#include "saved_gl_state.h"

#include <occlude/backends/gl/gl_scene.h>
#include <occlude/vtk/vtk_culling.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

class vtkActor;
class vtkInformation;
class vtkMapper;
class vtkRenderer;

namespace occlude {

/// An actor, or one block of it.
struct DrawnItem {
    vtkActor* actor = nullptr;
    vtkMapper* block = nullptr; ///< draws this block; null: the actor draws itself
    uint32_t block_number = 0;
};

/// Draws items one after the other, as the renderer would draw their actors. Those of one actor in
/// a row share what is set up for the actor.
class ItemPainter {
public:
    /// `keys`: what a render pass has told the prop that stands for the actors; may be null.
    void start(vtkRenderer& renderer, vtkInformation* keys);
    void draw(const DrawnItem& item);
    void finish();

private:
    void enter(vtkActor& actor);
    void leave();

    vtkRenderer* renderer_ = nullptr;
    vtkInformation* keys_ = nullptr;
    vtkActor* actor_ = nullptr; ///< whose block was drawn last
};

class PropView final : public GlScene {
public:
    PropView(const VtkCullingOptions& options, const ItemTree& tree);

    /// Draws the items that may be seen. False if culling is not possible here: nothing was drawn.
    bool draw(vtkRenderer& renderer, vtkInformation* keys, std::span<const DrawnItem> items,
              std::span<const ItemId> ids, VtkCullingStats& stats);

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void prepare_tests() override;
    void restore_state() override;

private:
    static constexpr uint32_t kNotThere = 0xffffffffu;

    void draw_place(uint32_t place);
    size_t settle_ties(std::span<const ItemId> ids);
    void follow_context(vtkRenderer& renderer);
    bool can_test(vtkRenderer& renderer);

    const ItemTree& tree_;
    HostCuller culler_;
    ItemPainter painter_;
    SavedGlState saved_;
    std::array<int, 4> viewport_{};
    uint64_t context_made_ = 0;        ///< when the context was made that the culler has seen
    std::span<const DrawnItem> items_; ///< of the frame
    std::vector<uint32_t> first_;      ///< places that are drawn before all tests
    std::vector<uint32_t> place_of_item_;
    std::vector<uint32_t> sequence_; ///< places in the order of drawing
    std::vector<uint32_t> drawn_at_; ///< by place: its number in sequence_, or kNotThere
    std::vector<uint32_t> late_;     ///< places drawn after later ones
    bool last_wins_ = false;         ///< at equal depth
    PlaceSet batch_;                 ///< empty between calls
};

} // namespace occlude
