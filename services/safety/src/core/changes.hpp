// G025: when a part may be told in another mode or frame, or a composite switch may turn.
#pragma once

#include "row_view.hpp"

namespace fairlead {

/// A part changes its mode as its transitions allow, and its mode or frame at standstill only.
/// `last`: its command in the row that acts before, nullptr if there is none.
Evidence check_change(const RowView& view, const RowBefore& before, const ActionPart* last);

/// The first live row of a composite switch turns where every part of the claim stands still.
/// `acted`: the row of the same part and mode that acts before, of no action if there is none.
Evidence check_switch(const RowView& view, const ClaimLimits& claim, const RowBefore& before,
                      const Setpoint& acted);

/// A later row does not turn: nobody has measured yet that the robot stands still there.
Evidence check_later_switch(const RowView& view);

}  // namespace fairlead
