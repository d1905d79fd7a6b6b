// G034: the footprint of a mobile base, against zones of the floor.
#pragma once

#include "core/chunk/judgement.hpp"
#include "core/kinematics/forward_kinematics.hpp"

namespace fairlead {

using Polygon = FixedVec<Corner, max_corners>;

/// How far two convex polygons are apart at least, along the edge that separates them best;
/// negative where none does: they overlap.
double separation(const Polygon& one, const Polygon& other);

/// How far the corner that is nearest to leaving a convex polygon is inside it; negative outside.
double inside(const Polygon& corners, const Polygon& zone);

/// Corners of the footprint in odom.
Polygon footprint_at(const BaseLimits& base, const Joints& joints);

/// How far a corner moves at most between two configurations, also where one slide stops sooner
/// than the other: the ways of both, added up [m].
double base_way(const RobotModel& model, const Joints& from, const Joints& to);

/// The same, where each joint goes so far, either way.
double base_way(const RobotModel& model, const Joints& ways);

/// How far the base may be from where it is said to be, after a row and before it [m].
struct BaseOff {
  double now = 0.0;
  double before = 0.0;
};

/// What is at fault where the base is, give or take `off`. What was broken where it was `before`
/// may stay as it was. Without a fault, `slack`: the smallest margin [m].
Evidence check_base(const RobotModel& model, const Joints& joints, const Joints& before,
                    const BaseOff& off, double& slack);

}  // namespace fairlead
