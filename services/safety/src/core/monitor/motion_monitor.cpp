#include "core/monitor/motion_monitor.hpp"

#include "core/chunk/state_check.hpp"
#include "core/monitor/tracking.hpp"

namespace fairlead {

void MotionMonitor::begin() {
  knows_before_ = false;
  stuck_.clear();
  grasp_.clear();
}

Evidence MotionMonitor::check(const MeasuredState& before, const MeasuredState& now,
                              const ClaimTable& claims) {
  Evidence evidence = knows_before_ ? check_jump(limits_, before, now) : Evidence{};
  if (!evidence.ok()) return evidence;
  stuck_.note_state(limits_, now);
  evidence = check_contact(limits_, now);
  for (std::size_t part = 0; part != limits_.parts.size() && evidence.ok(); ++part) {
    evidence = check_part(part, before, now, claims);
    if (!evidence.ok()) evidence = of(evidence, limits_.parts[part].name);
  }
  if (evidence.ok()) knows_before_ = true;
  return evidence;
}

// Not judged: a part that held, and a row of a claim that has ended or whose numbers are gone.
Evidence MotionMonitor::check_part(std::size_t part, const MeasuredState& before,
                                   const MeasuredState& now, const ClaimTable& claims) {
  const LiveClaim* claim = claims.holder_of(part);
  if (claim == nullptr) {
    grasp_.forget(part);
    return {};
  }
  const ReleasePlan& plan = claim->plan;
  const Acted& act = now.acted[part];
  const Setpoint row = command_of(part, plan.row_of(act), limits_);
  Evidence evidence = grasp_.note(limits_, now, part, row);
  if (!evidence.ok() || row.action == nullptr) return evidence;
  Setpoint previous = command_of(part, plan.row_of(plan.act_before(act)), limits_);
  // Another mode or frame was left at standstill.
  if (previous.action != nullptr && (previous.action->mode != row.action->mode ||
                                     !(previous.action->frame_id == row.action->frame_id)))
    previous = Setpoint{};
  const MotionView view{model_,
                        claim->limits.modes[part],
                        before,
                        now,
                        knows_before_ && before.tick + 1 == now.tick,
                        row,
                        previous};
  evidence = check_tracking(view);
  return evidence.ok() && knows_before_ ? stuck_.after_row(view) : evidence;
}

}  // namespace fairlead
