// Whether a motion keeps to a constraint all the way, and not at its ends alone: adaptive dynamic
// collision checking (Schwarzer, Saha, Latombe, 2005).
#pragma once

#include "core/geometry/shape_check.hpp"
#include "core/geometry/zones.hpp"
#include "core/trajectory/braking.hpp"

namespace fairlead {

/// A configuration on a motion from its start, place 0, to its end, place 1.
struct WayPoint {
  double place = 0.0;
  Joints joints;
  // Everything there is clear by at least this share of how far it moves on the whole motion.
  double clear = 0.0;
};

/// All joints go straight from one configuration to another: a row, or from where one share of the
/// rows leads to where another does.
struct StraightMotion {
  const Joints& from;
  const Joints& to;

  [[nodiscard]] const Joints& start() const { return from; }
  [[nodiscard]] const Joints& end() const { return to; }
  void at(double place, Joints& joints) const {
    for (std::size_t j = 0; j < joints.size(); ++j) joints[j] = from[j] + place * (to[j] - from[j]);
  }
};

/// Between two points of a motion nothing goes a larger share of its way than this. Of braking some
/// joints stop sooner than others.
inline double share_between(const StraightMotion&, const WayPoint& from, const WayPoint& to) {
  return to.place - from.place;
}
inline double share_between(const Braking& braking, const WayPoint& from, const WayPoint& to) {
  return braking.largest_share(from.joints, to.joints);
}

/// G031 and G032: tools and capsules, which a motion displaces by `bound` at most. `poses` is room
/// to place them in.
struct ShapeConstraint {
  const RobotModel& model;
  ShapeCheck& check;
  const FramePoses& before;
  const DisplacementBound& bound;
  FramePoses& poses;
  QueryBudget& budget;

  [[nodiscard]] double longest() const { return bound.longest(); }
  Evidence query(const Joints& joints, double need, double& clear) const {
    Clearance found;
    Evidence fault = budget.take();
    if (!fault.ok()) return fault;
    poses.place(model, joints);
    fault = check.check(poses, before, bound, need, found);
    clear = check.clear_fraction_of(found, bound);
    return fault;
  }
};

/// G034: the base's zones. `way`: of its footprint, on the whole motion [m].
struct ZoneConstraint {
  const RobotModel& model;
  const Joints& before;
  double way;
  const BaseOff& off;
  QueryBudget& budget;

  [[nodiscard]] double longest() const { return way; }
  Evidence query(const Joints& joints, double, double& clear) const {
    double margin = unset;
    Evidence fault = budget.take();
    if (!fault.ok()) return fault;
    fault = check_base(model, joints, before, off, margin);
    clear = clear_fraction(margin, way);
    return fault;
  }
};

/// Between two configurations that are queried nothing moves further than this [m].
inline constexpr double sweep_resolution = 0.01;
/// No part of a motion is halved that is shorter, of its length or time: that ends what would never
/// end, motions that are no numbers. Braking is halved by its time, of which a joint may need a
/// small part only.
inline constexpr double shortest_part = 1e-7;

/// What is at fault between two points of a motion. Nothing can come nearer than it is clear by at
/// both together, unless it moves further: then all between is clear. Otherwise the middle is
/// queried, and so on. `constraint.query(joints, need, clear)` gives the fault of a configuration,
/// otherwise the share that it is clear by, which need not be found beyond `need`; `longest()` how
/// far anything moves on the whole motion [m].
template <class Motion, class Constraint>
Evidence certify(const Motion& motion, const Constraint& constraint, const WayPoint& from,
                 const WayPoint& to) {
  const double share = share_between(motion, from, to);
  if (from.clear + to.clear >= share || share * constraint.longest() <= sweep_resolution ||
      to.place - from.place <= shortest_part)
    return {};
  WayPoint middle;
  middle.place = 0.5 * (from.place + to.place);
  motion.at(middle.place, middle.joints);
  Evidence evidence = constraint.query(middle.joints, share, middle.clear);
  if (evidence.ok()) evidence = certify(motion, constraint, from, middle);
  if (evidence.ok()) evidence = certify(motion, constraint, middle, to);
  return evidence;
}

/// A whole motion, by the shares that its start and its end are clear by.
template <class Motion, class Constraint>
Evidence certify(const Motion& motion, const Constraint& constraint, double clear_at_start,
                 double clear_at_end) {
  return certify(motion, constraint, WayPoint{0.0, motion.start(), clear_at_start},
                 WayPoint{1.0, motion.end(), clear_at_end});
}

/// The same, with a look at its end, unless its start is clear by all of it.
template <class Motion, class Constraint>
Evidence certify_to_end(const Motion& motion, const Constraint& constraint, double clear_at_start) {
  if (clear_at_start >= 1.0) return {};
  double clear_at_end = unset;
  const Evidence evidence = constraint.query(motion.end(), 1.0, clear_at_end);
  return evidence.ok() ? certify(motion, constraint, clear_at_start, clear_at_end) : evidence;
}

}  // namespace fairlead
