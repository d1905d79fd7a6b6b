#include "decisions/unit.hpp"

namespace fairlead {

std::string unit_of(const Limits& limits, const Verdict& verdict, std::uint8_t mode) {
  const auto kind = static_cast<Mode>(mode);
  const std::string_view axis = verdict.axis.view();
  const bool rate = kind == Mode::body_twist || kind == Mode::cartesian_twist;
  if (axis == "linear") return rate ? "m/s" : "m";
  if (axis == "angular") return rate ? "rad/s" : "rad";
  if (axis == "opening" || axis == "x" || axis == "y" || axis == "z") return "m";
  for (const JointLimits& joint : limits.joints) {
    if (!(joint.name == axis)) continue;
    const std::string length = joint.kind == JointKind::prismatic ? "m" : "rad";
    const bool still = verdict.limit_source.view().find("standstill") != std::string_view::npos;
    if (kind == Mode::joint_velocity || still) return length + "/s";
    if (kind == Mode::joint_torque) return length == "m" ? "N" : "N m";
    return length;
  }
  return "";
}

}  // namespace fairlead
