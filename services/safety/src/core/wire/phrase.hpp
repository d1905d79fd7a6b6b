// Sentences for people, put together in place: no allocation, no locale.
#pragma once

#include <charconv>
#include <concepts>
#include <string_view>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

/// An id as it is printed everywhere: 16 hexadecimal digits.
struct Hex {
  std::uint64_t id;
};

inline void say(Text& text, std::string_view part) { text.append(part); }

template <std::size_t N>
void say(Text& text, const FixedText<N>& part) {
  text.append(part.view());
}

template <class Number>
  requires std::integral<Number> || std::floating_point<Number>
void say(Text& text, Number number) {
  if (number != number)  // GCOVR_EXCL_BR_LINE: of two ways to differ nan takes one
    return say(text, std::string_view("nan"));  // its sign means nothing
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(std::string_view(digits.data(), static_cast<std::size_t>(end.ptr - digits.data())));
}

/// A number for people, told beside another one: six digits, or all where these are the same.
struct Beside {
  double value;
  double other;
};

inline std::string_view six_digits(std::array<char, 32>& digits, double value) {
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::general, 6);
  return {digits.data(), static_cast<std::size_t>(end.ptr - digits.data())};
}

inline void say(Text& text, Beside number) {
  std::array<char, 32> one{};
  std::array<char, 32> two{};
  const std::string_view digits = six_digits(one, number.value);
  const bool alike = digits == six_digits(two, number.other) && number.value != number.other;
  if (alike || number.value != number.value) return say(text, number.value);  // nan is nan
  say(text, digits);
}

inline void say(Text& text, Hex hex) {
  for (int shift = 60; shift >= 0; shift -= 4)
    text.append(std::string_view("0123456789abcdef")
                    .substr((hex.id >> static_cast<unsigned>(shift)) & 0xFU, 1));
}

/// phrase("part ", name, " is held by ", holder)
template <class... Parts>
Text phrase(const Parts&... parts) {
  Text text;
  (say(text, parts), ...);
  return text;
}

}  // namespace fairlead
