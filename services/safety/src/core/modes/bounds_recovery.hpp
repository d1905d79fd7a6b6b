// G011: what may be commanded while a joint is measured outside its bounds.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/modes/row_view.hpp"

namespace fairlead {

/// How far `position` lies outside the bounds, signed by the side; 0 inside.
inline double excess(const Bounds& bounds, double position) {
  return std::max(0.0, position - bounds.upper) - std::max(0.0, bounds.lower - position);
}

/// Whether a measurement lies outside its bounds by more than their tolerance.
inline bool is_outside(const Bounds& bounds, double measured) {
  return !(std::abs(excess(bounds, measured)) <= bounds.tolerance);
}

/// A measured joint for which no row is refused: a passive one, which nothing moves, or a
/// gripper's, whose targets all lead back. `bounds` is null for any other joint.
struct UnmovedJoint {
  std::string_view kind;
  Name name;
  const Bounds* bounds = nullptr;
};
UnmovedJoint unmoved_joint(const Limits& limits, std::size_t measured);

/// A joint of the part is outside and this row cannot be seen to bring it back.
/// Targets and velocities of the joint itself are judged by their mode instead.
Evidence check_outside(const RowView& view);

}  // namespace fairlead
