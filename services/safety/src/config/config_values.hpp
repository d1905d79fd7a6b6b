// Values that several sections of a compiled gate file are made of.
#pragma once

#include <string>

#include "config/strict_json.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

inline Name name_in(Section& section, const char* key) {
  return Name(section.text(key, Name::capacity));
}

inline Text source_in(Section& section) { return Text(section.text("source", 4096)); }

/// Appends, refusing what exceeds the gate's fixed capacity.
template <class T, std::size_t N>
void append(FixedVec<T, N>& list, const T& item, const std::string& path) {
  if (!list.push_back(item)) throw ConfigRefused(path + ": more than " + std::to_string(N));
}

/// Exactly N numbers.
template <std::size_t N>
std::array<double, N> numbers_in(Section& section, const char* key) {
  const nlohmann::json& list = section.list(key);
  std::array<double, N> numbers{};
  if (list.size() != N) refuse(section.path_of(key), std::to_string(N) + " numbers", list);
  for (std::size_t i = 0; i < N; ++i) {
    if (!list[i].is_number()) refuse(section.path_of(key, i), "a number", list[i]);
    numbers[i] = list[i].get<double>();
  }
  return numbers;
}

}  // namespace fairlead
