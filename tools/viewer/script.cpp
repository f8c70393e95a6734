#include "viewer/script.h"

#include "options/options.h"
#include "viewer/keys.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

namespace occlude::tools::viewer {

namespace {

using Kind = ScriptStep::Kind;

std::vector<std::string> words_of(const std::string& line)
{
    std::istringstream stream{line};
    return {std::istream_iterator<std::string>{stream}, {}};
}

template <class Number>
std::optional<Number> number(const std::string& text)
{
    Number value{};
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = failed == std::errc{} && end == text.data() + text.size();
    return whole ? std::optional{value} : std::nullopt;
}

bool read_key(const std::string& text, ScriptStep& step)
{
    std::string_view key = text;
    if (key.starts_with("ctrl+") && key.size() > 5) {
        step.control = true;
        key.remove_prefix(5);
    }
    const auto code = key_code(key);
    step.key = code.value_or(0);
    return code.has_value();
}

bool read_count(const std::string& text, int least, ScriptStep& step)
{
    const auto count = number<int>(text);
    step.count = count.value_or(0);
    return count && *count >= least;
}

bool read_point(const std::string& x, const std::string& y, glm::vec2& point)
{
    const auto px = number<float>(x);
    const auto py = number<float>(y);
    point = {px.value_or(0.0f), py.value_or(0.0f)};
    return px && py;
}

// click 1 2; click "Label"
bool read_click(const std::vector<std::string>& words, const std::string& rest, ScriptStep& step)
{
    if (rest.size() > 2 && rest.front() == '"' && rest.back() == '"') {
        step.kind = Kind::click_label;
        step.text = rest.substr(1, rest.size() - 2);
        return true;
    }
    return words.size() == 3 && read_point(words[1], words[2], step.from);
}

bool read_drag(std::vector<std::string> words, ScriptStep& step)
{
    if (words.size() == 6 && (words[1] == "left" || words[1] == "right")) {
        step.button = words[1] == "right" ? 1 : 0;
        words.erase(words.begin() + 1);
    }
    return words.size() == 5 && read_point(words[1], words[2], step.from) &&
           read_point(words[3], words[4], step.to);
}

bool read_size(const std::string& text, ScriptStep& step)
{
    const auto size = parse_size(text);
    if (size) {
        step.to = glm::vec2{*size};
    }
    return static_cast<bool>(size);
}

struct Form {
    std::string_view name;
    Kind kind;
    const char* shape;
};
constexpr std::array<Form, 15> kForms = {
    {{"wait", Kind::wait, "wait FRAMES"},
     {"key", Kind::key, "key NAME or key ctrl+NAME"},
     {"hold", Kind::hold, "hold NAME FRAMES"},
     {"move", Kind::move, "move X Y"},
     {"click", Kind::click, "click X Y or click \"LABEL\""},
     {"drag", Kind::drag, "drag X Y X Y or drag right X Y X Y"},
     {"scroll", Kind::scroll, "scroll NOTCHES"},
     {"type", Kind::type, "type TEXT"},
     {"drop", Kind::drop, "drop FILE"},
     {"resize", Kind::resize, "resize WIDTHxHEIGHT"},
     {"wait-loaded", Kind::wait_loaded, "wait-loaded"},
     {"wait-text", Kind::wait_text, "wait-text TEXT"},
     {"assert-text", Kind::assert_text, "assert-text TEXT"},
     {"assert-no-text", Kind::assert_no_text, "assert-no-text TEXT"},
     {"screenshot", Kind::screenshot, "screenshot FILE.png"}}};

bool read_arguments(const std::vector<std::string>& words, const std::string& rest,
                    ScriptStep& step)
{
    constexpr int kAnyCount = -1000000;
    const size_t count = words.size();
    switch (step.kind) {
    case Kind::wait:
        return count == 2 && read_count(words[1], 1, step);
    case Kind::key:
        return count >= 2 && read_key(rest, step);
    case Kind::hold:
        return count == 3 && read_key(words[1], step) && read_count(words[2], 1, step);
    case Kind::move:
        return count == 3 && read_point(words[1], words[2], step.from);
    case Kind::click:
    case Kind::click_label:
        return read_click(words, rest, step);
    case Kind::drag:
        return read_drag(words, step);
    case Kind::scroll:
        return count == 2 && read_count(words[1], kAnyCount, step);
    case Kind::resize:
        return count == 2 && read_size(words[1], step);
    case Kind::wait_loaded:
        return count == 1;
    case Kind::type:
    case Kind::drop:
    case Kind::wait_text:
    case Kind::assert_text:
    case Kind::assert_no_text:
    case Kind::screenshot:
        step.text = rest;
        return !rest.empty();
    }
    return false;
}

} // namespace

Result<std::vector<ScriptStep>> parse_script(std::string_view text, const std::string& name)
{
    std::vector<ScriptStep> steps;
    std::istringstream stream{std::string{text}};
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        const std::vector<std::string> words = words_of(line);
        if (words.empty() || words[0].starts_with('#')) {
            continue;
        }
        const size_t verb_end = line.find(words[0]) + words[0].size();
        const size_t rest_begin = std::min(line.find_first_not_of(" \t", verb_end), line.size());
        std::string rest = line.substr(rest_begin);
        rest.erase(rest.find_last_not_of(" \t\r") + 1);
        const Form* form = nullptr;
        std::string known;
        for (const Form& candidate : kForms) {
            known += (known.empty() ? "" : ", ") + std::string{candidate.name};
            if (candidate.name == words[0]) {
                form = &candidate;
            }
        }
        if (form == nullptr) {
            return Error{ErrorCode::invalid_argument,
                         fmt::format("{}: line {}: there is no input '{}'; choose from: {}", name,
                                     number, words[0], known)};
        }
        ScriptStep step{.kind = form->kind, .line = number};
        if (!read_arguments(words, rest, step)) {
            return Error{ErrorCode::invalid_argument,
                         fmt::format("{}: line {}: '{}' cannot be understood; write {}", name,
                                     number, line, form->shape)};
        }
        steps.push_back(std::move(step));
    }
    return steps;
}

Result<std::vector<ScriptStep>> read_script(const std::string& file)
{
    std::ifstream stream{file};
    if (!stream) {
        return Error{ErrorCode::not_found,
                     fmt::format("--script: '{}' cannot be read; name a file of inputs", file)};
    }
    const std::string text{std::istreambuf_iterator<char>{stream}, {}};
    return parse_script(text, file);
}

} // namespace occlude::tools::viewer
