// Is a configuration fit to judge with? Missing is NaN here, so it fails like any other non-number.

#include "core/limits/validation_text.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

Text check_bounds(const Text& key, const Bounds& bounds) {
  const Text range = check_range(phrase(key, ".bounds"), bounds.lower, bounds.upper);
  if (!range.empty()) return range;
  return not_negative(phrase(key, ".bounds.tolerance"), bounds.tolerance);
}

Text check_joint(const Limits& limits, const JointLimits& joint) {
  const Text key = phrase("joints.", joint.name);
  if (joint.name.empty()) return "joints: a joint without a name";
  if (joint.part >= limits.parts.size()) return phrase(key, ".part: no such part");
  return first_of({joint.bounded ? check_bounds(key, joint.bounds) : Text(),
                   positive(phrase(key, ".effort_limit"), joint.effort_limit),
                   positive(phrase(key, ".jump_limit"), joint.jump_limit),
                   positive(phrase(key, ".standstill_velocity"), joint.standstill_velocity),
                   positive(phrase(key, ".contact_limit"), joint.contact_limit),
                   positive(phrase(key, ".encoder_step"), joint.encoder_step),
                   positive(phrase(key, ".dead_band"), joint.dead_band),
                   not_negative(phrase(key, ".stop_lag"), joint.stop_lag)});
}

Text check_passive_joint(const PassiveLimits& joint) {
  const Text key = phrase("passive_joints.", joint.name);
  if (joint.name.empty()) return "passive_joints: a joint without a name";
  return first_of({check_bounds(key, joint.bounds),
                   positive(phrase(key, ".jump_limit"), joint.jump_limit),
                   positive(phrase(key, ".standstill_velocity"), joint.standstill_velocity)});
}

// A number that nothing judges by would look like a limit.
Text check_speeds(const Limits& limits, const PartLimits& part) {
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = limits.joints[j];
    const double velocity = joint.velocity_limit, acceleration = joint.acceleration_limit;
    const Text key = phrase("joints.", joint.name);
    if (!only_grips(part.modes)) {
      const Text fault = first_of({positive(phrase(key, ".velocity_limit"), velocity),
                                   positive(phrase(key, ".acceleration_limit"), acceleration)});
      if (!fault.empty()) return fault;
    } else if (!std::isnan(velocity) || !std::isnan(acceleration)) {
      return phrase(key, ".velocity_limit, acceleration_limit: expected null, a gripper is not ",
                    "told how fast, got ", velocity, " and ", acceleration);
    }
  }
  return {};
}

Text check_part(const Limits& limits, std::size_t index) {
  const PartLimits& part = limits.parts[index];
  if (part.name.empty()) return "parts: a part without a name";
  const Text key = phrase("parts.", part.name);
  for (const std::size_t j : part.joints)
    if (j >= limits.joints.size() || limits.joints[j].part != index)
      return phrase(key, ".joints: a joint that is not this part's");
  for (std::size_t i = 1; i < part.joints.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (part.joints[i] == part.joints[k])
        return phrase(key, ".joints: ", limits.joints[part.joints[i]].name, " is there twice");
  for (std::size_t j = 0; j < limits.joints.size(); ++j)
    if (limits.joints[j].part == index && !part.joints.contains(j))
      return phrase("joints.", limits.joints[j].name, ": ", part.name,
                    " does not list it among its joints");
  if (part.tool != no_link && part.tool >= limits.kinematics.links.size())
    return phrase(key, ".tool_frame: no such link");
  const Text fault = first_of({check_speeds(limits, part), check_modes(limits, part)});
  if (!fault.empty() || !moves_tool(part.modes)) return fault;
  return positive(phrase(key, ".singularity_limit"), part.singularity_limit);
}

Text in_range(std::string_view key, double value, double lowest, double highest) {
  if (value >= lowest && value <= highest) return {};
  return phrase("protocol.", key, ": expected ", lowest, " to ", highest, ", got ", value);
}

// A slower step is found by its length, not by the age of the state that it held up (G011).
Text check_deadline(const ProtocolLimits& protocol) {
  if (protocol.step_deadline_us < protocol.state_timeout_ms * 1000ULL) return {};
  return phrase("protocol.step_deadline_us: expected less than state_timeout_ms, ",
                protocol.state_timeout_ms * 1000ULL, " us, got ", protocol.step_deadline_us);
}

// The upper ends are what the gate has room or numbers for.
Text check_protocol(const ProtocolLimits& protocol) {
  return first_of({in_range("horizon_max", protocol.horizon_max, 1, max_rows),
                   in_range("age_max_ticks", protocol.age_max_ticks, 1, 1000),
                   in_range("chunk_rate_max_hz", protocol.chunk_rate_max_hz, 0.01, 50),
                   in_range("seq_jump_max", static_cast<double>(protocol.seq_jump_max), 1, 1e9),
                   in_range("state_timeout_ms", protocol.state_timeout_ms, 1, 10'000),
                   in_range("heartbeat_timeout_realtime_ms", protocol.heartbeat_timeout_realtime_ms,
                            50, 10'000),
                   in_range("heartbeat_timeout_lockstep_ms", protocol.heartbeat_timeout_lockstep_ms,
                            50, 60'000),
                   in_range("lease_interval_ms", protocol.lease_interval_ms, 6, 1000),
                   in_range("idle_disarm_s", protocol.idle_disarm_s, 1, 86'400),
                   in_range("stops_to_latch", protocol.stops_to_latch, 1, 16),
                   in_range("stop_window_s", protocol.stop_window_s, 1, 86'400),
                   in_range("bad_frames_limit", protocol.bad_frames_limit, 1, 16),
                   in_range("bad_frames_window_ticks", protocol.bad_frames_window_ticks, 1, 1000),
                   in_range("stuck_ticks", protocol.stuck_ticks, 1, 1000),
                   in_range("stop_ramp_ms", protocol.stop_ramp_ms, 1, 60'000),
                   in_range("step_deadline_us", protocol.step_deadline_us, 1, 1'000'000),
                   in_range("second_person_s", protocol.second_person_s, 0, 3600),
                   check_deadline(protocol)});
}

}  // namespace

Text check_limits(const Limits& limits) {
  if (limits.robot.empty() || limits.profile.empty()) return "robot, profile: expected names";
  if (limits.robot_hash == Hash{}) return "robot_hash: expected the robot's hash, got none";
  if (limits.period_ns < 1'000'000 || limits.period_ns > 1'000'000'000)
    return phrase("period_ns: expected 1000000 to 1000000000, got ", limits.period_ns);
  if (limits.joints.empty() || limits.parts.empty())
    return "joints, parts: expected at least one of each";
  Text fault = first_of({check_names(limits.joints, "joints"),
                         check_names(limits.passive_joints, "passive_joints"),
                         check_names(limits.parts, "parts"), check_tree(limits)});
  for (const JointLimits& joint : limits.joints)
    if (fault.empty()) fault = check_joint(limits, joint);
  for (const PassiveLimits& joint : limits.passive_joints)
    if (fault.empty()) fault = check_passive_joint(joint);
  for (std::size_t i = 0; i < limits.parts.size(); ++i)
    if (fault.empty()) fault = check_part(limits, i);
  return first_of({fault, check_collision(limits), check_workspace(limits), check_base(limits),
                   check_protocol(limits.protocol)});
}

}  // namespace fairlead
