#include "core/release/part_history.hpp"

#include "core/chunk/state_check.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/release/claim_table.hpp"

namespace fairlead {
namespace {

// A mode without a checker never acts.
std::uint16_t modes_of(const PartLimits& part) {
  std::uint16_t modes = 0;
  for (std::uint8_t mode = 0; mode != mode_count; ++mode)
    if (part.modes.supports(mode)) modes |= PartMemory::mode_bit(mode);
  return modes;
}

void note_acted(PartMemory& memory, const Setpoint& row) {
  memory.note(*row.action);
  memory.released.act(*row.action);
  memory.acted_modes = PartMemory::mode_bit(row.action->mode);
  if (row.action->mode == static_cast<std::uint8_t>(Mode::composite_mode))
    memory.composite = switch_of(row[0]);
}

}  // namespace

void PartHistory::begin(const MeasuredState& state) {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const ReleasedRows released = memories_[i].released;  // the HAL may not know yet
    memories_[i] = PartMemory{};
    memories_[i].released = released;
    if (part_at_standstill(limits_, state, limits_.parts[i]))
      memories_[i].goal = tool_of(i, state);
    else
      memories_[i].kind = PartMemory::Kind::unknown;
  }
}

void PartHistory::begin_session() {
  for (PartMemory& memory : memories_) memory.released = ReleasedRows{};
}

// What a part was commanded in the tick before the newest state; of no action if nobody remembers.
Setpoint PartHistory::acted_row(std::size_t part, const MeasuredState& now,
                                const ClaimTable& claims) const {
  const LiveClaim* claim = claims.holder_of(part);
  const RowBefore row = claim != nullptr ? claim->plan.row_of(now.acted[part]) : RowBefore{};
  return command_of(part, row, limits_);
}

void PartHistory::update(const MeasuredState& before, const MeasuredState& now,
                         const ClaimTable& claims) {
  const Switch composite = switched(now, claims);
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    PartMemory& memory = memories_[i];
    if (may_have_acted(i, now.tick)) memory.note_unseen();
    const bool holds = now.acted[i].hold != 0;
    const Setpoint row = holds ? Setpoint{} : acted_row(i, now, claims);
    if (!holds && row.action != nullptr)
      note_acted(memory, row);
    else if (!holds)
      memory.note_forgotten(modes_of(limits_.parts[i]));
    else if (part_at_standstill(limits_, now, limits_.parts[i]))
      memory.rest();
    if (holds && is_left_out(i, now, claims)) memory.composite = Switch::negative;
    note_goal(i, row, composite, before, now);
  }
  forget_held(now);
}

// A switch that the rows of its claim left out: that turns it down.
bool PartHistory::is_left_out(std::size_t part, const MeasuredState& now,
                              const ClaimTable& claims) const {
  if (!limits_.parts[part].modes.composite_mode.supported) return false;
  const LiveClaim* claim = claims.holder_of(part);  // none: it has ended since
  for (std::size_t other = 0; other < limits_.parts.size(); ++other)
    if (now.acted[other].hold == 0 && (claim == nullptr || claim->covers(other))) return true;
  return false;
}

// Which way a controller was switched in that tick: down where no row did.
Switch PartHistory::switched(const MeasuredState& now, const ClaimTable& claims) const {
  Switch found = Switch::negative;
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    if (!limits_.parts[i].modes.composite_mode.supported || now.acted[i].hold != 0) continue;
    const Setpoint row = acted_row(i, now, claims);
    found = row.action != nullptr ? switch_of(row[0]) : Switch::unknown;
  }
  return found;
}

Pose PartHistory::tool_of(std::size_t part, const MeasuredState& state) const {
  return pose_at(model_.tools[part].place, {model_, state.positions});
}

// A controller brings a tool on from where it was when the tick began; where the composite switch
// is up, from its last goal: what it has not made of that is left for the next tick. A hold is a
// motion of nothing with the switch down.
void PartHistory::note_goal(std::size_t part, const Setpoint& row, Switch switched,
                            const MeasuredState& before, const MeasuredState& now) {
  std::optional<Pose>& goal = memories_[part].goal;
  if (now.acted[part].hold != 0) {
    const bool stands = memories_[part].kind == PartMemory::Kind::none;
    if (before.tick + 1 == now.tick)
      goal = tool_of(part, before);
    else if (stands)
      goal = tool_of(part, now);
    else
      goal.reset();
    return;
  }
  const bool is_known = row.action != nullptr && is_tool_motion(row.action->mode) &&
                        switched != Switch::unknown && before.tick + 1 == now.tick;
  if (!is_known) return goal.reset();
  if (switched == Switch::negative) goal = tool_of(part, before);
  if (goal) goal = moved(*goal, tick_motion(model_, {model_, before.positions}, row));
}

void PartHistory::forget_held(const MeasuredState& now) {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i)
    if (now.acted[i].hold != 0) memories_[i].released.hold(now.tick - 1);
}

void PartHistory::note_released(const LiveClaim& claim) {
  const Released& release = *claim.plan.current();
  for (const ActionPart& action : claim.plan.chunk_of(release).parts)
    memories_[action.part].released.add(action, release.first_tick, release.end_tick());
}

void PartHistory::keep(const LiveClaim& claim) {
  const Released* release = claim.plan.current();
  if (release == nullptr) return;
  for (const ActionPart& action : claim.plan.chunk_of(*release).parts)
    memories_[action.part].add(action);
}

}  // namespace fairlead
