#include "walk/path_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string_view>
#include <vector>

namespace occlude::tools {

namespace {

/// How many letters must be put in, taken out or replaced to make one word of another.
size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

/// What is wrong with the keys of an object; empty if nothing is.
std::string unknown_key(const Json& object, std::initializer_list<const char*> keys)
{
    for (const Json::Member& member : object.members()) {
        const std::string& key = member.first;
        const auto is_it = [&](const char* known) { return key == known; };
        if (std::none_of(keys.begin(), keys.end(), is_it)) {
            const auto nearest =
                std::min_element(keys.begin(), keys.end(), [&](const char* a, const char* b) {
                    return edit_distance(key, a) < edit_distance(key, b);
                });
            return fmt::format("has an unknown key \"{}\"; did you mean \"{}\"? Known are {}", key,
                               *nearest, fmt::join(keys, ", "));
        }
    }
    return {};
}

} // namespace

Error bad_path(const std::string& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file, what)};
}

Result<Json> read_path_json(const std::string& file)
{
    std::error_code failed;
    std::ifstream in(file, std::ios::binary);
    if (!in || std::filesystem::is_directory(file, failed)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; check the name and permissions", file)};
    }
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Json root;
    try {
        root = Json::parse(text);
    } catch (const std::exception& error) {
        return bad_path(file, fmt::format("is not JSON that can be read: {}", error.what()));
    }
    if (!root.is_object()) {
        return bad_path(file, "must hold {\"version\": 1, \"frames\": [...]}");
    }
    const Json* const version = root.find("version");
    if (version == nullptr || !version->is_number() || version->number() != 1.0) {
        return bad_path(file, "\"version\" must be 1");
    }
    if (const std::string problem = unknown_key(root, {"version", "frames", "keyframes", "movers"});
        !problem.empty()) {
        return bad_path(file, problem);
    }
    return root;
}

PathEntry::PathEntry(const Json& value, std::string place, const char* example)
    : value_(value)
    , place_(std::move(place))
{
    if (!value_.is_object()) {
        problem_ = fmt::format("{} must be an object such as {}", place_, example);
    }
}

void PathEntry::require(const char* key)
{
    if (!has(key)) {
        fail(fmt::format("{} has no \"{}\"", place_, key));
    }
}

void PathEntry::allow_only(std::initializer_list<const char*> keys)
{
    if (value_.is_object()) {
        if (const std::string problem = unknown_key(value_, keys); !problem.empty()) {
            fail(fmt::format("{} {}", place_, problem));
        }
    }
}

void PathEntry::read(const char* key, glm::vec3& out)
{
    glm::dvec3 precise = out;
    read(key, precise);
    out = glm::vec3{precise};
}

void PathEntry::read(const char* key, glm::dvec3& out)
{
    if (!has(key)) {
        return;
    }
    const Json& list = value_.at(key);
    for (size_t i = 0; i < 3; ++i) {
        const bool is_number = list.is_array() && list.size() == 3 && list.at(i).is_number();
        const double number = is_number ? list.at(i).number() : 0.0;
        if (!is_number || !(std::abs(number) <= double{FLT_MAX})) {
            fail(fmt::format("{}.{} must be three numbers, such as [1.0, 2.0, 3.0]", place_, key));
            return;
        }
        out[static_cast<int>(i)] = number;
    }
}

void PathEntry::read(const char* key, float& out, float least, float most)
{
    if (!has(key)) {
        return;
    }
    const float number =
        value_.at(key).is_number() ? static_cast<float>(value_.at(key).number()) : NAN;
    if (!(number >= least && number <= most)) {
        fail(fmt::format("{}.{} must be a number from {} to {}", place_, key, least, most));
        return;
    }
    out = number;
}

void PathEntry::read(const char* key, uint32_t& out, uint32_t most)
{
    if (!has(key)) {
        return;
    }
    const Json& value = value_.at(key);
    if (!value.is_unsigned() || value.unsigned_number() > most) {
        fail(fmt::format("{}.{} must be a whole number from 0 to {}", place_, key, most));
        return;
    }
    out = static_cast<uint32_t>(value.unsigned_number());
}

void PathEntry::read(const char* key, bool& out)
{
    if (has(key) && !value_.at(key).is_boolean()) {
        fail(fmt::format("{}.{} must be true or false", place_, key));
    } else if (has(key)) {
        out = value_.at(key).boolean();
    }
}

void PathEntry::fail(std::string problem)
{
    if (problem_.empty()) {
        problem_ = std::move(problem);
    }
}

} // namespace occlude::tools
