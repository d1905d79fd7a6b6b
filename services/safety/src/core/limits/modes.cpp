#include "fairlead_safety/modes.hpp"

#include <array>

namespace fairlead {
namespace {

enum class Width : std::uint8_t { none, robot, one, six, seven };

struct ModeRow {
  std::string_view name;
  Width width;
  bool has_checker;
};

constexpr std::array<ModeRow, mode_count> table{{
    {"joint_position", Width::robot, true},
    {"joint_velocity", Width::robot, true},
    {"joint_torque", Width::none, false},
    {"joint_trajectory", Width::none, false},
    {"cartesian_pose", Width::seven, true},
    {"cartesian_delta", Width::six, true},
    {"cartesian_twist", Width::six, true},
    {"body_twist", Width::six, true},
    {"foot_placement", Width::none, false},
    {"gripper_binary", Width::one, true},
    {"gripper_position", Width::one, true},
    {"dex_hand_joint", Width::robot, true},
    {"composite_mode", Width::one, true},
}};

}  // namespace

std::string_view mode_name(std::uint8_t mode) {
  return mode < mode_count ? table[mode].name : "unknown";
}

bool mode_has_checker(std::uint8_t mode) { return mode < mode_count && table[mode].has_checker; }

bool is_joint_mode(std::uint8_t mode) {
  return mode < mode_count && table[mode].width == Width::robot;
}

std::size_t mode_width(std::uint8_t mode, std::size_t joint_count) {
  if (mode >= mode_count) return 0;
  switch (table[mode].width) {  // GCOVR_EXCL_BR_LINE: the enum has no further value
    case Width::none:
      break;
    case Width::robot:
      return joint_count;
    case Width::one:
      return 1;
    case Width::six:
      return 6;
    case Width::seven:
      return 7;
  }
  return 0;
}

}  // namespace fairlead
