// G043: after the end of permission, standstill within the declared ramp.
#pragma once

#include <array>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/gate/hal_link.hpp"
#include "core/monitor/ramp_watch.hpp"
#include "core/release/claim_table.hpp"
#include "core/release/part_history.hpp"

namespace fairlead {

class StopMonitor {
 public:
  /// Both must outlive the monitor.
  StopMonitor(const Limits& limits, const HalLink& hal) : limits_(limits), hal_(hal) {}

  /// After a stop every part has to be seen at standstill, whoever moved it.
  void begin_all(std::uint64_t now_ns);
  /// A claim that ends leaves its parts to their hold law.
  void begin_of(const LiveClaim& claim, std::uint64_t now_ns);
  /// A new session counts its ticks anew.
  void begin_session();
  /// The newest state.
  void see(const ClaimTable& claims, const PartHistory& history, bool is_armed,
           std::uint64_t now_ns);

  /// The first part that has not come to standstill in time: which joint of it, or which silence.
  Evidence find_unstopped(std::uint64_t now_ns);
  /// All that were found then have been told: they are watched no longer.
  void end_unstopped();

 private:
  [[nodiscard]] Evidence why_unstopped(std::size_t index, std::uint64_t now_ns) const;

  const Limits& limits_;
  const HalLink& hal_;
  std::array<RampWatch, max_parts> ramps_;   // since each part's permission ended
  std::array<bool, max_parts> unstopped_{};  // as found last
};

}  // namespace fairlead
