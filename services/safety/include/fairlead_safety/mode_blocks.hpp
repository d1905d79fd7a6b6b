// Which block of limits belongs to which mode. The modes of one family share their blocks' type
// and their rules.
#pragma once

#include <type_traits>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// `Block*`, to const where `Modes` is.
template <class Modes, class Block>
using BlockPointer = std::conditional_t<std::is_const_v<Modes>, const Block*, Block*>;

/// Whether a mode tells joints where to be.
inline bool is_target(Mode mode) {
  return mode == Mode::joint_position || mode == Mode::dex_hand_joint;
}

/// Block of a mode that commands joints one by one; nullptr for any other mode.
template <class Modes>
BlockPointer<Modes, JointModeLimits> joint_block(Modes& modes, std::uint8_t mode) {
  switch (static_cast<Mode>(mode)) {
    case Mode::joint_position:
      return &modes.joint_position;
    case Mode::joint_velocity:
      return &modes.joint_velocity;
    case Mode::dex_hand_joint:
      return &modes.dex_hand_joint;
    default:
      return nullptr;
  }
}

/// Block of a mode judged by two norms; nullptr for any other mode.
template <class Modes>
BlockPointer<Modes, CartesianLimits> norm_block(Modes& modes, std::uint8_t mode) {
  switch (static_cast<Mode>(mode)) {
    case Mode::cartesian_delta:
      return &modes.cartesian_delta;
    case Mode::cartesian_twist:
      return &modes.cartesian_twist;
    case Mode::body_twist:
      return &modes.body_twist;
    default:
      return nullptr;
  }
}

/// Block of a mode that is one number in a range; nullptr for any other mode.
template <class Modes>
BlockPointer<Modes, ScalarLimits> scalar_block(Modes& modes, std::uint8_t mode) {
  switch (static_cast<Mode>(mode)) {
    case Mode::gripper_position:
      return &modes.gripper_position;
    case Mode::composite_mode:
      return &modes.composite_mode;
    default:
      return nullptr;
  }
}

/// The frames a mode may be given in; nullptr for a mode that has none.
inline const FixedVec<Name, max_frames>* frames_of(const ModeLimits& modes, std::uint8_t mode) {
  if (mode == static_cast<std::uint8_t>(Mode::cartesian_pose)) return &modes.cartesian_pose.frames;
  const CartesianLimits* norms = norm_block(modes, mode);
  return norms == nullptr ? nullptr : &norms->frames;
}

/// A gripper is told openings and nothing else: not how fast.
inline bool only_grips(const ModeLimits& modes) {
  for (std::uint8_t mode = 0; mode < mode_count; ++mode) {
    const bool opening = static_cast<Mode>(mode) == Mode::gripper_position ||
                         static_cast<Mode>(mode) == Mode::gripper_binary;
    if (modes.supports(mode) && !opening) return false;
  }
  return modes.gripper_position.supported || modes.gripper_binary.supported;
}

/// Whether a mode moves the part's tool frame as a whole, and not its joints one by one.
inline bool moves_tool(const ModeLimits& modes) {
  return modes.cartesian_pose.supported || modes.cartesian_delta.supported ||
         modes.cartesian_twist.supported;
}

}  // namespace fairlead
