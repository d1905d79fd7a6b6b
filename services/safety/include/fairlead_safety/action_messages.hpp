// From the runner through the gate to the robot: candidates, what was released, and leases.
#pragma once

#include <array>
#include <cstdint>

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/robot_messages.hpp"
#include "fairlead_safety/wire_fields.hpp"

namespace fairlead {

struct ActionPart {
  std::uint8_t part = 0;
  std::uint8_t mode = 0;
  Name frame_id;
  NumberView values;  // [horizon x width]
  FixedVec<std::uint8_t, max_joints> active;
  FAIRLEAD_FIELDS(part, mode, frame_id, values, active)
};

using Trace = std::array<std::uint8_t, 24>;

struct ActionChunk {
  static constexpr std::uint8_t type_id = 7;
  Hash robot_hash{};
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t seq = 0;
  std::uint64_t goal_id = 0;
  std::uint64_t obs_tick = 0;
  std::uint64_t oldest_tick = 0;
  std::uint64_t start_tick = 0;
  std::uint32_t horizon = 0;
  FixedVec<ActionPart, max_parts> parts;
  Trace trace{};
  FAIRLEAD_FIELDS(robot_hash, session, epoch, claim_id, source, seq, goal_id, obs_tick, oldest_tick,
                  start_tick, horizon, parts, trace)
};

struct SafeChunk {
  static constexpr std::uint8_t type_id = 8;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t verdict_id = 0;
  std::uint64_t judged_tick = 0;
  std::uint64_t first_tick = 0;
  std::uint32_t horizon = 0;
  Acted after;
  FixedVec<ActionPart, max_parts> parts;
  FAIRLEAD_FIELDS(session, epoch, claim_id, source, verdict_id, judged_tick, first_tick, horizon,
                  after, parts)
};

enum class Decision : std::uint8_t { undecided = 0, row = 1, hold = 2 };

struct Grant {
  Name source;
  std::uint64_t claim_id = 0;
  std::uint64_t until_tick = 0;
  std::uint8_t decision = 0;
  std::uint64_t verdict_id = 0;
  FAIRLEAD_FIELDS(source, claim_id, until_tick, decision, verdict_id)
  friend bool operator==(const Grant&, const Grant&) = default;
};

enum class GateState : std::uint8_t { boot = 0, disarmed = 1, armed = 2, stopped = 3, latched = 4 };

struct Lease {
  static constexpr std::uint8_t type_id = 9;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t lease_seq = 0;
  Hash config_hash{};
  std::uint8_t state = 0;
  std::uint64_t state_tick = 0;
  FixedVec<Grant, max_claims> grants;
  FixedVec<std::uint64_t, max_stops> stop_ids;
  FAIRLEAD_FIELDS(session, epoch, lease_seq, config_hash, state, state_tick, grants, stop_ids)
  friend bool operator==(const Lease&, const Lease&) = default;
};

enum class Outcome : std::uint8_t { released = 0, truncated = 1, refused = 2 };

struct Verdict {
  static constexpr std::uint8_t type_id = 10;
  static constexpr std::size_t optional_fields = 1;
  std::uint64_t verdict_id = 0;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t seq = 0;
  std::uint8_t outcome = 0;
  std::uint32_t code = 0;
  std::int64_t row = -1;
  Name part;
  Text axis;
  double value = 0.0;
  double limit = 0.0;
  double margin = 0.0;
  Text limit_source;
  std::uint64_t released_first = 0;
  std::uint64_t released_last = 0;
  Hash config_hash{};
  std::uint64_t latency_ns = 0;
  Name unit;  // of value, limit and margin; empty: a rule, or by an older gate
  /// Else it is a rule that `limit_source` words.
  [[nodiscard]] bool has_magnitude() const { return !unit.empty() || margin != 0.0; }
  FAIRLEAD_FIELDS(verdict_id, session, epoch, claim_id, source, seq, outcome, code, row, part, axis,
                  value, limit, margin, limit_source, released_first, released_last, config_hash,
                  latency_ns, unit)
};

struct StopLevel {
  static constexpr std::uint8_t type_id = 12;
  std::uint64_t stop_id = 0;
  Text by;
  Text reason;
  FAIRLEAD_FIELDS(stop_id, by, reason)
};

struct Heartbeat {
  static constexpr std::uint8_t type_id = 13;
  std::uint64_t claim_id = 0;
  FAIRLEAD_FIELDS(claim_id)
};

}  // namespace fairlead
