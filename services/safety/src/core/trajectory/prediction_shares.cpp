// Of each row another share may happen: where that leads each joint at most, and how fast (G026).

#include <cmath>
#include <limits>

#include "core/geometry/distances.hpp"
#include "core/kinematics/robot_model.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead {
namespace {

// Of the base's slides, whichever way it is turned [m].
double slide_way(const RobotModel& model, const Joints& ways) {
  const auto& joints = model.limits.base.joints;
  return std::hypot(ways[joints[0]], ways[joints[1]]);
}

}  // namespace

// Which share of a row happens may be another one in the next: each goes on from the furthest that
// any of those before it can have got to.
void Prediction::note_spread() {
  const double turn_before = turn_width();
  for (const std::size_t j : JointsIn(moving_)) {
    const bool adds_up = (lagging_ & only(j)) != 0;
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const Branch& branch : branches()) {
      const double now = branch.now[j], before = branch.before[j];
      lowest = std::min(lowest, adds_up ? now + (interval_.lowest[j] - before) : now);
      highest = std::max(highest, adds_up ? now + (interval_.highest[j] - before) : now);
    }
    interval_.lowest[j] = lowest;
    interval_.highest[j] = highest;
  }
  if (share_count_ > 1) note_shares(turn_before);
}

// How far shares may have turned the base apart.
double Prediction::turn_width() const {
  if (!model_.limits.base.present) return 0.0;
  const std::size_t yaw = model_.limits.base.joints[2];
  return interval_.highest[yaw] - interval_.lowest[yaw];
}

void Prediction::note_shares(double turn_before) {
  const Branch &least = branches_[1], &most = branches_[share_count_ - 1];
  Joints lower{}, upper{};
  for (const std::size_t j : JointsIn(moving_)) {
    lower[j] = least.now[j] - least.before[j];
    upper[j] = most.now[j] - most.before[j];
  }
  note_speeds();
  for (std::size_t part = 0; part < model_.limits.parts.size(); ++part) {
    UnequalShares& shares = unequal_shares_[part];
    if (rows_shared_ == 0) shares.begin(model_.part_joints[part] & moving_);
    shares.add_row({lower, upper, shared_by_[part]});
    speeds_differ_ |=
        shares.widen_speeds(model_.period_s, way_less_, way_more_, speeds_.lowest, speeds_.highest);
  }
  ++rows_shared_;
  if (turn_before > 0.0) turned_off_ += turn_before * slide_way(model_, upper);
}

// Of the branches; unequal shares widen them.
void Prediction::note_speeds() {
  for (const std::size_t j : JointsIn(moving_)) {
    double &lowest = speeds_.lowest[j], &highest = speeds_.highest[j];
    lowest = highest = branches().front().speed[j];
    for (const Branch& branch : branches()) {
      lowest = smaller(lowest, branch.speed[j]);
      highest = larger(highest, branch.speed[j]);
    }
  }
}

// G026, of what any shares make of a tool motion that goes on from what is left.
Evidence Prediction::check_speeds() const {
  if (!speeds_differ_) return {};
  for (const std::size_t j : JointsIn(commanded_)) {
    const JointLimits& joint = model_.limits.joints[j];
    if (!shared_by_[joint.part].goes_on) continue;
    const double speed = larger(-speeds_.lowest[j], speeds_.highest[j]);
    if (speed <= joint.velocity_limit) continue;
    return of(above(code::speed, joint.name.view(), speed, joint.velocity_limit,
                    velocity_unit(joint.kind), joint.source.view()),
              model_.limits.parts[joint.part].name);
  }
  return {};
}

Branch Prediction::with_speeds(bool highest) const {
  Branch branch = branches_.front();
  for (const std::size_t j : JointsIn(moving_))
    branch.speed[j] = (highest ? speeds_.highest : speeds_.lowest)[j];
  return branch;
}

void Prediction::raise_off(const Joints& lower, const Joints& upper, Joints& off) const {
  const Branch &least = branches_[1], &most = branches_[share_count_ - 1];
  Joints stop{}, ways{};
  for (const std::size_t j : JointsIn(moving_)) {
    ways[j] = upper[j] - most.now[j];
    stop[j] = ways[j] - (lower[j] - least.now[j]);
  }
  Joints raised{};
  for (std::size_t part = 0; part < model_.limits.parts.size(); ++part) {
    unequal_shares_[part].raise_to_bound(nullptr, raised);
    unequal_shares_[part].raise_to_bound(&stop, raised);
  }
  if (turn_width() > 0.0)
    for (const std::size_t slide : {model_.limits.base.joints[0], model_.limits.base.joints[1]})
      raised[slide] += turned_off_ + turn_width() * slide_way(model_, ways);
  for (std::size_t j = 0; j < off.size(); ++j) off[j] = larger(off[j], raised[j]);
}

}  // namespace fairlead
