#include "fuzz/targets.h"

#include "commands/cli.h"
#include "generate/scene_source.h"
#include "replay/replay.h"
#include "suites/suite_results.h"
#include "walk/paths.h"

#include <occlude/device/recording.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

namespace occlude::fuzz {

namespace {

namespace fs = std::filesystem;

std::string text_of(Bytes bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A file that belongs to this process and is overwritten by each input.
std::string file_of(Bytes bytes, const std::string& ending)
{
    static const fs::path folder = [] {
        const fs::path made =
            fs::temp_directory_path() / ("occlude-fuzz-" + std::to_string(::getpid()));
        fs::create_directories(made);
        return made;
    }();
    const fs::path file = folder / ("input" + ending);
    std::ofstream{file, std::ios::binary}.write(reinterpret_cast<const char*>(bytes.data()),
                                                static_cast<std::streamsize>(bytes.size()));
    return file.string();
}

/// The same, with the hash of the preceding bytes as the last eight. Hostile files have a right
/// hash, and random mutations never find it.
std::string with_checksum(Bytes bytes)
{
    constexpr size_t kHashBytes = 8;
    std::string text = text_of(bytes.first(bytes.size() - std::min(bytes.size(), kHashBytes)));
    uint64_t hash = 0xcbf29ce484222325ull; // FNV-1a
    for (const char c : text) {
        hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3ull;
    }
    for (size_t i = 0; i < kHashBytes; ++i) {
        text.push_back(static_cast<char>(hash >> (8 * i) & 0xff));
    }
    return text;
}

/// An error without a sentence is a failure, too.
template <class T>
void expect_sentence(const Result<T>& result)
{
    if (!result && result.error().message.size() < 10) {
        std::abort();
    }
}

} // namespace

void path_file(Bytes bytes)
{
    const std::string file = file_of(bytes, ".json");
    expect_sentence(tools::read_path_file(file, 50));
    tools::SceneModel model;
    expect_sentence(tools::read_movers(file, model));
}

void results(Bytes bytes)
{
    const std::string text = text_of(bytes);
    expect_sentence(tools::parse_suite_results("results.json", text));
    const std::vector<std::string> names{"one", "two"};
    expect_sentence(tools::add_to_results("results.json", text, text, names));
}

void device_recording(Bytes bytes)
{
    for (const std::string& text : {text_of(bytes), with_checksum(bytes)}) {
        std::istringstream stream{text};
        expect_sentence(load_recording(stream));
    }
}

void run_recording(Bytes bytes)
{
    for (const std::string& text : {text_of(bytes), with_checksum(bytes)}) {
        const auto recording = tools::from_bytes(text, "run.rec");
        expect_sentence(recording);
        if (recording) {
            for (const tools::RecordedRun& run : recording->runs) {
                expect_sentence(tools::replay(*recording, run));
            }
        }
    }
}

void scene(Bytes bytes)
{
    constexpr std::array kEndings{".obj", ".gltf", ".glb", ".ply", ".stl", ".dae", ".off"};
    if (bytes.empty()) {
        return;
    }
    const std::string file = file_of(bytes.subspan(1), kEndings[bytes[0] % kEndings.size()]);
    expect_sentence(tools::load_scene(file));
}

// Nothing runs: the last argument is unknown.
void command_line(Bytes bytes)
{
    std::istringstream lines{text_of(bytes)};
    std::vector<std::string> arguments{"occlude"};
    for (std::string line; std::getline(lines, line) && arguments.size() < 40;) {
        arguments.push_back(line);
    }
    arguments.emplace_back("--no-such-option=1");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) {
        argv.push_back(argument.c_str());
    }
    std::ostringstream out;
    std::ostringstream err;
    const int code = tools::run_program(static_cast<int>(argv.size()), argv.data(), {out, err});
    if (code == 2 && err.str().rfind("occlude: ", 0) != 0) {
        std::abort();
    }
}

} // namespace occlude::fuzz
