// A candidate chunk on its way from the key to the judge and to the door.
#pragma once

#include "core/chunk/judge_chunk.hpp"
#include "core/gate/state_machine.hpp"
#include "core/release/door.hpp"
#include "fairlead_safety/gate.hpp"

namespace fairlead {

class Candidates {
 public:
  /// All must outlive it.
  Candidates(const Limits& limits, const HalLink& hal, ClaimTable& claims, StateMachine& machine,
             ChunkJudge& judge, Door& door, Outbox& outbox)
      : limits_(limits),
        hal_(hal),
        claims_(claims),
        machine_(machine),
        judge_(judge),
        door_(door),
        outbox_(outbox) {}

  void on_candidate(const Event& event);
  /// G006: chunks that waited for the state that has just come.
  void take_waiting();

 private:
  void take_chunk(const ActionChunk& chunk, Bytes frame, const Name& source,
                  std::uint64_t received_ns);
  /// One at a time: what it replaces is refused.
  void let_wait(LiveClaim& claim, Bytes frame, std::uint64_t received_ns);
  void refuse_frame(FrameFault fault, std::size_t at, const Name& source, const Event& event);

  const Limits& limits_;
  const HalLink& hal_;
  ClaimTable& claims_;
  StateMachine& machine_;
  ChunkJudge& judge_;
  Door& door_;
  Outbox& outbox_;
  ActionChunk chunk_;  // room for the one in hand
};

}  // namespace fairlead
