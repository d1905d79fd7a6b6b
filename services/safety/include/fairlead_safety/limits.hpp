// The compiled gate file as plain data. One struct per JSON object, one field per key.
//
// Every limit starts as NaN and every comparison is written so that NaN fails it: a limit
// that was never set refuses everything, it never allows everything.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/geometry_limits.hpp"
#include "fairlead_safety/modes.hpp"

namespace fairlead {

inline constexpr std::size_t max_parts = 8;
inline constexpr std::size_t max_rows = 64;
inline constexpr std::size_t max_claims = 8;
inline constexpr std::size_t max_frames = 4;  // frames a cartesian mode accepts
inline constexpr std::size_t max_stops = 16;  // stops held at once
inline constexpr std::size_t max_frame_bytes = 65536;

enum class JointKind : std::uint8_t { revolute, prismatic, continuous };

/// Position bounds of a measured joint [rad or m]; tolerance: how far a measurement may lie
/// outside.
struct Bounds {
  double lower = unset;
  double upper = unset;
  double tolerance = unset;
};

/// One measured joint. SI units.
struct MeasuredLimits {
  Name name;
  Bounds bounds;              // unused where a commanded joint is not bounded
  double jump_limit = unset;  // largest change of the measured position in one tick
  double standstill_velocity = unset;
  Text source;
};

/// One that nothing commands.
using PassiveLimits = MeasuredLimits;

/// One commanded joint, in wire order.
struct JointLimits : MeasuredLimits {
  std::size_t part = max_parts;  // index into Limits::parts
  JointKind kind = JointKind::revolute;
  bool bounded = true;            // false only where the file declares `zones` instead of `bounds`
  double velocity_limit = unset;  // unset for a gripper's: nothing commands how fast
  double acceleration_limit = unset;  // likewise
  double effort_limit = unset;
  double contact_limit = unset;  // G042: largest measured effort [N m or N]
  double encoder_step = unset;   // G041: a smaller change of the measured position is none
  // G041: what may be commanded since the last measured change, over any number of ticks, without
  // anything having to move [rad or m].
  double dead_band = unset;
  // G024, G031, G032, G034: for so long it goes on at its speed when a motion that was commanded as
  // a speed or a share of one ends [s]: a servo lags, and makes up for that.
  double stop_lag = unset;
};

/// Which share of the motion that a row asks for happens within its tick: the tracking model.
struct Gain {
  double lower = unset;
  double upper = unset;
};

/// joint_position, dex_hand_joint [rad or m], joint_velocity [rad/s or m/s].
struct JointModeLimits {
  bool supported = false;
  // By index of the robot's commanded joint (not of the part's): the file lists them in part order.
  std::array<double, max_joints> step_limit = [] {
    std::array<double, max_joints> none{};
    none.fill(unset);
    return none;
  }();
  double claimed_limit = unset;  // joint_velocity: a claim's own, for all joints
  Gain gain;                     // joint_velocity
  // G040, by index of the robot's commanded joint: how far the measured position (or velocity, in
  // joint_velocity) may be from the rows that acted.
  std::array<double, max_joints> tracking = [] {
    std::array<double, max_joints> none{};
    none.fill(unset);
    return none;
  }();
  Text source;
};

/// cartesian_delta [m, rad], cartesian_twist and body_twist [m/s, rad/s]. Limits are norms, not
/// per axis.
struct CartesianLimits {
  bool supported = false;
  FixedVec<Name, max_frames> frames;
  double linear_limit = unset;
  double angular_limit = unset;
  double linear_step_limit = unset;
  double angular_step_limit = unset;
  std::array<bool, 6> free_axes{};  // body_twist: axes the base can move along; else all true
  Gain gain;
  double linear_tracking = unset;  // G040: beyond what the gain allows [m or m/s]
  double angular_tracking = unset;
  Text source;
};

/// cartesian_pose: a box for the tool frame's origin, along the axes of the frame that the pose is
/// given in [m], and the largest step from row to row [m, rad].
struct PoseLimits {
  bool supported = false;
  FixedVec<Name, max_frames> frames;
  std::array<double, 3> lower{unset, unset, unset};
  std::array<double, 3> upper{unset, unset, unset};
  double linear_step_limit = unset;
  double angular_step_limit = unset;
  double linear_tracking = unset;  // G040: distance of the measured tool from the pose [m]
  double angular_tracking = unset;
  Text source;
};

/// gripper_binary: 0 or 1, and every switch is legal.
struct BinaryLimits {
  bool supported = false;
  Text source;
};

/// gripper_position [m], composite_mode (whose lower and upper are always -1 and 1).
struct ScalarLimits {
  bool supported = false;
  double lower = unset;
  double upper = unset;
  double step_limit = unset;
  // gripper_position, G042: opening that a gripper may lose on what it holds; infinite where the
  // file declares that losing an object is no stop.
  double slip_limit = unset;
  // composite_mode, G025: the sign may change at standstill only, unless declared otherwise.
  bool switches_anywhere = false;
  Text source;
};

/// Everything one part may be commanded. A claim has its own copy, which it can only tighten.
struct ModeLimits {
  JointModeLimits joint_position;
  JointModeLimits joint_velocity;
  PoseLimits cartesian_pose;
  CartesianLimits cartesian_delta;
  CartesianLimits cartesian_twist;
  CartesianLimits body_twist;
  BinaryLimits gripper_binary;
  ScalarLimits gripper_position;
  JointModeLimits dex_hand_joint;
  ScalarLimits composite_mode;

  [[nodiscard]] bool supports(std::uint8_t mode) const;
};

// Which block belongs to which mode: modes of one family share their blocks' type and rules.

/// `Block*`, to const where `Modes` is.
template <class Modes, class Block>
using BlockPointer = std::conditional_t<std::is_const_v<Modes>, const Block*, Block*>;

/// Whether a mode commands joints to positions.
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

/// A gripper is commanded to openings and by nothing else: not how fast.
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

struct PartLimits {
  Name name;
  FixedVec<std::size_t, max_joints> joints;  // indices into Limits::joints
  std::size_t tool = no_link;                // link that cartesian modes move, none without a tool
  ModeLimits modes;
  // G033, for modes that move the tool: smallest singular value of its Jacobian.
  double singularity_limit = unset;
  // G025, by number of the mode that acted last: bit m is set if mode m may follow.
  std::array<std::uint16_t, mode_count> followers{};
  Text source;
};

/// Limits of the protocol itself, the same for every part.
struct ProtocolLimits {
  std::uint32_t horizon_max = 0;
  std::uint32_t age_max_ticks = 0;
  double chunk_rate_max_hz = unset;
  std::uint64_t seq_jump_max = 0;
  std::uint32_t state_timeout_ms = 0;
  std::uint32_t heartbeat_timeout_realtime_ms = 0;
  std::uint32_t heartbeat_timeout_lockstep_ms = 0;
  std::uint32_t lease_interval_ms = 0;
  std::uint32_t idle_disarm_s = 0;
  std::uint32_t stops_to_latch = 0;
  std::uint32_t stop_window_s = 0;
  std::uint32_t bad_frames_limit = 0;
  std::uint32_t bad_frames_window_ticks = 0;
  std::uint32_t stuck_ticks = 0;       // G041: ticks of commanded motion without a change
  std::uint32_t stop_ramp_ms = 0;      // G043: at standstill within it
  std::uint32_t step_deadline_us = 0;  // G050: a step of the gate itself, in realtime
  std::uint32_t second_person_s = 0;   // a latch is reset by two persons within it; 0: by one
};

/// The whole file. The loader fills it; `check_limits` must then find no fault.
struct Limits {
  Name robot;
  Name profile;
  Hash robot_hash{};
  Hash config_hash{};  // SHA-256 of the file's bytes
  std::uint64_t period_ns = 0;
  bool lockstep_allowed = false;
  FixedVec<JointLimits, max_joints> joints;
  FixedVec<PassiveLimits, max_passive> passive_joints;
  FixedVec<PartLimits, max_parts> parts;
  Kinematics kinematics;
  CollisionLimits collision;
  WorkspaceLimits workspace;
  BaseLimits base;
  ProtocolLimits protocol;

  [[nodiscard]] std::size_t measured_count() const { return joints.size() + passive_joints.size(); }
  /// Measured joint `i`: the commanded ones come first.
  [[nodiscard]] const MeasuredLimits& measured(std::size_t i) const {
    return i < joints.size() ? joints[i] : passive_joints[i - joints.size()];
  }
};

/// The first thing wrong with a configuration, "" if nothing is: the key, what was expected and
/// what was found. Covers missing (NaN), not finite, inverted and non-positive values, capacities,
/// joints or modes that contradict each other, and a tree that is none. Unknown keys are the
/// loader's to refuse.
Text check_limits(const Limits& limits);

}  // namespace fairlead
