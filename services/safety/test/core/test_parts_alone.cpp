// Parts of the gate without the gate: each owns its state and is asked by what it is given.

#include <doctest/doctest.h>

#include <memory>

#include "chunk_builder.hpp"
#include "core/chunk/judge_chunk.hpp"
#include "core/gate/state_machine.hpp"
#include "core/monitor/self_monitor.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The state machine and what it acts on; no judge, no door, no publisher.
struct Machine {
  Limits limits = test_limits();
  CountingIds ids;
  HalLink hal{limits};
  ClaimTable claims;
  RobotModel model{limits};
  PartHistory history{model};
  StopMonitor stopping{limits, hal};
  Outbox outbox;
  StateMachine machine{limits, ids, hal, claims, history, stopping, outbox};
  std::unique_ptr<Outputs> out = std::make_unique<Outputs>();

  explicit Machine(const BootInfo& info) {
    outbox.begin_step(1000 * ms, *out);
    machine.boot(info);
  }
};

const BootInfo clean{false, true, {}};
const BootInfo unclean{false, false, {}};

}  // namespace

TEST_CASE("the state machine alone: a stop while armed ends its claims and is left by its reset") {
  const auto one = std::make_unique<Machine>(clean);
  REQUIRE(one->machine.is(GateState::disarmed));
  one->machine.arm("armed by a test");
  LiveClaim& claim = *one->claims.free_place();
  claim.id = 7;
  (void)claim.limits.parts.push_back(arm);
  one->machine.hold_stop(33, "by a test: enough");
  CHECK(one->machine.is(GateState::stopped));
  CHECK_FALSE(claim.live());
  CHECK(one->machine.fix() == phrase("fairlead reset ", Hex{33}));
  REQUIRE(one->machine.reset_stop(33));
  one->machine.leave_stops(33, "a test");
  CHECK(one->machine.is(GateState::disarmed));
}

TEST_CASE("the state machine alone: what was not left clean boots latched, and says so on disk") {
  const auto one = std::make_unique<Machine>(unclean);
  CHECK(one->machine.is(GateState::latched));
  CHECK(one->machine.latch_id() != 0);
  CHECK(one->outbox.persist_latch_due);
}

TEST_CASE("G050 the self monitor alone: a limit that changes in memory is found in a whole pass") {
  const auto limits = std::make_unique<Limits>(test_limits());
  const auto model = std::make_unique<RobotModel>(*limits);
  const auto table = std::make_unique<ClaimTable>();
  ClaimTable& claims = *table;
  SelfMonitor monitor(*limits, *model);
  CHECK(monitor.find_changed(claims).ok());
  limits->joints[0].velocity_limit += 1.0;
  std::uint64_t now_ns = 1000 * ms;
  for (int slice = 0; slice < 200; ++slice, now_ns += 4 * ms) (void)monitor.read_on(now_ns, claims);
  CHECK(monitor.find_changed(claims).code == code::own);
}

TEST_CASE("G002 to G004 alone: the first that does not fit is told, in the order of the codes") {
  const Limits limits = test_limits();
  ChunkBuilder builder;
  builder.joint(arm, Mode::joint_position, arm_1, {0.0});
  ActionChunk& chunk = builder.chunk;
  const Name runner("runner");
  const auto told = [&](const Identity& here, const LiveClaim* claim) {
    return check_identity(here, claim, chunk, runner).code;
  };
  CHECK(told({limits, 5, true, 9}, nullptr) == code::session);
  chunk.session = 5;
  CHECK(told({limits, 5, false, 9}, nullptr) == code::epoch);
  CHECK(told({limits, 5, true, 9}, nullptr) == code::epoch);
  chunk.epoch = 9;
  CHECK(told({limits, 5, true, 9}, nullptr) == code::claim);
  const auto claim = std::make_unique<LiveClaim>();
  claim->source = runner;
  CHECK(told({limits, 5, true, 9}, claim.get()) == code::claim);
  (void)claim->limits.parts.push_back(arm);
  CHECK(told({limits, 5, true, 9}, claim.get()) == 0);
}
