// What the checks of a configuration have in common: a fault is a text, none is "".
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>

#include "core/wire/phrase.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

inline Text positive(const Text& key, double value) {
  if (std::isfinite(value) && value > 0.0) return {};
  return phrase(key, ": expected a finite number above 0, got ", value);
}

inline Text not_negative(const Text& key, double value) {
  if (std::isfinite(value) && value >= 0.0) return {};
  return phrase(key, ": expected a finite number of at least 0, got ", value);
}

template <std::size_t N>
bool all_finite(const std::array<double, N>& numbers) {
  for (const double number : numbers)
    if (!std::isfinite(number)) return false;
  return true;
}

inline Text first_of(std::initializer_list<Text> faults) {
  for (const Text& fault : faults)
    if (!fault.empty()) return fault;
  return {};
}

inline Text check_range(const Text& key, double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper) && lower < upper) return {};
  return phrase(key, ": expected finite lower < upper, got ", lower, " and ", upper);
}

inline bool has_tool(const Limits& limits) {
  for (const PartLimits& part : limits.parts)
    if (part.tool != no_link) return true;
  return false;
}

/// Two entries of a list with the same name, "" if there are none.
template <class List>
Text check_names(const List& list, std::string_view key) {
  for (std::size_t i = 1; i < list.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (list[i].name == list[k].name) return phrase(key, ": ", list[i].name, " is there twice");
  return {};
}

/// validate_modes.cpp: the limits of every mode the part declares.
Text check_modes(const Limits& limits, const PartLimits& part);

/// validate_tree.cpp: the robot's links are one tree of measured joints.
Text check_tree(const Limits& limits);

/// validate_collision.cpp: capsules on links there are, and pairs of two that can come nearer.
Text check_collision(const Limits& limits);

/// validate_surroundings.cpp: where tools and links may be, and where the base may be.
Text check_workspace(const Limits& limits);
Text check_base(const Limits& limits);

}  // namespace fairlead
