// A claim that its holder offers goes on under its next owner.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

void offer_to(GateRig& rig, const char* source) {
  rig.send(EventKind::release, Release{"runner", rig.claim_id, source});
  CHECK(rig.reply<Done>().text == "offered");
}

Claim of_next(const GateRig& rig) {
  Claim next = rig.claim_request();
  next.source = "next";
  (void)next.limits.push_back(
      LimitOverride{"base", static_cast<std::uint8_t>(Mode::joint_velocity), "step_limit", 0.25});
  return next;
}

}  // namespace

TEST_CASE("an offered claim goes on under its next owner: rows, seam and id are the same") {
  GateRig rig;
  rig.ready();
  const Verdict before = rig.send_chunk(rig.chunk({0.5, 0.5, 0.5, 0.5, 0.5}));
  REQUIRE(before.code == 0);
  rig.next_tick();
  rig.send(EventKind::claim, of_next(rig));
  CHECK(rig.refusal().reason == "part arm is held by runner (test-skill)");
  offer_to(rig, "next");
  rig.next_tick(Acted{0, before.verdict_id, 0});
  const std::uint64_t first_claim = rig.claim_id;
  rig.send(EventKind::claim, of_next(rig));
  CHECK(rig.reply<ClaimReply>().claim_id == first_claim);
  rig.next_tick(Acted{0, before.verdict_id, 1});
  const Lease lease = rig.get<Lease>(OutputKind::lease);
  REQUIRE(lease.grants.size() == 1);
  CHECK(lease.grants[0].source == "next");
  CHECK(lease.grants[0].decision == static_cast<std::uint8_t>(Decision::row));
  CHECK(lease.grants[0].verdict_id == before.verdict_id);

  ChunkBuilder former = rig.chunk({0.5, 0.5});
  CHECK(rig.send_chunk(former).code == code::claim);
  ChunkBuilder leap = rig.chunk({1.0, 1.0});
  leap.chunk.source = "next";
  leap.chunk.start_tick += 1;
  leap.chunk.seq = 1;
  CHECK(rig.send_chunk(leap, "next").code == code::seam);
  ChunkBuilder after = rig.chunk({0.5, 0.5});
  after.chunk.source = "next";
  after.chunk.start_tick += 1;
  after.chunk.seq = 2;
  CHECK(rig.send_chunk(after, "next").code == 0);
  const SafeChunk released = rig.get<SafeChunk>(OutputKind::safe_chunk);
  CHECK(released.source == "next");
  CHECK(released.after.hold == 0);
  CHECK(released.after.verdict_id == before.verdict_id);
}

TEST_CASE("what was released before a hand-over goes out again as it was") {
  GateRig rig;
  rig.ready();
  const Verdict before = rig.send_chunk(rig.chunk({0.5, 0.5, 0.5, 0.5, 0.5}));
  REQUIRE(before.code == 0);
  offer_to(rig, "next");
  rig.send(EventKind::claim, of_next(rig));
  CHECK(rig.reply<ClaimReply>().claim_id == rig.claim_id);
  rig.next_tick();
  const SafeChunk again = rig.get<SafeChunk>(OutputKind::safe_chunk);
  CHECK(again.verdict_id == before.verdict_id);
  CHECK(again.source == "runner");
}

TEST_CASE("an offer is for whom it names, and for a while: others are told the holder") {
  GateRig rig;
  rig.ready();
  offer_to(rig, "somebody");
  rig.send(EventKind::claim, of_next(rig));
  CHECK(rig.refusal().reason == "part arm is held by runner (test-skill)");
  SUBCASE("nobody came") {
    rig.next_tick();
    rig.timer(301 * ms);
    CHECK(rig.get<Lease>(OutputKind::lease).grants.empty());
  }
  SUBCASE("it comes for other parts: the offered claim ends") {
    Claim other = rig.claim_request({"arm"});
    other.source = "somebody";
    rig.send(EventKind::claim, other);
    CHECK(rig.reply<ClaimReply>().claim_id != rig.claim_id);
    rig.next_tick();
    REQUIRE(rig.get<Lease>(OutputKind::lease).grants.size() == 1);
    CHECK(rig.get<Lease>(OutputKind::lease).grants[0].source == "somebody");
  }
}

TEST_CASE(
    "G005 a chunk from before a hand-over stays refused when its source has the claim again") {
  GateRig rig;
  rig.ready();
  ChunkBuilder old = rig.chunk({0.1, 0.1});
  old.chunk.seq = 7;
  REQUIRE(rig.send_chunk(old).code == 0);
  for (int round = 0; round < 4; ++round) {
    rig.send(EventKind::release, Release{round % 2 == 0 ? "runner" : "next", rig.claim_id,
                                         round % 2 == 0 ? "next" : "runner"});
    Claim next = rig.claim_request();
    next.source = round % 2 == 0 ? "next" : "runner";
    rig.send(EventKind::claim, next);
    REQUIRE(rig.reply<ClaimReply>().claim_id == rig.claim_id);
    if (round % 2 == 1) CHECK(rig.send_chunk(old).code == code::sequence);
  }
  old.chunk.seq = 8;
  CHECK(rig.send_chunk(old).code == 0);
}

TEST_CASE("a claim that is offered to its own source may send no more for that") {
  GateRig rig;
  rig.ready();
  const auto offer_to_itself = [&rig] {
    offer_to(rig, "runner");
    rig.send(EventKind::claim, rig.claim_request());
    return rig.reply<ClaimReply>().claim_id == rig.claim_id;
  };
  SUBCASE("G010") {
    std::size_t released = 0;
    for (int i = 0; i < 20; ++i) {
      released += rig.send_chunk(rig.chunk()).code == 0 ? 1U : 0U;
      REQUIRE(offer_to_itself());
    }
    CHECK(released < 10);
  }
  SUBCASE("G001") {
    auto cut = rig.chunk().frame();
    cut.pop_back();
    for (int i = 0; i < 4; ++i) {
      rig.send_frame(EventKind::candidate, cut, "runner");
      REQUIRE(offer_to_itself());
    }
    rig.send_frame(EventKind::candidate, cut, "runner");
    CHECK(rig.status().claims.empty());
  }
  SUBCASE("G006") {
    for (int i = 0; i < 4; ++i) {
      ChunkBuilder ahead = rig.chunk();
      ahead.chunk.obs_tick += 9;
      CHECK(rig.send_chunk(ahead).code == 6);
      REQUIRE(offer_to_itself());
    }
    ChunkBuilder ahead = rig.chunk();
    ahead.chunk.obs_tick += 9;
    rig.send_chunk(ahead);
    CHECK(rig.gate->state() == GateState::stopped);
  }
}
