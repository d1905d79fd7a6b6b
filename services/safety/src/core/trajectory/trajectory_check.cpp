#include "core/trajectory/trajectory_check.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "core/geometry/distances.hpp"
#include "core/kinematics/inverse_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/stop_cells.hpp"

namespace fairlead {

TrajectoryCheck::TrajectoryCheck(const RobotModel& model, const ClaimLimits& claim,
                                 const MeasuredState& state, const ActionChunk& chunk,
                                 const JudgedRows& rows, const RowBefore& before,
                                 Companions companions)
    : model_(model),
      chunk_(chunk),
      certified_end_(rows.certified_end),
      prediction_(model, claim, state, chunk, rows.first, before, companions),
      shape_check_(model,
                   prediction_.drives_base() ? prediction_.commanded() | model.tree_joints
                                             : prediction_.commanded(),
                   prediction_.guessed()),
      budget_(rows.queries) {
  if (prediction_.is_start_off()) deviate_by(prediction_.start_off());
  if (const std::optional<Joints> targets = prediction_.last_targets()) {
    targets_before_.place(model, *targets);
    shape_check_.note_targets_before(targets_before_);
  }
}

Evidence TrajectoryCheck::check_next() {
  Evidence evidence;
  expect_drift();
  if (!has_begun_) note_singular_starts();
  if (!has_begun_) evidence = check_momentum();
  has_begun_ = true;
  if (prediction_.next_row() == certified_end_) prediction_.only_forecast();
  const Evidence unreachable = prediction_.advance();
  expect_drift();
  expect_unequal_shares();
  if (!unreachable.ok()) evidence = unreachable;
  for (std::size_t i = 0; i < prediction_.branch_count() && evidence.ok(); ++i)
    evidence = check_branch(i);
  if (evidence.ok()) evidence = check_between_shares();
  if (evidence.ok()) evidence = check_other_speeds();
  if (!evidence.ok()) evidence.row = static_cast<std::int64_t>(prediction_.row());
  return evidence;
}

// What a base carries lags behind it, whatever is commanded: the faster it drives, the more.
void TrajectoryCheck::expect_drift() {
  const double speed = prediction_.base_speed();
  const BaseLimits& base = model_.limits.base;
  if (base.present) shape_check_.drift_by(speed * base.tool_drift, speed * base.clearance_drift);
}

// Of the rows that have branches any other share may happen in each: that leads beside them, and
// braking from there beside where it ends for them.
void TrajectoryCheck::expect_unequal_shares() {
  shape_check_.begin_row();
  base_off_ = {.before = base_off_.now};
  Joints off = prediction_.start_off();
  const bool is_turned = prediction_.turn_off() > 0.0, is_shared = prediction_.shares_can_differ();
  if (is_shared) raise_by_unequal_shares(off);
  if (is_turned) raise_by_turn(off);
  if (is_shared || is_turned || prediction_.is_start_off()) deviate_by(off);
}

void TrajectoryCheck::deviate_by(const Joints& off) {
  shape_check_.deviate_by(off);
  if (model_.limits.base.present) base_off_.now = base_way(model_, off);
}

// What the base drives since it was measured, and to its end, may be turned about where it was.
void TrajectoryCheck::raise_by_turn(Joints& off) const {
  const auto& joints = model_.limits.base.joints;
  const Joints& from = prediction_.measured().now;
  double way = 0.0;
  for (std::size_t i = 0; i < prediction_.branch_count(); ++i) {
    const Braking braking = braking_of(prediction_.branch(i));
    const Joints& end = braking.end();
    way =
        larger(way, std::hypot(end[joints[0]] - from[joints[0]], end[joints[1]] - from[joints[1]]));
  }
  for (const std::size_t slide : {joints[0], joints[1]}) off[slide] += prediction_.turn_off() * way;
}

void TrajectoryCheck::raise_by_unequal_shares(Joints& start_off) const {
  const Branch &least = prediction_.branch(1),
               &most = prediction_.branch(prediction_.share_count() - 1);
  Joints off;
  off.fill(0.0);
  const auto raise = [&](const Branch& lower, const Branch& upper) {
    prediction_.raise_off(braking_of(lower).end(), braking_of(upper).end(), off);
  };
  raise(least, most);
  if ((least.slowing | most.slowing) != 0) raise(least.slowed(), most.slowed());
  if (prediction_.speeds_can_differ()) raise_by_other_stops(least, most, off);
  for (std::size_t j = 0; j < off.size(); ++j) start_off[j] += off[j];
}

// By as much as a joint stops later than behind its faster branch, or earlier than behind the
// slower.
void TrajectoryCheck::raise_by_other_stops(const Branch& least, const Branch& most,
                                           Joints& off) const {
  const Branch slow = prediction_.with_speeds(false), fast = prediction_.with_speeds(true);
  const Braking lower = braking_of(least), upper = braking_of(most), slowest = braking_of(slow),
                fastest = braking_of(fast);
  for (const std::size_t j : JointsIn(prediction_.moving())) {
    const double one = lower.end()[j] - least.now[j], other = upper.end()[j] - most.now[j];
    off[j] += larger(fastest.end()[j] - fast.now[j] - larger(one, other),
                     smaller(one, other) - (slowest.end()[j] - slow.now[j]));
  }
}

// G024 of joints as fast as any shares can make them.
Evidence TrajectoryCheck::check_other_speeds() const {
  Evidence evidence;
  for (const bool highest : {false, true}) {
    if (!prediction_.speeds_can_differ() || !evidence.ok()) return evidence;
    const Branch branch = prediction_.with_speeds(highest);
    evidence = check_braking(model_, branch, braking_of(branch).end(), prediction_.interval(),
                             prediction_.commanded());
  }
  return evidence;
}

Braking TrajectoryCheck::braking_of(const Branch& branch) const {
  return {model_, branch, prediction_.moving(), prediction_.lagging()};
}

// Whatever the rows say, what is measured may go on for a tick, and brake then; so may what the row
// that acts already leads to.
Evidence TrajectoryCheck::check_momentum() {
  Evidence evidence = check_momentum_of(prediction_.measured());
  for (std::size_t i = 0; i < prediction_.start_count() && evidence.ok(); ++i)
    evidence = check_momentum_of(prediction_.branch(i));
  return evidence;
}

Evidence TrajectoryCheck::check_momentum_of(const Branch& start) {
  if (!prediction_.is_coasting(start)) return {};  // before the copy, which costs more than that
  Branch branch = start;
  prediction_.coast_one_tick(branch);
  Clearance clearance;
  const Braking braking = braking_of(branch);
  Evidence evidence = check_body(branch, braking, Interval{branch.now, branch.now}, clearance);
  // One joint may go on while another is told to stop, and does.
  if (evidence.ok() && !shape_check_.has_nothing())
    evidence = certify_stops(branch, branch.before, braking);
  return evidence.ok() ? check_zones(branch, braking) : evidence;
}

Evidence TrajectoryCheck::check_branch(std::size_t index) {
  const Branch& branch = prediction_.branch(index);
  if (branch.slowing != 0) {
    Clearance clearance = clearances_[index];
    const Evidence evidence = check_row(branch.slowed(), clearance);
    if (!evidence.ok()) return evidence;
  }
  return check_row(branch, clearances_[index]);
}

Evidence TrajectoryCheck::check_row(const Branch& branch, Clearance& clearance) {
  const Braking braking = braking_of(branch);
  Evidence evidence = check_body(branch, braking, prediction_.interval(), clearance);
  if (evidence.ok()) evidence = check_singularities(branch, braking);
  if (evidence.ok()) evidence = check_zones(branch, braking);
  return evidence;
}

// Bounds, volumes and pairs.
Evidence TrajectoryCheck::check_body(const Branch& branch, const Braking& braking,
                                     const Interval& interval, Clearance& clearance) {
  const Evidence evidence =
      check_braking(model_, branch, braking.end(), interval, prediction_.commanded());
  if (evidence.ok() && !shape_check_.has_nothing()) return check_shapes(branch, braking, clearance);
  return evidence;
}

// What any other share of the rows makes of them: straight from one end of a part's gain to the
// other, whichever end of the others happens.
Evidence TrajectoryCheck::check_between_shares() {
  Evidence evidence;
  for (std::size_t i = 0; i < prediction_.branch_count(); ++i)
    for (std::size_t bit = 1; bit < prediction_.share_count() && evidence.ok(); bit <<= 1U)
      if (prediction_.has_lower_end(i, bit)) evidence = check_between(i, i + bit);
  return evidence;
}

// Where the row leads, and where braking from there ends.
Evidence TrajectoryCheck::check_between(std::size_t one, std::size_t other) {
  const Branch &from = prediction_.branch(one), &to = prediction_.branch(other);
  const Evidence evidence =
      certify_between(from, {from.now, to.now}, &clearances_[one], &clearances_[other]);
  if (!evidence.ok()) return evidence;
  const Braking first = braking_of(from), second = braking_of(to);
  return certify_between(from, {first.end(), second.end()}, nullptr, nullptr);
}

Evidence TrajectoryCheck::certify_between(const Branch& one, const StraightMotion& motion,
                                          const Clearance* at_start, const Clearance* at_end) {
  const DisplacementBound bound(model_, motion.from, motion.to);
  const auto clear_by = [&](const Clearance* at) {
    return at == nullptr ? 0.0 : shape_check_.clear_fraction_of(*at, bound);
  };
  Evidence evidence;
  if (!shape_check_.has_nothing())
    evidence = certify(motion, shapes(one, bound, between_), clear_by(at_start), clear_by(at_end));
  if (!evidence.ok() || !commands_base()) return evidence;
  return certify(motion, zones(one, base_way(model_, motion.from, motion.to)), 0.0, 0.0);
}

ShapeConstraint TrajectoryCheck::shapes(const Branch& branch, const DisplacementBound& bound,
                                        FramePoses& room) {
  return {model_, shape_check_, branch.poses_before(), bound, room, budget_};
}

ZoneConstraint TrajectoryCheck::zones(const Branch& branch, double way) {
  return {model_, branch.before, way, base_off_, budget_};
}

// Where the row leads, on the way there, where braking from there ends, on the way to that.
Evidence TrajectoryCheck::check_shapes(const Branch& branch, const Braking& braking,
                                       Clearance& clearance) {
  const DisplacementBound row(model_, branch.before, branch.now),
      stop(model_, branch.now, braking.end());
  const double clear_before = shape_check_.clear_fraction_of(clearance, row);
  Evidence evidence = budget_.take();
  if (evidence.ok())
    evidence = shape_check_.check(branch.poses_now(), branch.poses_before(),
                                  DisplacementBound(row, stop), clearance);
  if (!evidence.ok()) return evidence;
  evidence = certify(StraightMotion{branch.before, branch.now}, shapes(branch, row, between_),
                     clear_before, shape_check_.clear_fraction_of(clearance, row));
  if (!evidence.ok()) return evidence;
  const double clear = shape_check_.clear_fraction_of(clearance, stop);
  evidence = certify_to_end(braking, shapes(branch, stop, rest_), clear);
  // Clear by the whole way of all is clear by each joint's.
  if (!evidence.ok() || clear >= 1.0 || prediction_.is_forecast()) return evidence;
  return certify_stops(branch, branch.now, braking);
}

// Each joint stops by itself, anywhere from there to where it was declared to come to rest.
Evidence TrajectoryCheck::certify_stops(const Branch& branch, const Joints& from,
                                        const Braking& braking) {
  return StopCells(model_, shape_check_, branch.poses_before(), budget_, rest_, between_)
      .certify(from, braking.end());
}

Evidence TrajectoryCheck::check_zones(const Branch& branch, const Braking& braking) {
  if (!commands_base()) return {};
  const double row = base_way(model_, branch.before, branch.now);
  double margin = unset;
  Evidence evidence = budget_.take();
  if (evidence.ok()) evidence = check_base(model_, branch.now, branch.before, base_off_, margin);
  if (!evidence.ok()) return evidence;
  evidence = certify(StraightMotion{branch.before, branch.now}, zones(branch, row), 0.0,
                     clear_fraction(margin, row));
  if (!evidence.ok()) return evidence;
  const double stop = base_way(model_, branch.now, braking.end());
  return certify_to_end(braking, zones(branch, stop), clear_fraction(margin, stop));
}

}  // namespace fairlead
