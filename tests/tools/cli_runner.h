// Runs the program as its users do, and returns its exit status and output.
#pragma once

#include "commands/cli.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

namespace occlude::tools {

namespace fs = std::filesystem;

struct Outcome {
    int code = -1;
    std::string out;
    std::string err;
};

inline Outcome run(std::vector<std::string> arguments, Watcher watcher = Watcher::none)
{
    arguments.insert(arguments.begin(), "occlude");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) {
        argv.push_back(argument.c_str());
    }
    std::ostringstream out;
    std::ostringstream err;
    const int code = run_program(static_cast<int>(argv.size()), argv.data(), {out, err, watcher});
    return {code, out.str(), err.str()};
}

inline fs::path write_file(const std::string& name, const std::string& content)
{
    // Each test is its own process under ctest: a shared file could be read half written.
    const fs::path directory =
        fs::path{testing::TempDir()} / ("occlude_cli_test_" + std::to_string(getpid()));
    fs::create_directories(directory);
    std::ofstream{directory / name} << content;
    return directory / name;
}

// A file with a wall in front of a smaller quad.
inline std::string scene_file()
{
    return write_file("wall.obj", "o wall\nv -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\nf 1 2 3 4\n"
                                  "o behind\nv -1 -1 -2\nv 1 -1 -2\nv 1 1 -2\nv -1 1 -2\n"
                                  "f 5 6 7 8\n")
        .string();
}

inline std::vector<std::string> small(std::vector<std::string> arguments)
{
    const std::vector<std::string> rest = {"--device", "cpu", "--size", "40x30"};
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    return arguments;
}

// Expects that the program ends with 2, prints nothing to `out`, and prints one line to `err` that
// contains all of `parts`.
inline void expect_refused(const std::vector<std::string>& arguments,
                           const std::vector<std::string>& parts)
{
    const Outcome outcome = run(arguments);
    const std::string command = testing::PrintToString(arguments);
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_EQ(outcome.out, "") << command;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("occlude: ", 0), 0u) << outcome.err;
    for (const std::string& part : parts) {
        EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in: " << outcome.err;
    }
}

} // namespace occlude::tools
