// Who gets a claim, and with which limits.
#pragma once

#include "core/release/claim_table.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {

/// Why a query is refused and which command would change that; an empty reason: it is not.
struct Objection {
  Text reason;
  Text fix;

  [[nodiscard]] bool none() const { return reason.empty(); }
};

/// Judge a claim on an armed gate. On success `place` holds everything but id and times.
Objection admit_claim(const Limits& limits, const ClaimTable& table, const Claim& request,
                      LiveClaim& place);

/// limit_overrides.cpp: apply one of a claim's own limits to `modes`: each may only be tighter than
/// the robot's. The reason it cannot be applied, "" if it was. A joint mode's `step_limit` is one
/// number for all joints of the part.
Text tighten(const Limits& limits, std::size_t part, const LimitOverride& wanted,
             ModeLimits& modes);

}  // namespace fairlead
