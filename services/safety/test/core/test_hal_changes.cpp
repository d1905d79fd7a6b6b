// A HAL that goes, comes back, turns, or tells of a joint that is not where it was.

#include <cmath>
#include <numbers>
#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double quarter = std::numbers::pi / 2;

std::string cause(GateRig& rig) { return std::string(rig.status().cause.view()); }

// Another session proves with a state that it is there.
void another_hal(GateRig& rig, std::uint64_t session) {
  rig.send_hal_status(session);
  rig.session = session;
  rig.tick = 1;
  rig.send_state();
}

}  // namespace

TEST_CASE("G021 a turned base: what is measured in odom is compared along the base's own axes") {
  const Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[base].body_twist.linear_step_limit = 0.1;
  claim.modes[base].body_twist.angular_step_limit = 0.1;
  const auto starts = [&](double yaw, Row row) {
    MeasuredState state = state_at_rest();
    state.positions[base_yaw] = yaw;
    state.velocities[base_x] = 0.5;
    state.velocities[base_y] = 0.2;
    state.velocities[base_yaw] = 0.7;
    const ChunkBuilder twist = ChunkBuilder().add(base, Mode::body_twist, {row}, {}, "base_link");
    return judge_rows(limits, claim, state, twist.chunk, 0, {}).evidence.code == 0;
  };
  CHECK(starts(0.0, {0.5, 0.2, 0, 0, 0, 0.7}));
  CHECK(starts(quarter, {0.2, -0.5, 0, 0, 0, 0.7}));
  CHECK(starts(-quarter, {-0.2, 0.5, 0, 0, 0, 0.7}));
  CHECK(starts(2 * quarter, {-0.5, -0.2, 0, 0, 0, 0.7}));
  CHECK_FALSE(starts(quarter, {0.5, 0.2, 0, 0, 0, 0.7}));
  CHECK_FALSE(starts(0.0, {0.5, 0.2, 0, 0, 0, 0.0}));
  CHECK_FALSE(starts(0.0, {0.5, 0.2, 0, 0, 0, 0.5}));
}

TEST_CASE("G021 a base that is built otherwise starts from standstill only") {
  for (const std::size_t odd : {base_x, base_y, base_yaw}) {
    Limits limits = test_limits();
    JointKind& kind = limits.joints[odd].kind;
    kind = kind == JointKind::prismatic ? JointKind::continuous : JointKind::prismatic;
    const ChunkBuilder twist = ChunkBuilder().along(base, Mode::body_twist, 0, {0.1});
    MeasuredState state = state_at_rest();
    const ClaimLimits claim = whole_robot(limits);
    CHECK(judge_rows(limits, claim, state, twist.chunk, 0, {}).evidence.ok());
    state.velocities[base_x] = 0.1;
    const Evidence evidence = judge_rows(limits, claim, state, twist.chunk, 0, {}).evidence;
    CHECK(evidence.code == 21);
    CHECK(evidence.axis == "base_x");
  }
}

TEST_CASE("G021 a delta or a twist that goes on is judged against the row before alone") {
  for (const Mode mode : {Mode::cartesian_delta, Mode::cartesian_twist}) {
    const double top = mode == Mode::cartesian_delta ? 0.1 : 0.5;
    ChunkBuilder before = ChunkBuilder().along(arm, mode, 0, {-top});
    CHECK(code_after(before, ChunkBuilder().along(arm, mode, 0, {0.4 * top})) == 0);
    CHECK(code_after(before, ChunkBuilder().along(arm, mode, 0, {0.6 * top})) == 21);
  }
}

TEST_CASE("G021 a joint that the acting row left alone starts from what is measured of it") {
  ChunkBuilder before = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.5});
  CHECK(code_after(before, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {1.0})) == 0);
  CHECK(code_after(before, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.5})) == 0);
  CHECK(code_after(before, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.6})) == 21);
}

TEST_CASE("G011 every number of every joint has to be finite, and the fault names the joint") {
  for (std::size_t joint = 0; joint < measured_count; ++joint)
    for (std::vector<double> GateRig::*block :
         {&GateRig::positions, &GateRig::velocities, &GateRig::efforts}) {
      GateRig rig;
      rig.ready();
      (rig.*block)[joint] = joint % 2 == 0 ? not_a_number : infinite;
      rig.next_tick();
      CHECK(rig.gate->state() == GateState::stopped);
      const Name& name =
          joint < joint_count ? rig.limits.joints[joint].name : rig.limits.passive_joints[0].name;
      CHECK(cause(rig).find("stopped: G011 " + std::string(name.view())) == 0);
    }
}

TEST_CASE("G013 a jump is named, with distance, allowance and source") {
  GateRig rig;
  rig.ready();
  rig.next_tick();
  rig.positions[base_x] = -1.25;
  rig.pass(1);
  rig.next_tick();
  CHECK(cause(rig) == "stopped: G013 base_x: 1.25 m, limit 1 m (jump_per_tick)");
  GateRig slide;
  slide.ready();
  slide.next_tick();
  slide.positions[torso] = 0.25;
  slide.next_tick();
  CHECK(cause(slide) == "stopped: G013 torso: 0.25 m, limit 0.02 m (jump_per_tick)");
}

TEST_CASE("G011 a stale state is told with its age") {
  GateRig rig;
  rig.ready();
  rig.timer(300 * ms);
  CHECK(cause(rig) == "stopped: G011 state age: 300 ms, limit 250 ms (state_timeout_ms)");
}

TEST_CASE("G013 a tick too far is told with both distances") {
  GateRig rig;
  rig.ready();
  rig.now_ns += period_ns;
  rig.tick += 100;
  rig.send_state();
  CHECK(cause(rig) ==
        "stopped: G013 tick: 100 ticks, limit 2 ticks (the periods since the states before)");
  GateRig waiting(true);
  waiting.ready();
  CHECK(waiting.send_chunk(waiting.chunk(Row(8, 0.5))).code == 0);
  waiting.next_tick(row_of(waiting.safe_chunk(), 0));
  waiting.tick += 5;
  waiting.send_state();
  CHECK(cause(waiting) ==
        "stopped: G013 tick: 5 ticks, limit 1 ticks (lockstep: one tick for each lease)");
}

TEST_CASE("G013 a leap is confirmed by a later tick only, and only as far as periods have passed") {
  GateRig rig;
  rig.ready();
  const std::uint64_t start = rig.tick;
  const auto told = [&](std::uint64_t tick) {
    rig.tick = tick;
    rig.send_state();
    return rig.status().state_tick == tick;
  };
  CHECK_FALSE(told(start + 200));
  CHECK_FALSE(told(start + 200));
  CHECK_FALSE(told(start + 150));
  rig.now_ns += period_ns;
  CHECK_FALSE(told(start + 153));
  CHECK(told(start + 154));
}

TEST_CASE("a new HAL's past is not the old one's: its jumps, ticks and good states count anew") {
  GateRig rig;
  rig.connect_and_arm();
  for (int i = 0; i < 12; ++i) rig.next_tick();
  rig.send(EventKind::lease, Lease{});  // of epoch 0: another gate's
  CHECK(rig.gate->state() == GateState::latched);
  for (int i = 0; i < 12; ++i) rig.next_tick();
  rig.now_ns += 600 * ms;
  another_hal(rig, 77);
  CHECK(rig.lease().session == 77);
  const std::uint64_t latch = rig.status().latch_id;
  rig.reset(latch);
  const Refusal refusal = rig.refusal();
  CHECK(refusal.reason == "only 1 good joint states since the cause, 10 needed");
  CHECK(refusal.fix == rig.status().fix);
  CHECK_FALSE(refusal.fix.empty());
  for (int i = 0; i < 9; ++i) rig.next_tick();
  rig.reset(latch);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE(
    "a new HAL under an armed gate is the reason it gives, and the log says whom it follows") {
  GateRig rig(true);
  rig.ready();
  rig.now_ns += 501 * ms;
  another_hal(rig, 77);
  CHECK(cause(rig) == "disarmed: a new HAL session");
  another_hal(rig, 78);  // beside 77, which is there
  CHECK(cause(rig).find("two HALs publish") == 0);
  rig.now_ns += 501 * ms;
  rig.send_state();
  CHECK(rig.status().session == 78);
  another_hal(rig, 77);
  CHECK(rig.status().session == 78);  // left is left
}

TEST_CASE("a silence of exactly 500 ms is none") {
  GateRig rig(true);
  rig.ready();
  rig.now_ns += 500 * ms;
  another_hal(rig, 77);
  CHECK(rig.status().session == hal_session);
  rig.now_ns += 1;
  rig.send_state();
  CHECK(rig.status().session == 77);
}

TEST_CASE("a place that is claimed again remembers nothing of the claim before") {
  GateRig rig(true);
  rig.ready();
  CHECK(rig.send_chunk(rig.chunk({9.0})).code == 20);
  for (int i = 0; i < 4; ++i) rig.send_frame(EventKind::candidate, {1}, "runner");
  ChunkBuilder ahead = rig.chunk();
  for (int i = 0; i < 4; ++i) {
    ahead.chunk.seq = ++rig.seq;
    ahead.chunk.obs_tick = ahead.chunk.oldest_tick = rig.tick + 2;
    CHECK(rig.send_chunk(ahead).code == 6);
  }
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.take_claim();
  CHECK(rig.lease().grants[0].decision == number(Decision::undecided));
  rig.send_state();  // a repeat: no verdict of this claim is known yet
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.send_frame(EventKind::candidate, {1}, "runner");
  CHECK(rig.status().claims.size() == 1);
  ahead.chunk.claim_id = rig.claim_id;
  ahead.chunk.seq = 1;
  CHECK(rig.send_chunk(ahead).code == 6);
  CHECK(rig.gate->state() == GateState::armed);
  rig.seq = 1;
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
}
