#include "session/worst_frames.h"

#include "render/image.h"
#include "report/headline.h"
#include "session/picture.h"

#include <algorithm>
#include <array>

namespace occlude::tools {

static constexpr int kMaxWidth = 640; // of a picture in a report

static void append_pictures(Session& session, const Culler& culler, const Camera& camera,
                            FramePicture about, std::vector<FramePicture>& pictures)
{
    struct Kind {
        Show show;
        const char* caption;
    };
    constexpr std::array<Kind, 3> kKinds = {
        {{Show::visible, "the image"},
         {Show::hidden, "hidden items shine through in vermilion"},
         {Show::boxes, "boxes that were decided: hidden ones vermilion or purple, drawn ones "
                       "green, yellow, sky blue or orange"}}};
    for (const Kind& kind : kKinds) {
        about.caption = kind.caption;
        about.png = encode_png(
            shrunk(draw_picture(session, culler, camera, kind.show, std::nullopt), kMaxWidth));
        pictures.push_back(about);
    }
}

Result<std::vector<FramePicture>> picture_worst_frames(Session& session, const Contender& contender,
                                                       const AlgorithmRun& run,
                                                       std::span<const Camera> cameras,
                                                       size_t count)
{
    std::vector<FramePicture> pictures;
    for (const size_t place : worst_frames(run, count)) {
        const size_t frame = run.frames[place].frame;
        const auto culler =
            contender.make(contender.tree != nullptr ? *contender.tree : session.hierarchy());
        if (!culler) {
            return culler.error();
        }
        for (size_t i = frame - std::min(frame, kLeadInFrames); i <= frame; ++i) {
            cull_for_picture(session, **culler, make_view(cameras[i], session.options().size), i);
        }
        append_pictures(session, **culler, cameras[frame],
                        {.frame = frame, .algorithm = run.algorithm, .caption = {}, .png = {}},
                        pictures);
    }
    return pictures;
}

} // namespace occlude::tools
