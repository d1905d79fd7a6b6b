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
constexpr Gain none_to_all{0.0, 1.0};

Joints joints(double a, double b) {
  Joints joints{};
  joints[0] = a;
  joints[1] = b;
  return joints;
}

// Of rows that the upper ends take so far and the lower ones nowhere.
UnequalShares of(std::initializer_list<Joints> rows, const Gain* gain = &none_to_all) {
  UnequalShares shares;
  shares.begin(first_two);
  for (const Joints& row : rows) shares.add_row({nothing, row, {gain}});
  return shares;
}

void check_off(const UnequalShares& shares, const Joints* stop, double a, double b) {
  Joints off{};
  shares.raise_to_bound(stop, off);
  CHECK(off[0] == doctest::Approx(a));
  CHECK(off[1] == doctest::Approx(b));
  CHECK(off[2] == 0.0);
}

// Rows as they are asked for, in turn; of each a share.
struct Asked {
  Joints row;
  bool goes_on = false;
};

// Where each row leads, if of it that share happens and the next goes on from there.
std::vector<Joints> ways(const std::vector<Asked>& rows, const std::vector<double>& shares) {
  std::vector<Joints> found;
  Joints left{};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Joints& way = found.emplace_back();
    way.fill(0.0);
    for (const std::size_t j : {0U, 1U}) {
      const double asked = rows[k].row[j] + (rows[k].goes_on ? left[j] : 0.0);
      way[j] = shares[k] * asked;
      left[j] = asked - way[j];
    }
  }
  return found;
}

Joints place(const std::vector<Joints>& ways) {
  Joints sum{};
  for (const Joints& way : ways)
    for (const std::size_t j : {0U, 1U}) sum[j] += way[j];
  return sum;
}

UnequalShares of(const std::vector<Asked>& rows, const Gain& gain) {
  UnequalShares shares;
  shares.begin(first_two);
  const std::vector<Joints> lower = ways(rows, std::vector<double>(rows.size(), gain.lower));
  const std::vector<Joints> upper = ways(rows, std::vector<double>(rows.size(), gain.upper));
  for (std::size_t k = 0; k < rows.size(); ++k)
    shares.add_row({lower[k], upper[k], {&gain, rows[k].goes_on}});
  return shares;
}

}  // namespace

TEST_CASE("unequal shares: how far they lead from where equal ones do") {
  check_off(of({joints(1, 3)}), nullptr, 0.0, 0.0);
  check_off(of({joints(1, 3), joints(2, 6)}), nullptr, 0.0, 0.0);  // straight on
  check_off(of({joints(0, 0), joints(2, 6)}), nullptr, 0.0, 0.0);
  check_off(of({joints(1, 0), joints(0, 1)}), nullptr, 0.5, 0.5);  // any corner of a square
  check_off(of({joints(1, 0), joints(-1, 0)}), nullptr, 1.0, 0.0);
  check_off(of({joints(1, 0), joints(-0.5, 0)}), nullptr, 0.5, 0.0);  // to 1, equal ones to 0.5
  // The last row's stop takes it a further row; weights of 1 and 4.
  const Joints on = joints(0, 1), back = joints(0, -1);
  check_off(of({joints(1, 0), joints(0, 1)}), &on, 0.8, 0.4);
  check_off(of({joints(1, 0), joints(0, 1)}), &back, 0.0, 0.0);
  // Other parts' shares move it along: nobody knows which are equal.
  check_off(of({joints(1, 3), joints(2, 6)}, nullptr), nullptr, 3.0, 9.0);
  check_off(of({joints(0, 0), joints(0, 0)}, nullptr), nullptr, 0.0, 0.0);
}

TEST_CASE("unequal shares: bounds are raised, never lowered, and a new part begins without rows") {
  UnequalShares shares = of({joints(1, 0), joints(0, 1)});
  Joints off = joints(0.75, 0.25);
  shares.raise_to_bound(nullptr, off);
  CHECK(off[0] == 0.75);
  CHECK(off[1] == 0.5);
  shares.begin(first_two);
  shares.add_row({nothing, joints(0, 1), {&none_to_all}});
  check_off(shares, nullptr, 0.0, 0.0);
  UnequalShares again = of({joints(1, 3), joints(2, 6)}, nullptr);  // followed others
  again.begin(first_two);
  for (const Joints& row : {joints(1, 3), joints(2, 6)})
    again.add_row({nothing, row, {&none_to_all, true}});
  check_off(again, nullptr, 0.0, 0.0);
}

TEST_CASE("unequal shares: what a row leaves is asked for again where the next goes on") {
  constexpr Gain half_to_all{0.5, 1.0}, fifth_to_half{0.2, 0.5};
  const auto two = [](bool goes_on) {
    return std::vector<Asked>{{joints(1, 0)}, {joints(0, 1), goes_on}};
  };
  check_off(of(two(false), half_to_all), nullptr, 0.25, 0.25);
  // Widths of 1/4 and 1/2: what the upper end leaves is nothing, the lower one a quarter.
  check_off(of(two(true), half_to_all), nullptr, 0.2, 0.1);
  // Widths of 0.64 - 0.25 and 0.8 - 0.5.
  const double first = 0.39, second = 0.3, all = first * first + second * second;
  check_off(of(two(true), fifth_to_half), nullptr, first * second * second / all,
            second * first * first / all);
  // A third row that does not go on leaves the first two as they are.
  std::vector<Asked> three = two(true);
  three.push_back({joints(0, 0)});
  check_off(of(three, fifth_to_half), nullptr, first * second * second / all,
            second * first * first / all);
  check_off(of(std::vector<Asked>{{joints(1, 3)}, {joints(2, 6), true}, {joints(1, 3), true}},
               fifth_to_half),
            nullptr, 0.0, 0.0);
}

TEST_CASE("unequal shares: of any rows, no shares lead farther off than that") {
  std::mt19937 random(7);
  std::uniform_real_distribution<> size(-1.0, 1.0), half(0.0, 0.5);
  for (std::size_t walk = 0; walk < 400; ++walk) {
    const std::size_t count = 2 + walk % 4;
    std::vector<Asked> rows;
    const Joints around = joints(size(random), size(random));  // some walks keep their direction
    const double bend = walk % 3 == 0 ? 0.1 : 1.0;
    for (std::size_t k = 0; k < count; ++k)
      rows.push_back({joints(around[0] + bend * size(random), around[1] + bend * size(random)),
                      walk % 5 < 2 || (walk % 5 == 2 && size(random) > 0.0)});
    const Gain gain{half(random), 0.5 + half(random)};
    const UnequalShares shares = of(rows, gain);
    const Joints lowest = place(ways(rows, std::vector<double>(count, gain.lower)));
    const Joints highest = place(ways(rows, std::vector<double>(count, gain.upper)));
    Joints off{};
    shares.raise_to_bound(nullptr, off);
    for (unsigned corner = 0; corner < (1U << count); ++corner) {
      std::vector<double> happen;
      for (std::size_t k = 0; k < count; ++k)
        happen.push_back((corner >> k & 1U) != 0 ? gain.upper : gain.lower);
      const Joints here = place(ways(rows, happen));
      double nearest = 1e9;  // beyond the bound of the joint that is furthest beyond
      for (double t = 0.0; t <= 1.0; t += 1e-3) {
        const auto beyond = [&](std::size_t j) {
          return std::abs(here[j] - lowest[j] - t * (highest[j] - lowest[j])) - off[j];
        };
        nearest = std::min(nearest, std::max(beyond(0), beyond(1)));
      }
      CHECK(nearest <= 5e-3);
    }
  }
}

TEST_CASE("unequal shares: the newest row is as fast as any shares make it, and no faster") {
  std::mt19937 random(8);
  std::uniform_real_distribution<> size(-1.0, 1.0), half(0.05, 0.5), more(0.5, 1.0);
  for (std::size_t walk = 0; walk < 400; ++walk) {
    const std::size_t count = 1 + walk % 4;
    std::vector<Asked> rows;
    for (std::size_t k = 0; k < count; ++k)
      rows.push_back({joints(size(random), size(random)), walk % 3 != 0 || size(random) > 0.0});
    const Gain gain{half(random), more(random)};
    Joints least = joints(1e9, 1e9), most = joints(-1e9, -1e9);
    for (unsigned corner = 0; corner < (1U << count); ++corner) {
      std::vector<double> happen;
      for (std::size_t k = 0; k < count; ++k)
        happen.push_back((corner >> k & 1U) != 0 ? gain.upper : gain.lower);
      const Joints newest = ways(rows, happen).back();
      for (const std::size_t j : {0U, 1U}) {
        least[j] = std::min(least[j], newest[j]);
        most[j] = std::max(most[j], newest[j]);
      }
    }
    Joints lowest = joints(1e9, -1e9), highest = joints(-1e9, 1e9);
    const bool differs = of(rows, gain).widen_speeds(1.0, nothing, nothing, lowest, highest);
    CHECK(differs == (rows.back().goes_on && count > 1));
    CHECK(lowest[0] == (differs ? doctest::Approx(least[0]) : 1e9));
    CHECK(lowest[1] == -1e9);
    CHECK(highest[0] == (differs ? doctest::Approx(most[0]) : -1e9));
    CHECK(highest[1] == 1e9);
  }
}

TEST_CASE(
    "unequal shares: what each end asks of a joint where it leads bounds what shares can ask") {
  // Half or all happens. As if the joint were asked for 0.1 at the upper end, for 0.2 at the lower.
  constexpr Gain gain{0.5, 1.0};
  UnequalShares shares;
  shares.begin(first_two);
  shares.add_row({joints(0.1, -0.1), joints(0.1, -0.1), {&gain}});
  shares.add_row({joints(0.1, -0.1), joints(0.1, -0.1), {&gain, true}});
  // What is left: nothing to 0.1. Asked by the second row: 0.1 by the upper, 0.1 by the lower end.
  Joints least = nothing, most = nothing;
  CHECK(shares.widen_speeds(1.0, nothing, nothing, least, most));
  CHECK(most[0] == doctest::Approx(0.2));
  CHECK(least[0] == 0.0);
  CHECK(least[1] == doctest::Approx(-0.2));
  CHECK(most[1] == 0.0);
  // By where it starts 0.03 less or 0.04 more.
  CHECK(shares.widen_speeds(0.5, joints(0.03, 0.03), joints(0.04, 0.04), least, most));
  CHECK(most[0] == doctest::Approx((0.2 + 0.04) / 0.5));
  CHECK(least[1] == doctest::Approx((-0.2 - 0.03) / 0.5));
  least = most = nothing;
  shares.add_row({joints(0.3, 0), joints(0.1, 0), {&gain, true}});
  // Left: nothing to 0.1; asked: 0.1, or (0.3 - 0.5 * 0.1) / 0.5.
  CHECK(shares.widen_speeds(1.0, nothing, nothing, least, most));
  CHECK(most[0] == doctest::Approx(0.5 + 0.1));
}

TEST_CASE("unequal shares: what a row without a share leaves is nothing to the next") {
  constexpr Gain gain{0.5, 1.0};
  UnequalShares shares;
  shares.begin(first_two);
  shares.add_row({joints(0.5, 0), joints(1, 0), {&gain}});
  shares.add_row({joints(0.75, 0), joints(1, 0), {&gain, true}});
  Joints least = nothing, most = nothing;
  CHECK(shares.widen_speeds(0.1, nothing, nothing, least, most));
  CHECK(most[0] == doctest::Approx(15.0));
  shares.add_row({joints(0.5, 0), joints(0.5, 0), {}});
  CHECK(!shares.widen_speeds(1.0, nothing, nothing, least, most));
  shares.add_row({joints(0.5, 0), joints(1, 0), {&gain, true}});
  most = nothing;
  CHECK(shares.widen_speeds(1.0, nothing, nothing, least, most));
  CHECK(most[0] == 1.0);
}

TEST_CASE("unequal shares: of a lower end of nothing the upper one says what is asked") {
  UnequalShares shares;
  shares.begin(first_two);
  shares.add_row({nothing, joints(1, 0), {&none_to_all}});
  shares.add_row({nothing, joints(1, 0), {&none_to_all, true}});
  Joints least = nothing, most = nothing;
  CHECK(shares.widen_speeds(1.0, nothing, nothing, least, most));
  CHECK(most[0] == 2.0);
}
