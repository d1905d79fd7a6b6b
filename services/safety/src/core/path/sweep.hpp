// Whether what is clear at two configurations is clear on the way between them, too.
#pragma once

#include "../evidence.hpp"
#include "frames.hpp"

namespace fairlead {

/// A configuration on the way, and by how much everything there is clear at least [m].
struct WayPoint {
  double share = 0.0;
  Joints joints;
  double slack = 0.0;
};

/// Between two configurations that are looked at nothing moves further than this [m], unless a
/// single row goes further than `2^halvings` times as far.
inline constexpr double sweep_resolution = 0.01;
inline constexpr int halvings = 6;

/// Nothing that moves by `way` in all can come nearer than its slack at both ends covers: then all
/// between is clear. Otherwise the middle is looked at, and so on.
///
/// `at(share, joints)` gives a configuration on the way, `look(joints, need, slack)` what is at
/// fault there (`slack` need not be found beyond `need`), `bound(from, to)` how far anything moves.
template <class At, class Look, class Bound>
Evidence check_way(const WayPoint& from, const WayPoint& to, const At& at, const Look& look,
                   const Bound& bound, int depth = halvings) {
  const double way = bound(from.joints, to.joints);
  if (from.slack + to.slack >= way || way <= sweep_resolution || depth == 0) return {};
  WayPoint middle;
  middle.share = 0.5 * (from.share + to.share);
  at(middle.share, middle.joints);
  Evidence evidence = look(middle.joints, way, middle.slack);
  if (evidence.ok()) evidence = check_way(from, middle, at, look, bound, depth - 1);
  if (evidence.ok()) evidence = check_way(middle, to, at, look, bound, depth - 1);
  return evidence;
}

}  // namespace fairlead
