// The smaller and the larger of two numbers where one may be none: then that is the answer.
#pragma once

#include <algorithm>
#include <cmath>

namespace fairlead {

/// std::min and std::max drop a second argument that is no number, and keep a first.
inline double smaller(double a, double b) { return std::isnan(a) ? a : std::min(b, a); }
inline double larger(double a, double b) { return std::isnan(a) ? a : std::max(b, a); }

}  // namespace fairlead
