// When a row is at fault for a limit that geometry measures, and when it only finds one broken; and
// the smaller and the larger of two numbers where one may be none.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fairlead {

// What two computations of the same distance may differ by [m, or of a singular value].
inline constexpr double unchanged = 1e-6;

/// What a row that finds a limit broken may do: not act, leave it better, or leave it as it is too.
enum class Excuse : std::uint8_t { none, better, as_it_is };

/// A margin is what is left to a limit, negative beyond it. Where it was negative before the row
/// already, the row may leave it as `excuse` says. `margin_before()` is asked beyond it only.
template <class Before>
bool is_breach(double margin, const Before& margin_before, Excuse excuse = Excuse::as_it_is) {
  if (margin >= 0.0) return false;
  if (excuse == Excuse::none) return true;
  const double before = margin_before();
  const double least = excuse == Excuse::better ? before + unchanged : before - unchanged;
  return !(before < 0.0 && margin >= least);
}

/// std::min and std::max drop a second argument that is no number, and keep a first.
inline double smaller(double a, double b) { return std::isnan(a) ? a : std::min(b, a); }
inline double larger(double a, double b) { return std::isnan(a) ? a : std::max(b, a); }

}  // namespace fairlead
