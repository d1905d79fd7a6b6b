// Which leases this gate sent. Nobody else sends any: another one in its name is forged.
#pragma once

#include <array>
#include <cstdint>

#include "core/release/claim_table.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/messages.hpp"
#include "fairlead_safety/outputs.hpp"

namespace fairlead {

class SentLeases {
 public:
  static constexpr std::size_t epochs_known = 64;
  static constexpr std::size_t leases_kept = 64;

  void begin_epoch(std::uint64_t epoch) {
    newest_ = (newest_ + 1) % epochs_.size();
    epochs_[newest_] = Epoch{epoch, 0};
  }

  /// The next lease of the newest epoch, with its number; the caller fills in the rest and sends
  /// it.
  Lease& next() {
    Epoch& now = epochs_[newest_];
    Lease& lease = kept_[++now.last_seq % kept_.size()];
    lease.epoch = now.epoch;
    lease.lease_seq = now.last_seq;
    return lease;
  }

  /// Whether this gate sent it, however long ago. What it said is compared with those that are
  /// kept.
  [[nodiscard]] bool holds(const Lease& heard) const {
    for (const Epoch& own : epochs_) {
      if (own.epoch != heard.epoch) continue;
      if (heard.lease_seq < 1 || heard.lease_seq > own.last_seq) return false;
      const Lease& kept = kept_[heard.lease_seq % kept_.size()];
      const bool is_kept = kept.epoch == heard.epoch && kept.lease_seq == heard.lease_seq;
      return !is_kept || kept == heard;
    }
    return false;
  }

 private:
  struct Epoch {
    std::uint64_t epoch = 0;  // epochs are never 0
    std::uint64_t last_seq = 0;
  };
  std::array<Epoch, epochs_known> epochs_{};
  std::size_t newest_ = 0;
  std::array<Lease, leases_kept> kept_{};
};

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
