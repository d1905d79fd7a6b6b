// Are the limits of a part's modes there, and do they fit its joints and the robot's tree?

#include <algorithm>

#include "core/limits/validation_text.hpp"
#include "core/modes/commanded_motion.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

// A lower end below 0 would say that the robot moves against its command.
Text check_gain(const Text& key, const Gain& gain) {
  constexpr double most = 1.5;
  if (gain.lower >= 0.0 && gain.lower <= gain.upper && gain.upper > 0.0 && gain.upper <= most)
    return {};
  return phrase(key, ".gain: expected 0 <= lower <= upper <= ", most, " and upper above 0, got ",
                gain.lower, " and ", gain.upper);
}

Text check_joint_numbers(const JointModeLimits& block, std::size_t joint, const Text& key,
                         const Name& name) {
  const Text fault = positive(phrase(key, ".step_limit of ", name), block.step_limit[joint]);
  if (!fault.empty()) return fault;
  return positive(phrase(key, ".tracking of ", name), block.tracking[joint]);
}

Text check_joint_mode(const Limits& limits, const PartLimits& part, const JointModeLimits& block,
                      Mode mode, const Text& key) {
  if (part.joints.empty()) return phrase(key, ": the part has no joints");
  if (const Text fault = check_gain(key, block.gain);
      mode == Mode::joint_velocity && !fault.empty())
    return fault;
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = limits.joints[j];
    const Text fault = check_joint_numbers(block, j, key, joint.name);
    if (!fault.empty()) return fault;
    // A target needs a bound to be judged by; only a continuous joint has none to give.
    if (is_target(mode) && !joint.bounded && joint.kind != JointKind::continuous)
      return phrase(key, ": ", joint.name, " has no bounds to judge positions by");
  }
  return {};
}

Text check_norms(const CartesianLimits& block, const Text& key) {
  return first_of({positive(phrase(key, ".linear_limit"), block.linear_limit),
                   positive(phrase(key, ".angular_limit"), block.angular_limit),
                   positive(phrase(key, ".linear_step_limit"), block.linear_step_limit),
                   positive(phrase(key, ".angular_step_limit"), block.angular_step_limit),
                   check_gain(key, block.gain),
                   positive(phrase(key, ".linear_tracking"), block.linear_tracking),
                   positive(phrase(key, ".angular_tracking"), block.angular_tracking)});
}

Text check_pose(const PoseLimits& block, const Text& key) {
  return first_of({check_range(phrase(key, " x"), block.lower[0], block.upper[0]),
                   check_range(phrase(key, " y"), block.lower[1], block.upper[1]),
                   check_range(phrase(key, " z"), block.lower[2], block.upper[2]),
                   positive(phrase(key, ".linear_step_limit"), block.linear_step_limit),
                   positive(phrase(key, ".angular_step_limit"), block.angular_step_limit),
                   positive(phrase(key, ".linear_tracking"), block.linear_tracking),
                   positive(phrase(key, ".angular_tracking"), block.angular_tracking)});
}

Text check_gripper(const Limits& limits, const PartLimits& part, const Text& key) {
  if (part.joints.size() == 1 && limits.joints[part.joints[0]].bounded) return {};
  return phrase(key, ": expected exactly one joint, with bounds");
}

// Infinite where the file declares that losing an object is no stop.
Text check_slip(const Text& key, double slip) {
  if (slip > 0.0) return {};
  return phrase(key, ".slip_limit: expected a number above 0 or null, got ", slip);
}

// What a gripper may be commanded to lies inside its joint's bounds: targets are judged by nothing
// else.
Text check_openings(const Limits& limits, const PartLimits& part, const ScalarLimits& block,
                    const Text& key) {
  const Text fault = check_gripper(limits, part, key);
  if (!fault.empty()) return fault;
  const JointLimits& joint = limits.joints[part.joints[0]];
  if (block.lower >= joint.bounds.lower && block.upper <= joint.bounds.upper)
    return check_slip(key, block.slip_limit);
  return phrase(key, ": expected lower and upper inside the bounds of ", joint.name, ", ",
                joint.bounds.lower, " and ", joint.bounds.upper, ", got ", block.lower, " and ",
                block.upper);
}

Text check_scalar(const Limits& limits, const PartLimits& part, const ScalarLimits& block,
                  Mode mode, const Text& key) {
  const bool grips = mode == Mode::gripper_position;
  return first_of({check_range(key, block.lower, block.upper),
                   positive(phrase(key, ".step_limit"), block.step_limit),
                   grips ? check_openings(limits, part, block, key) : Text()});
}

// Whether one of the part's own joints stands between the root and a link.
bool moves(const Limits& limits, const PartLimits& part, std::size_t link) {
  const auto& links = limits.kinematics.links;
  for (; link != 0; link = links[link].parent)
    if (links[link].motion != LinkMotion::fixed && part.joints.contains(links[link].joint))
      return true;
  return false;
}

// A pose given in a frame that moves with the part would mean something else in every row.
Text check_frames(const Limits& limits, const PartLimits& part, Mode mode, const Text& key) {
  const auto* frames = frames_of(part.modes, static_cast<std::uint8_t>(mode));
  if (frames == nullptr) return {};
  if (frames->empty()) return phrase(key, ".frames: expected at least one");
  for (const Name& frame : *frames) {
    const std::size_t link = limits.kinematics.find(frame);
    if (link == no_link) return phrase(key, ".frames: ", frame, " is no link of the description");
    if (mode == Mode::cartesian_pose && moves(limits, part, link))
      return phrase(key, ".frames: ", frame, " moves with the part");
  }
  if (mode == Mode::body_twist) return {};
  if (part.tool == no_link) return phrase(key, ": the part has no tool_frame");
  if (moves(limits, part, part.tool)) return {};
  return phrase(key, ": tool_frame ", limits.kinematics.links[part.tool].name,
                " does not move with the part");
}

// With a composite switch up the next row does what one leaves: of more than all, less than
// nothing, which nothing here is made for.
Text check_gain_of_left(const Limits& limits, const CartesianLimits& block, const Text& key) {
  const auto switches = [](const PartLimits& part) { return part.modes.composite_mode.supported; };
  if (std::none_of(limits.parts.begin(), limits.parts.end(), switches)) return {};
  if (block.gain.upper <= 1.0) return {};
  return phrase(key, ".gain: expected at most 1, as the robot has a composite switch, got ",
                block.gain.upper);
}

// Rows of another mode would leave open which way the switch stands.
Text check_switch_alone(const PartLimits& part) {
  if (!part.modes.composite_mode.supported) return {};
  for (std::uint8_t mode = 0; mode != mode_count; ++mode)
    if (mode != static_cast<std::uint8_t>(Mode::composite_mode) && part.modes.supports(mode))
      return phrase("parts.", part.name, ".modes: expected composite_mode alone, got ",
                    mode_name(mode), " beside it");
  return {};
}

Text check_mode(const Limits& limits, const PartLimits& part, Mode mode) {
  const auto number = static_cast<std::uint8_t>(mode);
  if (!part.modes.supports(number)) return {};
  const Text key = phrase("parts.", part.name, ".modes.", mode_name(number));
  const Text frames = check_frames(limits, part, mode, key);
  if (!frames.empty()) return frames;
  if (const JointModeLimits* joints = joint_block(part.modes, number))
    return check_joint_mode(limits, part, *joints, mode, key);
  if (const CartesianLimits* norms = norm_block(part.modes, number)) {
    const Text fault = check_norms(*norms, key);
    return fault.empty() && is_tool_motion(number) ? check_gain_of_left(limits, *norms, key)
                                                   : fault;
  }
  if (const ScalarLimits* scalar = scalar_block(part.modes, number))
    return check_scalar(limits, part, *scalar, mode, key);
  if (mode == Mode::cartesian_pose) return check_pose(part.modes.cartesian_pose, key);
  return check_gripper(limits, part, key);  // gripper_binary has no number
}

}  // namespace

Text check_modes(const Limits& limits, const PartLimits& part) {
  Text fault = check_switch_alone(part);
  for (std::uint8_t mode = 0; mode != mode_count; ++mode)
    if (fault.empty()) fault = check_mode(limits, part, static_cast<Mode>(mode));
  return fault;
}

}  // namespace fairlead
