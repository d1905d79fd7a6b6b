// The free arm where half to all of each row's velocities happen, and the path of a chunk of it.
#pragma once

#include <initializer_list>
#include <utility>

#include "free_arm.hpp"

namespace fairlead::test::half_to_all {

// Of velocities of 1 m/s: 0.025 to 0.05 m. The tool is at (0.7, 0, 0.5).
inline Limits limits() {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  limits.parts[arm].modes.cartesian_delta.gain = {0.5, 1.0};
  return limits;
}

// 0.05 m along each slide in turn.
inline ChunkBuilder in_turn(std::initializer_list<std::pair<std::uint8_t, double>> steps) {
  Rows rows;
  for (const auto& [joint, speed] : steps) {
    rows.emplace_back(joint_count, 0.0);
    rows.back()[joint] = speed;
  }
  return ChunkBuilder().add(arm, Mode::joint_velocity, rows,
                            {free_arm::slide_x, free_arm::slide_y});
}

inline Evidence path_of(const Limits& limits, const ChunkBuilder& chunk,
                        const RowBefore& before = {}) {
  const RobotModel model(limits);
  Evidence evidence = judge_path(model, whole_robot(limits), free_arm::at_rest(), chunk.chunk, 0,
                                 chunk.chunk.horizon, before, {})
                          .evidence;
  evidence.limit_source = {};  // it points into the limits
  return evidence;
}

}  // namespace fairlead::test::half_to_all
