// Control modes: what the numbers of one action part mean. The numbers are on the wire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace fairlead {

enum class Mode : std::uint8_t {
  joint_position = 0,     // rad or m, as wide as the robot has commanded joints
  joint_velocity = 1,     // rad/s or m/s, likewise
  joint_torque = 2,       // N m or N, likewise; no checker: nothing bounds where it leads
  joint_trajectory = 3,   // no checker yet
  cartesian_pose = 4,     // xyz [m], quaternion xyzw, of the tool frame in frame_id
  cartesian_delta = 5,    // xyz [m], rotation vector [rad], along frame_id's axes
  cartesian_twist = 6,    // xyz [m/s], rotation vector [rad/s], along frame_id's axes
  body_twist = 7,         // xyz [m/s], xyz [rad/s], in the base frame
  foot_placement = 8,     // no checker yet
  gripper_binary = 9,     // 0 open, 1 closed
  gripper_position = 10,  // total opening [m]
  dex_hand_joint = 11,    // rad or m, as wide as the robot has commanded joints
  composite_mode = 12,    // [-1, 1], a simulator controller's own switch
};

inline constexpr std::uint8_t mode_count = 13;

/// The name used in configuration files, or "unknown".
std::string_view mode_name(std::uint8_t mode);

/// True for the modes this gate can judge; every other mode is refused by name.
bool mode_has_checker(std::uint8_t mode);

/// True where a row is as wide as the robot has commanded joints and `active` names some.
bool is_joint_mode(std::uint8_t mode);

/// Numbers per row, 0 where the mode has no defined width.
std::size_t mode_width(std::uint8_t mode, std::size_t joint_count);

}  // namespace fairlead
