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

bool is_switch(const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::composite_mode);
}

// In realtime the newest state was measured before the row of its own tick. Without a row that acts
// before it is the memories that say what the switch turns from.
bool rests(const ClaimLimits& claim, const RowBefore& before) {
  if (before.measured) return true;
  if (before.chunk != nullptr) return false;
  for (const std::size_t part : claim.parts)
    if ((*before.memories)[part].kind != PartMemory::Kind::none) return false;
  return true;
}

// What a part's switch turns from.
Switch switched_before(const Limits& limits, const RowBefore& before, std::size_t part) {
  const Setpoint acted = command_of(part, before, limits);
  if (acted.action != nullptr) return switch_of(acted[0]);
  if (before.chunk != nullptr) return Switch::negative;  // left out of that row, it is down
  return before.memories != nullptr ? (*before.memories)[part].composite : Switch::none;
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

Evidence check_switch(const Limits& limits, const MeasuredState& state, const ClaimLimits& claim,
                      const RowBefore& before, std::size_t part, const Setpoint& now) {
  const ScalarLimits& mode = claim.modes[part].composite_mode;
  const bool left_out = now.action == nullptr;
  if (!mode.supported || mode.switches_anywhere) return {};
  const double value = left_out ? -1.0 : now[0];
  const Switch from = switched_before(limits, before, part);
  if (from == Switch::none || from == switch_of(value)) return {};
  if (!rests(claim, before))
    return broken_rule(code::change, left_out ? "composite left out" : "composite",
                       "standstill after a held tick", value);
  for (const std::size_t other : claim.parts) {
    const Evidence still =
        check_still(code::change, limits, state, limits.parts[other], switch_rule);
    if (!still.ok()) return still;
  }
  return {};
}

Evidence check_later_switch(const RowView& view) {
  if (!is_switch(*view.now.action) || view.modes.composite_mode.switches_anywhere ||
      switch_of(view.previous[0]) == switch_of(view.now[0]))
    return {};
  return broken_rule(code::change, "composite", "a first row, and standstill", view.now[0],
                     view.previous[0]);
}

}  // namespace fairlead
