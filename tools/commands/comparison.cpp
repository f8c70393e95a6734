#include "commands/comparison.h"

#include "measure/verify.h"
#include "report/csv_report.h"
#include "report/html_report.h"
#include "report/json_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <ostream>
#include <ranges>

namespace occlude::tools {

// Opens `path` into `file`; does nothing for an empty path.
static Result<bool> open_into(std::optional<OutputFile>& file, const std::string& path)
{
    if (path.empty()) {
        return true;
    }
    auto opened = OutputFile::open(path);
    if (!opened) {
        return opened.error();
    }
    file.emplace(std::move(*opened));
    return true;
}

Result<ReportFiles> ReportFiles::open(const CompareOptions& options)
{
    ReportFiles files;
    if (const auto opened = open_into(files.json_, options.json); !opened) {
        return opened.error();
    }
    if (const auto opened = open_into(files.csv_, options.csv); !opened) {
        return opened.error();
    }
    if (const auto opened = open_into(files.html_, options.html); !opened) {
        return opened.error();
    }
    return files;
}

Result<bool> ReportFiles::write(std::span<const BenchDocument> documents)
{
    if (json_) {
        if (const auto written = json_->commit(json_report(documents)); !written) {
            return written.error();
        }
    }
    if (csv_) {
        if (const auto written = csv_->commit(csv_report(documents)); !written) {
            return written.error();
        }
    }
    if (html_) {
        if (const auto written = html_->commit(html_report(documents)); !written) {
            return written.error();
        }
    }
    return true;
}

// Drivers may give more samples than requested: a pixel has as many ids as samples.
int samples_given(SceneRenderer& renderer, glm::ivec2 size, int asked)
{
    if (asked <= 1) {
        return asked;
    }
    const View view = View::from_clip(glm::mat4{1.0f}, size);
    const auto pixels = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    return std::max(static_cast<int>(renderer.render_ids(view, {}).size() / pixels), 1);
}

BenchDocument describe(Session& session, const CompareOptions& options, const std::string& path,
                       size_t frames)
{
    return {.scene = session.model().name,
            .objects = session.model().instances.size(),
            .items = session.scene().items.size(),
            .triangles = drawn_triangles(session.model()),
            .load_notes = session.model().load_notes,
            .load_losses = session.model().load_losses,
            .device = session.device_name(),
            .api = session.renderer().api(),
            .renderer = session.renderer().renderer_name(),
            .hierarchy = fmt::format("{}", fmt::join(session.tree_labels(), ", ")),
            .test = session.options().test,
            .path = path,
            .size = options.stage.size,
            .samples = samples_given(session.renderer(), options.stage.size, options.stage.samples),
            .frames = frames,
            .repeat = options.repeat,
            .sample_every = 1,
            .leaf_triangles = options.stage.leaf_triangles,
            .item_triangles = options.stage.item_triangles,
            .split = options.stage.split,
            .sets = options.stage.sets,
            .preparation = session.preparation(),
            .entry = {},
            .date = {},
            .runs = {}};
}

void print_differences(std::span<const AlgorithmRun> runs, std::ostream& out)
{
    constexpr size_t kMaxLines = 10;
    for (const AlgorithmRun& run : runs) {
        for (const std::string& line : describe_differences(run, kMaxLines)) {
            out << line << '\n';
        }
    }
}

std::vector<CoincidentObjects> coincident_objects(const Session& session,
                                                  std::span<const AlgorithmRun> runs)
{
    constexpr size_t kMostPairs = 10;
    using Pair = std::pair<uint32_t, uint32_t>; // instances
    const std::vector<SceneModel::Item>& items = session.scene().items;
    std::map<Pair, uint64_t> most;
    for (const AlgorithmRun& run : runs) {
        for (const FrameFigures& frame : run.frames) {
            std::map<Pair, uint64_t> pixels_of;
            for (const CoincidentItems& pair :
                 frame.verdict ? frame.verdict->coincident : std::vector<CoincidentItems>{}) {
                if (pair.first.value < items.size() && pair.last.value < items.size()) {
                    const uint32_t a = items[pair.first.value].instance;
                    const uint32_t b = items[pair.last.value].instance;
                    pixels_of[{std::min(a, b), std::max(a, b)}] += pair.pixels;
                }
            }
            for (const auto& [pair, pixels] : pixels_of) {
                most[pair] = std::max(most[pair], pixels);
            }
        }
    }
    std::vector<CoincidentObjects> objects;
    for (const auto& [pair, pixels] : most) {
        objects.push_back({object_name(session.model(), pair.first),
                           object_name(session.model(), pair.second), pixels});
    }
    std::ranges::stable_sort(objects, std::greater{}, &CoincidentObjects::pixels);
    objects.resize(std::min(objects.size(), kMostPairs));
    return objects;
}

static std::string coincidence_text(const BenchDocument& document, uint64_t tied)
{
    constexpr size_t kNamed = 3;
    std::string text = fmt::format(
        "Coincident surfaces: {} pixels show one of two surfaces at the same depth, ", tied);
    if (!document.coincident.empty()) {
        text += "of ";
        for (size_t i = 0; i < std::min(kNamed, document.coincident.size()); ++i) {
            const CoincidentObjects& pair = document.coincident[i];
            text += pair.first == pair.second
                        ? fmt::format("{}'{}' and itself ({} pixels of a frame)", i > 0 ? ", " : "",
                                      pair.first, pair.pixels)
                        : fmt::format("{}'{}' and '{}' ({} pixels of a frame)", i > 0 ? ", " : "",
                                      pair.first, pair.second, pair.pixels);
        }
        text += document.coincident.size() > kNamed ? " and others, " : ", ";
    }
    return text +
           "and which one depends on the order of draws. Nothing was culled wrongly there, but "
           "culling changes that order: such pixels may flicker. Move one of the surfaces by a "
           "small distance or remove it, or draw depth first and shade afterwards in a fixed "
           "order.\n\n";
}

static uint64_t most_tied_pixels(const BenchDocument& document)
{
    uint64_t most = 0;
    for (const AlgorithmRun& run : document.runs) {
        most = std::max(most, summarise(run).tied_pixels);
    }
    return most;
}

int judge_evidence(const BenchDocument& document, bool must_hide, bool strict, std::ostream& out)
{
    const Evidence evidence = evidence_of(document.runs);
    int code = kDone;
    if (evidence.frames > 0 && evidence.empty_frames == evidence.frames) {
        out << fmt::format("Nothing is proven: nothing was in view in any of the {} frames of path "
                           "{}. Choose another --path.\n\n",
                           evidence.frames, document.path);
        return kNothingProven;
    }
    if (evidence.empty_frames > 0) {
        out << fmt::format(
            "Nothing was in view in {} of the {} frames: those frames prove nothing.\n\n",
            evidence.empty_frames, evidence.frames);
    }
    if (evidence.hiding_frames == 0) {
        out << fmt::format(
            "Nothing was hidden in any of the {} frames of path {}: every item in the "
            "frustum was drawn, so this says nothing about culling.{}\n\n",
            evidence.frames, document.path,
            must_hide ? " Choose another --path, or say --nothing-hidden-is-fine."
                      : " Choose another --path or --algorithms.");
        code = must_hide ? kNothingProven : kDone;
    }
    if (const uint64_t tied = most_tied_pixels(document); tied > 0) {
        out << coincidence_text(document, tied);
        code = strict ? worse(code, kDiffers) : code;
    }
    return code;
}

int worse(int a, int b)
{
    // A difference is worse than a frame that proves nothing.
    return a == kDone ? b : b == kDone ? a : std::min(a, b);
}

static Result<Pairing> choose_pairs(const CompareOptions& options, const DeviceCaps& caps,
                                    References references)
{
    const auto contenders =
        choose_contenders(options.algorithms, options.stage.sets, caps, references);
    if (!contenders) {
        return contenders.error();
    }
    const auto trees = choose_hierarchies(options.stage.hierarchy, options.stage.sets);
    if (!trees) {
        return trees.error();
    }
    return pair_with_hierarchies(*contenders, *trees, options.algorithms, options.stage.hierarchy);
}

Result<std::vector<Contender>> contenders_of(Session& session, const CompareOptions& options,
                                             References references)
{
    auto pairing = choose_pairs(options, session.renderer().device().caps(), references);
    if (!pairing) {
        return pairing.error();
    }
    for (Contender& contender : pairing->contenders) {
        contender.tree = session.tree(contender.hierarchy);
    }
    return std::move(pairing->contenders);
}

Result<bool> check_compare_options(const CompareOptions& options, std::ostream& notes)
{
    if (const auto checked = check_stage_options(options.stage); !checked) {
        return checked.error();
    }
    // There is no device yet, so assume one that supports everything.
    DeviceCaps any;
    any.read_depth = true;
    const auto pairing = choose_pairs(options, any, References::always);
    if (!pairing) {
        return pairing.error();
    }
    const Hierarchy nothing = build_bvh({});
    for (const Contender& contender : pairing->contenders) {
        if (const auto culler = contender.make(nothing); !culler) {
            return culler.error();
        }
    }
    for (const std::string& note : pairing->notes) {
        notes << "occlude: " << note << '\n';
    }
    return true;
}

} // namespace occlude::tools
