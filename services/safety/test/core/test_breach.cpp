// A margin beyond its limit is a breach, unless the row finds it so and does not make it worse.

#include <doctest/doctest.h>

#include "boundary.hpp"
#include "core/geometry/distances.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

bool breach(double margin, double before) {
  return is_breach(margin, [before] { return before; });
}

}  // namespace

TEST_CASE("a margin of 0 keeps the limit, whatever it was before") {
  CHECK_FALSE(breach(0.0, 0.5));
  CHECK_FALSE(breach(0.0, -0.5));
  CHECK_FALSE(breach(infinite, 0.5));
  CHECK(breach(just_below(0.0), 0.5));
}

TEST_CASE("what was beyond its limit may stay there or come back, but for a rounding error") {
  CHECK_FALSE(breach(-0.5, -0.5));
  CHECK_FALSE(breach(-0.4, -0.5));
  CHECK_FALSE(breach(-0.5 - 0.9e-6, -0.5));
  CHECK(breach(-0.5 - 1.1e-6, -0.5));
  CHECK_FALSE(breach(-0.5 - unchanged, -0.5));
  const auto better = [](double margin) {
    return is_breach(margin, [] { return -0.5; }, Excuse::better);
  };
  CHECK_FALSE(better(-0.5 + unchanged));
  CHECK(better(just_below(-0.5 + unchanged)));
}

TEST_CASE("what was at its limit may not leave it, not even by a rounding error") {
  CHECK(breach(-1e-7, 0.0));
  CHECK_FALSE(breach(-1e-7, -1e-9));
}

TEST_CASE("a margin that is no number is a breach, and so is one that follows it") {
  CHECK(breach(not_a_number, 0.5));
  CHECK(breach(not_a_number, -0.5));
  CHECK(breach(-0.5, not_a_number));
}

TEST_CASE("what is no number is the smaller and the larger one of two") {
  for (const double number : {-1.0, 0.0, infinite, -infinite}) {
    CHECK(std::isnan(smaller(not_a_number, number)));
    CHECK(std::isnan(smaller(number, not_a_number)));
    CHECK(std::isnan(larger(not_a_number, number)));
    CHECK(std::isnan(larger(number, not_a_number)));
  }
  CHECK(smaller(1.0, 2.0) == 1.0);
  CHECK(smaller(2.0, 1.0) == 1.0);
  CHECK(larger(1.0, 2.0) == 2.0);
  CHECK(larger(2.0, 1.0) == 2.0);
}
