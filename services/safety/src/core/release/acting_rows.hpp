// Which rows act around the newest state: the one before the first open tick, and what the claims
// have released for the ticks after.
#pragma once

#include "core/chunk/judgement.hpp"
#include "core/gate/hal_link.hpp"
#include "core/release/claim_table.hpp"
#include "core/release/part_history.hpp"

namespace fairlead {

class ActingRows {
 public:
  /// All must outlive it.
  ActingRows(const RobotModel& model, const HalLink& hal, const ClaimTable& claims,
             const PartHistory& history)
      : model_(model), hal_(hal), claims_(claims), history_(history) {}

  /// The first tick a row can still be for: in lockstep the robot waits in the newest one. After
  /// the last tick there is none, and G007 lets no row be for that one.
  [[nodiscard]] std::uint64_t first_open_tick() const {
    return hal_.lockstep() || hal_.tick() == UINT64_MAX ? hal_.tick() : hal_.tick() + 1;
  }
  /// How many rows from the first open tick on can act before the gate judges anew; in realtime one
  /// more than it grants.
  [[nodiscard]] std::size_t before_next_judgement() const {
    return hal_.lockstep() ? 1 : hal_.last_granted_tick() - first_open_tick() + 2;
  }
  /// The row that the claim's parts executed in the tick before the newest state. A part that its
  /// chunk did not address held beside it; any other mixture is an act that nothing can continue
  /// from (verdict 0).
  [[nodiscard]] Acted acted_of(const LiveClaim& claim) const;
  /// What acts in the tick before the first open one: measured in lockstep, expected in realtime.
  [[nodiscard]] Acted act_before(const LiveClaim& claim) const {
    return hal_.lockstep() ? acted_of(claim) : claim.plan.expected();
  }
  /// G021: a row that acts but that this claim did not release, or whose numbers are gone, is not
  /// standing still: nothing can be judged against it. One held tick later a hold is known.
  [[nodiscard]] bool knows_act_before(const LiveClaim& claim) const;
  [[nodiscard]] RowBefore row_before(const LiveClaim& claim) const;
  /// What the other claims' parts do while `chunk` of this one acts, as far as it is released; also
  /// of claims that have ended, as long as their rows may act. Not of rows for a part that `chunk`
  /// moves: it is taken after a hold of that part, so they do not act in the tick before, nor then.
  /// `holding`: those that `may_hold` do, in the tick that runs and after it.
  [[nodiscard]] FixedVec<Companion, max_claims> companions_of(const LiveClaim& claim,
                                                              const ActionChunk& chunk,
                                                              bool holding) const;
  /// Whether the row of another claim in the tick that runs acts only where the HAL had not heard
  /// the newest lease yet when that began: it was revoked, or its claim has ended.
  [[nodiscard]] bool others_may_hold(const LiveClaim& claim) const;

  /// The rows that act next were released from an older state. What they may not do in this one is
  /// a stop: the HAL has them already. Other limits cannot be broken by a newer state.
  [[nodiscard]] Evidence check_running_rows() const;

 private:
  [[nodiscard]] Companion companion_of(const LiveClaim& other) const;
  [[nodiscard]] bool may_hold(const LiveClaim& other) const;

  const RobotModel& model_;
  const HalLink& hal_;
  const ClaimTable& claims_;
  const PartHistory& history_;
};

}  // namespace fairlead
