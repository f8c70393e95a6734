#include "commands/commands.h"

#include "files/output_file.h"
#include "load/glb_writer.h"
#include "load/scene_loader.h"
#include "session/session.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <ostream>

namespace occlude::tools {

Result<int> convert_command(const ConvertOptions& options, const Streams& streams)
{
    if (!options.out.ends_with(".glb")) {
        return Error{
            ErrorCode::invalid_argument,
            fmt::format("--out: '{}' is not the name of a binary glTF file; end it in .glb",
                        options.out)};
    }
    auto scene_options = parse_file_options(options.file);
    if (!scene_options) {
        return scene_options.error();
    }
    std::optional<Progress> progress;
    progress.emplace(streams.err, streams.watcher, "converting " + options.scene);
    scene_options->progress = [&](double share) { progress->show("reading", share); };
    auto file = OutputFile::open(options.out);
    if (!file) {
        return file.error();
    }
    const auto model = load_scene_file(options.scene, *scene_options);
    if (!model) {
        return model.error();
    }
    if (const auto problem =
            options.strict ? left_out_error(options.scene, *model) : std::nullopt) {
        return *problem;
    }
    progress->show("writing", std::nan(""));
    const auto bytes = to_glb(*model);
    if (!bytes) {
        return bytes.error();
    }
    if (const auto written = file->commit(*bytes); !written) {
        return written.error();
    }
    progress.reset();
    streams.out << fmt::format("{}: {} objects of {} meshes, {} triangles, {:.1f} MB\n",
                               options.out, model->instances.size(), model->meshes.size(),
                               drawn_triangles(*model), 1e-6 * static_cast<double>(bytes->size()))
                << load_summary(*model);
    return kDone;
}

} // namespace occlude::tools
