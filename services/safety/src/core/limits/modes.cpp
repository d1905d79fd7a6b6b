#include "fairlead_safety/modes.hpp"

#include <array>
#include <cstdint>

#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

struct ModeRow {
  std::string_view name;
  std::size_t width;  // numbers of a row; 0: it has no checker
};

constexpr std::size_t of_robot = SIZE_MAX;  // as many as the robot has commanded joints

constexpr std::array<ModeRow, mode_count> table{{
    {"joint_position", of_robot},
    {"joint_velocity", of_robot},
    {"joint_torque", 0},
    {"joint_trajectory", 0},
    {"cartesian_pose", 7},
    {"cartesian_delta", 6},
    {"cartesian_twist", 6},
    {"body_twist", 6},
    {"foot_placement", 0},
    {"gripper_binary", 1},
    {"gripper_position", 1},
    {"dex_hand_joint", of_robot},
    {"composite_mode", 1},
}};

}  // namespace

std::string_view mode_name(std::uint8_t mode) {
  return mode < mode_count ? table[mode].name : "unknown";
}

bool mode_has_checker(std::uint8_t mode) { return mode < mode_count && table[mode].width != 0; }

bool is_joint_mode(std::uint8_t mode) { return mode < mode_count && table[mode].width == of_robot; }

std::size_t mode_width(std::uint8_t mode, std::size_t joint_count) {
  if (is_joint_mode(mode)) return joint_count;
  return mode < mode_count ? table[mode].width : 0;
}

bool ModeLimits::supports(std::uint8_t mode) const {
  if (const JointModeLimits* joints = joint_block(*this, mode)) return joints->supported;
  if (const CartesianLimits* norms = norm_block(*this, mode)) return norms->supported;
  if (const ScalarLimits* scalar = scalar_block(*this, mode)) return scalar->supported;
  if (mode == static_cast<std::uint8_t>(Mode::cartesian_pose)) return cartesian_pose.supported;
  if (mode == static_cast<std::uint8_t>(Mode::gripper_binary)) return gripper_binary.supported;
  return false;
}

}  // namespace fairlead
