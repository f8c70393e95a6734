#include "commands/commands.h"

#include "files/output_file.h"
#include "generate/scene_source.h"
#include "load/glb_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

namespace occlude::tools {

Result<int> generate_command(const GenerateOptions& options, const Streams& streams)
{
    const std::string kind = options.scene.substr(0, options.scene.find(':'));
    std::string known;
    for (const GeneratorInfo& info : generators()) {
        known += fmt::format("{}{}", known.empty() ? "" : ", ", info.name);
    }
    const auto is_it = [&](const GeneratorInfo& info) { return info.name == kind; };
    if (std::none_of(generators().begin(), generators().end(), is_it)) {
        return Error{
            ErrorCode::not_found,
            fmt::format("generate: there is no generator '{}'; choose one of {}", kind, known)};
    }
    if (!options.out.ends_with(".glb")) {
        return Error{
            ErrorCode::invalid_argument,
            fmt::format("--out: '{}' is not the name of a binary glTF file; end it in .glb",
                        options.out)};
    }
    auto file = OutputFile::open(options.out);
    if (!file) {
        return file.error();
    }
    const auto model = load_scene(options.scene);
    if (!model) {
        return model.error();
    }
    const auto bytes = to_glb(*model);
    if (!bytes) {
        return bytes.error();
    }
    if (const auto written = file->commit(*bytes); !written) {
        return written.error();
    }
    streams.out << fmt::format("{}: {} objects of {} meshes, {} triangles, {:.1f} MB\n",
                               options.out, model->instances.size(), model->meshes.size(),
                               drawn_triangles(*model), 1e-6 * static_cast<double>(bytes->size()));
    if (!model->motion.empty() || !model->paths.empty()) {
        streams.err
            << "occlude: the file has no paths and no motion; give 'bench' the generator itself "
               "to measure with them\n";
    }
    return kDone;
}

} // namespace occlude::tools
