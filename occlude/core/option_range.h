// The range of a numeric option. visit_options() declares it together with the option
// (option_text.h).
#pragma once

#include <limits>
#include <type_traits>

namespace occlude {

template <class T>
concept OptionNumber = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// The values that a numeric option may have, both ends included. The default: any finite number
/// from 0 on.
template <OptionNumber T>
struct OptionRange {
    T least = 0;
    T most = std::numeric_limits<T>::max();

    /// False for NaN.
    constexpr bool contains(T value) const { return value >= least && value <= most; }
    /// The nearest value of the range; `least` for NaN.
    constexpr T clamp(T value) const
    {
        return contains(value) ? value : value > most ? most : least;
    }
};

namespace detail {

struct OptionClamp {
    template <class T>
    requires(!OptionNumber<T>) constexpr void operator()(const char*, T&, const char*) const {}
    template <OptionNumber T>
    constexpr void operator()(const char*, T& value, OptionRange<std::type_identity_t<T>> range,
                              const char*) const
    {
        value = range.clamp(value);
    }
};

} // namespace detail

/// A copy of `options` with every number moved into its range, because options that are set in code
/// are not checked elsewhere.
template <class Options>
Options clamped(Options options)
{
    visit_options(options, detail::OptionClamp{});
    return options;
}

} // namespace occlude
