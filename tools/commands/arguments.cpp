#include "commands/arguments.h"

#include "commands/commands.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <ostream>

namespace occlude::tools {

struct CommandLine::Parser {
    CLI::App app;
};

struct Command::Parser {
    CLI::App* app;
};

namespace {

// Accepts only digits; larger numbers than memory could hold are typing errors.
CLI::Validator whole_number(ValueRange<uint64_t> range)
{
    return CLI::Validator{[range](const std::string& text) {
                              constexpr size_t kMaxDigits = 18;
                              const bool digits = !text.empty() && text.size() <= kMaxDigits &&
                                                  std::all_of(text.begin(), text.end(), [](char c) {
                                                      return c >= '0' && c <= '9';
                                                  });
                              const uint64_t value = digits ? std::stoull(text) : 0;
                              return digits && value >= range.low && value <= range.high
                                         ? std::string{}
                                         : fmt::format("'{}' is not a whole number from {} to {}",
                                                       text, range.low, range.high);
                          },
                          ""};
}

CLI::Validator file_name()
{
    return CLI::Validator{[](const std::string& text) {
                              return text.empty() ? std::string{"the file name is empty"}
                                                  : std::string{};
                          },
                          ""};
}

// Adds the option or the flag, with the parser for the type of its target.
struct AddTo {
    CLI::App& app;
    const Argument& argument;

    CLI::Option* operator()(bool* flag) const
    {
        return app.add_flag(argument.name, *flag, argument.help);
    }
    CLI::Option* operator()(std::vector<std::string>* texts) const
    {
        CLI::Option* option = app.add_option(argument.name, *texts, argument.help);
        const bool positional = argument.name.front() != '-';
        return positional ? option
                          : option->expected(1)->multi_option_policy(
                                CLI::MultiOptionPolicy::TakeAll); // the option may be repeated
    }
    template <class T>
    CLI::Option* operator()(T* value) const
    {
        return app.add_option(argument.name, *value, argument.help);
    }
};

} // namespace

Command::Command(std::unique_ptr<Parser> parser, Run run)
    : parser_(std::move(parser))
    , run_(std::move(run))
{
}

Command::~Command() = default;

void Command::add(const Argument& argument)
{
    CLI::Option* option = std::visit(AddTo{*parser_->app, argument}, argument.target);
    if (!argument.type.empty()) {
        option->type_name(argument.type);
    }
    if (!argument.group.empty()) {
        option->group(argument.group);
    }
    if (!argument.excludes.empty()) {
        option->excludes(parser_->app->get_option(argument.excludes));
    }
    if (argument.whole) {
        option->check(whole_number(*argument.whole));
    }
    if (argument.real) {
        option->check(CLI::Range(argument.real->low, argument.real->high));
    }
    if (argument.is_file) {
        option->check(file_name());
    }
    if (argument.shows_default) {
        option->capture_default_str();
    }
    option->required(argument.required);
}

void Command::add(std::initializer_list<Argument> arguments)
{
    for (const Argument& argument : arguments) {
        add(argument);
    }
}

bool Command::given(const std::string& name) const
{
    return parser_->app->count(name) > 0;
}

Error Command::misused(const std::string& problem) const
{
    return {ErrorCode::invalid_argument,
            fmt::format("{}; see 'occlude {} --help'", problem, parser_->app->get_name())};
}

CommandLine::CommandLine(const std::string& description, const std::string& version)
    : parser_(new Parser{CLI::App{description, "occlude"}})
{
    parser_->app.require_subcommand(1);
    parser_->app.set_version_flag("--version", version);
}

CommandLine::~CommandLine() = default;

Command& CommandLine::add(const std::string& name, const std::string& help, Command::Run run)
{
    CLI::App* app = parser_->app.add_subcommand(name, help);
    std::unique_ptr<Command::Parser> parser{new Command::Parser{app}};
    commands_.emplace_back(new Command{std::move(parser), std::move(run)});
    return *commands_.back();
}

std::vector<std::string> CommandLine::names() const
{
    std::vector<std::string> names;
    for (const auto& command : commands_) {
        names.push_back(command->parser_->app->get_name());
    }
    return names;
}

Result<int> CommandLine::run(int argc, const char* const* argv, const Streams& streams)
{
    const auto named = [&](const auto& command) {
        return argc > 1 && command->parser_->app->get_name() == argv[1];
    };
    try {
        parser_->app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) { // --help, --version
            parser_->app.exit(error, streams.out, streams.err);
            return int{kDone};
        }
        const auto command = std::find_if(commands_.begin(), commands_.end(), named);
        return command != commands_.end()
                   ? (*command)->misused(error.what())
                   : Error{ErrorCode::invalid_argument,
                           fmt::format("{}; see 'occlude --help'", error.what())};
    }
    const auto parsed = std::find_if(commands_.begin(), commands_.end(), [](const auto& command) {
        return command->parser_->app->parsed();
    });
    OCCLUDE_ASSERT(parsed != commands_.end(), "the parser requires a command");
    return (*parsed)->run_(**parsed, streams);
}

} // namespace occlude::tools
