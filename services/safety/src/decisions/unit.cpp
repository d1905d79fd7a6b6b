#include "decisions/unit.hpp"

namespace fairlead {
namespace {

enum class Quantity : std::uint8_t { none, position, velocity, effort };

// What a mode tells of a joint.
Quantity told_by(Mode mode) {
  switch (mode) {
    case Mode::joint_position:
    case Mode::dex_hand_joint:
    case Mode::gripper_position:
    case Mode::gripper_binary:
      return Quantity::position;
    case Mode::joint_velocity:
      return Quantity::velocity;
    default:
      return Quantity::none;
  }
}

// The rule about a joint's measured speed, whatever it is told.
bool is_about_speed(std::string_view rule) {
  return rule == "a first twist of this part: from standstill";
}

// What a verdict's numbers about a joint are, by its code.
Quantity joint_quantity(const Verdict& verdict, Mode mode) {
  const std::string_view rule = verdict.limit_source.view();
  switch (verdict.code) {
    case 11:  // outside its bounds: as measured, but a velocity that has to lead back
      return mode == Mode::joint_velocity && rule == "outside its bounds: only towards them"
                 ? Quantity::velocity
                 : Quantity::position;
    case 13:
    case 24:
    case 41:
      return Quantity::position;
    case 20:
    case 22:
      return told_by(mode);
    case 21:
    case 23:
      return is_about_speed(rule) ? Quantity::velocity : told_by(mode);
    case 25:
      return Quantity::velocity;
    case 40:
      return mode == Mode::joint_velocity ? Quantity::velocity : Quantity::position;
    case 42:
      return Quantity::effort;
    default:
      return Quantity::none;
  }
}

std::string of_joint(JointKind kind, Quantity quantity) {
  const std::string length = kind == JointKind::prismatic ? "m" : "rad";
  switch (quantity) {
    case Quantity::none:
      break;
    case Quantity::position:
      return length;
    case Quantity::velocity:
      return length + "/s";
    case Quantity::effort:
      return kind == JointKind::prismatic ? "N" : "N m";
  }
  return "";
}

// Places and distances that a row leads to, whatever volume, pair or zone they are named by.
bool is_a_length(std::uint32_t code) { return code == 31 || code == 32 || code == 34; }

// Motions of a tool or a base, and single numbers of a mode.
std::string of_axis(Mode mode, std::string_view axis) {
  if (axis == "tool position") return "m";
  if (axis == "tool rotation") return "rad";
  const bool is_rate = mode == Mode::body_twist || mode == Mode::cartesian_twist;
  if (axis == "linear") return is_rate ? "m/s" : "m";
  if (axis == "angular") return is_rate ? "rad/s" : "rad";
  if (mode == Mode::cartesian_pose && (axis == "x" || axis == "y" || axis == "z")) return "m";
  return "";
}

}  // namespace

std::string unit_of(const Limits& limits, const Verdict& verdict, std::uint8_t mode) {
  const auto kind = static_cast<Mode>(mode);
  const std::string_view axis = verdict.axis.view();
  if (is_a_length(verdict.code)) return "m";
  for (const JointLimits& joint : limits.joints)
    if (joint.name == axis) return of_joint(joint.kind, joint_quantity(verdict, kind));
  if (kind == Mode::gripper_position && axis == "opening")
    for (const PartLimits& part : limits.parts)
      if (part.name == verdict.part)
        return of_joint(limits.joints[part.joints[0]].kind, Quantity::position);
  return of_axis(kind, axis);
}

}  // namespace fairlead
