// Shape, surroundings and tracking so wide that they refuse nothing: a test of one check narrows
// its own numbers, and every other test sees none of them.
#pragma once

#include "fairlead_safety/limits.hpp"

namespace fairlead::test {

inline constexpr double vast = 1e4;

/// Next to none of what a row asks for is predicted to happen.
inline constexpr Gain hardly_moves{0.0, 1e-9};

/// Measured joints may press, lag and rest as they like. They brake at once.
inline void widen(JointLimits& joint) {
  joint.acceleration_limit = 1e18;
  joint.contact_limit = vast;
  joint.encoder_step = 1e-6;
  joint.dead_band = vast;
  joint.stop_lag = 0.0;
}

/// After any mode any mode may follow.
inline void widen(PartLimits& part) {
  part.singularity_limit = 1e-12;
  part.followers.fill((1U << mode_count) - 1U);
}

/// A ball on each of two links, far below the robot and far from each other.
inline CollisionLimits wide_shape(std::size_t link, std::size_t other_link) {
  CollisionLimits shape;
  (void)shape.capsules.push_back({link, {0.0, 0.0, -20.0}, {0.0, 0.0, -20.0}, 0.01});
  (void)shape.capsules.push_back({other_link, {0.0, 0.0, -10.0}, {0.0, 0.0, -10.0}, 0.01});
  (void)shape.pairs.push_back({0, 1});
  shape.clearance = 0.001;
  shape.source = "test shape";
  return shape;
}

inline WorkspaceLimits wide_workspace() {
  WorkspaceLimits workspace;
  (void)workspace.volumes.push_back(
      {"everywhere", false, {-vast, -vast, -vast}, {vast, vast, vast}});
  workspace.source = "test workspace";
  return workspace;
}

/// Corners of a square about the origin, counter-clockwise.
inline FixedVec<Corner, max_corners> square(double half) {
  FixedVec<Corner, max_corners> corners;
  for (const Corner& corner :
       {Corner{-half, -half}, Corner{half, -half}, Corner{half, half}, Corner{-half, half}})
    (void)corners.push_back(corner);
  return corners;
}

inline BaseLimits wide_base(std::size_t x, std::size_t y, std::size_t yaw) {
  BaseLimits limits;
  limits.present = true;
  limits.joints = {x, y, yaw};
  limits.yaw_axis = {0.0, 0.0};
  limits.footprint = square(0.5);
  limits.reaction_s = 0.1;
  limits.tool_drift = limits.clearance_drift = 0.0;
  (void)limits.zones.push_back({"everywhere", false, square(vast)});
  limits.source = "test base";
  return limits;
}

inline void widen(ProtocolLimits& protocol) {
  protocol.stuck_ticks = 1000;
  protocol.stop_ramp_ms = 60'000;
  protocol.step_deadline_us = 999;  // below the shortest state_timeout_ms
}

}  // namespace fairlead::test
