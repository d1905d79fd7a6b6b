// G010: how many chunks a claim's rate admits, in how many ticks.

#include <doctest/doctest.h>

#include <memory>

#include "chunk_builder.hpp"
#include "core/gate/admission.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

struct Admitted {
  std::uint64_t ticks = 0;
  std::size_t chunks = 0;
  bool operator==(const Admitted&) const = default;
};

// For a robot whose ticks are 50 ms.
Admitted admitted(double rate_hz) {
  const Limits limits = test_limits();
  REQUIRE(limits.period_ns == 50'000'000);
  Claim request;
  request.source = "runner";
  request.skill = "test";
  request.skill_hash = hash_of(3);
  request.robot_hash = limits.robot_hash;
  request.period_ns = limits.period_ns;
  (void)request.parts.push_back(limits.parts[0].name);
  request.chunk_rate_hz = rate_hz;
  request.horizon_max = 1;
  request.age_max_ticks = 1;
  const auto table = std::make_unique<ClaimTable>();
  const auto place = std::make_unique<LiveClaim>();
  const Objection objection = admit_claim(limits, *table, request, *place);
  CHECK(objection.reason == "");
  return {place->admitted_window, place->admitted_limit};
}

}  // namespace

TEST_CASE("G010 a rate is counted over 250 ms, or two chunks where that is longer") {
  CHECK(admitted(20.0) == Admitted{5, 7});  // 1.2 x 20 x 0.25 = 6
  CHECK(admitted(10.0) == Admitted{5, 4});  // 1.2 x 10 x 0.25 = 3
  CHECK(admitted(8.0) == Admitted{5, 4});   // 2.4
  CHECK(admitted(5.0) == Admitted{8, 4});   // two chunks in 400 ms: 2.4
  CHECK(admitted(2.0) == Admitted{20, 4});  // in 1 s: 2.4
  CHECK(admitted(0.125) == Admitted{320, 4});
}

TEST_CASE("G010 a window that is no whole number of ticks ends with the tick begun") {
  CHECK(admitted(2.0 / 0.300025) == Admitted{7, 4});  // 6.0005 ticks; 1.2 x 2 x 7 / 6.0005 = 2.8
  CHECK(admitted(10.002) == Admitted{5, 5});          // 1.2 x 10.002 x 0.25 = 3.0006
}

TEST_CASE("G010 a rate that next to never sends is counted over as many ticks as there are") {
  CHECK(admitted(1e-300) == Admitted{UINT32_MAX, 1});
}
