// What of the candidates gets a turn: each claim its own, and strangers together a little.
#include <doctest/doctest.h>

#include <string_view>
#include <vector>

#include "../core/chunk_builder.hpp"
#include "process/intake.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr std::uint64_t second = 1'000'000'000;

std::vector<std::uint8_t> chunk_of(std::uint64_t claim_id, std::uint64_t seq = 1) {
  ChunkBuilder builder;
  builder.joint(base, Mode::joint_velocity, base_x, {0.0});
  builder.chunk.session = 0xABCD;
  builder.chunk.epoch = 7;
  builder.chunk.claim_id = claim_id;
  builder.chunk.seq = seq;
  return builder.frame();
}

// How many of `count` frames, one a microsecond from `now_ns` on, get a turn.
template <class Make>
int admitted(Intake& intake, int count, std::uint64_t now_ns, const Make& make,
             std::string_view source = "runner") {
  int found = 0;
  for (int i = 0; i < count; ++i)
    found += intake.admits(source, make(i), now_ns + 1000U * static_cast<std::uint64_t>(i)) ? 1 : 0;
  return found;
}

}  // namespace

TEST_CASE("intake: strangers share a hundred frames a second, whatever they cite") {
  Intake intake;
  intake.expect("runner", 0xABCD, 7, 5, {});
  const auto junk = [](int i) {
    const std::vector<std::vector<std::uint8_t>> kinds{{}, {1, 2, 3}, chunk_of(6), {0x9F, 3, 1}};
    return kinds[static_cast<std::size_t>(i) % kinds.size()];
  };
  CHECK(admitted(intake, 1000, second, junk) == 100);
  const int later = admitted(intake, 1000, 2 * second, junk);
  CHECK(later >= 99);
  CHECK(later <= 101);
  CHECK(intake.take_left_out().strangers == 2000 - 100 - static_cast<std::uint64_t>(later));
  CHECK(intake.take_left_out().sum() == 0);
  // Nor do they take anything from the claim.
  CHECK(intake.admits("runner", chunk_of(5), 2 * second));
}

TEST_CASE("intake: strangers share so many bytes, too") {
  Intake intake;
  const auto big = [](int) { return std::vector<std::uint8_t>(65'536, 1); };
  CHECK(admitted(intake, 90, second, big) == 15);  // a megabyte
  CHECK(admitted(intake, 90, 5 * second, big) == 1);
}

TEST_CASE("intake: copies of a claim's newest chunk have a budget of their own") {
  Intake intake;
  intake.expect("runner", 0xABCD, 7, 5, {});
  CHECK(admitted(intake, 1000, second, [](int) { return chunk_of(5); }) == 21);
  CHECK(intake.take_left_out().copies == 979);
  CHECK(admitted(intake, 100, second,
                 [](int i) { return chunk_of(5, 2 + static_cast<std::uint64_t>(i)); }) == 100);
}

TEST_CASE("intake: a claim gets a thousand chunks a second") {
  Intake intake;
  intake.expect("runner", 0xABCD, 7, 5, {});
  const auto next = [](int i) { return chunk_of(5, 1 + static_cast<std::uint64_t>(i)); };
  CHECK(admitted(intake, 1000, second, next) == 200);
  CHECK(intake.take_left_out().excess == 800);
  CHECK(admitted(intake, 1000, 2 * second, next) == 200);
}

TEST_CASE("intake: the claims of one source have their turns, up to as many as may live") {
  Intake intake;
  for (std::uint64_t id = 1; id <= max_claims + 1; ++id) intake.expect("runner", 0xABCD, 7, id, {});
  (void)admitted(intake, 200, second, [](int) { return std::vector<std::uint8_t>{}; });
  CHECK_FALSE(intake.admits("runner", chunk_of(1), second));
  for (std::uint64_t id = 2; id <= max_claims + 1; ++id)
    CHECK(intake.admits("runner", chunk_of(id), second));
}

TEST_CASE("intake: a claim that lives keeps its turns however many others its source has had") {
  Intake intake;
  FixedVec<Grant, max_claims> live;
  Grant grant;
  grant.claim_id = 1;
  (void)live.push_back(grant);
  for (std::uint64_t id = 1; id <= 3 * max_claims; ++id)
    intake.expect("runner", 0xABCD, 7, id, live);
  (void)admitted(intake, 200, second, [](int) { return std::vector<std::uint8_t>{}; });
  CHECK(intake.admits("runner", chunk_of(1), second));
  CHECK(intake.admits("runner", chunk_of(3 * max_claims), second));
  CHECK_FALSE(intake.admits("runner", chunk_of(2), second));
}

TEST_CASE("intake: another claim brings its source no budget beside the one it has") {
  Intake intake;
  const auto next = [&](std::uint64_t id) {
    intake.expect("runner", 0xABCD, 7, id, {});
    return admitted(intake, 300, second,
                    [&](int i) { return chunk_of(id, 1 + static_cast<std::uint64_t>(i)); });
  };
  CHECK(next(5) == 200);
  CHECK(next(6) == 0);
}

TEST_CASE("intake: a claim that is handed over is the next source's; an arming ends all") {
  Intake intake;
  const auto next = [](int i) { return chunk_of(5, 1 + static_cast<std::uint64_t>(i)); };
  intake.expect("runner", 0xABCD, 7, 5, {});
  CHECK(admitted(intake, 300, second, next) == 200);
  intake.expect("other", 0xABCD, 7, 5, {});
  CHECK(admitted(intake, 300, second, next, "other") == 200);
  intake.expect("runner", 0xABCD, 9, 10, {});
  (void)admitted(intake, 200, second, [](int) { return std::vector<std::uint8_t>{}; });
  CHECK_FALSE(intake.admits("runner", chunk_of(5, 2), second));
}

TEST_CASE("intake: what cites another source's claim takes nothing from it") {
  Intake intake;
  intake.expect("runner", 0xABCD, 7, 5, {});
  const auto next = [](int i) { return chunk_of(5, 1 + static_cast<std::uint64_t>(i)); };
  CHECK(admitted(intake, 1000, second, next, "other") <= 100);
  CHECK(admitted(intake, 1000, second, next) == 200);
}
