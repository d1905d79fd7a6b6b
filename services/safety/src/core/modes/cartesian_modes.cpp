// Modes that move a frame by a small motion or a velocity: three linear and three angular numbers,
// judged by the norms of the two halves, never by single axes. And poses.

#include <array>
#include <cmath>

#include "core/chunk/state_check.hpp"
#include "core/kinematics/forward_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/modes/row_limit_check.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

struct HalfUnits {
  std::string_view linear, angular;
};
constexpr HalfUnits of_a_motion{"m", "rad"};

HalfUnits units_of(const RowView& view) {
  const bool is_motion = view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta);
  return is_motion ? of_a_motion : HalfUnits{"m/s", "rad/s"};
}

const CartesianLimits& block_of(const RowView& view) {
  return *norm_block(view.modes, view.mode());
}

struct Halves {
  double linear, angular;
};

Evidence both_at_most(std::uint32_t code, const Halves& values, const Halves& limits,
                      const HalfUnits& units, const Text& source) {
  const Evidence linear =
      at_most(code, "linear", values.linear, limits.linear, units.linear, source);
  if (!linear.ok()) return linear;
  return at_most(code, "angular", values.angular, limits.angular, units.angular, source);
}

Evidence step_from(std::uint32_t code, const RowView& view, const Twist& before) {
  const CartesianLimits& mode = block_of(view);
  const Twist now = halves(view.now);
  return both_at_most(
      code, {(now.linear - before.linear).norm(), (now.angular - before.angular).norm()},
      {mode.linear_step_limit, mode.angular_step_limit}, units_of(view), mode.source);
}

}  // namespace

bool measured_base_twist(const Limits& limits, const PartLimits& part, const MeasuredState& state,
                         Twist& twist) {
  const auto& joints = part.joints;
  const auto slides = [&](std::size_t i) {
    return limits.joints[joints[i]].kind == JointKind::prismatic;
  };
  if (joints.size() != 3 || !slides(0) || !slides(1) || slides(2)) return false;
  const double yaw = state.positions[joints[2]];
  const double vx = state.velocities[joints[0]];
  const double vy = state.velocities[joints[1]];
  const double turn = state.velocities[joints[2]];
  const double cosine = std::cos(yaw), sine = std::sin(yaw);
  twist.linear = {cosine * vx + sine * vy, cosine * vy - sine * vx, 0.0};
  twist.angular = {0.0, 0.0, turn};
  // The slides carry the yaw axis; base_link's origin swings about it.
  if (limits.base.present) {
    twist.linear.x() += turn * limits.base.yaw_axis[1];
    twist.linear.y() -= turn * limits.base.yaw_axis[0];
  }
  return true;
}

Evidence norm_absolute(const RowView& view) {
  const CartesianLimits& mode = block_of(view);
  const Twist now = halves(view.now);
  return both_at_most(code::absolute, {now.linear.norm(), now.angular.norm()},
                      {mode.linear_limit, mode.angular_limit}, units_of(view), mode.source);
}

// Holding is a delta of zero.
Evidence delta_start(const RowView& view, const Setpoint* acted) {
  if (acted != nullptr) return {};
  return step_from(code::start, view, Twist{});
}

// A twist after none: against the tool's measured one, along the axes of the row's frame. What
// other parts add to it is not this part's: its twist comes on top of theirs.
Evidence tool_twist_start(const RowView& view, const Setpoint* acted) {
  if (acted != nullptr) return {};
  return step_from(code::start, view,
                   link_twist(view.model, view.state, link_of(view.limits, view.now),
                              view.part().tool, &view.part()));
}

Evidence body_twist_start(const RowView& view, const Setpoint* acted) {
  if (acted != nullptr) return {};
  Twist measured;
  if (!measured_base_twist(view.limits, view.part(), view.state, measured))
    return check_still(code::start, view.limits, view.state, view.part(),
                       "standstill, for a first twist of this part");
  return step_from(code::start, view, measured);
}

Evidence norm_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  return step_from(code, view, halves(before));
}

namespace {

// A quaternion that has come through float32 is this close to a unit one.
constexpr double norm_tolerance = 1e-6;

Evidence step_from(std::uint32_t code, const RowView& view, const Pose& before,
                   bool goes_on = false) {
  const PoseLimits& mode = view.modes.cartesian_pose;
  const Motion6 step = motion_between(before, pose_of(view.now));
  const double linear = mode.linear_step_limit, angular = mode.angular_step_limit;
  return both_at_most(code, {step.head<3>().norm(), step.tail<3>().norm()},
                      {linear + unmeasured_step(view, goes_on, linear),
                       angular + unmeasured_step(view, goes_on, angular)},
                      of_a_motion, mode.source);
}

}  // namespace

Evidence pose_absolute(const RowView& view) {
  constexpr std::array<std::string_view, 3> axes{"x", "y", "z"};
  const PoseLimits& mode = view.modes.cartesian_pose;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Evidence evidence =
        in_range(axes[i], view.now[i], mode.lower[i], mode.upper[i], "m", mode.source);
    if (!evidence.ok()) return evidence;
  }
  const double norm = Eigen::Vector4d(view.now[3], view.now[4], view.now[5], view.now[6]).norm();
  return in_range("quaternion norm", norm, 1.0 - norm_tolerance, 1.0 + norm_tolerance, "1",
                  mode.source);
}

// Like a joint target, a pose starts where the tool is measured to be, also while rows act.
Evidence pose_start(const RowView& view, const Setpoint* acted) {
  return step_from(code::start, view,
                   link_pose(view.model, {view.model, view.state.positions},
                             link_of(view.limits, view.now), view.part().tool),
                   acted != nullptr);
}

Evidence pose_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  return step_from(code, view, pose_of(before));
}

}  // namespace fairlead
