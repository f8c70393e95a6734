// A JSON document as a value. Only json.cpp includes the parser and the printer, because their
// library costs each including file seconds of compile time.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace occlude::tools {

/// Arrays nested deeper than this are refused, because documents are walked by recursion.
constexpr int kDeepestJson = 256;

/// Thrown when a document is not what the reader expects; what() is a sentence.
class JsonError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// null, a boolean, a number, a text, an array or an object. Members of an object keep the order in
/// which they came; no two have the same name.
class Json {
public:
    using Array = std::vector<Json>;
    using Member = std::pair<std::string, Json>;
    using Object = std::vector<Member>;
    /// A whole number is an int64_t only if it is negative.
    using Value =
        std::variant<std::monostate, bool, uint64_t, int64_t, double, std::string, Array, Object>;

    Json() = default;
    Json(bool value)
        : value_(value)
    {
    }
    template <class T>
    requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) Json(T value)
    {
        if constexpr (std::is_floating_point_v<T>) {
            value_ = double{value};
        } else if constexpr (std::is_signed_v<T>) {
            value_ = value < 0 ? Value{int64_t{value}} : Value{static_cast<uint64_t>(value)};
        } else {
            value_ = uint64_t{value};
        }
    }
    Json(std::string value)
        : value_(std::move(value))
    {
    }
    Json(const char* value)
        : value_(std::string{value})
    {
    }
    explicit Json(Array elements)
        : value_(std::move(elements))
    {
    }
    /// Precondition: no two members have the same name.
    explicit Json(Object members)
        : value_(std::move(members))
    {
    }
    static Json array(std::initializer_list<Json> elements = {}) { return Json{Array{elements}}; }
    static Json object(std::initializer_list<Member> members = {}) { return Json{Object{members}}; }
    /// An array of the elements of any range, converted.
    template <class Range>
    static Json list(const Range& range)
    {
        Json result = array();
        for (const auto& element : range) {
            result.push_back(Json(element));
        }
        return result;
    }

    /// Throws JsonError for a text that is not JSON or nests deeper than kDeepestJson. A member
    /// that comes twice has its last value.
    static Json parse(std::string_view text);
    /// Printed with an indent per level, or on one line if `indent` is negative. Bytes that are not
    /// UTF-8 are replaced.
    std::string dump(int indent = -1) const;

    const Value& value() const { return value_; }
    bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
    bool is_boolean() const { return std::holds_alternative<bool>(value_); }
    bool is_string() const { return std::holds_alternative<std::string>(value_); }
    bool is_array() const { return std::holds_alternative<Array>(value_); }
    bool is_object() const { return std::holds_alternative<Object>(value_); }
    bool is_number() const;
    /// A whole number that is not negative, written without a fraction.
    bool is_unsigned() const { return std::holds_alternative<uint64_t>(value_); }

    /// Each throws JsonError if the value is of another kind.
    bool boolean() const;
    double number() const;
    uint64_t unsigned_number() const;
    const std::string& text() const;
    const Array& elements() const;
    const Object& members() const;

    /// The member of that name, or null; also null for a value that is not an object.
    const Json* find(std::string_view name) const;
    bool contains(std::string_view name) const { return find(name) != nullptr; }
    /// Throws JsonError if there is no such member, or no such element.
    const Json& at(std::string_view name) const;
    const Json& at(size_t index) const;
    /// The number of elements or members; 0 for other values.
    size_t size() const;
    bool empty() const { return size() == 0; }

    /// Of an array.
    void push_back(Json element);
    /// Of an object: replaces the member of that name, or adds it at the end.
    void set(std::string_view name, Json value);
    /// set() for all members of `other`.
    void update(const Json& other);

    bool operator==(const Json&) const = default;

private:
    Value value_;
};

/// A number that fits, without a fraction. Throws JsonError for anything else; the sentence quotes
/// it and names it `what`.
uint32_t whole_number(const Json& value, std::string_view what);

} // namespace occlude::tools
