// Which leases this gate sent. Nobody else sends any: another one in its name is forged.
#pragma once

#include <array>
#include <cstdint>

#include "fairlead_safety/messages.hpp"

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

}  // namespace fairlead
