// Which functions judge the rows of which mode.
//
//   absolute  G020: limits of a row by itself; and G011 for joints that the row moves
//   start     G021: the first live row against the measured state. `acted`: the row of the same
//             part, mode and frame that acts right before, nullptr if there is none
//   acting    what must hold on when a newer state is measured, nullptr if nothing does
//   step      G022, and G021 or G023 against `acted`: the change from one row to the next
#pragma once

#include "core/modes/row_view.hpp"

namespace fairlead {

/// G011 and G020 of one row.
Evidence check_absolute(const RowView& view);

/// G021, G023, G025: the chunk's first live row against what acts before it and what is measured.
Evidence check_start(const RowView& view, const ClaimLimits& claim, const RowBefore& before);

/// G022, G025: a row against `view.previous`.
Evidence check_step(const RowView& view);

/// What a released row has to keep to when a newer state has been measured: G011.
Evidence check_acting(const RowView& view);

// joint_modes.cpp: joint_position and dex_hand_joint (targets), joint_velocity
Evidence joint_target_absolute(const RowView& view);
Evidence joint_target_start(const RowView& view, const Setpoint* acted);
Evidence joint_target_acting(const RowView& view);
Evidence joint_velocity_absolute(const RowView& view);
Evidence joint_velocity_start(const RowView& view, const Setpoint* acted);
Evidence joint_velocity_acting(const RowView& view);
Evidence joint_velocity_step(std::uint32_t code, const RowView& view, const Setpoint& before);
Evidence joint_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// cartesian_modes.cpp: cartesian_delta, cartesian_twist, body_twist
Evidence norm_absolute(const RowView& view);
Evidence delta_start(const RowView& view, const Setpoint* acted);
Evidence tool_twist_start(const RowView& view, const Setpoint* acted);
Evidence body_twist_start(const RowView& view, const Setpoint* acted);
Evidence norm_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// pose_mode.cpp: cartesian_pose
Evidence pose_absolute(const RowView& view);
Evidence pose_start(const RowView& view, const Setpoint* acted);
Evidence pose_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// scalar_modes.cpp: gripper_position, gripper_binary, composite_mode
Evidence scalar_absolute(const RowView& view);
Evidence binary_absolute(const RowView& view);
Evidence gripper_start(const RowView& view, const Setpoint* acted);
Evidence scalar_step(std::uint32_t code, const RowView& view, const Setpoint& before);

}  // namespace fairlead
