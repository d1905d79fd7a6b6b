// A limit swept from both sides, and the numbers that are no numbers.
#pragma once

#include <cmath>
#include <limits>

namespace fairlead::test {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinite = std::numeric_limits<double>::infinity();

inline double just_above(double limit) { return std::nextafter(limit, infinite); }
inline double just_below(double limit) { return std::nextafter(limit, -infinite); }

}  // namespace fairlead::test
