#include "walk/path_json.h"

#include <fmt/core.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace occlude::tools {

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

void PathEntry::read(const char* key, glm::vec3& out)
{
    if (!has(key)) {
        return;
    }
    const Json& list = value_.at(key);
    for (size_t i = 0; i < 3; ++i) {
        const bool is_number = list.is_array() && list.size() == 3 && list.at(i).is_number();
        const float number = is_number ? static_cast<float>(list.at(i).number()) : 0.0f;
        if (!is_number || !std::isfinite(number)) {
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
