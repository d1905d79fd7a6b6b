#include "core/modes/row_limit_check.hpp"

#include <bit>

#include "core/chunk/state_check.hpp"

namespace fairlead {
namespace {

constexpr std::string_view still_rule = "standstill, to change mode or frame";
constexpr std::string_view switch_rule = "standstill, to turn the composite switch";

// Every mode that the last row may have been of; the part's transitions know the new one after it.
Evidence check_listed(const RowView& view, std::uint16_t acted_modes) {
  const std::uint8_t mode = view.mode();
  for (unsigned left = acted_modes; left != 0; left &= left - 1U) {
    const auto from = static_cast<std::uint8_t>(std::countr_zero(left));
    if (from == mode || (view.part().followers[from] & PartMemory::mode_bit(mode)) != 0) continue;
    return broken_rule(code::change, "mode", "a change in its transitions", mode, from);
  }
  return {};
}

bool turns_anywhere(const RowView& view) {
  return view.mode() != static_cast<std::uint8_t>(Mode::composite_mode) ||
         view.modes.composite_mode.switches_anywhere;
}

// In realtime the newest state was measured before the row of its own tick. Without a row that acts
// before it is the memories that told what the switch turns from.
bool rests(const ClaimLimits& claim, const RowBefore& before) {
  if (before.measured) return true;
  if (before.chunk != nullptr) return false;
  for (const std::size_t part : claim.parts)
    if ((*before.memories)[part].kind != PartMemory::Kind::none) return false;
  return true;
}

// What a switch turns from. `acted`: what the row that acts before tells it.
Switch switched_before(const RowBefore& before, std::size_t part, const Setpoint& acted) {
  if (acted.action != nullptr) return switch_of(acted[0]);
  if (before.chunk != nullptr) return Switch::negative;  // left out of that row, it is down
  return before.memories != nullptr ? (*before.memories)[part].composite : Switch::none;
}

Evidence check_turn(const Limits& limits, const MeasuredState& state, const ClaimLimits& claim,
                    const RowBefore& before, std::string_view axis, double value) {
  if (!rests(claim, before))
    return broken_rule(code::change, axis, "standstill after a held tick", value);
  for (const std::size_t part : claim.parts) {
    const Evidence still =
        check_still(code::change, limits, state, limits.parts[part], switch_rule);
    if (!still.ok()) return still;
  }
  return {};
}

}  // namespace

// In lockstep the state was measured after the row that acts before, so standstill is all it takes;
// in realtime it was measured before that row, so only a state after a tick without a row can show
// it, and such a state ends the memory.
Evidence check_change(const RowView& view, const RowBefore& before, const ActionPart* last) {
  static const PartMemory nothing;
  const ActionPart& action = *view.now.action;
  const PartMemory& memory = before.memories != nullptr ? (*before.memories)[action.part] : nothing;
  const Evidence listed =
      check_listed(view, last != nullptr ? PartMemory::mode_bit(last->mode) : memory.acted_modes);
  const bool differs = last != nullptr ? !is_alike(*last, action) : memory.differs(action);
  if (!listed.ok() || !differs) return listed;
  if (before.measured)
    return check_still(code::change, view.limits, view.state, view.part(), still_rule);
  std::uint8_t from = action.mode;
  if (memory.kind == PartMemory::Kind::known) from = memory.mode;
  if (last != nullptr) from = last->mode;
  return broken_rule(code::change, "mode", "standstill after a held tick", action.mode, from);
}

Evidence check_switch(const RowView& view, const ClaimLimits& claim, const RowBefore& before,
                      const Setpoint& acted) {
  if (turns_anywhere(view)) return {};
  const Switch from = switched_before(before, view.now.action->part, acted);
  if (from == Switch::none || from == switch_of(view.now[0])) return {};
  return check_turn(view.limits, view.state, claim, before, "composite", view.now[0]);
}

Evidence check_left_out(const Limits& limits, const MeasuredState& state, const ClaimLimits& claim,
                        const RowBefore& before, std::size_t part) {
  if (!limits.parts[part].modes.composite_mode.supported ||
      claim.modes[part].composite_mode.switches_anywhere)
    return {};
  const Switch from = switched_before(before, part, told_to(part, before, limits));
  if (from == Switch::none || from == Switch::negative) return {};
  return check_turn(limits, state, claim, before, "composite left out", -1.0);
}

Evidence check_later_switch(const RowView& view) {
  if (turns_anywhere(view) || switch_of(view.previous[0]) == switch_of(view.now[0])) return {};
  return broken_rule(code::change, "composite", "a first row, and standstill", view.now[0],
                     view.previous[0]);
}

}  // namespace fairlead
