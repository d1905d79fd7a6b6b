// Tools of which a row leaves most undone, and the goals that rows have left them.
#pragma once

#include "predicted.hpp"
#include "row_judge.hpp"

namespace fairlead::test::goals {

// Of arm_1 in each row [rad]; the tool is 0.7 m away from its axis.
inline constexpr double turn = 0.1;
inline constexpr std::size_t upper = 2;  // the branch of the larger share

// 0.1 to 0.3 of a motion happens in its tick: a turn of 0.1 rad at 0.6 rad/s at most. The limit of
// the joint is 1.5 rad/s.
inline Limits shared_out() {
  Limits limits = test_limits();
  limits.parts[arm].modes.cartesian_delta.gain = {0.1, 0.3};
  CartesianLimits& twist = limits.parts[arm].modes.cartesian_twist;
  twist.gain = {0.1, 0.3};
  twist.linear_limit = twist.angular_limit = 3.0;
  twist.linear_step_limit = twist.angular_step_limit = 9.0;
  limits.parts[composite].modes.composite_mode.step_limit = 2.0;
  return limits;
}

inline Row turned(double angle) { return {0, 0.7 * angle, 0, 0, 0, angle}; }

inline ChunkBuilder turns(const Row& angles, Mode mode = Mode::cartesian_delta) {
  Rows rows;
  for (const double angle : angles) rows.push_back(turned(angle));
  return ChunkBuilder().add(arm, mode, rows, {}, "base_link");
}

inline ChunkBuilder switched(ChunkBuilder builder, double value) {
  return builder.scalar(composite, Mode::composite_mode, Row(builder.chunk.horizon, value));
}

inline const Row four(4, turn);

// arm_1 is told to be at that angle by the rows before.
inline PartMemories goal_at(double angle) {
  PartMemories memories;
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  memories[arm].goal =
      Pose{rotation, rotation * Eigen::Vector3d(0.7, 0, 0) + Eigen::Vector3d(0, 0, 0.5)};
  return memories;
}

inline const Limits a_tenth_to_three = shared_out();

inline Evidence of(const ChunkBuilder& chunk, const PartMemories& memories) {
  RowBefore before;
  before.memories = &memories;
  return judge_rows(a_tenth_to_three, whole_robot(a_tenth_to_three), state_at_rest(), chunk.chunk,
                    0, before)
      .evidence;
}

}  // namespace fairlead::test::goals
