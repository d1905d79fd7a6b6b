// A gate whose robot executes the rows of one chunk, one a tick, while the test says what is
// measured.
#pragma once

#include <string>

#include "acted_rows.hpp"

namespace fairlead::test {

inline constexpr Acted no_row{2, 0, 0};

class TrackedRig : public GateRig {
 public:
  /// Armed, claimed, with limits that the test has narrowed.
  template <class Narrow>
  TrackedRig(bool in_lockstep, Narrow narrow) : GateRig(in_lockstep) {
    narrow(limits);
    restart(BootInfo{true, false, {}});
    ready();
    hold();
  }

  /// The rows of one chunk are released; the first acts in the tick that begins now.
  void begin(const ChunkBuilder& command) {
    ChunkBuilder builder = chunk();
    builder.chunk.parts = command.chunk.parts;
    builder.chunk.horizon = command.chunk.horizon;
    builder.chunk.start_tick += lockstep ? 0 : 1;
    const Verdict verdict = send_chunk(builder);
    REQUIRE(verdict.code == 0);
    safe = safe_chunk();
    row_ = 0;
    if (!lockstep) hold();
  }
  /// The next row acted; what is measured now is in `positions`, `velocities` and `efforts`.
  void act() {
    std::vector<Acted> did(part_count, no_row);
    for (const ActionPart& part : safe.parts) did[part.part] = row_of(safe, row_);
    ++row_;
    step(did);
  }
  /// `safe` is another chunk now: the next row is its first.
  void restart_rows() { row_ = 0; }
  /// No row acted.
  void hold() { step(std::vector<Acted>(part_count, no_row)); }
  [[nodiscard]] bool stopped() const { return gate->state() == GateState::stopped; }
  std::string cause() { return std::string(status().cause.view()); }

  SafeChunk safe;

 private:
  void step(const std::vector<Acted>& did) {
    send_heartbeat();
    next_tick_of(did);
  }
  std::uint32_t row_ = 0;
};

}  // namespace fairlead::test
