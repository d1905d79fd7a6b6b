// G001 to G005: which chunks are listened to at all, and what is answered.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("a good chunk is released: verdict, SafeChunk and lease, from the next tick on") {
  GateRig rig;
  rig.ready();
  const Verdict verdict = rig.send_chunk(rig.chunk());
  CHECK(verdict.outcome == static_cast<std::uint8_t>(Outcome::released));
  CHECK(verdict.code == 0);
  CHECK(verdict.row == -1);
  CHECK(verdict.seq == 1);
  CHECK(verdict.released_first == rig.tick + 1);
  CHECK(verdict.released_last == rig.tick + 3);
  CHECK(verdict.config_hash == hash_of(9));
  const SafeChunk safe = rig.safe_chunk();
  CHECK(safe.verdict_id == verdict.verdict_id);
  CHECK(safe.first_tick == rig.tick + 1);
  CHECK(safe.judged_tick == rig.tick);
  CHECK(safe.horizon == 3);
  CHECK(safe.after.hold != 0);
  REQUIRE(safe.parts.size() == 1);
  CHECK(safe.parts[0].values.size() == 3 * joint_count);
  CHECK(rig.lease().grants[0].claim_id == rig.claim_id);
  CHECK(rig.lease().grants[0].until_tick == rig.tick + 2);
  CHECK(rig.out->items()[0].kind == OutputKind::safe_chunk);  // before the lease that permits it
  CHECK(rig.out->items()[1].kind == OutputKind::lease);
  CHECK(rig.out->items()[0].source == "runner");
}

TEST_CASE("latency counts from reception") {
  GateRig rig;
  rig.ready();
  const auto frame = rig.chunk().frame();
  rig.gate->step(rig.now_ns, Event{EventKind::candidate, "runner", frame, rig.now_ns - 123},
                 *rig.out);
  CHECK(rig.verdict().latency_ns == 123);
}

TEST_CASE("G001 an unreadable frame is refused; five in 20 ticks end the claim") {
  GateRig rig;
  rig.ready();
  auto frame = rig.chunk().frame();
  frame.push_back(0);
  for (int i = 1; i <= 5; ++i) {
    rig.send_frame(EventKind::candidate, frame, "runner");
    CHECK(rig.verdict().code == 1);
    CHECK(rig.verdict().axis == "frame");
    CHECK(rig.verdict().limit_source.view().starts_with("a chunk, got trailing bytes, at byte "));
    rig.timer(30 * ms);
    CHECK(rig.lease().grants.size() == (i < 5 ? 1U : 0U));
  }
  CHECK(rig.counter("G001") == 5);
}

TEST_CASE(
    "G001 bad frames far apart, on another key, or that do not cite it leave the claim alone") {
  GateRig rig;
  rig.ready();
  auto cut = rig.chunk().frame();
  cut.pop_back();
  const auto spoilt = [&rig](const auto& change) {
    ChunkBuilder builder = rig.chunk();
    change(builder.chunk);
    auto frame = builder.frame();
    frame.pop_back();
    return frame;
  };
  const std::vector<std::vector<std::uint8_t>> not_its_own{
      {1, 2, 3},
      {},
      std::vector<std::uint8_t>(max_frame_bytes + 1, 0),
      spoilt([](ActionChunk& chunk) { chunk.claim_id ^= 1; }),
      spoilt([](ActionChunk& chunk) { chunk.epoch ^= 1; }),
      spoilt([](ActionChunk& chunk) { chunk.session ^= 1; })};
  for (int i = 0; i < 10; ++i) {
    rig.send_frame(EventKind::candidate, cut, "stranger");
    for (const auto& frame : not_its_own) {
      rig.send_frame(EventKind::candidate, frame, "runner");
      CHECK(rig.verdict().code == 1);
      CHECK(rig.verdict().claim_id == 0);
    }
  }
  for (int i = 0; i < 10; ++i) {
    rig.send_frame(EventKind::candidate, cut, "runner");
    rig.pass(4);
    rig.next_tick();
    rig.send_heartbeat();
  }
  rig.timer(30 * ms);
  CHECK(rig.lease().grants.size() == 1);
}

TEST_CASE("G002 G003 G004 nothing of another session, robot, epoch, claim or source passes") {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  std::uint32_t code = 0;
  const char* key = "runner";
  SUBCASE("session") {
    chunk.chunk.session = 1;
    code = 2;
  }
  SUBCASE("no session") {
    chunk.chunk.session = 0;
    code = 2;
  }
  SUBCASE("robot hash") {
    chunk.chunk.robot_hash = hash_of(8);
    code = 2;
  }
  SUBCASE("epoch") {
    chunk.chunk.epoch -= 1;
    code = 3;
  }
  SUBCASE("claim") {
    chunk.chunk.claim_id += 1;
    code = 4;
  }
  SUBCASE("claim 0") {
    chunk.chunk.claim_id = 0;
    code = 4;
  }
  SUBCASE("source in the chunk") {
    chunk.chunk.source = "other";
    code = 4;
  }
  SUBCASE("key") {
    key = "other";
    code = 4;
  }
  SUBCASE("both") {
    chunk.chunk.source = "other";
    key = "other";
    code = 4;
  }
  SUBCASE("part index beyond the robot") {
    chunk.chunk.parts[0].part = 200;
    code = 4;
  }
  CHECK(rig.send_chunk(chunk, key).code == code);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
  CHECK(rig.verdict().source == key);
}

TEST_CASE("G003 a chunk sent to a gate that is not armed is refused, before and after a stop") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder chunk = rig.chunk();
  rig.send(EventKind::disarm, Disarm{"test"});
  CHECK(rig.send_chunk(chunk).code == 3);
  rig.arm();
  CHECK(rig.send_chunk(chunk).code == 3);  // recorded in the epoch before
}

TEST_CASE("G004 a part that another claim holds is out of reach") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::claim, rig.claim_request({"arm"}));
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  const Verdict verdict = rig.send_chunk(rig.chunk());
  CHECK(verdict.code == 4);
  CHECK(verdict.part == "base");
}

TEST_CASE("G005 seq is strictly increasing and jumps at most 1,000") {
  GateRig rig;
  rig.ready();
  const auto with_seq = [&rig](std::uint64_t seq) {
    ChunkBuilder chunk = rig.chunk();
    chunk.chunk.seq = seq;
    return rig.send_chunk(chunk).code;
  };
  CHECK(with_seq(0) == 5);
  CHECK(with_seq(1001) == 5);
  CHECK(with_seq(1000) == 0);
  rig.next_tick();
  CHECK(with_seq(1000) == 5);  // other bytes, same number
  CHECK(with_seq(999) == 5);
  CHECK(with_seq(2001) == 5);
  CHECK(with_seq(1'000'001'000) == 5);
  CHECK(with_seq(UINT64_MAX) == 5);
  CHECK(with_seq(2000) == 0);
  CHECK(rig.status().state == static_cast<std::uint8_t>(GateState::armed));
}

TEST_CASE("G005 a copy of the newest chunk gets the same answer and is not counted") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder chunk = rig.chunk();
  const Verdict first = rig.send_chunk(chunk);
  const SafeChunk safe = rig.safe_chunk();
  const Verdict second = rig.send_chunk(chunk);
  CHECK(second.verdict_id == first.verdict_id);
  CHECK(second.latency_ns == first.latency_ns);
  CHECK(rig.safe_chunk().verdict_id == safe.verdict_id);
  CHECK(rig.counter("released") == 1);
  CHECK(rig.counter("copies") == 1);
  CHECK(rig.counter("G005") == 0);
}

TEST_CASE("G005 a copy of a refused chunk is refused by the same verdict") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder chunk = rig.chunk({2.0, 2.0});
  const Verdict first = rig.send_chunk(chunk);
  CHECK(first.code == 20);
  CHECK(rig.send_chunk(chunk).verdict_id == first.verdict_id);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("heartbeats keep a claim, their loss ends it, and only its own source's count") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    const std::uint64_t limit = (lockstep ? 2000 : 300) * ms;
    const auto pass = [&rig](std::uint64_t time, bool with_heartbeat, const char* source) {
      for (std::uint64_t passed = 0; passed < time; passed += 50 * ms) {
        rig.next_tick();
        if (with_heartbeat) rig.send(EventKind::heartbeat, Heartbeat{rig.claim_id}, source);
      }
      return rig.status().claims.size();
    };
    CHECK(pass(2 * limit, true, "runner") == 1);
    CHECK(pass(limit, false, "") == 1);
    CHECK(pass(50 * ms, true, "other") == 0);
    CHECK(rig.gate->state() == GateState::armed);
  }
}

TEST_CASE("releasing a claim needs its source and its id") {
  GateRig rig;
  rig.ready();
  rig.send(EventKind::release, Release{"other", rig.claim_id});
  CHECK(rig.count(OutputKind::refusal) == 1);
  rig.send(EventKind::release, Release{"runner", rig.claim_id + 1});
  CHECK(rig.count(OutputKind::refusal) == 1);
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  CHECK(rig.reply<Done>().text == "released");
  CHECK(rig.lease().grants.empty());
  rig.take_claim();
}

TEST_CASE("a refusal before G006 names the claim only to the claim's own runner") {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.session ^= 1;
  CHECK(rig.send_chunk(chunk).claim_id == 0);
  chunk = rig.chunk();
  chunk.chunk.epoch ^= 1;
  CHECK(rig.send_chunk(chunk).claim_id == 0);
  chunk = rig.chunk();
  CHECK(rig.send_chunk(chunk, "other").claim_id == 0);
  chunk.chunk.seq = 5000;
  const Verdict own = rig.send_chunk(chunk);
  CHECK(own.code == 5);
  CHECK(own.claim_id == rig.claim_id);
}

TEST_CASE("G006 of chunks that wait for the next state the newest stays, each other is answered") {
  GateRig rig;
  rig.ready();
  const auto ahead = [&rig] {
    ChunkBuilder chunk = rig.chunk();
    ++chunk.chunk.obs_tick;
    return chunk.frame();
  };
  const auto first = ahead();
  rig.send_frame(EventKind::candidate, first, "runner");
  rig.send_frame(EventKind::candidate, first, "runner");  // a copy
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.send_frame(EventKind::candidate, ahead(), "runner");
  CHECK(rig.verdict().code == 6);
  CHECK(rig.verdict().seq == rig.seq - 1);
  CHECK(rig.verdict().axis == "obs_tick");
  rig.next_tick();
  CHECK(rig.verdict().code == 0);
  CHECK(rig.verdict().seq == rig.seq);
}
