// The only way out: from a verdict about a claim's rows to the SafeChunk that the HAL may execute,
// and back again where released rows are revoked.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/gate/outbox.hpp"
#include "core/gate/state_machine.hpp"
#include "core/release/acting_rows.hpp"

namespace fairlead {

class Door {
 public:
  /// All must outlive it. `first_verdict`: the id of the first; others count on from it.
  Door(const Limits& limits, const HalLink& hal, ClaimTable& claims, PartHistory& history,
       const ActingRows& rows, const StateMachine& machine, Outbox& outbox,
       std::uint64_t first_verdict)
      : limits_(limits),
        hal_(hal),
        claims_(claims),
        history_(history),
        rows_(rows),
        machine_(machine),
        outbox_(outbox),
        next_verdict_(first_verdict) {}

  /// Whether this gate released such a row to the part: one of a claim that it remembers, or of one
  /// of the newest SafeChunks.
  [[nodiscard]] bool has_released(std::size_t part, const Acted& acted) const;

  /// A new chunk of a live claim has been judged.
  void answer(LiveClaim& claim, const ActionChunk& chunk, Bytes frame, const Judgement& judgement,
              std::uint64_t received_ns);
  /// The same bytes get the same answer: verdict, SafeChunk and lease again; nothing is counted.
  void answer_again(LiveClaim& claim);
  /// A verdict that leaves no trace in any claim: it may not even be the claim's own runner. It
  /// names the claim only if the chunk is the claim's by session, epoch and source.
  void refuse_stranger(const ActionChunk& chunk, const Name& source, const Evidence& evidence,
                       std::uint64_t received_ns);
  /// What is left of the claim's release has been judged again: that much of it goes out under a
  /// new verdict; if nothing is, the claim's parts hold. The state that told has a lease due.
  void answer_rest(LiveClaim& claim, const Judgement& judgement);

  /// In realtime the HAL goes on with rows that it has already. Without the SafeChunk that shortens
  /// them, the grant ends before the first that may not act. In lockstep each row needs a decision.
  void revoke_from(LiveClaim& claim, std::uint64_t tick) const;

 private:
  Verdict make_verdict(const ActionChunk& chunk, const Name& source, const Judgement& judgement,
                       std::uint64_t received_ns);
  void pass(LiveClaim& claim, const Judgement& judgement, const Verdict& verdict,
            std::optional<Bytes> frame);
  [[nodiscard]] SafeChunk safe_chunk_of(const LiveClaim& claim) const;
  void note_sent(const SafeChunk& safe);

  const Limits& limits_;
  const HalLink& hal_;
  ClaimTable& claims_;
  PartHistory& history_;
  const ActingRows& rows_;
  const StateMachine& machine_;
  Outbox& outbox_;
  std::uint64_t next_verdict_;

  struct Sent {
    std::uint64_t verdict_id = 0;  // 0: none
    std::uint32_t row_count = 0;
    std::uint32_t parts = 0;  // a bit for each
  };
  // A replaced or ended release acts for a few ticks at most, in which each of 8 claims can get a
  // few more.
  std::array<Sent, 256> sent_;
  std::size_t next_sent_ = 0;
};

}  // namespace fairlead
