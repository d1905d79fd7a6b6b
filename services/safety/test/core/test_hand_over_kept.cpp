// What of a claim goes on under its next owner, and what is that owner's own.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

// The claim's holder offers it, and `next` takes it, whatever it asks for.
void hand_over(GateRig& rig, const Claim& next, const char* holder = "runner") {
  rig.send(EventKind::release, Release{holder, rig.claim_id, next.source});
  REQUIRE(rig.reply<Done>().text == "offered");
  rig.send(EventKind::claim, next);
}

Claim of_next(const GateRig& rig) {
  Claim next = rig.claim_request();
  next.source = "next";
  return next;
}

// A chunk of the next owner's.
Verdict send_as_next(GateRig& rig, std::uint64_t seq) {
  ChunkBuilder builder = rig.chunk({0.1, 0.1});
  builder.chunk.source = "next";
  builder.chunk.seq = seq;
  return rig.send_chunk(builder, "next");
}

void heartbeat_of_next(GateRig& rig) {
  rig.send(EventKind::heartbeat, Heartbeat{rig.claim_id}, "next");
}

}  // namespace

TEST_CASE("after a hand-over the status names the skill of the next owner") {
  GateRig rig;
  rig.ready();
  Claim next = of_next(rig);
  next.skill = "another-skill";
  hand_over(rig, next);
  const GateStatus status = rig.status();
  REQUIRE(status.claims.size() == 1);
  CHECK(status.claims[0].claim_id == rig.claim_id);
  CHECK(status.claims[0].source == "next");
  CHECK(status.claims[0].skill == "another-skill");
}

TEST_CASE("G010 after a hand-over the rate is the one that the next owner declared") {
  // At 1 Hz four chunks in 2 s, at 20 Hz seven in 250 ms.
  GateRig rig;
  rig.ready();
  Claim next = of_next(rig);
  next.chunk_rate_hz = 1.0;
  hand_over(rig, next);
  std::uint64_t seq = 0;
  for (int i = 0; i < 4; ++i) CHECK(send_as_next(rig, ++seq).code == 0);
  CHECK(send_as_next(rig, ++seq).code == code::rate);
  for (int i = 0; i < 6; ++i) {  // 300 ms, in which the rate before would allow others
    heartbeat_of_next(rig);
    rig.next_tick(hold);
  }
  CHECK(send_as_next(rig, ++seq).code == code::rate);
  for (int i = 0; i < 34; ++i) {
    heartbeat_of_next(rig);
    rig.next_tick(hold);
  }
  CHECK(send_as_next(rig, ++seq).code == 0);
}

TEST_CASE("lockstep: a HAL that followed the rows of a claim waits for its next owner, too") {
  for (const bool followed : {true, false}) {
    CAPTURE(followed);
    GateRig rig(true);
    rig.ready();
    if (followed) {
      REQUIRE(rig.send_chunk(rig.chunk({0.1})).code == 0);
      rig.next_tick_of({hold, hold, row_of(rig.safe_chunk(), 0), hold});
    }
    hand_over(rig, of_next(rig));
    REQUIRE(rig.reply<ClaimReply>().claim_id == rig.claim_id);
    rig.pass(1);
    rig.next_tick(hold);  // two ticks after the newest: one without a lease
    CHECK(rig.gate->state() == (followed ? GateState::stopped : GateState::armed));
    CHECK(rig.counter("G013") == (followed ? 1 : 0));
  }
}

TEST_CASE("a chunk that waits for its state is gone when its claim is handed over") {
  for (const char* source : {"runner", "next"}) {
    CAPTURE(source);
    GateRig rig;
    rig.ready();
    ChunkBuilder ahead = rig.chunk({0.1, 0.1});
    ++ahead.chunk.obs_tick;
    ++ahead.chunk.start_tick;
    rig.send_frame(EventKind::candidate, ahead.frame(), "runner");
    REQUIRE(rig.count(OutputKind::verdict) == 0);
    Claim next = rig.claim_request();
    next.source = source;
    hand_over(rig, next);
    REQUIRE(rig.reply<ClaimReply>().claim_id == rig.claim_id);
    rig.next_tick(hold);
    CHECK(rig.count(OutputKind::verdict) == 0);
    CHECK(rig.count(OutputKind::safe_chunk) == 0);
  }
}

TEST_CASE("G005 a copy of the newest chunk from before a hand-over is no copy after it") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder old = rig.chunk({0.1, 0.1});
  const Verdict first = rig.send_chunk(old);
  REQUIRE(first.code == 0);
  CHECK(rig.send_chunk(old).verdict_id == first.verdict_id);
  hand_over(rig, rig.claim_request());
  REQUIRE(rig.reply<ClaimReply>().claim_id == rig.claim_id);
  CHECK(rig.send_chunk(old).code == code::sequence);
}

TEST_CASE("G005 after two hand-overs and a third one back an old chunk is still an old one") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder old = rig.chunk({0.1, 0.1});
  REQUIRE(rig.send_chunk(old).code == 0);
  const char* holder = "runner";
  for (const char* next : {"next", "third", "runner"}) {
    Claim claim = rig.claim_request();
    claim.source = next;
    hand_over(rig, claim, holder);
    REQUIRE(rig.reply<ClaimReply>().claim_id == rig.claim_id);
    holder = next;
  }
  CHECK(rig.send_chunk(old).code == code::sequence);
}

TEST_CASE("an offered claim ends where its next owner asks for other parts, fewer or more") {
  struct Case {
    std::initializer_list<const char*> held, asked;
  };
  for (const Case& parts : {Case{{"arm", "gripper"}, {"arm", "base"}},
                            Case{{"arm", "gripper"}, {"arm"}}, Case{{"arm"}, {"arm", "gripper"}}}) {
    GateRig rig;
    rig.connect_and_arm();
    rig.send(EventKind::claim, rig.claim_request(parts.held));
    rig.claim_id = rig.reply<ClaimReply>().claim_id;
    Claim next = rig.claim_request(parts.asked);
    next.source = "next";
    hand_over(rig, next);
    CHECK(rig.reply<ClaimReply>().claim_id != rig.claim_id);
    const GateStatus status = rig.status();
    REQUIRE(status.claims.size() == 1);
    CHECK(status.claims[0].source == "next");
    CHECK(status.claims[0].parts.size() == parts.asked.size());
  }
}
