// Whether what is clear at two configurations is clear on the way between them, too.
#pragma once

#include "core/chunk/evidence.hpp"
#include "core/kinematics/frames.hpp"

namespace fairlead {

/// A configuration on a way from its start, place 0, to its end, place 1.
struct WayPoint {
  double place = 0.0;
  Joints joints;
  // Everything there is clear by at least this share of how far it moves on the whole way.
  double free = 0.0;
};

/// Between two configurations that are looked at nothing moves further than this [m], unless a
/// single row goes further than `2^halvings` times as far.
inline constexpr double sweep_resolution = 0.01;
inline constexpr int halvings = 8;

/// `at(place, joints)` gives a configuration on the way; `part(from, to)` which share of its whole
/// way anything goes at most between two points of it; `look(joints, need, free)` what is at fault
/// somewhere, and otherwise the share that it is clear by (need not be found beyond `need`).
template <class At, class Part, class Look>
struct Way {
  double longest;  // of anything, in all [m]
  const At& at;
  const Part& part;
  const Look& look;
};

/// Nothing can come nearer than it is clear by at both ends together, unless it moves further: then
/// all between is clear. Otherwise the middle is looked at, and so on.
template <class AnyWay>
Evidence check_way(const WayPoint& from, const WayPoint& to, const AnyWay& way,
                   int depth = halvings) {
  const double part = way.part(from, to);
  if (from.free + to.free >= part || part * way.longest <= sweep_resolution || depth == 0)
    return {};
  WayPoint middle;
  middle.place = 0.5 * (from.place + to.place);
  way.at(middle.place, middle.joints);
  Evidence evidence = way.look(middle.joints, part, middle.free);
  if (evidence.ok()) evidence = check_way(from, middle, way, depth - 1);
  if (evidence.ok()) evidence = check_way(middle, to, way, depth - 1);
  return evidence;
}

}  // namespace fairlead
