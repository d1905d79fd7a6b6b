// The absolute limits of released rows once more, by hand, for any robot.
#pragma once

#include <algorithm>
#include <cmath>

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead::test {

/// How far a joint was ever told to be measured outside its bounds: targets may lead back.
class FarthestMeasured {
 public:
  void note(const Limits& limits, const JointState& state) {
    for (std::size_t j = 0; j < limits.joints.size() && j < state.positions.size(); ++j) {
      const double excess = std::max(limits.joints[j].bounds.lower - state.positions[j],
                                     state.positions[j] - limits.joints[j].bounds.upper);
      if (excess > excess_[j]) excess_[j] = excess;  // NaN never
    }
  }
  [[nodiscard]] double of(std::size_t j) const { return excess_[j]; }

 private:
  std::array<double, max_joints> excess_{};
};

class ReleasedRows {
 public:
  ReleasedRows(const Limits& limits, const FarthestMeasured& farthest)
      : limits_(limits), farthest_(farthest) {}

  [[nodiscard]] bool within_limits(const SafeChunk& chunk) const {
    for (const ActionPart& part : chunk.parts)
      for (std::size_t row = 0; row < chunk.horizon; ++row)
        if (part.part >= limits_.parts.size() || !row_within(part, row, chunk.horizon))
          return false;
    return true;
  }

 private:
  [[nodiscard]] bool row_within(const ActionPart& part, std::size_t row, std::size_t rows) const {
    const ModeLimits& modes = limits_.parts[part.part].modes;
    const std::size_t width = part.values.size() / rows;
    const auto value = [&](std::size_t i) { return part.values[row * width + i]; };
    const auto norm = [&](std::size_t at) {
      return std::sqrt(value(at) * value(at) + value(at + 1) * value(at + 1) +
                       value(at + 2) * value(at + 2));
    };
    const auto norms = [&](const CartesianLimits& mode) {
      return norm(0) <= mode.linear_limit + slack && norm(3) <= mode.angular_limit + slack;
    };
    const auto each_joint = [&](auto rule) {
      return std::all_of(part.active.begin(), part.active.end(),
                         [&](std::uint8_t j) { return rule(j, value(j)); });
    };
    const auto reaches = [&](std::size_t j, double target) {
      const JointLimits& joint = limits_.joints[j];
      const double more = farthest_.of(j);
      return std::isfinite(target) &&
             (!joint.bounded || (target >= joint.bounds.lower - more - slack &&
                                 target <= joint.bounds.upper + more + slack));
    };
    switch (static_cast<Mode>(part.mode)) {
      case Mode::joint_position:
      case Mode::dex_hand_joint:
        return each_joint(reaches);
      case Mode::joint_velocity:
        return each_joint([&](std::size_t j, double speed) {
          return std::abs(speed) <= limits_.joints[j].velocity_limit;
        });
      case Mode::cartesian_pose:
        return inside(modes.cartesian_pose, {value(0), value(1), value(2)});
      case Mode::cartesian_delta:
        return norms(modes.cartesian_delta);
      case Mode::cartesian_twist:
        return norms(modes.cartesian_twist);
      case Mode::body_twist:
        return norms(modes.body_twist);
      case Mode::gripper_position:
        return value(0) >= modes.gripper_position.lower && value(0) <= modes.gripper_position.upper;
      case Mode::gripper_binary:
        return value(0) == 0.0 || value(0) == 1.0;
      case Mode::composite_mode:
        return value(0) >= -1.0 && value(0) <= 1.0;
      default:
        return false;
    }
  }

  static bool inside(const PoseLimits& box, const std::array<double, 3>& place) {
    for (std::size_t i = 0; i < place.size(); ++i)
      if (!(place[i] >= box.lower[i] && place[i] <= box.upper[i])) return false;
    return true;
  }

  static constexpr double slack = 1e-12;
  const Limits& limits_;
  const FarthestMeasured& farthest_;
};

}  // namespace fairlead::test
