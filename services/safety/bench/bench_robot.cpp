#include "bench_robot.hpp"

#include <stdexcept>

#include "fairlead_safety/limits.hpp"

namespace fairlead::bench {
namespace {

constexpr double step_limit = 0.05;    // [rad or m] a row: ten times the share that chunks use
constexpr double slow = 0.2;           // [m/s]
constexpr double sway = 0.02;          // of its limits, what a row of a whole step asks for
constexpr std::size_t still_rows = 2;  // that may act before the next chunk replaces the rest

// The mode of a part that its chunks use: the first that it has and that can be told to stay.
Mode mode_of(const PartLimits& part) {
  for (const Mode mode : {Mode::cartesian_delta, Mode::joint_position, Mode::dex_hand_joint,
                          Mode::gripper_position, Mode::joint_velocity, Mode::composite_mode})
    if (part.modes.supports(static_cast<std::uint8_t>(mode))) return mode;
  throw std::runtime_error("no mode of part " + std::string(part.name.view()) +
                           " can be told to stay");
}

// To and fro by a share of the limits, joint targets about the measured place; grippers stay.
std::vector<double> swaying_row(const Limits& limits, const MeasuredState& state,
                                const PartLimits& part, double share) {
  const Mode mode = mode_of(part);
  const auto number = static_cast<std::uint8_t>(mode);
  std::vector<double> row(mode_width(number, limits.joints.size()), 0.0);
  if (mode == Mode::cartesian_delta)
    for (std::size_t i = 0; i < row.size(); ++i)  // each of three axes: a norm below the limit
      row[i] = 0.5 * share *
               (i < 3 ? part.modes.cartesian_delta.linear_limit
                      : part.modes.cartesian_delta.angular_limit);
  for (const std::size_t j : part.joints) {
    if (mode == Mode::joint_velocity) row[j] = share * limits.joints[j].velocity_limit;
    if (is_target(mode))
      row[j] = state.positions[j] + share * joint_block(part.modes, number)->step_limit[j];
  }
  if (mode == Mode::gripper_position) row[0] = state.positions[part.joints[0]];
  return row;
}

}  // namespace

Limits one_part_of(const Limits& shipped, std::size_t pairs) {
  Limits limits = shipped;
  PartLimits part;
  part.name = "all";
  part.source = "bench";
  part.tool = shipped.parts[0].tool;
  part.singularity_limit = shipped.parts[0].singularity_limit;
  JointModeLimits& mode = part.modes.joint_position;
  mode.supported = true;
  mode.source = "bench";
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    JointLimits& joint = limits.joints[j];
    joint.part = 0;
    if (!joint.bounded) joint.bounds = {-1.0, 1.0, 0.01};
    joint.bounded = true;
    if (!(joint.acceleration_limit > 0.0)) {  // a gripper, that nothing else tells to move so
      joint.velocity_limit = slow;
      joint.acceleration_limit = 100.0 * slow * slow;
    }
    (void)part.joints.push_back(j);
    mode.step_limit[j] = step_limit;
    mode.tracking[j] = 1.0;
  }
  limits.parts.clear();
  (void)limits.parts.push_back(part);
  if (limits.collision.pairs.size() > pairs) (void)limits.collision.pairs.resize(pairs);
  return limits;
}

ClaimLimits claim_of(const Limits& limits) {
  ClaimLimits claim;
  for (std::size_t i = 0; i < limits.parts.size(); ++i) {
    (void)claim.parts.push_back(i);
    claim.modes[i] = limits.parts[i].modes;
  }
  claim.horizon_max = max_rows;
  claim.age_max_ticks = limits.protocol.age_max_ticks;
  return claim;
}

MeasuredState middle_of(const Limits& limits) {
  MeasuredState state;
  state.tick = 100;
  state.count = limits.measured_count();
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const Bounds& bounds = limits.joints[j].bounds;
    if (limits.joints[j].bounded) state.positions[j] = 0.5 * (bounds.lower + bounds.upper);
  }
  for (std::size_t i = 0; i < limits.passive_joints.size(); ++i) {
    const Bounds& bounds = limits.passive_joints[i].bounds;
    state.positions[limits.joints.size() + i] = 0.5 * (bounds.lower + bounds.upper);
  }
  (void)state.acted.resize(limits.parts.size());
  return state;
}

JointChunk::JointChunk(const Limits& limits, const MeasuredState& state, std::uint32_t horizon) {
  const std::size_t width = limits.joints.size();
  for (std::size_t row = 0; row < horizon; ++row)
    for (std::size_t j = 0; j < width; ++j)
      numbers_.push_back(state.positions[j] + (row % 2 == 0 ? 0.1 * step_limit : 0.0));
  ActionPart action;
  action.mode = static_cast<std::uint8_t>(Mode::joint_position);
  action.values = NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers_.data()),
                                   numbers_.size() * sizeof(double)));
  for (std::size_t j = 0; j < width; ++j)
    (void)action.active.push_back(static_cast<std::uint8_t>(j));
  chunk_.horizon = horizon;
  chunk_.obs_tick = chunk_.oldest_tick = chunk_.start_tick = state.tick;
  (void)chunk_.parts.push_back(action);
}

std::vector<double> rows_for(const Limits& limits, const MeasuredState& state, std::size_t part,
                             std::uint32_t rows, bool moving) {
  std::vector<double> numbers;
  for (std::uint32_t i = 0; i < rows; ++i) {
    const double share = !moving || i < still_rows ? 0.0 : i % 2 == 0 ? sway : -sway;
    const std::vector<double> row = swaying_row(limits, state, limits.parts[part], share);
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  return numbers;
}

ActionPart action_of(const Limits& limits, std::size_t part, const std::vector<double>& numbers) {
  return action_of(limits, part, static_cast<std::uint8_t>(mode_of(limits.parts[part])), numbers);
}

ActionPart action_of(const Limits& limits, std::size_t part, std::uint8_t mode,
                     const std::vector<double>& numbers) {
  const PartLimits& robot = limits.parts[part];
  ActionPart action;
  action.part = static_cast<std::uint8_t>(part);
  action.mode = mode;
  action.values = NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                                   numbers.size() * sizeof(double)));
  if (is_joint_mode(action.mode))
    for (const std::size_t j : robot.joints)
      (void)action.active.push_back(static_cast<std::uint8_t>(j));
  const FixedVec<Name, max_frames>* frames = frames_of(robot.modes, action.mode);
  if (frames != nullptr) action.frame_id = (*frames)[0];
  return action;
}

}  // namespace fairlead::bench
