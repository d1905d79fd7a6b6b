// Whether a part, or the whole robot, stands still: by its velocities and by its positions, since
// either channel may be the one that is stuck.

#include "core/modes/standstill.hpp"

#include <algorithm>
#include <cmath>

#include "core/chunk/measured_change.hpp"

namespace fairlead {
namespace {

double standstill_limit(const Limits& limits, std::size_t i) {
  const std::size_t commanded = limits.joints.size();
  return i < commanded ? limits.joints[i].standstill_velocity
                       : limits.passive_joints[i - commanded].standstill_velocity;
}

double speed_of(const MeasuredState& state, std::size_t i) {
  return std::max(std::abs(state.velocities[i]), state.travel_speeds[i]);
}

bool is_still(const Limits& limits, const MeasuredState& state, std::size_t i) {
  return speed_of(state, i) < standstill_limit(limits, i);
}

}  // namespace

double travel_speed(const Limits& limits, std::size_t i, double from, double to,
                    std::uint64_t ticks) {
  // Nobody declares the noise of a joint that nothing commands.
  const double noise = i < limits.joints.size() ? limits.joints[i].encoder_step : 0.0;
  const double travel = std::abs(measured_change(limits, i, from, to)) - noise;
  return travel / (static_cast<double>(ticks) * static_cast<double>(limits.period_ns) * 1e-9);
}

Evidence check_still(std::uint32_t code, const Limits& limits, const MeasuredState& state,
                     const PartLimits& part, std::string_view rule) {
  for (const std::size_t j : part.joints) {
    if (is_still(limits, state, j)) continue;
    const JointLimits& joint = limits.joints[j];
    const Evidence evidence =
        above(code, joint.name.view(), speed_of(state, j), joint.standstill_velocity,
              rule.empty() ? joint.source.view() : rule);
    return in(evidence, velocity_unit(joint.kind), "standstill_per_s");
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
