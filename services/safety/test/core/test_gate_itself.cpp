// G050: the gate's own steps in time, and the limits in its own memory.

#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "fairlead_safety/crc32.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr std::uint32_t us = 1000;

// Armed, with a deadline of 2 ms for a step.
struct Timed : GateRig {
  explicit Timed(bool in_lockstep = false) : GateRig(in_lockstep) {
    limits.protocol.step_deadline_us = 2000;
    restart(BootInfo{true, false, {}});
    ready();
  }
  // A step `later_ns` after the last, which had taken so long.
  void step(std::uint32_t previous_step_ns, std::uint64_t later_ns = 5 * ms) {
    now_ns += later_ns;
    Event event;
    event.previous_step_ns = previous_step_ns;
    gate->step(now_ns, event, *out);
  }
  // Time passes; states and heartbeats keep the gate armed.
  void live(std::uint64_t for_ns) {
    for (std::uint64_t passed = 0; passed < for_ns; passed += period_ns) {
      next_tick();
      send_heartbeat();
    }
  }
};

}  // namespace

TEST_CASE("G050 the third step over its deadline within 60 s stops, at the deadline none does") {
  Timed rig;
  for (int i = 0; i < 10; ++i) rig.step(2000 * us);
  rig.step(2000 * us - 1);
  CHECK(rig.counter("G050") == 0);
  rig.step(2000 * us + 1);
  CHECK(rig.count(OutputKind::log) == 1);
  rig.step(2000 * us + 1);
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.counter("G050") == 2);
  rig.step(2500 * us);
  REQUIRE(rig.gate->state() == GateState::stopped);
  CHECK(rig.counter("G050") == 3);
  CHECK(std::string(rig.status().cause.view()) ==
        "stopped: G050 step: 2500 us, limit 2000 us (step_deadline_us, three times in 60 s)");
}

TEST_CASE("G050 the longest step that can be told is one of three too") {
  Timed rig;
  for (int i = 0; i < 3; ++i) rig.step(UINT32_MAX);
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("G050 a step that was too long 60 s ago does not count any more") {
  for (const std::uint64_t late : {std::uint64_t{0}, std::uint64_t{1}}) {
    Timed rig;
    rig.step(3000 * us);
    const std::uint64_t first_ns = rig.now_ns;
    rig.step(3000 * us);
    rig.live(59'900 * ms);
    REQUIRE(rig.gate->state() == GateState::armed);
    rig.step(3000 * us, first_ns + 60'000 * ms - 1 + late - rig.now_ns);
    CHECK(rig.gate->state() == (late == 0 ? GateState::stopped : GateState::armed));
  }
}

TEST_CASE("G050 steps count while armed in realtime only, and arming counts anew") {
  Timed world(true);
  for (int i = 0; i < 5; ++i) world.step(3000 * us);
  CHECK(world.gate->state() == GateState::armed);
  CHECK(world.counter("G050") == 0);
  Timed rig;
  rig.step(3000 * us);
  rig.step(3000 * us);
  rig.send(EventKind::disarm, Disarm{"test"});
  for (int i = 0; i < 5; ++i) rig.step(3000 * us);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.next_tick();
  rig.arm();
  rig.step(3000 * us);
  rig.step(3000 * us);
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.counter("G050") == 4);
}

namespace {

constexpr std::string_view marker = "a robot of this name is nowhere else";
constexpr const char* volume = "a far shelf";

// The gate's limits where they lie in memory, found by a name that only they hold.
struct Poked : GateRig {
  explicit Poked(bool in_lockstep = false) : GateRig(in_lockstep) {
    limits.profile = marker;
    (void)limits.workspace.volumes.push_back(
        {volume, true, {90.0, 90.0, 90.0}, {91.0, 91.0, 91.0}});
    restart(BootInfo{true, false, {}});
    connect_and_arm();
  }
  unsigned char* byte() const { return byte_of(marker); }
  // The first copy of a text, or of the bytes of a number.
  unsigned char* byte_of(std::string_view text) const {
    void* core = nullptr;
    std::memcpy(&core, gate.get(), sizeof core);  // all that a Gate is: a pointer to its core
    auto* const begin = static_cast<char*>(core);
    auto* const end = begin + malloc_usable_size(core);
    auto* const found = std::search(begin, end, text.begin(), text.end());
    REQUIRE(found != end);
    return reinterpret_cast<unsigned char*>(found);
  }
  // The 5 ms timer for so long; a state now and then keeps the gate armed.
  void run(std::uint64_t for_ns) {
    for (std::uint64_t passed = 0; passed < for_ns; passed += 5 * ms) {
      timer(5 * ms);
      if (passed % period_ns == 0) {
        ++tick;
        send_state();
        if (claim_id != 0) send_heartbeat();
      }
      if (gate->state() != GateState::armed) return;
    }
  }
};

}  // namespace

TEST_CASE("the CRC is the one of IEEE 802.3, and goes on from where it was") {
  const std::string_view text = "123456789";
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  CHECK(crc32(bytes) == 0xCBF43926);
  CHECK(crc32(bytes.subspan(4), crc32(bytes.first(4))) == 0xCBF43926);
  CHECK(crc32({}) == 0);
}

TEST_CASE("G050 a bit of the limits that turns over stops within two passes of a second") {
  for (const bool lockstep : {false, true}) {
    Poked rig(lockstep);
    rig.run(3000 * ms);
    REQUIRE(rig.gate->state() == GateState::armed);
    CHECK(rig.counter("G050") == 0);
    const std::uint64_t turned_ns = rig.now_ns;
    *rig.byte() ^= 0x10;
    rig.run(3000 * ms);
    REQUIRE(rig.gate->state() == GateState::stopped);
    CHECK(rig.now_ns - turned_ns <= 2100 * ms);
    CHECK(rig.counter("G050") == 1);
    CHECK(std::string(rig.status().cause.view()).starts_with("stopped: G050 limits in memory: "));
  }
}

TEST_CASE("G050 chunks do not read memory, what comes between them does") {
  Poked rig(true);
  *rig.byte() ^= 0x10;
  Event chunk;
  chunk.kind = EventKind::candidate;
  chunk.source = "runner";
  for (int i = 0; i < 420; ++i) {
    rig.now_ns += 5 * ms;
    rig.gate->step(rig.now_ns, chunk, *rig.out);
  }
  CHECK(rig.gate->state() == GateState::armed);
  rig.run(2100 * ms);
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("G050 a whole pass takes about a second of the timer's steps") {
  Poked rig;
  rig.send(EventKind::disarm, Disarm{"test"});
  *rig.byte() ^= 1;
  const auto next_fault = [&rig] {
    do {
      rig.timer(5 * ms);
    } while (rig.count(OutputKind::log) == 0);
    for (const Output& output : rig.out->items()) {
      if (output.kind != OutputKind::log) continue;
      const Bytes said = rig.out->payload(output);
      const std::string text(said.begin(), said.end());
      CHECK(text.starts_with("G050 limits in memory: "));
    }
    return rig.now_ns;
  };
  next_fault();
  const std::uint64_t first_ns = next_fault();
  const std::uint64_t pass_ns = next_fault() - first_ns;
  CHECK(pass_ns >= 900 * ms);
  CHECK(pass_ns <= 1100 * ms);
}

TEST_CASE("G050 nothing is armed with limits that changed, and again when they are back") {
  Poked rig;
  rig.send(EventKind::disarm, Disarm{"test"});
  unsigned char& byte = *rig.byte();
  byte ^= 0x10;
  for (int i = 0; i < 420; ++i) rig.timer(5 * ms);
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.counter("G050") >= 1);
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(std::string(rig.refusal().reason.view()).starts_with("G050 limits in memory: "));
  CHECK(rig.refusal().fix == "fairlead restart safety");
  byte ^= 0x10;
  for (int i = 0; i < 420; ++i) rig.timer(5 * ms);
  rig.next_tick();
  rig.arm();
  CHECK(rig.gate->state() == GateState::armed);
}

namespace {

std::vector<std::uint8_t> plan_in(const Limits& limits, int fill) {
  std::vector<std::uint8_t> memory(sizeof(RobotModel), static_cast<std::uint8_t>(fill));
  static_assert(alignof(RobotModel) <= alignof(std::max_align_t));
  const RobotModel* model = new (memory.data()) RobotModel(limits);
  model->~RobotModel();
  return memory;
}

}  // namespace

TEST_CASE("G050 no byte of what the gate makes of the limits is what memory held before") {
  const Limits limits = test_limits();
  const std::vector<std::uint8_t> zero = plan_in(limits, 0x00), ones = plan_in(limits, 0xFF);
  CHECK(std::mismatch(zero.begin(), zero.end(), ones.begin()).first - zero.begin() ==
        static_cast<std::ptrdiff_t>(sizeof(RobotModel)));
}

TEST_CASE("G050 a bit of what the gate made of the limits, or of a claim's own limits, stops too") {
  for (const bool of_claim : {false, true}) {
    Poked rig;
    Claim claim = rig.claim_request();
    constexpr double tightened = 0.2371;  // a number that is nowhere else
    const auto mode = static_cast<std::uint8_t>(Mode::joint_velocity);
    (void)claim.limits.push_back({"base", mode, "step_limit", tightened});
    rig.send(EventKind::claim, claim);
    rig.claim_id = rig.reply<ClaimReply>().claim_id;
    rig.run(2500 * ms);
    REQUIRE(rig.gate->state() == GateState::armed);
    std::array<char, sizeof tightened> bytes{};
    std::memcpy(bytes.data(), &tightened, sizeof tightened);
    const std::string_view number(bytes.data(), bytes.size());
    *rig.byte_of(of_claim ? number : "tool / a far shelf") ^= 0x01;
    const std::uint64_t turned_ns = rig.now_ns;
    rig.run(3000 * ms);
    REQUIRE(rig.gate->state() == GateState::stopped);
    CHECK(rig.now_ns - turned_ns <= 2100 * ms);
    CHECK(rig.counter("G050") == 1);
  }
}
