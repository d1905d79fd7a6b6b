// Symmetric six by six matrices: which are positive definite, and what solves them.

#include <doctest/doctest.h>

#include <new>

#include "boundary.hpp"
#include "core/kinematics/inverse_kinematics.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("a matrix is definite while every pivot is above 0, each of the six") {
  CHECK(Factors6(Square6::Identity()).definite());
  for (int i = 0; i < 6; ++i)
    for (const double pivot : {0.0, -1.0, not_a_number}) {
      Square6 matrix = Square6::Identity();
      matrix(i, i) = pivot;
      CHECK_FALSE(Factors6(matrix).definite());
    }
}

namespace {

Square6 heavy_diagonal() {
  Square6 matrix;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) matrix(i, j) = i == j ? 10.0 + i : 1.0 / (1 + i + j);
  return matrix;
}

}  // namespace

TEST_CASE("the solution, multiplied again, is the right side") {
  Motion6 right;
  right << 1.0, -2.0, 3.0, -4.0, 5.0, -6.0;
  const Factors6 factors(heavy_diagonal());
  CHECK(factors.definite());
  CHECK((heavy_diagonal() * factors.solve(right) - right).norm() < 1e-12);
}

TEST_CASE("the solution is six numbers long: what lies behind it is not written") {
  alignas(64) double room[8] = {7.0, 7.0, 7.0, 7.0, 7.0, 7.0, 7.0, 7.0};
  const Factors6 factors(heavy_diagonal());
  const auto* solution = new (room) Motion6(factors.solve(Motion6::Ones()));
  CHECK((*solution)[5] != 7.0);
  CHECK(room[6] == 7.0);
  CHECK(room[7] == 7.0);
}
