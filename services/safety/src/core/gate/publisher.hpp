// What every step ends with: SafeChunks before the lease that permits them, then the rest.
#pragma once

#include <cstdint>

#include "core/gate/outbox.hpp"
#include "core/gate/state_machine.hpp"
#include "core/release/acting_rows.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {

class Publisher {
 public:
  /// All must outlive it.
  Publisher(const Limits& limits, const HalLink& hal, ClaimTable& claims, const ActingRows& rows,
            StateMachine& machine, Outbox& outbox)
      : limits_(limits),
        hal_(hal),
        claims_(claims),
        rows_(rows),
        machine_(machine),
        outbox_(outbox) {}

  /// All that is due by now.
  void finish();
  /// The status, published or as a reply.
  void publish_status(OutputKind kind);

 private:
  void publish_lease();
  void publish_safe_chunk(LiveClaim& claim);
  [[nodiscard]] Grant grant_for(const LiveClaim& claim) const;
  void fill_status();

  const Limits& limits_;
  const HalLink& hal_;
  ClaimTable& claims_;
  const ActingRows& rows_;
  StateMachine& machine_;
  Outbox& outbox_;
  std::uint64_t lease_ns_ = 0;  // when the last lease was published
  std::uint64_t status_ns_ = 0;
  GateStatus status_;  // room: too big for the stack of a thread that Zenoh made
};

}  // namespace fairlead
