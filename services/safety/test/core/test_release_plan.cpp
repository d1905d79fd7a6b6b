// What the gate takes the HAL to do: the plan of one claim, by itself.

#include <doctest/doctest.h>

#include <memory>

#include "chunk_builder.hpp"
#include "core/release/claim_table.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted holds{static_cast<std::uint8_t>(Hold::no_row), 0, 0};

Acted row(std::uint64_t verdict_id, std::uint32_t number) { return {0, verdict_id, number}; }

std::vector<std::uint8_t> frame_with(std::uint64_t seq, std::size_t rows) {
  ChunkBuilder builder;
  builder.joint(base, Mode::joint_velocity, base_x, Row(rows, 0.25));
  builder.chunk.seq = seq;
  return builder.frame();
}

// Too big for the stack.
struct Plan {
  std::unique_ptr<ReleasePlan> plan = std::make_unique<ReleasePlan>();
  ReleasePlan* operator->() const { return plan.get(); }

  /// A chunk of ten rows with that seq, released from its second row on: three rows.
  void release(std::uint64_t verdict_id, std::uint64_t first_tick, const Acted& after,
               std::uint64_t seq = 1) {
    plan->release(made(verdict_id, first_tick, after), frame_with(seq, 10));
  }
  static Released made(std::uint64_t verdict_id, std::uint64_t first_tick, const Acted& after) {
    Released released;
    released.verdict_id = verdict_id;
    released.first_tick = first_tick;
    released.row_count = 3;
    released.first_row = 1;
    released.after = after;
    return released;
  }
};

bool expects(const Plan& plan, const Acted& act) {
  const Acted& expected = plan->expected();
  return expected.hold == act.hold && expected.verdict_id == act.verdict_id &&
         expected.row == act.row;
}

}  // namespace

TEST_CASE("a release is taken at its first tick after what it says, and goes on row by row") {
  Plan plan;
  CHECK(plan->current() == nullptr);
  CHECK_FALSE(plan->on_track());
  plan->begin_tick(100, holds);
  CHECK_FALSE(plan->on_track());
  plan.release(7, 101, holds);
  CHECK(plan->on_track());
  REQUIRE(plan->current() != nullptr);
  CHECK(plan->current()->verdict_id == 7);
  CHECK_FALSE(plan->current()->seen);

  plan->begin_tick(101, holds);
  CHECK(expects(plan, row(7, 0)));
  CHECK(plan->on_track());
  CHECK_FALSE(plan->current()->seen);
  plan->begin_tick(102, row(7, 0));
  CHECK(expects(plan, row(7, 1)));
  CHECK(plan->current()->seen);
  plan->begin_tick(103, row(7, 1));
  CHECK(expects(plan, row(7, 2)));
  CHECK(plan->on_track());
  // After its last row there is nothing: a hold.
  plan->begin_tick(104, row(7, 2));
  CHECK(expects(plan, holds));
  CHECK(plan->current() == nullptr);
  CHECK_FALSE(plan->on_track());
}

TEST_CASE("a release that the HAL did not take, or left, is off the track") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, row(6, 4));
  plan->begin_tick(101, holds);  // something else acted than it comes after
  CHECK(expects(plan, holds));
  CHECK_FALSE(plan->on_track());
  CHECK(plan->current() != nullptr);
  plan->begin_tick(102, holds);
  CHECK_FALSE(plan->on_track());
  plan->begin_tick(103, holds);
  CHECK(plan->current() != nullptr);
  plan->begin_tick(104, holds);
  CHECK(plan->current() == nullptr);
}

TEST_CASE("a row of a wrong tick continues nothing") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds);
  plan->begin_tick(103, row(7, 0));  // row 0 was for tick 101, and this is what tick 102 did
  CHECK(expects(plan, holds));
  CHECK_FALSE(plan->on_track());
  CHECK(plan->current()->seen);
}

TEST_CASE("a new release replaces the rest of the old one, which the HAL may still be in") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds);
  plan->begin_tick(101, holds);
  plan.release(8, 102, row(7, 0), 2);
  CHECK(plan->current()->verdict_id == 8);
  plan->begin_tick(102, row(7, 0));
  CHECK(expects(plan, row(8, 0)));
  CHECK(plan->on_track());
  CHECK_FALSE(plan->current()->seen);
  // The HAL did not get it: it goes on with the old one, for as long as that has rows.
  plan->begin_tick(103, row(7, 1));
  CHECK(expects(plan, row(7, 2)));
  CHECK_FALSE(plan->on_track());
  CHECK_FALSE(plan->current()->seen);
  plan->begin_tick(104, row(7, 2));
  CHECK(expects(plan, holds));
}

TEST_CASE("the row behind an act: of the chunk it came from, counted from its first released row") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds, 41);
  CHECK(plan->row_of(row(7, 0)).row == 1);
  CHECK(plan->row_of(row(7, 2)).row == 3);
  REQUIRE(plan->row_of(row(7, 2)).chunk != nullptr);
  CHECK(plan->row_of(row(7, 2)).chunk->seq == 41);
  CHECK(plan->row_of(row(7, 3)).chunk == nullptr);  // it has three rows
  CHECK(plan->row_of(row(8, 0)).chunk == nullptr);
  CHECK(plan->row_of(holds).chunk == nullptr);
  CHECK(plan->row_of({static_cast<std::uint8_t>(Hold::no_row), 7, 0}).chunk == nullptr);
  CHECK(plan->row_of(row(0, 0)).chunk == nullptr);  // an empty place in the ring has verdict 0
}

TEST_CASE("rows that act now or acted before are kept while newer candidates come") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds, 41);
  plan->begin_tick(101, holds);  // 7 row 0 is expected
  for (std::uint64_t i = 1; i <= 40; ++i) {
    plan.release(100 + i, 102, row(7, 0), 41 + i);
    CHECK(plan->chunk_of(*plan->current()).seq == 41 + i);
    REQUIRE(plan->row_of(row(100 + i, 0)).chunk != nullptr);
    CHECK(plan->row_of(row(100 + i, 0)).chunk->seq == 41 + i);
    // With one place taken, the newest three candidates are there.
    for (std::uint64_t past = 1; past < 3 && past < i; ++past)
      CHECK(plan->row_of(row(100 + i - past, 0)).chunk != nullptr);
    if (i > 15) continue;  // the ring remembers sixteen releases
    REQUIRE(plan->row_of(row(7, 0)).chunk != nullptr);
    CHECK(plan->row_of(row(7, 0)).chunk->seq == 41);
  }
}

TEST_CASE("the numbers of a release whose place was used again are gone, not another chunk's") {
  Plan plan;
  plan->begin_tick(100, holds);
  for (std::uint64_t i = 1; i <= 6; ++i) plan.release(i, 101, holds, 40 + i);
  for (std::uint64_t i = 1; i <= 6; ++i) {
    const RowBefore found = plan->row_of(row(i, 0));
    const bool gone = found.chunk == nullptr;
    CHECK((gone || found.chunk->seq == 40 + i));
    CHECK(gone == (i <= 2));  // four places
  }
}

TEST_CASE("verdict 1 is one like any other: found while it is remembered, and not after that") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(1, 101, holds, 41);
  REQUIRE(plan->row_of(row(1, 0)).chunk != nullptr);
  CHECK(plan->row_of(row(1, 0)).chunk->seq == 41);
  for (std::uint64_t i = 0; i < 20; ++i) plan.release(101 + i, 101, holds);
  CHECK(plan->row_of(row(1, 0)).chunk == nullptr);
}

TEST_CASE("what is left of a candidate is released again under another verdict") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds, 41);
  plan->begin_tick(101, row(3, 3));
  CHECK_FALSE(plan->on_track());
  Released rest = Plan::made(8, 102, holds);
  rest.first_row = 2;
  rest.row_count = 2;
  plan->release_again(rest);
  CHECK(plan->on_track());
  CHECK(plan->current()->verdict_id == 8);
  CHECK(plan->chunk_of(*plan->current()).seq == 41);
  CHECK(plan->row_of(row(8, 1)).row == 3);
  CHECK(plan->row_of(row(7, 1)).row == 2);  // the HAL may still name the old verdict
}

TEST_CASE("dropped and cleared") {
  Plan plan;
  plan->begin_tick(100, holds);
  plan.release(7, 101, holds);
  plan->drop_current();
  CHECK(plan->current() == nullptr);
  CHECK(plan->row_of(row(7, 0)).chunk != nullptr);  // it may have acted
  plan->begin_tick(101, row(7, 0));
  CHECK_FALSE(plan->on_track());

  plan.release(8, 102, holds);
  plan->begin_tick(102, holds);
  CHECK(expects(plan, row(8, 0)));
  plan->clear();
  CHECK(plan->current() == nullptr);
  CHECK_FALSE(plan->on_track());
  CHECK(plan->row_of(row(8, 0)).chunk == nullptr);
  CHECK(plan->expected().hold != 0);
}

TEST_CASE("a stored chunk is a copy of the same bytes only") {
  auto stored = std::make_unique<StoredChunk>();
  CHECK(stored->empty());
  CHECK_FALSE(stored->is_copy_of({}));
  const auto frame = frame_with(9, 2);
  stored->store(frame);
  CHECK_FALSE(stored->empty());
  CHECK(stored->is_copy_of(frame));
  CHECK(stored->chunk().seq == 9);
  CHECK(stored->frame().size() == frame.size());
  auto other = frame;
  other.back() ^= 1U;
  CHECK_FALSE(stored->is_copy_of(other));
  CHECK_FALSE(stored->is_copy_of(Bytes(frame).first(frame.size() - 1)));
  other = frame;
  other.push_back(0);
  CHECK_FALSE(stored->is_copy_of(other));
  // A shorter one in the same place: what was behind it counts no more.
  const auto shorter = frame_with(9, 1);
  stored->store(shorter);
  CHECK(stored->is_copy_of(shorter));
  stored->clear();
  CHECK(stored->empty());
  CHECK_FALSE(stored->is_copy_of(shorter));
}

TEST_CASE("before a hold came nothing, and before a row of a release that is forgotten") {
  Plan plan;
  plan.release(7, 100, holds);
  CHECK(plan->act_before(holds).hold != 0);
  CHECK(plan->act_before(row(99, 2)).hold != 0);
  CHECK(same_act(plan->act_before(row(7, 2)), row(7, 1)));
}

TEST_CASE("rows of a claim that has ended act until the last tick that was granted, no longer") {
  const auto claim = std::make_unique<LiveClaim>();
  Released release;
  release.first_tick = 100;
  release.row_count = 16;
  claim->id = 1;
  CHECK(claim->end_tick_of(release) == 116);
  claim->id = 0;
  claim->leaves_by = 110;
  CHECK(claim->is_leaving());
  CHECK(claim->end_tick_of(release) == 111);
  release.row_count = 11;
  CHECK(claim->end_tick_of(release) == 111);
  release.row_count = 8;  // it has no more
  CHECK(claim->end_tick_of(release) == 108);
  claim->leave();
  CHECK_FALSE(claim->is_leaving());
}
