#include "commands/commands.h"

#include "generate/scene_source.h"
#include "report/table.h"
#include "session/hierarchies.h"
#include "walk/paths.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <fmt/format.h>

#include <ostream>

namespace occlude::tools {

namespace {

std::string list_algorithms()
{
    std::string text;
    for (const AlgorithmInfo& info : algorithms()) {
        text += fmt::format("{} ({}{})\n    {}\n", info.name, info.paper,
                            info.exact ? "" : ", not exact", info.summary);
        text += info.hierarchies.empty()
                    ? "    hierarchies: any, it does not use their nodes\n"
                    : fmt::format("    hierarchies: {}\n", fmt::join(info.hierarchies, ", "));
        for (const OptionInfo& option : info.options) {
            text += fmt::format("    --set {}.{}={}  {}\n", info.name, option.name,
                                option.default_value, option.description);
        }
    }
    return text;
}

std::string list_hierarchies()
{
    std::string text;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        text += fmt::format("{}\n    {}\n", kind.name, kind.summary);
        for (const OptionInfo& option : kind.options()) {
            text += fmt::format("    --set {}.{}={}  {}\n", tree_set_name(kind.name), option.name,
                                option.default_value, option.description);
        }
    }
    return text;
}

std::string list_scenes()
{
    std::string text = "any file that Assimp reads: .glb, .gltf, .obj, .ply, .stl, .fbx, ...\n";
    for (const GeneratorInfo& info : generators()) {
        text += fmt::format("{}:{}\n    {}\n", info.name, info.parameters, info.description);
    }
    return text;
}

Result<std::string> list_paths(const std::string& scene)
{
    SceneModel model;
    if (!scene.empty()) {
        auto loaded = load_scene(scene);
        if (!loaded) {
            return loaded.error();
        }
        model = std::move(*loaded);
    }
    std::string text;
    for (const PathInfo& path : path_names(model)) {
        text += fmt::format("{}\n    {}\n", path.name, path.description);
    }
    text += "FILE.json\n    a path file: frames or keyframes\n";
    if (scene.empty()) {
        text += "'occlude list paths SCENE' also shows the paths that come with a scene\n";
    }
    return text;
}

Result<std::string> list_text(const ListOptions& options)
{
    if (options.what == "algorithms") {
        return list_algorithms();
    }
    if (options.what == "hierarchies") {
        return list_hierarchies();
    }
    if (options.what == "devices") {
        return std::string{"gl\n    OpenGL without a window; a software driver where there is no "
                           "GPU\ncpu\n    a software renderer: slow, exact, needs no driver\n"
                           "cpu_fast\n    OpenGL draws; tests are answered at once by occluders "
                           "rasterised on the CPU\n"};
    }
    if (options.what == "scenes") {
        return list_scenes();
    }
    if (options.what == "paths") {
        return list_paths(options.scene);
    }
    return Error{ErrorCode::invalid_argument,
                 fmt::format("list: there is no list of '{}'; choose algorithms, hierarchies, "
                             "devices, scenes or paths",
                             options.what)};
}

} // namespace

Result<int> list_command(const ListOptions& options, const Streams& streams)
{
    if (!options.scene.empty() && options.what != "paths") {
        return Error{
            ErrorCode::invalid_argument,
            fmt::format("list {}: takes no scene; only 'list paths SCENE' does", options.what)};
    }
    const auto text = list_text(options);
    if (!text) {
        return text.error();
    }
    streams.out << *text;
    return kDone;
}

} // namespace occlude::tools
