#include "core/gate/admission.hpp"

#include <algorithm>
#include <cmath>

#include "core/wire/phrase.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

// The same alphabet as key chunks: the source becomes part of keys.
bool is_key_chunk(const Name& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  const auto is_inner = [&](char c) { return is_letter(c) || c == '_' || c == '.' || c == '-'; };
  const std::string_view text = name.view();
  return !text.empty() && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), is_inner);
}

Objection check_identity(const Limits& limits, const Claim& request) {
  if (!is_key_chunk(request.source))
    return {
        phrase("source: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit, got '",
               request.source, "'"),
        {}};
  if (request.robot_hash != limits.robot_hash)
    return {phrase("robot_hash is not that of ", limits.robot),
            phrase("fairlead robot show ", limits.robot)};
  if (request.period_ns != limits.period_ns)
    return {phrase("period: expected ", limits.period_ns, " ns, got ", request.period_ns, " ns"),
            {}};
  if (request.skill_hash == Hash{}) return {"skill_hash: expected the skill's hash, got none", {}};
  return {};
}

Objection check_budget(const Limits& limits, const Claim& request) {
  const ProtocolLimits& protocol = limits.protocol;
  if (!(request.chunk_rate_hz > 0.0 && request.chunk_rate_hz <= protocol.chunk_rate_max_hz))
    return {phrase("chunk_rate_hz: expected above 0 and at most ", protocol.chunk_rate_max_hz,
                   ", got ", request.chunk_rate_hz),
            {}};
  if (request.horizon_max < 1 || request.horizon_max > protocol.horizon_max)
    return {
        phrase("horizon_max: expected 1 to ", protocol.horizon_max, ", got ", request.horizon_max),
        {}};
  if (request.age_max_ticks > protocol.age_max_ticks)
    return {phrase("age_max_ticks: expected at most ", protocol.age_max_ticks, ", got ",
                   request.age_max_ticks),
            {}};
  return {};
}

std::size_t find_part(const Limits& limits, const Name& name) {
  std::size_t index = 0;
  while (index < limits.parts.size() && !(limits.parts[index].name == name)) ++index;
  return index;
}

Text known_parts(const Limits& limits) {
  Text list;
  for (const PartLimits& part : limits.parts)
    list.append(list.empty() ? "" : ", ").append(part.name.view());
  return list;
}

Objection take_parts(const Limits& limits, const ClaimTable& table, const Claim& request,
                     ClaimLimits& claim) {
  if (request.parts.empty()) return {"parts: expected at least one", {}};
  for (const Name& name : request.parts) {
    const std::size_t part = find_part(limits, name);
    if (part == limits.parts.size())
      return {phrase("parts: no part ", name, "; known: ", known_parts(limits)), {}};
    if (claim.parts.contains(part)) return {phrase("parts: ", name, " is named twice"), {}};
    const LiveClaim* holder = table.holder_of(part);
    if (holder != nullptr && !(holder->offered_to == request.source))
      return {phrase("part ", name, " is held by ", holder->source, " (", holder->skill, ")"),
              phrase("fairlead cancel ", holder->source, " (if no runner: end it where it began)")};
    claim.modes[part] = limits.parts[part].modes;
    (void)claim.parts.push_back(part);  // as many places as there are parts
  }
  return {};
}

// A composite switch says from where a tool goes on: turned by somebody else, it would change
// motions that are judged already.
Objection check_switches(const Limits& limits, const ClaimLimits& claim) {
  for (const std::size_t part : claim.parts) {
    if (!limits.parts[part].modes.composite_mode.supported) continue;
    for (std::size_t other = 0; other < limits.parts.size(); ++other)
      if (moves_tool(limits.parts[other].modes) && !claim.parts.contains(other))
        return {phrase("parts: expected ", limits.parts[other].name, " with ",
                       limits.parts[part].name, ", the switch of its motion"),
                {}};
  }
  return {};
}

Objection take_overrides(const Limits& limits, const Claim& request, ClaimLimits& claim) {
  for (const LimitOverride& wanted : request.limits) {
    const std::size_t part = find_part(limits, wanted.part);
    if (!claim.parts.contains(part))
      return {phrase("limits: ", wanted.part, " is not a part of this claim"), {}};
    const Text fault = tighten(limits, part, wanted, claim.modes[part]);
    if (!fault.empty()) return {fault, {}};
  }
  return {};
}

// G010: at most ceil(1.2 x rate x W) + 1 chunks in a window W of max(250 ms, 2 chunk intervals).
void set_rate(const Limits& limits, double rate_hz, LiveClaim& place) {
  const double period_s = static_cast<double>(limits.period_ns) * 1e-9;
  const double ticks = std::ceil(std::max(0.25, 2.0 / rate_hz) / period_s - 1e-9);
  place.admitted_window = static_cast<std::uint64_t>(std::min(ticks, double{UINT32_MAX}));
  const double window_s = static_cast<double>(place.admitted_window) * period_s;
  place.admitted_limit = static_cast<std::size_t>(std::ceil(1.2 * rate_hz * window_s - 1e-9)) + 1;
}

}  // namespace

Objection admit_claim(const Limits& limits, const ClaimTable& table, const Claim& request,
                      LiveClaim& place) {
  Objection objection = check_identity(limits, request);
  if (objection.none()) objection = check_budget(limits, request);
  place.limits.parts.clear();
  if (objection.none()) objection = take_parts(limits, table, request, place.limits);
  if (objection.none()) objection = check_switches(limits, place.limits);
  if (objection.none()) objection = take_overrides(limits, request, place.limits);
  if (!objection.none()) return objection;
  place.limits.horizon_max = request.horizon_max;
  place.limits.age_max_ticks = request.age_max_ticks;
  place.source = request.source;
  place.skill = request.skill;
  set_rate(limits, request.chunk_rate_hz, place);
  return {};
}

}  // namespace fairlead
