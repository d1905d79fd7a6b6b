// G025: when a part may be told in another mode or frame, or a composite switch may turn.
#pragma once

#include "core/modes/row_view.hpp"

namespace fairlead {

/// The command of the same part in the row that acts before, nullptr if that row has none.
const ActionPart* command_before(const RowBefore& before, const ActionPart& action);

/// A part changes its mode as its transitions allow, and its mode or frame at standstill only.
/// `last`: its command in the row that acts before, nullptr if there is none.
Evidence check_change(const RowView& view, const RowBefore& before, const ActionPart* last);

/// Whether both are of the same mode and frame.
inline bool is_alike(const ActionPart& one, const ActionPart& other) {
  return one.mode == other.mode && one.frame_id == other.frame_id;
}

/// The first live row of a composite switch turns where every part of the claim stands still.
/// `acted`: the row of the same part and mode that acts before, of no action if there is none.
Evidence check_switch(const RowView& view, const ClaimLimits& claim, const RowBefore& before,
                      const Setpoint& acted);

/// A later row does not turn: nobody has measured yet that the robot stands still there.
Evidence check_later_switch(const RowView& view);

}  // namespace fairlead
