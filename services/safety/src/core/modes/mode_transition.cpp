#include "core/modes/row_limit_check.hpp"

#include <bit>

#include "core/chunk/state_check.hpp"

namespace fairlead {
namespace {

constexpr std::string_view still_rule = "a part changes its mode or frame at standstill only";
constexpr std::string_view switch_rule = "standstill, to turn the composite switch";

// Every mode that the last row may have been of; the part's transitions know the new one after it.
Evidence check_listed(const RowView& view, std::uint16_t acted_modes) {
  const std::uint8_t mode = view.mode();
  for (unsigned left = acted_modes; left != 0; left &= left - 1U) {
    const auto from = static_cast<std::uint8_t>(std::countr_zero(left));
    if (from == mode || (view.part().followers[from] & PartMemory::mode_bit(mode)) != 0) continue;
    return broken_rule(code::change, "mode",
                       "a mode that the part's transitions allow after the one that acted last",
                       mode, from);
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
  return broken_rule(code::change, "mode",
                     "a part changes its mode or frame at standstill only, after a tick without a "
                     "row for it",
                     action.mode, from);
}

Evidence check_switch(const RowView& view, const ClaimLimits& claim, const RowBefore& before,
                      const Setpoint& acted) {
  if (turns_anywhere(view)) return {};
  Switch from = Switch::none;
  if (acted.action != nullptr)
    from = switch_of(acted[0]);
  else if (before.chunk != nullptr)
    from = Switch::negative;  // left out of the row that acts, it is down
  else if (before.memories != nullptr)
    from = (*before.memories)[view.now.action->part].composite;
  if (from == Switch::none || from == switch_of(view.now[0])) return {};
  if (!rests(claim, before))
    return broken_rule(code::change, "composite",
                       "standstill after a tick without a row, to turn the composite switch",
                       view.now[0]);
  for (const std::size_t part : claim.parts) {
    const Evidence still =
        check_still(code::change, view.limits, view.state, view.limits.parts[part], switch_rule);
    if (!still.ok()) return still;
  }
  return {};
}

Evidence check_later_switch(const RowView& view) {
  if (turns_anywhere(view) || switch_of(view.previous[0]) == switch_of(view.now[0])) return {};
  return broken_rule(code::change, "composite",
                     "the first row of a chunk and standstill, to turn the composite switch",
                     view.now[0], view.previous[0]);
}

}  // namespace fairlead
