// Checks of the measured state itself. Whether a part, or the whole robot, stands still: by its
// velocities and by its positions, since either channel may be the one that is stuck.

#include "core/chunk/state_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/chunk/judgement.hpp"

namespace fairlead {
namespace {

// Of its position: what a passive joint is, its link says; "1" if it moves none.
std::string_view unit_of(const Limits& limits, std::size_t i) {
  if (i < limits.joints.size()) return position_unit(limits.joints[i].kind);
  for (const Link& link : limits.kinematics.links)
    if (link.joint == i) return link.motion == LinkMotion::slide ? "m" : "rad";
  return "1";
}

Evidence check_block(const Limits& limits, const NumberView& block, std::string_view what) {
  const std::size_t expected = limits.measured_count();
  if (block.size() != expected)
    return broken_rule(code::state, what, "one number per measured joint",
                       static_cast<double>(block.size()), static_cast<double>(expected));
  for (std::size_t i = 0; i < expected; ++i)
    if (!std::isfinite(block[i]))
      return broken_rule(code::state, limits.measured(i).name.view(), "a finite measurement",
                         block[i]);
  return {};
}

}  // namespace

// G011: all joints are there and finite, and every part says what it did.
Evidence check_state(const Limits& limits, const JointState& state) {
  Evidence evidence = check_block(limits, state.positions, "positions");
  if (evidence.ok()) evidence = check_block(limits, state.velocities, "velocities");
  if (evidence.ok()) evidence = check_block(limits, state.efforts, "efforts");
  if (evidence.ok() && state.acted.size() != limits.parts.size())
    evidence = broken_rule(code::state, "acted", "one entry per part",
                           static_cast<double>(state.acted.size()),
                           static_cast<double>(limits.parts.size()));
  evidence.raises_stop = !evidence.ok();
  return evidence;
}

// G013: the measured position moves no further than the robot can in the ticks between.
Evidence check_jump(const Limits& limits, const MeasuredState& before, const MeasuredState& now) {
  const auto ticks = static_cast<double>(now.tick - before.tick);
  for (std::size_t i = 0; i < now.count; ++i) {
    const MeasuredLimits& joint = limits.measured(i);
    const double most = joint.jump_limit * ticks;
    const double distance =
        std::abs(measured_change(limits, i, before.positions[i], now.positions[i]));
    if (distance <= most) continue;
    Evidence evidence = declared_as(above(code::jump, joint.name.view(), distance, most,
                                          unit_of(limits, i), joint.source.view()),
                                    "jump_per_tick");
    evidence.raises_stop = true;
    return evidence;
  }
  return {};
}

// G042: what presses harder than declared has met something, or something pushes the robot.
Evidence check_contact(const Limits& limits, const MeasuredState& state) {
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const JointLimits& joint = limits.joints[j];
    const double effort = std::abs(state.efforts[j]);
    if (effort <= joint.contact_limit) continue;
    Evidence evidence = above(code::contact, joint.name.view(), effort, joint.contact_limit,
                              effort_unit(joint.kind), joint.source.view());
    evidence = of(declared_as(evidence, "contact_limit"), limits.parts[joint.part].name);
    evidence.raises_stop = true;
    return evidence;
  }
  return {};
}

namespace {

double period_s(const Limits& limits) { return static_cast<double>(limits.period_ns) * 1e-9; }

// By its positions, beyond the noise of its encoder. Nobody declares that of a joint that nothing
// commands.
double travel_beyond_noise(const Limits& limits, const MeasuredState& state, std::size_t i) {
  const double noise = i < limits.joints.size() ? limits.joints[i].encoder_step : 0.0;
  const double speed = state.travel_speeds[i];
  return std::copysign(std::max(std::abs(speed) - noise / period_s(limits), 0.0), speed);
}

double speed_of(const Limits& limits, const MeasuredState& state, std::size_t i) {
  return std::max(std::abs(state.velocities[i]), std::abs(travel_beyond_noise(limits, state, i)));
}

bool is_still(const Limits& limits, const MeasuredState& state, std::size_t i) {
  return speed_of(limits, state, i) < limits.measured(i).standstill_velocity;
}

}  // namespace

double travel_speed(const Limits& limits, std::size_t i, double from, double to) {
  const double change = measured_change(limits, i, from, to);
  const double travel = std::min(std::abs(change), limits.measured(i).jump_limit);
  return std::copysign(travel, change) / period_s(limits);
}

double measured_speed(const Limits& limits, const MeasuredState& state, std::size_t i) {
  const double velocity = state.velocities[i];
  if (std::abs(velocity) >= limits.measured(i).standstill_velocity || is_still(limits, state, i))
    return velocity;
  return travel_beyond_noise(limits, state, i);
}

double possible_speed(const MeasuredState& state, std::size_t i) {
  const double velocity = state.velocities[i], travel = state.travel_speeds[i];
  return std::abs(travel) > std::abs(velocity) ? travel : velocity;
}

Evidence check_still(std::uint32_t code, const Limits& limits, const MeasuredState& state,
                     const PartLimits& part, std::string_view rule) {
  for (const std::size_t j : part.joints) {
    if (is_still(limits, state, j)) continue;
    const JointLimits& joint = limits.joints[j];
    const Evidence evidence =
        above(code, joint.name.view(), speed_of(limits, state, j), joint.standstill_velocity,
              velocity_unit(joint.kind), rule.empty() ? joint.source.view() : rule);
    return declared_as(evidence, "standstill_per_s");
  }
  return {};
}

bool part_at_standstill(const Limits& limits, const MeasuredState& state, const PartLimits& part) {
  return check_still(code::ramp, limits, state, part).ok();
}

bool at_standstill(const Limits& limits, const MeasuredState& state) {
  for (std::size_t i = 0; i < state.count; ++i)
    if (!is_still(limits, state, i)) return false;
  return state.count == limits.measured_count();
}

}  // namespace fairlead
