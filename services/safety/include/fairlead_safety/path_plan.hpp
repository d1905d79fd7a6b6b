// What of a robot's limits the prediction needs, laid out once so that a row costs little.
#pragma once

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Made when the gate starts. `limits` must outlive it.
struct PathPlan {
  explicit PathPlan(const Limits& robot_limits) : limits(robot_limits) {}

  const Limits& limits;
};

}  // namespace fairlead
