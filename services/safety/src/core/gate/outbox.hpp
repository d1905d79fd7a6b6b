// The step in progress: its time, and what goes out of it. What is due at its end stands here until
// the publisher comes; what was counted stands here from the start on.
#pragma once

#include <array>
#include <cstdint>

#include "core/release/claim_table.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/messages.hpp"
#include "fairlead_safety/outputs.hpp"

namespace fairlead {

/// Since the start of the process, as the status tells it.
struct Counters {
  std::array<std::uint64_t, 64> codes{};  // by code: what was refused, stopped or found
  std::uint64_t released = 0, truncated = 0, refused = 0, copies = 0, resets_refused = 0,
                stops_ignored = 0;
};

struct Outbox {
  std::uint64_t now_ns = 0;
  Outputs* out = nullptr;
  Counters counters;

  // At the end of the step. Verdicts come last: the HAL waits for the lease.
  bool lease_due = true;
  bool status_due = true;
  bool clean_mark_due = false;     // after the lease that says disarmed
  bool persist_latch_due = false;  // after the lease that says latched: the hold goes out first
  FixedVec<Verdict, 4 * max_claims + 2> verdicts;

  void begin_step(std::uint64_t now, Outputs& outputs) {
    outputs.clear();
    out = &outputs;
    now_ns = now;
  }
  void log(const Text& line) const { out->add_log(line.view()); }
  void count(std::uint32_t code) { ++counters.codes[code]; }
  void tell(const Verdict& verdict) { (void)verdicts.push_back(verdict); }
  /// Something changed that everybody has to know.
  void announce() { lease_due = status_due = true; }
};

}  // namespace fairlead
