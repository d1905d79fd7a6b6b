// The two-armed robot, without a hand, in realtime: a claim for each arm.
#pragma once

#include "gate_rig.hpp"
#include "two_arms.hpp"

namespace fairlead::test::two_arms {

// Arms of which each is a capsule, 20 mm to be kept between them; the left one is at the first
// position, the right one at the second [rad].
struct TwoClaims : GateRig {
  TwoClaims(double at_left, double at_right, double acceleration, double stop_lag = 0.0) {
    limits = two_arms::limits();
    for (const std::size_t j : {left_1, right_1}) {
      limits.joints[j].acceleration_limit = acceleration;
      limits.joints[j].stop_lag = stop_lag;
      limits.joints[j].standstill_velocity = 1e-4;
    }
    limits.collision.capsules.clear();
    limits.collision.pairs.clear();
    for (const std::size_t link : {1UL, 3UL})
      (void)limits.collision.capsules.push_back({link, {0.1, 0, 0}, {0.5, 0, 0}, 0.05});
    (void)limits.collision.pairs.push_back({0, 1});
    limits.collision.clearance = 0.02;
    part_count = 3;
    positions = {at_left, at_right, 0.0, 0.0};
    velocities.assign(two_arms::joint_count, 0.0);
    efforts.assign(two_arms::joint_count, 0.0);
    restart(BootInfo{true, false, {}});
    connect_and_arm();
    for (const std::uint8_t arm : {left, right}) {
      take_claim_of(arm);
      CHECK(claims[arm] != 0);
    }
  }

  void take_claim_of(std::uint8_t arm) {
    Claim claim = claim_request({arm == left ? "left_arm" : "right_arm"});
    claim.source = source(arm);
    send(EventKind::claim, claim);
    const std::optional<ClaimReply> taken = find<ClaimReply>(OutputKind::reply);
    claims[arm] = taken ? taken->claim_id : 0;
  }

  static const char* source(std::uint8_t arm) { return arm == left ? "a" : "b"; }

  Verdict send_rows(std::uint8_t arm, const Row& targets) {
    ChunkBuilder builder;
    command(builder, arm, Mode::joint_position, arm == left ? left_1 : right_1, targets);
    builder.chunk.session = session;
    builder.chunk.epoch = epoch;
    builder.chunk.claim_id = claims[arm];
    builder.chunk.source = source(arm);
    builder.chunk.seq = ++seq[arm];
    builder.chunk.obs_tick = builder.chunk.oldest_tick = tick;
    builder.chunk.start_tick = tick + 1;
    return send_chunk(builder, source(arm));
  }

  // A tick later; the left arm did this, the right one held.
  void next_state(double at_left, double at_right, double left_speed, const Acted& did) {
    positions[left_1] = at_left;
    positions[right_1] = at_right;
    velocities[left_1] = left_speed;
    next_tick_of({did, Acted{}, Acted{}});
  }

  std::uint64_t claims[2] = {};
  std::uint64_t seq[2] = {};
};

}  // namespace fairlead::test::two_arms
