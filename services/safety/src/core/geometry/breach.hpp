// When a row is at fault for a limit that geometry measures, and when it only finds one broken.
#pragma once

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

}  // namespace fairlead
