// Random sessions: events of every kind in any order, good and bad. Whatever happens, nothing moves
// that should not.

#include <cstdlib>
#include <random>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::size_t sequence_steps() {
  const char* wanted = std::getenv("FAIRLEAD_SEQUENCE_STEPS");
  return wanted != nullptr ? std::strtoul(wanted, nullptr, 10) : 20'000;
}

class RandomSession {
 public:
  RandomSession(std::uint64_t seed, bool lockstep) : random_(seed), rig_(lockstep) {
    rig_.connect_and_arm();
  }

  void run(std::size_t steps) {
    for (std::size_t i = 0; i < steps; ++i) {
      one_event();
      look_at_outputs();
    }
    CHECK(rig_.counter("released") > steps / 200);  // a session on which something happened
    CHECK(rig_.counter("refused") > steps / 100);
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }

  void one_event() {
    // Somebody who wants to work clears what stands in the way.
    if (rig_.gate->state() != GateState::armed && below(3) == 0) return operate();
    switch (below(24)) {
      case 0:
        return operate();
      case 1:
        return rig_.send(EventKind::claim, rig_.claim_request());
      case 2:
        return rig_.send_heartbeat();
      case 3:
        return rig_.timer(below(60) * ms);
      case 4:
        return rig_.send_state();
      case 5:
        return spoiled_frame();
      case 6:
        rig_.positions[below(measured_count)] = below(8) == 0 ? not_a_number : 0.1;
        return;
      case 7:
      case 8:
      case 9:
      case 10:
      case 11:
        return tick();
      case 12:
      case 13:
        rig_.positions.assign(measured_count, 0.0);
        return rig_.send_heartbeat();
      default:
        return candidate();
    }
  }
  void operate() {
    const GateStatus status = rig_.status();
    const std::uint64_t stop = status.stop_ids.empty() ? below(10) : status.stop_ids[0];
    switch (below(7)) {
      case 0:
        return rig_.send(EventKind::stop_level, StopLevel{1 + below(50), "operator", ""});
      case 1:
        return rig_.send(EventKind::disarm, Disarm{"test"});
      case 2:
        return rig_.send_hal_status(below(40) == 0 ? ++rig_.session : rig_.session);
      case 3:
      case 4:
        return rig_.reset(status.latch_id != 0 ? status.latch_id : stop);
      default:
        return rig_.send(EventKind::arm, Arm{"test"});
    }
  }
  void tick() {
    Acted did{1, 0, 0};
    if (last_.horizon > 0 && below(4) != 0)
      did = Acted{0, last_.verdict_id, static_cast<std::uint32_t>(below(last_.horizon))};
    if (below(200) == 0) ++did.row;
    rig_.pass(below(10) == 0 ? below(4) : 0);
    rig_.next_tick(did);
  }
  void candidate() {
    Row speeds;
    for (std::uint64_t i = 1 + below(10); i > 0; --i)
      speeds.push_back(0.1 * static_cast<double>(below(17)) - 0.8);
    if (below(10) == 0) speeds.back() = 7.0;
    if (below(60) == 0) speeds.back() = not_a_number;
    ChunkBuilder chunk = rig_.chunk(speeds);
    chunk.chunk.obs_tick += below(8) == 0 ? 1 + below(2) : 0;
    chunk.chunk.oldest_tick -= below(4) == 0 ? below(8) : 0;
    chunk.chunk.start_tick -= below(4) == 0 ? below(8) : 0;
    if (below(20) == 0) chunk.chunk.epoch ^= 1;
    frame_ = chunk.frame();
    rig_.send_frame(EventKind::candidate, frame_, below(30) == 0 ? "other" : "runner");
  }
  void spoiled_frame() {
    if (frame_.empty()) return;
    std::vector<std::uint8_t> frame = frame_;
    frame[below(frame.size())] ^= static_cast<std::uint8_t>(1 + below(255));
    rig_.send_frame(static_cast<EventKind>(below(12)), frame, "runner");
  }

  void look_at_outputs() {
    const bool armed = rig_.gate->state() == GateState::armed;
    if (const auto reply = rig_.find_first(OutputKind::reply, ArmReply::type_id)) {
      ArmReply armed_now;
      if (decode(*reply, armed_now) == FrameFault::none) rig_.epoch = armed_now.epoch;
    }
    if (const auto reply = rig_.find_first(OutputKind::reply, ClaimReply::type_id)) {
      ClaimReply claimed;
      REQUIRE(decode(*reply, claimed) == FrameFault::none);
      rig_.claim_id = claimed.claim_id;
      rig_.seq = 0;
    }
    if (const auto lease = rig_.find<Lease>(OutputKind::lease)) {
      CHECK((armed || lease->grants.empty()));
      heard_tick_ = lease->state_tick;
      if (lease->grants.empty()) last_.horizon = 0;  // an honest HAL executes nothing then
      CHECK((!armed || lease->stop_ids.empty()));
    }
    const auto safe = rig_.find<SafeChunk>(OutputKind::safe_chunk);
    if (!safe) return;
    REQUIRE(armed);
    last_ = *safe;
    CHECK(safe->epoch == rig_.epoch);
    // By the newest state that the gate has taken: one that came too soon for its tick is none.
    CHECK(safe->first_tick + safe->horizon > heard_tick_);
    for (const ActionPart& part : safe->parts) {
      REQUIRE(part.values.size() == safe->horizon * joint_count);
      for (std::size_t i = 0; i < part.values.size(); ++i) CHECK(std::abs(part.values[i]) <= 1.5);
    }
    last_.parts.clear();
  }

  std::mt19937_64 random_;
  GateRig rig_;
  SafeChunk last_;
  std::uint64_t heard_tick_ = 0;
  std::vector<std::uint8_t> frame_;
};

}  // namespace

TEST_CASE(
    "random sessions in both pacings release nothing while not armed, and nothing over a limit") {
  for (const bool lockstep : {false, true})
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      RandomSession(seed, lockstep).run(sequence_steps() / 8);
}
