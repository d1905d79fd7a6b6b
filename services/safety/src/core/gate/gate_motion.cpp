// What moves: the rows that acted, in which mode each part still moves, and whether the rows that
// act next still may.

#include "core/gate/gate_core.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/modes/standstill.hpp"

namespace fairlead {
namespace {

const ActionPart* command_of(const ActionChunk& chunk, std::size_t part) {
  for (const ActionPart& action : chunk.parts)
    if (action.part == part) return &action;
  return nullptr;
}

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

// What acts in the tick before the first open one: measured in lockstep, expected in realtime.
Acted Gate::Core::act_before(const LiveClaim& claim) const {
  return hal_.lockstep() ? acted_of(claim) : claim.plan.expected();
}

// The row that the claim's parts executed. A part that its chunk did not address held beside it;
// any other mixture is an act that nothing can continue from (verdict 0).
Acted Gate::Core::acted_of(const LiveClaim& claim) const {
  constexpr Acted unknown{.hold = 0};
  const FixedVec<Acted, max_parts>& acted = hal_.state().acted;
  Acted act = acted[claim.limits.parts[0]];
  for (const std::size_t part : claim.limits.parts) {
    if (acted[part].hold != 0) continue;
    if (act.hold == 0 && !same_act(act, acted[part])) return unknown;
    act = acted[part];
  }
  const RowBefore row = claim.plan.row_of(act);
  if (row.chunk == nullptr) return act;
  for (const ActionPart& part : row.chunk->parts)
    if (acted[part.part].hold != 0) return unknown;
  return act;
}

RowBefore Gate::Core::row_before(const LiveClaim& claim) const {
  RowBefore before = claim.plan.row_of(act_before(claim));
  before.measured = hal_.lockstep();
  before.memories = &memories_;
  return before;
}

// What the other claims' parts do from the first open tick on, as far as it is released.
FixedVec<Companion, max_claims> Gate::Core::companions_of(const LiveClaim& claim) const {
  FixedVec<Companion, max_claims> companions;
  for (const LiveClaim& other : claims_.places()) {
    if (!other.live() || other.id == claim.id) continue;
    Companion companion{row_before(other)};
    const Released* release = other.plan.current();
    // Rows are released from the first open tick on, never later.
    if (release != nullptr &&
        first_open_tick() >= release->first_tick) {  // GCOVR_EXCL_BR_LINE: see above
      companion.chunk = &other.plan.chunk_of(*release);
      companion.row = release->first_row + (first_open_tick() - release->first_tick);
      companion.end_row = release->first_row + release->row_count;
    }
    (void)companions.push_back(companion);
  }
  return companions;
}

// Nothing is known of what happened before arming.
void Gate::Core::begin_memories() {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const ReleasedRows released = memories_[i].released;  // the HAL may not know yet
    memories_[i] = PartMemory{};
    memories_[i].released = released;
    if (part_at_standstill(limits_, hal_.state(), limits_.parts[i]))
      memories_[i].goal = tool_of(i, hal_.state());
    else
      memories_[i].kind = PartMemory::Kind::unknown;
  }
}

// What a part was told in the tick before the newest state; of no action if nobody remembers.
Setpoint Gate::Core::acted_row(std::size_t part) const {
  const LiveClaim* claim = claims_.holder_of(part);
  const RowBefore row =
      claim != nullptr ? claim->plan.row_of(hal_.state().acted[part]) : RowBefore{};
  const ActionPart* action = row.chunk != nullptr ? command_of(*row.chunk, part) : nullptr;
  return action != nullptr ? row_of(*action, row.row, limits_) : Setpoint{};
}

// By what each part did in the tick before the newest state, which began at `before`.
void Gate::Core::update_memories(const MeasuredState& before) {
  const Switch composite = switched();
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    PartMemory& memory = memories_[i];
    if (may_have_acted(i)) memory.note_unseen();
    const bool holds = hal_.state().acted[i].hold != 0;
    const Setpoint row = holds ? Setpoint{} : acted_row(i);
    if (!holds && row.action != nullptr)
      note_acted(memory, row);
    else if (!holds)
      memory.note_forgotten(modes_of(limits_.parts[i]));
    else if (part_at_standstill(limits_, hal_.state(), limits_.parts[i]))
      memory.rest();
    note_goal(i, row, composite, before);
  }
  forget_held();
}

// Which way a controller was switched in that tick: down where nothing told it.
Switch Gate::Core::switched() const {
  Switch found = Switch::negative;
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const bool is_switch =
        limits_.parts[i].modes.supports(static_cast<std::uint8_t>(Mode::composite_mode));
    if (!is_switch || hal_.state().acted[i].hold != 0) continue;
    const Setpoint row = acted_row(i);
    found = row.action != nullptr ? switch_of(row[0]) : Switch::unknown;
  }
  return found;
}

Pose Gate::Core::tool_of(std::size_t part, const MeasuredState& state) const {
  return link_pose(limits_.kinematics, state, 0, limits_.parts[part].tool);
}

// A controller brings a tool on from where it was when the tick began; where the composite switch
// is up, from its last goal: what it has not made of that is left for the next tick. A hold is a
// motion of nothing with the switch down.
void Gate::Core::note_goal(std::size_t part, const Setpoint& row, Switch switched,
                           const MeasuredState& before) {
  std::optional<Pose>& goal = memories_[part].goal;
  if (hal_.state().acted[part].hold != 0) {
    const bool stands = memories_[part].kind == PartMemory::Kind::none;
    if (before.tick + 1 == hal_.tick())
      goal = tool_of(part, before);
    else if (stands)
      goal = tool_of(part, hal_.state());
    else
      goal.reset();
    return;
  }
  const bool is_known = row.action != nullptr && is_tool_motion(row.action->mode) &&
                        switched != Switch::unknown && before.tick + 1 == hal_.tick();
  if (!is_known) return goal.reset();
  if (switched == Switch::negative) goal = tool_of(part, before);
  if (!goal) return;
  const Kinematics& tree = limits_.kinematics;
  const double period_s = static_cast<double>(limits_.period_ns) * 1e-9;
  goal = moved(*goal, link_pose(tree, before, 0, tree.find(row.action->frame_id)).rotation,
               tick_motion(row, period_s));
}

// Also while disarmed: what a part could have done before it held says nothing of later ticks.
void Gate::Core::forget_held() {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i)
    if (hal_.state().acted[i].hold != 0) memories_[i].released.hold(hal_.tick() - 1);
}

// The newest release of a claim has gone out.
void Gate::Core::note_released(const LiveClaim& claim) {
  const Released& release = *claim.plan.current();
  for (const ActionPart& action : claim.plan.chunk_of(release).parts)
    memories_[action.part].released.add(action, release.first_tick, release.end_tick());
}

// A state tells what acted in the tick before it. Of the ticks before that, which had a state each
// that was lost, it is only known what had been released.
bool Gate::Core::may_have_acted(std::size_t part) const {
  return hal_.tick() - seen_tick_ > 1 && memories_[part].released.end_tick > seen_tick_;
}

// The HAL may still execute a row of a claim that ends here.
void Gate::Core::keep_memories(const LiveClaim& claim) {
  const Released* release = claim.plan.current();
  if (release == nullptr) return;
  for (const ActionPart& action : claim.plan.chunk_of(*release).parts)
    memories_[action.part].add(action);
}

// The rows that act next were released from an older state. What they may not do in this one is a
// stop: the HAL has them already. Other limits cannot be broken by a newer state.
Evidence Gate::Core::check_live_rows() const {
  for (const LiveClaim& claim : claims_.places()) {
    if (!claim.live()) continue;
    Acted next = claim.plan.expected();
    if (!hal_.lockstep()) ++next.row;  // the row of this tick acts already
    const RowBefore row = claim.plan.row_of(next);
    if (row.chunk == nullptr) continue;
    const Evidence evidence =
        check_running(limits_, claim.limits, hal_.state(), *row.chunk, row.row);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

}  // namespace fairlead
