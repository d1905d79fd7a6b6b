// What the gate tells: every field of a verdict, a release, a lease and a status, and its log.

#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::vector<std::string> logged(const GateRig& rig) {
  std::vector<std::string> lines;
  for (const Output& output : rig.out->items()) {
    if (output.kind != OutputKind::log) continue;
    const Bytes line = rig.out->payload(output);
    lines.emplace_back(reinterpret_cast<const char*>(line.data()), line.size());
  }
  return lines;
}

using Lines = std::vector<std::string>;

}  // namespace

TEST_CASE("a verdict says whose chunk it was and which numbers decided") {
  GateRig rig(true);
  rig.ready();
  const Verdict refused = rig.send_chunk(rig.chunk({1.75}));
  CHECK(refused.session == rig.session);
  CHECK(refused.epoch == rig.epoch);
  CHECK(refused.claim_id == rig.claim_id);
  CHECK(refused.source == "runner");
  CHECK(refused.seq == 1);
  CHECK(refused.outcome == static_cast<std::uint8_t>(Outcome::refused));
  CHECK(refused.code == 20);
  CHECK(refused.part == "base");
  CHECK(refused.axis == "base_x");
  CHECK(refused.value == 1.75);
  CHECK(refused.limit == 1.5);
  CHECK(refused.margin == -0.25);
  CHECK(refused.limit_source == "test joint");
  CHECK(refused.released_first == 0);
  CHECK(refused.released_last == 0);
  CHECK(refused.config_hash == hash_of(9));
  const Verdict low = rig.send_chunk(rig.chunk({-1.75}));
  CHECK(low.limit == -1.5);
  CHECK(low.margin == -0.25);
}

TEST_CASE("a refusal for an unreadable frame says whose key it was, and has no number") {
  GateRig rig;
  rig.ready();
  rig.send_frame(EventKind::candidate, {1, 2, 3}, "runner");
  const Verdict verdict = rig.verdict();
  CHECK(verdict.session == rig.session);
  CHECK(verdict.epoch == rig.epoch);
  CHECK(verdict.source == "runner");
  CHECK(verdict.claim_id == 0);  // anybody may have put it there
  CHECK(verdict.axis == "frame");
  CHECK(verdict.margin == 0.0);
  CHECK(verdict.row == -1);
  rig.send_frame(EventKind::candidate, {1, 2, 3}, "nobody");
  CHECK(rig.verdict().claim_id == 0);
}

TEST_CASE("a refusal without a place says so: part, axis and row") {
  GateRig rig;
  rig.ready();
  ChunkBuilder foreign = rig.chunk();
  foreign.chunk.parts[0].part = 4;  // the robot has four
  const Verdict unknown = rig.send_chunk(foreign);
  CHECK(unknown.code == 4);
  CHECK(unknown.part == "");
  CHECK(unknown.row == -1);
  ChunkBuilder late = rig.chunk();
  CHECK(rig.send_chunk(late).code == 0);
  late.chunk.epoch = rig.epoch;
  late.chunk.start_tick = rig.tick - 1;
  const Verdict repeated = rig.send_chunk(late);
  CHECK(repeated.code == 5);
  CHECK(repeated.limit == static_cast<double>(late.chunk.seq) + 1.0);
}

TEST_CASE("G012 says the last tick of the chunk and the first that is open") {
  GateRig rig;
  rig.ready();
  ChunkBuilder past = rig.chunk({0.5, 0.5});
  past.chunk.start_tick = rig.tick - 5;
  const Verdict verdict = rig.send_chunk(past);
  CHECK(verdict.code == 12);
  CHECK(verdict.value == static_cast<double>(rig.tick - 4));
  CHECK(verdict.limit == static_cast<double>(rig.tick + 1));
}

TEST_CASE("a release, its grant and the lease name the same chunk") {
  GateRig rig(true);
  rig.ready();
  const Verdict verdict = rig.send_chunk(rig.chunk());
  const SafeChunk safe = rig.safe_chunk();
  CHECK(safe.session == rig.session);
  CHECK(safe.epoch == rig.epoch);
  CHECK(safe.claim_id == rig.claim_id);
  CHECK(safe.source == "runner");
  CHECK(safe.verdict_id == verdict.verdict_id);
  CHECK(safe.judged_tick == rig.tick);
  const Lease lease = rig.lease();
  CHECK(lease.config_hash == hash_of(9));
  REQUIRE(lease.grants.size() == 1);
  CHECK(lease.grants[0].source == "runner");
  CHECK(lease.grants[0].claim_id == rig.claim_id);
  CHECK(lease.grants[0].verdict_id == verdict.verdict_id);
  CHECK(lease.grants[0].until_tick == rig.tick);
}

TEST_CASE("a grant outlives its lease by 75 ms in whole periods, and by two at least") {
  const auto ahead = [](std::uint64_t period) {
    GateRig rig;
    rig.limits.period_ns = period;
    rig.restart(BootInfo{false, true, {}});
    HalStatus status = rig.hal_status();
    status.period_ns = period;
    rig.send(EventKind::hal_status, status);
    rig.send_state();
    rig.epoch = rig.arm().epoch;
    Claim claim = rig.claim_request();
    claim.period_ns = period;
    rig.send(EventKind::claim, claim);
    return rig.lease().grants[0].until_tick - rig.tick;
  };
  CHECK(ahead(25 * ms) == 3);
  CHECK(ahead(25 * ms - 1) == 4);
  CHECK(ahead(20 * ms) == 4);
  CHECK(ahead(50 * ms) == 2);
  CHECK(ahead(100 * ms) == 2);
}

TEST_CASE("a status says which gate it is, whom it follows and who may move what") {
  GateRig rig;
  rig.ready();
  const GateStatus status = rig.status();
  CHECK(status.robot == "test_robot");
  CHECK(status.profile == "sim");
  CHECK(status.session == rig.session);
  CHECK(status.epoch == rig.epoch);
  CHECK(status.lockstep_allowed);
  CHECK(status.config_hash == hash_of(9));
  CHECK(status.robot_hash == hash_of(7));
  CHECK(status.cause == "armed by test");
  REQUIRE(status.claims.size() == 1);
  CHECK(status.claims[0].source == "runner");
  CHECK(status.claims[0].skill == "test-skill");
  CHECK(status.claims[0].claim_id == rig.claim_id);
  REQUIRE(status.claims[0].parts.size() == 4);
  CHECK(status.claims[0].parts[3] == "composite");
}

TEST_CASE("a status counts outcomes and every code by its name") {
  GateRig rig;
  Lines names;
  for (const Counter& counter : rig.status().counters)
    names.push_back(std::string(counter.name.view()));
  CHECK(names ==
        Lines{"released", "truncated", "refused", "copies", "resets_refused", "stops_ignored",
              "G001",     "G002",      "G003",    "G004",   "G005",           "G006",
              "G007",     "G008",      "G009",    "G010",   "G011",           "G012",
              "G013",     "G020",      "G021",    "G022",   "G023",           "G024",
              "G025",     "G026",      "G030",    "G031",   "G032",           "G033",
              "G034",     "G040",      "G041",    "G042",   "G043",           "G050"});
  rig.ready();
  CHECK(rig.send_chunk(rig.chunk({0.5, 9.0})).code == 20);
  ChunkBuilder past = rig.chunk();
  past.chunk.start_tick = 1;
  CHECK(rig.send_chunk(past).code == 12);
  CHECK(rig.send_chunk(rig.chunk({0.0, 0.5, -1.5, 1.0})).code == 22);
  CHECK(rig.counter("G012") == 1);
  CHECK(rig.counter("G020") == 1);
  CHECK(rig.counter("G022") == 1);
  CHECK(rig.send_chunk(rig.chunk({not_a_number})).code == 8);
  CHECK(rig.counter("G008") == 1);
}

TEST_CASE("the log tells a claim's life and every refused query") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::claim, rig.claim_request());
  const std::uint64_t id = rig.reply<ClaimReply>().claim_id;
  REQUIRE(logged(rig).size() == 1);
  CHECK(logged(rig)[0].find(" of runner for test-skill") != std::string::npos);
  rig.send(EventKind::release, Release{"runner", id});
  REQUIRE(logged(rig).size() == 1);
  CHECK(logged(rig)[0].find(" of runner ended: released") != std::string::npos);
  rig.send(EventKind::release, Release{"runner", id});
  REQUIRE(logged(rig).size() == 1);
  CHECK(logged(rig)[0].find("refused a query: runner holds no claim") == 0);
  rig.send_frame(EventKind::arm, {1});
  CHECK(rig.counter("G001") == 1);
}

TEST_CASE("an arm, a stop and a latch are each one line of the log") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::disarm, Disarm{"me"});
  CHECK(logged(rig) == Lines{"disarmed: by me"});
  rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
  CHECK(logged(rig) == Lines{"stopped: by you: because"});
}

TEST_CASE("ignored copies of a stop are said once a second") {
  GateRig rig;
  const auto copy = [&rig] {
    rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
    return logged(rig).size();
  };
  CHECK(copy() == 1);
  rig.reset(5);
  CHECK(copy() == 1);
  CHECK(logged(rig)[0] ==
        "ignored a copy of stop 0000000000000005, which was reset (1 ignored so far)");
  rig.now_ns += 999 * ms;
  CHECK(copy() == 0);
  rig.now_ns += ms - 1;
  CHECK(copy() == 0);
  rig.now_ns += 1;
  CHECK(copy() == 1);
  CHECK(copy() == 0);
}
