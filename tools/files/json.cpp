#include "files/json.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace occlude::tools {

namespace {

// Keeps each name once, with its last value, at its first place. O(n log n), because files may hold
// anything.
void drop_repeated_names(Json::Object& members)
{
    std::vector<size_t> order(members.size());
    for (size_t i = 0; i < order.size(); ++i) {
        order[i] = i;
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return members[a].first < members[b].first; });
    std::vector<bool> repeated(members.size(), false);
    size_t first = 0;
    for (size_t i = 1; i < order.size(); ++i) {
        if (members[order[i]].first == members[order[first]].first) {
            members[order[first]].second = std::move(members[order[i]].second);
            repeated[order[i]] = true;
        } else {
            first = i;
        }
    }
    size_t next = 0;
    std::erase_if(members, [&](const Json::Member&) { return repeated[next++]; });
}

// Builds a document directly from the parser's events, without a second document in between.
class Builder final : public nlohmann::json_sax<nlohmann::json> {
public:
    Json root;

    bool null() override { return add({}); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(number_integer_t value) override { return add(value); }
    bool number_unsigned(number_unsigned_t value) override { return add(value); }
    bool number_float(number_float_t value, const string_t&) override { return add(value); }
    bool string(string_t& value) override { return add(std::move(value)); }
    bool binary(binary_t&) override { return false; }
    bool start_object(size_t) override { return open(); }
    bool start_array(size_t) override { return open(); }
    bool key(string_t& name) override
    {
        open_.back().members.emplace_back(std::move(name), Json{});
        return true;
    }
    bool end_object() override
    {
        Json::Object members = std::move(open_.back().members);
        open_.pop_back();
        drop_repeated_names(members);
        return add(Json{std::move(members)});
    }
    bool end_array() override
    {
        Json::Array elements = std::move(open_.back().elements);
        open_.pop_back();
        return add(Json{std::move(elements)});
    }
    bool parse_error(size_t, const std::string&, const nlohmann::json::exception& error) override
    {
        throw JsonError{error.what()};
    }

private:
    // An array or an object that has not ended.
    struct Open {
        Json::Array elements;
        Json::Object members; ///< the last one waits for its value
    };

    bool open()
    {
        if (open_.size() == kDeepestJson) {
            throw JsonError{fmt::format("nested more than {} deep", kDeepestJson)};
        }
        open_.emplace_back();
        return true;
    }
    bool add(Json value)
    {
        if (open_.empty()) {
            root = std::move(value);
        } else if (!open_.back().members.empty()) {
            open_.back().members.back().second = std::move(value);
        } else {
            open_.back().elements.push_back(std::move(value));
        }
        return true;
    }

    std::vector<Open> open_;
};

nlohmann::ordered_json printable(const Json& json);

struct Printable {
    nlohmann::ordered_json operator()(std::monostate) const { return nullptr; }
    nlohmann::ordered_json operator()(const Json::Array& elements) const
    {
        auto list = nlohmann::ordered_json::array();
        for (const Json& element : elements) {
            list.push_back(printable(element));
        }
        return list;
    }
    nlohmann::ordered_json operator()(const Json::Object& members) const
    {
        auto object = nlohmann::ordered_json::object();
        for (const auto& [name, value] : members) {
            object[name] = printable(value);
        }
        return object;
    }
    template <class T>
    nlohmann::ordered_json operator()(const T& value) const
    {
        return value;
    }
};

nlohmann::ordered_json printable(const Json& json)
{
    return std::visit(Printable{}, json.value());
}

template <class T>
const T& as(const Json::Value& value, const char* kind)
{
    const T* const held = std::get_if<T>(&value);
    if (held == nullptr) {
        throw JsonError{fmt::format("{} is expected", kind)};
    }
    return *held;
}

} // namespace

Json Json::parse(std::string_view text)
{
    Builder builder;
    nlohmann::json::sax_parse(text, &builder);
    return std::move(builder.root);
}

std::string Json::dump(int indent) const
{
    using Print = nlohmann::ordered_json;
    return printable(*this).dump(indent, ' ', false, Print::error_handler_t::replace);
}

bool Json::is_number() const
{
    return is_unsigned() || std::holds_alternative<int64_t>(value_) ||
           std::holds_alternative<double>(value_);
}

bool Json::boolean() const
{
    return as<bool>(value_, "true or false");
}

double Json::number() const
{
    if (is_unsigned()) {
        return static_cast<double>(std::get<uint64_t>(value_));
    }
    const int64_t* const negative = std::get_if<int64_t>(&value_);
    return negative != nullptr ? static_cast<double>(*negative) : as<double>(value_, "a number");
}

uint64_t Json::unsigned_number() const
{
    return as<uint64_t>(value_, "a whole number from 0 on");
}

const std::string& Json::text() const
{
    return as<std::string>(value_, "a text");
}

const Json::Array& Json::elements() const
{
    return as<Array>(value_, "a list");
}

const Json::Object& Json::members() const
{
    return as<Object>(value_, "an object");
}

const Json* Json::find(std::string_view name) const
{
    if (const Object* const members = std::get_if<Object>(&value_)) {
        for (const Member& member : *members) {
            if (member.first == name) {
                return &member.second;
            }
        }
    }
    return nullptr;
}

const Json& Json::at(std::string_view name) const
{
    const Json* const found = find(name);
    if (found == nullptr) {
        throw JsonError{fmt::format("there is no \"{}\"", name)};
    }
    return *found;
}

const Json& Json::at(size_t index) const
{
    const Array& list = elements();
    if (index >= list.size()) {
        throw JsonError{fmt::format("a list has {} elements; it needs {}", list.size(), index + 1)};
    }
    return list[index];
}

size_t Json::size() const
{
    if (const Array* const list = std::get_if<Array>(&value_)) {
        return list->size();
    }
    const Object* const members = std::get_if<Object>(&value_);
    return members != nullptr ? members->size() : 0;
}

void Json::push_back(Json element)
{
    static_cast<void>(elements()); // throws if it is none
    std::get<Array>(value_).push_back(std::move(element));
}

void Json::set(std::string_view name, Json value)
{
    static_cast<void>(members());
    Object& all = std::get<Object>(value_);
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Member& m) { return m.first == name; });
    if (found != all.end()) {
        found->second = std::move(value);
    } else {
        all.emplace_back(std::string{name}, std::move(value));
    }
}

void Json::update(const Json& other)
{
    for (const auto& [name, value] : other.members()) {
        set(name, value);
    }
}

uint32_t whole_number(const Json& value, std::string_view what)
{
    if (!value.is_unsigned() || value.unsigned_number() > UINT32_MAX) {
        throw JsonError{fmt::format("{} must be a whole number from 0 to {}, not {}", what,
                                    UINT32_MAX, value.dump())};
    }
    return static_cast<uint32_t>(value.unsigned_number());
}

} // namespace occlude::tools
