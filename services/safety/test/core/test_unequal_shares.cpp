// Of each row another share may happen: how far that leads from where equal shares do. What the
// gate makes of it is in test_unequal_rows.cpp.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/trajectory/unequal_shares.hpp"

using namespace fairlead;

namespace {

constexpr JointSet first_two = 0b11;
constexpr Joints nothing{};

Joints joints(double a, double b) {
  Joints joints{};
  joints[0] = a;
  joints[1] = b;
  return joints;
}

// Of rows that the upper ends take so far and the lower ones nowhere.
UnequalShares of(std::initializer_list<Joints> rows, bool leaves_rest = false) {
  UnequalShares shares;
  for (const Joints& row : rows) shares.add_row(first_two, nothing, row, leaves_rest);
  return shares;
}

void check_off(const UnequalShares& shares, const Joints& stop, double a, double b) {
  Joints off;
  shares.bound(stop, off);
  CHECK(off[0] == doctest::Approx(a));
  CHECK(off[1] == doctest::Approx(b));
  CHECK(off[2] == 0.0);
}

}  // namespace

TEST_CASE("unequal shares: how far they lead from where equal ones do") {
  check_off(of({joints(1, 3)}), nothing, 0.0, 0.0);
  check_off(of({joints(1, 3), joints(2, 6)}), nothing, 0.0, 0.0);  // straight on
  check_off(of({joints(1, 0), joints(0, 1)}), nothing, 0.5, 0.5);  // any corner of a square
  check_off(of({joints(1, 0), joints(-1, 0)}), nothing, 1.0, 0.0);
  check_off(of({joints(1, 0), joints(-0.5, 0)}), nothing, 0.5, 0.0);  // up to 1, equal ones to 0.5
  // The last row's stop takes it a further row; weights of 1 and 4.
  check_off(of({joints(1, 0), joints(0, 1)}), joints(0, 1), 0.8, 0.5);
  check_off(of({joints(1, 0), joints(0, 1)}), joints(0, -1), 0.5, 0.5);
  check_off(of({joints(1, 3), joints(2, 6)}, true), nothing, 1.5, 4.5);
  UnequalShares one_leaves = of({joints(1, 3)}, true);
  one_leaves.add_row(first_two, nothing, joints(2, 6), false);
  check_off(one_leaves, nothing, 1.5, 4.5);
}

TEST_CASE("unequal shares: which rows there are, and from where they are counted") {
  UnequalShares shares = of({joints(1, 3)});
  CHECK_FALSE(shares.can_differ());
  shares.add_row(first_two, joints(5, 7), joints(5, 8), false);
  CHECK(shares.can_differ());
  // (1, 3) and (0, 1) add up to (1, 4), along which they go 13 and 4.
  check_off(shares, nothing, 0.5 * (4.0 / 17 + 4.0 / 17), 0.5 * (1.0 / 17 + 1.0 / 17));
  shares.clear();
  shares.add_row(first_two, nothing, joints(1, 3), false);
  CHECK_FALSE(shares.can_differ());
}

TEST_CASE("unequal shares: of any rows, no shares lead farther off than that") {
  std::mt19937 random(7);
  std::uniform_real_distribution<> size(-1.0, 1.0);
  for (std::size_t walk = 0; walk < 300; ++walk) {
    const std::size_t count = 2 + walk % 4;
    std::vector<Joints> rows;
    UnequalShares shares;
    const Joints around = joints(size(random), size(random));  // some walks keep their direction
    const double bend = walk % 3 == 0 ? 0.1 : 1.0;
    for (std::size_t row = 0; row < count; ++row) {
      rows.push_back(joints(around[0] + bend * size(random), around[1] + bend * size(random)));
      shares.add_row(first_two, nothing, rows.back(), false);
    }
    const Joints stop = walk % 2 == 0 ? joints(size(random), size(random)) : nothing;
    Joints off;
    shares.bound(stop, off);
    for (const bool stopped : {false, true})
      for (unsigned corner = 0; corner < (1U << count); ++corner) {
        Joints place{}, all{};
        for (std::size_t row = 0; row < count; ++row)
          for (const std::size_t j : {0U, 1U}) {
            const double way = rows[row][j] + (stopped && row + 1 == count ? stop[j] : 0.0);
            all[j] += way;
            if ((corner >> row & 1U) != 0) place[j] += way;
          }
        double nearest = 1e9;  // beyond the bound of the joint that is furthest beyond
        for (double t = 0.0; t <= 1.0; t += 1e-3)
          nearest = std::min(nearest, std::max(std::abs(place[0] - t * all[0]) - off[0],
                                               std::abs(place[1] - t * all[1]) - off[1]));
        CHECK(nearest <= 5e-3);
      }
  }
}
