// Whether a part, or the whole robot, stands still.

#include <cmath>

#include "mode_checkers.hpp"

namespace fairlead {

Evidence check_still(std::uint32_t code, const RowView& view, const PartLimits& part,
                     std::string_view rule) {
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = view.limits.joints[j];
    const double speed = std::abs(view.state.velocities[j]);
    if (!(speed < joint.standstill_velocity))
      return above(code, joint.name.view(), speed, joint.standstill_velocity, rule);
  }
  return {};
}

bool part_at_standstill(const Limits& limits, const MeasuredState& state, const PartLimits& part) {
  for (const std::size_t j : part.joints)
    if (!(std::abs(state.velocities[j]) < limits.joints[j].standstill_velocity)) return false;
  return true;
}

bool at_standstill(const Limits& limits, const MeasuredState& state) {
  const std::size_t commanded = limits.joints.size();
  for (std::size_t i = 0; i < state.count; ++i) {
    const double limit = i < commanded ? limits.joints[i].standstill_velocity
                                       : limits.passive_joints[i - commanded].standstill_velocity;
    if (!(std::abs(state.velocities[i]) < limit)) return false;
  }
  return state.count == limits.measured_count();
}

}  // namespace fairlead
