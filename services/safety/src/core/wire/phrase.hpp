// Sentences for people, put together in place: no allocation, no locale. And text from outside, so
// that it cannot end a line, move a cursor or turn around what is read.
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
  if (alike || number.value != number.value)  // GCOVR_EXCL_BR_LINE: as above, of nan
    return say(text, number.value);
  say(text, digits);
}

inline void say(Text& text, Hex hex) {
  for (int shift = 60; shift >= 0; shift -= 4)
    text.append(std::string_view("0123456789abcdef")
                    .substr((hex.id >> static_cast<unsigned>(shift)) & 0xFU, 1));
}

/// phrase("part ", name, " is held by ", holder)
template <class... Parts>
Text phrase(const Parts&... parts) noexcept {
  Text text;
  (say(text, parts), ...);
  return text;
}

/// Whether the UTF-8 character that begins at `text[i]` is a control character: C0, DEL, C1, line
/// and paragraph separators, and those that turn the direction of writing.
inline bool is_control(std::string_view text, std::size_t i) {
  const auto at = [&](std::size_t k) {
    return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0U;
  };
  if (at(0) < 0x20 || at(0) == 0x7F) return true;
  if (at(0) == 0xC2) return at(1) < 0xA0;
  if (at(0) != 0xE2) return false;
  if (at(1) == 0x80) return at(2) == 0x8E || at(2) == 0x8F || (at(2) >= 0xA8 && at(2) <= 0xAE);
  return at(1) == 0x81 && at(2) >= 0xA6 && at(2) <= 0xA9;
}

inline bool has_control(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if (is_control(text, i)) return true;
  return false;
}

/// Appends valid UTF-8 to a text, of a control character each byte as \xNN.
template <class Target>
void append_printable(Target& target, std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::size_t escaped = 0;  // bytes of a control character still to come
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t bytes = byte < 0x80 ? 1 : byte < 0xE0 ? 2 : 3;
    if (escaped == 0 && is_control(text, i)) escaped = bytes;
    if (escaped == 0) {
      std::size_t end = i + 1;
      while (end < text.size() && !is_control(text, end)) ++end;
      target.append(text.substr(i, end - i));
      i = end - 1;
      continue;
    }
    --escaped;
    target.append("\\x");
    target.append(digits.substr(byte >> 4U, 1));
    target.append(digits.substr(byte & 0xFU, 1));
  }
}

}  // namespace fairlead
