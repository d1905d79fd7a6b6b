// A row's numbers, as motions and poses too, and the base's measured motion in the same terms.
#pragma once

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/forward_kinematics.hpp"
#include "core/kinematics/robot_model.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// The numbers that command one part in one tick.
struct Setpoint {
  const ActionPart* action = nullptr;
  std::size_t offset = 0;  // of the row's first number

  double operator[](std::size_t i) const { return action->values[offset + i]; }
  /// Joint modes: whether the joint is commanded; its number is padding if not.
  [[nodiscard]] bool commands(std::size_t joint) const {
    return is_joint_mode(action->mode) &&  // GCOVR_EXCL_BR_LINE: edges of exceptions, both lines
           action->active.contains(        // GCOVR_EXCL_BR_LINE: nothing here throws
               static_cast<std::uint8_t>(joint));
  }
};

inline Setpoint row_of(const ActionPart& action, std::size_t row, const Limits& limits) {
  return {&action, row * mode_width(action.mode, limits.joints.size())};
}

/// What a row commands of one part; of no action if it leaves it out, or there is no row.
inline Setpoint command_of(std::size_t part, const RowBefore& row, const Limits& limits) {
  if (row.chunk == nullptr) return {};
  for (const ActionPart& action : row.chunk->parts)
    if (action.part == part) return row_of(action, row.row, limits);
  return {};
}

/// A delta or a twist: three linear and three angular numbers.
inline Twist halves(const Setpoint& row) {
  return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}

inline bool is_tool_motion(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::cartesian_delta) ||
         mode == static_cast<std::uint8_t>(Mode::cartesian_twist);
}

/// The link in whose frame a row has its numbers.
inline std::size_t link_of(const Limits& limits, const Setpoint& row) {
  return limits.kinematics.find(row.action->frame_id);
}

/// How far a row of a delta or a twist commands a tool in its tick.
inline Motion6 tick_motion(const RobotModel& model, const FramePoses& poses, const Setpoint& row) {
  const bool per_tick = row.action->mode == static_cast<std::uint8_t>(Mode::cartesian_delta);
  const double share = per_tick ? 1.0 : model.period_s;
  const Twist commanded = halves(row);
  const Eigen::Matrix3d axes = pose_at(model.places[link_of(model.limits, row)], poses).rotation;
  Motion6 motion;
  motion << axes * (share * commanded.linear), axes * (share * commanded.angular);
  return motion;
}

inline Pose pose_of(const Setpoint& row) {
  const Eigen::Quaterniond rotation(row[6], row[3], row[4], row[5]);
  return {rotation.normalized().toRotationMatrix(), {row[0], row[1], row[2]}};
}

/// What a row of joint_velocity makes of one joint [rad/s, m/s]. The two slides of a base whose
/// commands turn against its yaw get what is left of the row when that has been turned.
/// `positions`: where the joints are when the row begins.
inline double commanded_velocity(const Limits& limits, const Setpoint& row, std::size_t joint,
                                 const std::array<double, max_measured>& positions) {
  if (!limits.base.is_turned(joint)) return row[joint];
  const auto& [x, y, yaw] = limits.base.joints;
  const double cosine = std::cos(positions[yaw]), sine = std::sin(positions[yaw]);
  return joint == x ? cosine * row[x] + sine * row[y] : cosine * row[y] - sine * row[x];
}

/// How fast a joint can be commanded to go. A row of a base whose commands turn against its yaw is
/// limited before it is turned: one slide may get what was commanded of both.
inline double fastest_command(const Limits& limits, std::size_t joint) {
  if (!limits.base.is_turned(joint)) return limits.joints[joint].velocity_limit;
  const auto& [x, y, yaw] = limits.base.joints;
  return std::hypot(limits.joints[x].velocity_limit, limits.joints[y].velocity_limit);
}

/// The measured twist of base_link's origin along its axes: the base's joints are two slides along
/// odom's x and y and a yaw, about the axis that BaseLimits names (about the origin where it names
/// none). False if the part is built otherwise. (cartesian_modes.cpp)
bool measured_base_twist(const Limits& limits, const PartLimits& part, const MeasuredState& state,
                         Twist& twist);

inline constexpr auto velocity_mode = static_cast<std::uint8_t>(Mode::joint_velocity);

inline bool is_pose(const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::cartesian_pose);
}

inline bool moves_tool(const ActionPart& action) {
  return is_pose(action) || is_tool_motion(action.mode);
}

// The tracking model of a mode, nullptr where all of a row happens.
inline const Gain* gain_block(const ModeLimits& modes, std::uint8_t mode) {
  if (mode == velocity_mode) return &modes.joint_velocity.gain;
  const CartesianLimits* norms = norm_block(modes, mode);
  return norms == nullptr ? nullptr : &norms->gain;
}

inline bool is_gripper(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::gripper_binary) ||
         mode == static_cast<std::uint8_t>(Mode::gripper_position);
}

// Joints that a command moves, as far as it is predicted.
inline JointSet moved_by(const RobotModel& model, const ActionPart& action) {
  if (is_gripper(action.mode)) return 0;
  if (!is_joint_mode(action.mode)) return model.part_joints[action.part];
  JointSet joints = 0;
  const BaseLimits& base = model.limits.base;
  for (const std::uint8_t j : action.active) {
    joints |= only(j);
    if (action.mode == velocity_mode && base.is_turned(j))  // what turns moves both slides
      joints |= only(base.joints[0]) | only(base.joints[1]);
  }
  return joints;
}

}  // namespace fairlead
