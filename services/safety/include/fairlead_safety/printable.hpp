// Text from outside that cannot end a line, move a cursor or turn around what is read.
#pragma once

#include <string_view>

namespace fairlead {

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
    if (escaped == 0 && is_control(text, i)) escaped = byte < 0x80 ? 1 : byte < 0xE0 ? 2 : 3;
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
