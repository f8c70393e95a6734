// Asserts the contract of core/query_device.h, line by line, on both sides: the requests of the
// caller and the answers of the device.
//
//   C1            frames nest, or a verb comes outside of a frame
//   C2, C3, C4    only with DepthChecks::around_batches, from depth read before and after: a test
//                 counts no sample although a pixel deep inside a box shows farther depth. This is
//                 named C2 if something was drawn in between, which the test may have seen. Or a
//                 batch changed depth. (Colour cannot be read.)
//   C3            likewise: a tile of depth is nearer than one of its pixels
//   C5            a box is unbounded or touches the near rectangle, after inflation, as it is
//                 handed to the device. A box with a transform breaks C5 only if it touches both as
//                 an AABB in world space and exactly, in its own space.
//   C6            a test without boxes; ends that do not ascend or do not cover all boxes. Such a
//                 batch does not reach the device: its tickets are invalid.
//   C7            a spent or foreign ticket is asked again, or is not answered as lost; a ticket is
//                 given out again. Asking an invalid ticket is fine: it was lost from the start.
//   C8            a lost or pending answer that does not read as visible
//   C9            wait() answers pending. (It cannot be seen whether poll() blocks.)
//   C10           an item twice in one pass of a frame
//   C11           more than caps.max_outstanding tests would be unspent
//   C12           the device gives an unspent ticket of an earlier frame to another test
//   methods       a batch names a test method that caps.methods does not list
//   passes        shade_equal without depth_only before it, or depth_only without shade_equal after
//                 it
//   precondition  of a verb: sizes of spans, rectangles inside the target, valid items; or depth
//                 was read outside of 0..1
//                 read outside of 0..1
#pragma once

#include <occlude/device/forwarding_device.h>

#include <functional>
#include <map>
#include <string_view>
#include <unordered_map>

namespace occlude {

/// Called with the name of the broken rule and a sentence.
using ViolationHandler = std::function<void(std::string_view rule, std::string_view message)>;

class ValidatingDevice final : public ForwardingDevice {
public:
    enum class DepthChecks : uint8_t {
        off,
        around_batches, ///< reads all depth twice per batch: slow; needs caps().read_depth
    };

    struct Options {
        /// The receiver of violations. Default: the assert handler (set_assert_handler), also in
        /// release builds.
        ViolationHandler on_violation = {};
        DepthChecks depth_checks = DepthChecks::off;
    };

    /// Keeps a reference: `inner` must outlive this device. Tickets pass through unchanged.
    explicit ValidatingDevice(QueryDevice& inner)
        : ValidatingDevice(inner, Options{})
    {
    }
    ValidatingDevice(QueryDevice& inner, Options options);

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    struct Test {
        uint64_t frame = 0;
        uint64_t draws_before = 0;
        int sure_pixels = 0; ///< pixels that must show the boxes; 0 without depth checks
    };

    void report(std::string_view rule, const std::string& message) const;
    void require_frame(const char* verb) const;
    void check_items(std::span<const ItemId> items, DrawPass pass);
    void check_method(TestMethod method) const;
    bool check_batch(const QueryBatch& batch, size_t ticket_count) const;
    void check_box(const QueryBox& box, size_t index) const;
    void check_outstanding(size_t new_tests) const;
    void adopt(Ticket ticket, int sure_pixels);
    Answer check_answer(const char* verb, Ticket ticket, Answer answer);
    void check_count(const Test& test, const Answer& answer) const;
    void check_depths(std::span<const float> depths) const;
    void check_tiles(int tile_px, std::span<const float> tiles) const;
    std::vector<float> depth() const;

    Options options_;
    View view_;
    bool in_frame_ = false;
    uint64_t frame_ = 0;
    uint64_t draws_ = 0;
    std::map<Ticket, Test> unspent_;
    std::unordered_map<uint32_t, uint32_t> last_generation_; ///< of each ticket index
    std::unordered_map<ItemId, uint8_t> passes_;             ///< bit p: drawn in pass p this frame
};

} // namespace occlude
