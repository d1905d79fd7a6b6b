// Queries with their replies, the status, and what the gate keeps on its own disk.
#pragma once

#include <cstdint>
#include <string_view>

#include "fairlead_safety/messages.hpp"

namespace fairlead {

struct ClaimInfo {
  Name source;
  Name skill;
  std::uint64_t claim_id = 0;
  FixedVec<Name, max_parts> parts;
  FAIRLEAD_FIELDS(source, skill, claim_id, parts)
};

struct Counter {
  Name name;
  std::uint64_t count = 0;
  FAIRLEAD_FIELDS(name, count)
};

struct GateStatus {
  static constexpr std::uint8_t type_id = 11;
  Name robot;
  Name profile;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint8_t state = 0;
  Text cause;
  Text fix;
  std::uint64_t latch_id = 0;
  FixedVec<std::uint64_t, max_stops> stop_ids;
  FixedVec<ClaimInfo, max_claims> claims;
  FixedVec<Counter, 48> counters;
  std::uint64_t state_tick = 0;
  bool lockstep_allowed = false;
  Hash config_hash{};
  Hash robot_hash{};
  FAIRLEAD_FIELDS(robot, profile, session, epoch, state, cause, fix, latch_id, stop_ids, claims,
                  counters, state_tick, lockstep_allowed, config_hash, robot_hash)
};

struct Refusal {
  static constexpr std::uint8_t type_id = 20;
  Text who;
  Text reason;
  Text fix;
  FAIRLEAD_FIELDS(who, reason, fix)
};

struct Done {
  static constexpr std::uint8_t type_id = 21;
  Text text;
  FAIRLEAD_FIELDS(text)
};

struct StatusQuery {
  static constexpr std::uint8_t type_id = 22;
  auto fields() const { return std::tie(); }
};

struct Arm {
  static constexpr std::uint8_t type_id = 23;
  Text by;
  FAIRLEAD_FIELDS(by)
};

struct ArmReply {
  static constexpr std::uint8_t type_id = 24;
  std::uint64_t epoch = 0;
  std::uint64_t session = 0;
  FAIRLEAD_FIELDS(epoch, session)
};

struct Disarm {
  static constexpr std::uint8_t type_id = 25;
  Text by;
  FAIRLEAD_FIELDS(by)
};

struct Reset {
  static constexpr std::uint8_t type_id = 26;
  Text by;
  std::uint64_t id = 0;
  FAIRLEAD_FIELDS(by, id)
};

/// The person in "ada@lab (fairlead run)"; it proves nothing by itself.
inline std::string_view person_of(const Text& by) {
  return by.view().substr(0, by.view().find_first_of(" @"));
}

/// A tighter limit for one claim; `name` as in the configuration's mode block.
struct LimitOverride {
  Name part;
  std::uint8_t mode = 0;
  Name name;
  double value = 0.0;
  FAIRLEAD_FIELDS(part, mode, name, value)
};

struct Claim {
  static constexpr std::uint8_t type_id = 27;
  static constexpr std::size_t optional_fields = 1;
  Name source;
  Name skill;
  Hash skill_hash{};
  Hash robot_hash{};
  std::uint64_t period_ns = 0;
  FixedVec<Name, max_parts> parts;
  double chunk_rate_hz = 0.0;
  std::uint32_t horizon_max = 0;
  std::uint32_t age_max_ticks = 0;
  FixedVec<LimitOverride, 64> limits;
  Text by{};  // the person who asks, for the log
  FAIRLEAD_FIELDS(source, skill, skill_hash, robot_hash, period_ns, parts, chunk_rate_hz,
                  horizon_max, age_max_ticks, limits, by)
};

struct ClaimReply {
  static constexpr std::uint8_t type_id = 28;
  std::uint64_t claim_id = 0;
  std::uint64_t epoch = 0;
  std::uint64_t session = 0;
  FAIRLEAD_FIELDS(claim_id, epoch, session)
};

struct Release {
  static constexpr std::uint8_t type_id = 29;
  static constexpr std::size_t optional_fields = 1;
  Name source;
  std::uint64_t claim_id = 0;
  Name offered_to{};  // whose next claim of the same parts goes on with its rows; empty: nobody's
  FAIRLEAD_FIELDS(source, claim_id, offered_to)
};

/// What survives a restart. Written by the shell as opaque bytes; not a message on the wire.
struct LatchRecord {
  static constexpr std::uint8_t type_id = 60;
  std::uint64_t latch_id = 0;
  std::uint64_t tick = 0;
  Text cause;
  FAIRLEAD_FIELDS(latch_id, tick, cause)
};

}  // namespace fairlead
