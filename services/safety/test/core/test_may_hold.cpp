// Realtime, two claims of an arm each: the row that one arm is to execute in the tick that runs was
// revoked, or its claim has ended. It acts if the HAL has not heard of that yet, and else holds:
// the other arm's rows have to be clear of both.

#include <doctest/doctest.h>

#include "two_claims.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::two_arms;

namespace {

// The left arm begins to move, and its claim may end while it does.
std::uint32_t beside_a_claim(bool ends, double left_row, double right_row) {
  TwoClaims rig(-1.9, 1.35, 40.0);
  CHECK(rig.send_rows(left, {left_row, left_row, left_row}).code == 0);
  rig.next_state(-1.9, 1.35, 0.0, Acted{});
  if (ends) rig.send(EventKind::release, Release{"a", rig.claims[left]});
  return rig.send_rows(right, {right_row}).code;
}

}  // namespace

TEST_CASE("an arm whose rows were revoked may go on and brake, not turn back") {
  TwoClaims rig(-1.9775, 1.256, 4.0, 0.1);
  const Verdict there_and_back =
      rig.send_rows(left, {-1.9439, -1.8984, -1.8529, -1.8655, -1.8781, -1.8907, -1.9033});
  CHECK(there_and_back.code == 0);
  const auto row = [&](std::uint32_t index) { return Acted{0, there_and_back.verdict_id, index}; };
  rig.next_state(-1.9775, 1.256, 0.0, Acted{});
  rig.next_state(-1.9439, 1.256, 0.672, row(0));
  rig.next_state(-1.8984, 1.2566, 0.91, row(1));  // the right arm is nearer by a hair
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
  rig.next_state(-1.8529, 1.2566, 0.91, row(2));
  const Verdict verdict = rig.send_rows(right, {1.286, 1.2573, 1.2286, 1.1999, 1.1712});
  CHECK(verdict.code == 32);
  CHECK(verdict.value < 0.0);
}

// The left arm goes on, and then turns back by a newer chunk; of its rows for later ticks the gate
// revokes all but the first when the right arm comes nearer.
std::uint32_t beside_a_newer_chunk(double nearer) {
  TwoClaims rig(-1.9775, 1.23, 4.0, 0.1);
  Row targets;
  for (int k = 1; k <= 8; ++k) targets.push_back(-1.9775 + 0.03 * k);
  const std::uint64_t first = rig.send_rows(left, targets).verdict_id;
  rig.next_state(-1.9775, 1.23, 0.0, Acted{});
  rig.next_state(targets[0], 1.23, 0.6, Acted{0, first, 0});
  rig.next_state(targets[1], 1.23, 0.6, Acted{0, first, 1});
  rig.next_state(targets[2], 1.23 + nearer, 0.6, Acted{0, first, 2});
  CHECK(rig.lease().grants[0].until_tick == rig.tick + (nearer > 0.0 ? 1 : 2));
  const double turn = targets[4];
  const Verdict newer = rig.send_rows(left, {turn, turn - 0.02, turn - 0.04});
  CHECK(newer.code == 0);
  rig.next_state(targets[3], 1.23 + nearer, 0.6, Acted{0, first, 3});
  rig.next_state(turn, 1.23 + nearer, 0.6, Acted{0, newer.verdict_id, 0});
  return rig.send_rows(right, {1.21 + nearer}).code;
}

TEST_CASE("an arm may hold in the tick after the last one that a lease had granted") {
  CHECK(beside_a_newer_chunk(0.0) == 0);
  CHECK(beside_a_newer_chunk(0.012) == 32);
}

TEST_CASE("an arm whose claim has ended may stay where its row would have led away from") {
  CHECK(beside_a_claim(false, -1.96, 1.395) == 0);
  CHECK(beside_a_claim(true, -1.96, 1.395) == 32);
}

TEST_CASE("an arm whose claim has ended may still execute the row that runs") {
  CHECK(beside_a_claim(true, -1.9, 1.385) == 0);
  CHECK(beside_a_claim(true, -1.8, 1.385) == 32);
}
