// The two ways of a row: to where it leads, and on from there to where braking ends.
#pragma once

#include <algorithm>
#include <span>

#include "core/trajectory/braking.hpp"
#include "core/trajectory/sweep.hpp"

namespace fairlead {

/// All joints, `count` of them, go straight from one configuration to the next. `longest`, `free_*`
/// and `look` as for `check_way`.
template <class Look>
Evidence check_row_way(const Branch& branch, std::size_t count, double longest, double free_before,
                       double free_now, const Look& look) {
  const auto at = [&](double place, Joints& joints) {
    const auto before = std::span(branch.before).first(count);
    std::transform(before.begin(), before.end(), branch.now.begin(), joints.begin(),
                   [place](double from, double to) { return from + place * (to - from); });
  };
  const auto part = [](const WayPoint& from, const WayPoint& to) { return to.place - from.place; };
  return check_way(WayPoint{0.0, branch.before, free_before}, WayPoint{1.0, branch.now, free_now},
                   Way{longest, at, part, look});
}

/// On the way of braking some joints stop sooner than others.
template <class Look>
Evidence check_braking_way(const Branch& branch, const Braking& braking, double longest,
                           double free_now, double free_at_rest, const Look& look) {
  const auto at = [&](double place, Joints& joints) { braking.at(place, joints); };
  const auto part = [&](const WayPoint& from, const WayPoint& to) {
    return braking.largest_share(from.joints, to.joints);
  };
  return check_way(WayPoint{0.0, branch.now, free_now}, WayPoint{1.0, braking.end(), free_at_rest},
                   Way{longest, at, part, look});
}

/// The same with its end, where `look_at_rest` looks. Nothing of it is looked at if all is clear by
/// the whole of its way.
template <class LookAtRest, class Look>
Evidence check_to_rest(const Branch& branch, const Braking& braking, double longest,
                       double free_now, const LookAtRest& look_at_rest, const Look& look) {
  if (free_now >= 1.0) return {};
  double free_at_rest = unset;
  const Evidence evidence = look_at_rest(braking.end(), 1.0, free_at_rest);
  if (!evidence.ok()) return evidence;
  return check_braking_way(branch, braking, longest, free_now, free_at_rest, look);
}

}  // namespace fairlead
