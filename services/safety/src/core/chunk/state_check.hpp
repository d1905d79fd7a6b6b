// A measured state by itself and against the one before it: G011, G013, G042, and standstill.
#pragma once

#include <cmath>
#include <numbers>

#include "core/chunk/judgement.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// From one position of a commanded joint to another [rad or m]; a continuous one may be reported
/// in any turn.
inline double measured_change(const JointLimits& joint, double from, double to) {
  const double change = to - from;
  return joint.kind == JointKind::continuous ? std::remainder(change, 2.0 * std::numbers::pi)
                                             : change;
}

/// The same of measured joint `i`, which may be passive.
inline double measured_change(const Limits& limits, std::size_t i, double from, double to) {
  return i < limits.joints.size() ? measured_change(limits.joints[i], from, to) : to - from;
}

/// How fast measured joint `i` went between two states [rad/s or m/s]: what its velocity does not
/// say if that channel is stuck. If states between were lost, all of the way counts as the last
/// tick's, up to the longest that G013 takes in one.
double travel_speed(const Limits& limits, std::size_t i, double from, double to);

/// How fast measured joint `i` goes [rad/s or m/s], by its positions, beyond the noise of its
/// encoder, where its velocity says that it stands and they do not.
double measured_speed(const Limits& limits, const MeasuredState& state, std::size_t i);

/// How fast it may go even if that counts as standing, noise included: the larger of the two.
double possible_speed(const MeasuredState& state, std::size_t i);

/// The part's first joint that does not stand still, by its velocity or by its positions; `rule`
/// says what for, the joint's source if it is empty.
Evidence check_still(std::uint32_t code, const Limits& limits, const MeasuredState& state,
                     const PartLimits& part, std::string_view rule = {});

bool part_at_standstill(const Limits& limits, const MeasuredState& state, const PartLimits& part);

/// Every measured joint, also those that nothing commands.
bool at_standstill(const Limits& limits, const MeasuredState& state);

/// G011: every joint there and finite. `state` is the decoded message.
Evidence check_state(const Limits& limits, const JointState& state);

/// G013: no joint moved further between two states than it can in the ticks between them.
Evidence check_jump(const Limits& limits, const MeasuredState& before, const MeasuredState& now);

/// G042: no commanded joint is measured to press harder than its contact limit.
Evidence check_contact(const Limits& limits, const MeasuredState& state);

}  // namespace fairlead
