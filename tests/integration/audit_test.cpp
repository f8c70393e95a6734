#include <occlude/integration/audit.h>

#include "support/box_scene.h"

#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

namespace occlude {
namespace {

constexpr glm::ivec2 kSize{96, 64};

glm::mat4 camera()
{
    return glm::perspective(1.0f, 1.5f, 0.5f, 60.0f) *
           glm::lookAt(glm::vec3{4.0f, 5.0f, 14.0f}, {4.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
}

// Three by three boxes on a floor.
std::vector<ItemBounds> boxes()
{
    std::vector<ItemBounds> items;
    for (int i = 0; i < 9; ++i) {
        const glm::vec3 low{static_cast<float>(i % 3) * 4.0f, 0.0f,
                            static_cast<float>(i / 3) * -4.0f};
        items.push_back({{low, low + 1.0f + 0.25f * static_cast<float>(i % 4)}, 12});
    }
    return items;
}

TEST(AuditItemBounds, TrueBoxesHaveNothingOutside)
{
    const std::vector<ItemBounds> items = boxes();
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    const auto audit = audit_item_bounds(device, View::from_clip(camera(), kSize), items);
    ASSERT_TRUE(audit);
    EXPECT_TRUE(audit->outside.empty());
    EXPECT_EQ(audit->verdict, "");
    EXPECT_EQ(audit->items_drawn, 9u);
}

TEST(AuditItemBounds, ABoxThatIsTooSmallIsNamed)
{
    std::vector<ItemBounds> items = boxes();
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    items[5].box.max.y -= 0.5f;
    const auto audit = audit_item_bounds(device, View::from_clip(camera(), kSize), items);
    ASSERT_TRUE(audit);
    ASSERT_EQ(audit->outside.size(), 1u);
    EXPECT_EQ(audit->outside[0].item, ItemId{5u});
    EXPECT_GT(audit->outside[0].pixels, 0u);
    EXPECT_NE(audit->verdict.find("item 5 leaves its box"), std::string::npos) << audit->verdict;
}

TEST(AuditItemBounds, AnItemThatIsNearerThanItsBoxIsNamedThoughItFillsNoOtherPixels)
{
    std::vector<ItemBounds> items{{{{-1, -1, -1}, {1, 1, 1}}, 12}};
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    const View view = View::from_clip(glm::ortho(-2.0f, 2.0f, -2.0f, 2.0f, 1.0f, 9.0f) *
                                          glm::lookAt(glm::vec3{0, 0, 5}, {0, 0, 0}, {0, 1, 0}),
                                      kSize);
    EXPECT_TRUE(audit_item_bounds(device, view, items)->outside.empty());
    items[0].box.max.z = 0.5f;
    EXPECT_EQ(audit_item_bounds(device, view, items)->outside.size(), 1u);
}

TEST(AuditItemBounds, ATransposedMatrixIsToldFromWrongBoxes)
{
    const std::vector<ItemBounds> items = boxes();
    const test::BoxCpuScene scene(items);
    // The engine draws with the right matrix, whatever the view says.
    class Engine final : public QueryDevice {
    public:
        explicit Engine(QueryDevice& inner)
            : inner_(inner)
        {
        }
        const DeviceCaps& caps() const override { return inner_.caps(); }
        void begin_frame(const View&) override
        {
            inner_.begin_frame(View::from_clip(camera(), kSize));
        }
        void draw(std::span<const ItemId> drawn, DrawPass pass) override
        {
            inner_.draw(drawn, pass);
        }
        void query(const QueryBatch& batch, std::span<Ticket> tickets) override
        {
            inner_.query(batch, tickets);
        }
        void flush() override {}
        Answer poll(Ticket ticket) override { return inner_.poll(ticket); }
        Answer wait(Ticket ticket) override { return inner_.wait(ticket); }
        bool read_depth(const PixelRect& rect, std::span<float> out) override
        {
            return inner_.read_depth(rect, out);
        }
        void end_frame() override { inner_.end_frame(); }

    private:
        QueryDevice& inner_;
    };
    CpuDevice cpu(scene);
    Engine engine(cpu);
    const View wrong = View::from_clip(glm::transpose(camera()), kSize);
    const auto audit = audit_item_bounds(engine, wrong, items);
    ASSERT_TRUE(audit);
    EXPECT_NE(audit->verdict.find("transposed"), std::string::npos) << audit->verdict;
    const View other_range =
        View::from_clip(camera(), kSize, {DepthRange::zero_to_one, DepthOrder::near_is_small});
    EXPECT_NE(audit_item_bounds(engine, other_range, items)->verdict.find("zero_to_one"),
              std::string::npos);
}

TEST(AuditItemBounds, ADeviceWithoutDepthIsRefused)
{
    ScriptedDevice device;
    EXPECT_FALSE(audit_item_bounds(device, View::from_clip(camera(), kSize), boxes()));
}

TEST(StaleItems, AreThoseThatChangedSinceTheLastRefit)
{
    std::vector<ItemBounds> items = boxes();
    Hierarchy hierarchy = build_bvh(items);
    EXPECT_TRUE(stale_items(hierarchy, items).empty());
    items[2].box.max.x += 1.0f;
    items[7].triangles = 13;
    std::vector<ItemId> stale = stale_items(hierarchy, items);
    std::sort(stale.begin(), stale.end());
    EXPECT_EQ(stale, (std::vector<ItemId>{ItemId{2u}, ItemId{7u}}));
    hierarchy.refit(items);
    EXPECT_TRUE(stale_items(hierarchy, items).empty());
}

} // namespace
} // namespace occlude
