// What `check_way` looks at: configurations on the way of a row, one at a time.
#pragma once

#include "core/geometry/shape_check.hpp"
#include "core/geometry/zones.hpp"

namespace fairlead {

/// Bounds of tools and capsules. `poses` is room to place them in; `looks` counts.
struct ShapeQuery {
  const PathPlan& plan;
  ShapeCheck& check;
  const FramePoses& before;
  const DisplacementBound& ways;  // of the whole way
  FramePoses& poses;
  std::size_t& looks;

  Evidence operator()(const Joints& joints, double need, double& free) const {
    Clearance found;
    ++looks;
    poses.place(plan, joints);
    const Evidence fault = check.look(poses, before, ways, need, found);
    free = check.free_of(found, ways);
    return fault;
  }
};

/// The base's zones. `way`: of its footprint, on the whole way [m].
struct ZoneQuery {
  const PathPlan& plan;
  const Joints& before;
  double way;
  std::size_t& looks;

  Evidence operator()(const Joints& joints, double, double& free) const {
    double found = unset;
    ++looks;
    const Evidence fault = check_base(plan, joints, before, found);
    free = clear_fraction(found, way);
    return fault;
  }
};

}  // namespace fairlead
