// G040: did the part move as the rows that acted told it to?
#pragma once

#include "core/monitor/motion_view.hpp"

namespace fairlead {

/// Targets against where the robot is; velocities, deltas and twists against the share of them that
/// the tracking model says happens, where the two states are consecutive. A gripper's opening and
/// a composite switch are not judged.
Evidence check_tracking(const MotionView& view);

}  // namespace fairlead
