// G011: what may be commanded while a joint is measured outside its bounds.
#pragma once

#include "row_view.hpp"

namespace fairlead {

/// Whether a measurement lies outside its bounds by more than their tolerance.
bool is_outside(const Bounds& bounds, double measured);

/// How far `position` lies outside the bounds, signed by the side; 0 inside.
double excess(const Bounds& bounds, double position);

/// A joint of the part is outside and this row cannot be seen to bring it back.
/// Targets and velocities of the joint itself are judged by their mode instead.
Evidence check_outside(const RowView& view);

}  // namespace fairlead
