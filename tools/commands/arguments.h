// The arguments of the command line, declared as data.
//
// CLI11 does the parsing. Its header alone takes as long to compile as a whole command, so only
// arguments.cpp includes it.
#pragma once

#include <occlude/core/result.h>

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace occlude::tools {

struct Streams;

/// The variable that an argument sets. Its type says which values are accepted.
using ArgumentTarget =
    std::variant<bool*, int*, uint32_t*, uint64_t*, std::optional<uint64_t>*, std::optional<float>*,
                 std::string*, std::optional<std::string>*, std::vector<std::string>*>;

/// Which values are accepted, both ends included.
template <class T>
struct ValueRange {
    T low;
    T high;
};

/// An option ("--frames"), a flag (an option with a bool) or a positional ("scene").
struct Argument {
    std::string name;
    ArgumentTarget target;
    std::string help;
    std::string type = {};     ///< type name in the help; empty: derived from the target
    std::string group = {};    ///< heading in the help; empty: the default heading
    std::string excludes = {}; ///< an option that excludes this one
    bool required = false;
    bool shows_default = false; ///< show the target's present value in the help
    bool is_file = false;       ///< refuse an empty name, as in --json "$UNSET"
    std::optional<ValueRange<uint64_t>> whole = {};
    std::optional<ValueRange<float>> real = {};
};

/// One command with its arguments.
class Command {
public:
    /// Runs a command whose arguments are filled in.
    using Run = std::function<Result<int>(const Command& command, const Streams& streams)>;

    ~Command();

    /// Targets must outlive the command. Names differ from those of earlier arguments.
    void add(const Argument& argument);
    void add(std::initializer_list<Argument> arguments);

    /// True if the user gave the argument. Precondition: there is one of this name.
    bool given(const std::string& name) const;

    /// An error in how the command was called; its sentence also says how to get help.
    Error misused(const std::string& problem) const;

private:
    friend class CommandLine;
    struct Parser;
    Command(std::unique_ptr<Parser> parser, Run run);

    std::unique_ptr<Parser> parser_;
    Run run_;
};

/// The program's commands.
class CommandLine {
public:
    CommandLine(const std::string& description, const std::string& version);
    ~CommandLine();

    /// Adds a command. The reference lives as long as the command line.
    Command& add(const std::string& name, const std::string& help, Command::Run run);

    /// The names of all commands, in the order in which they were added.
    std::vector<std::string> names() const;

    /// Reads `argv` and runs the command that it names, or prints the requested help and returns 0.
    Result<int> run(int argc, const char* const* argv, const Streams& streams);

private:
    struct Parser;
    std::unique_ptr<Parser> parser_;
    std::vector<std::unique_ptr<Command>> commands_;
};

} // namespace occlude::tools
