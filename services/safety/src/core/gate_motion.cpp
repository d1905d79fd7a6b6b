// What moves: the rows that acted, in which mode each part still moves, and whether the rows that
// act next still may.

#include "gate_core.hpp"
#include "row_view.hpp"
#include "standstill.hpp"

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
    if (!part_at_standstill(limits_, hal_.state(), limits_.parts[i]))
      memories_[i].kind = PartMemory::Kind::unknown;
  }
}

// By what each part did in the tick before the newest state.
void Gate::Core::update_memories() {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const Acted& act = hal_.state().acted[i];
    PartMemory& memory = memories_[i];
    if (may_have_acted(i)) memory.note_unseen();
    if (act.hold != 0) {
      if (part_at_standstill(limits_, hal_.state(), limits_.parts[i])) memory.rest();
      continue;
    }
    const LiveClaim* claim = claims_.holder_of(i);
    const RowBefore row = claim != nullptr ? claim->plan.row_of(act) : RowBefore{};
    const ActionPart* action = row.chunk != nullptr ? command_of(*row.chunk, i) : nullptr;
    if (action != nullptr)
      note_acted(memory, row_of(*action, row.row, limits_));
    else
      memory.note_forgotten(modes_of(limits_.parts[i]));
  }
  forget_held();
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
