// When a row is at fault for a limit that geometry measures, and when it only finds one broken.
#pragma once

namespace fairlead {

// What two computations of the same distance may differ by [m, or of a singular value].
inline constexpr double unchanged = 1e-6;

/// A margin is what is left to a limit, negative beyond it. Where it was negative before the row
/// already, the row may leave it as it is or better. `margin_before()` is asked beyond it only.
template <class Before>
bool is_breach(double margin, const Before& margin_before) {
  if (margin >= 0.0) return false;
  const double before = margin_before();
  return !(before < 0.0 && margin >= before - unchanged);
}

}  // namespace fairlead
