// How far a measured motion is from those that the tracking model allows: two triangles in space.
#include <doctest/doctest.h>

#include <cmath>

#include "boundary.hpp"
#include "core/monitor/tracking.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Point = Eigen::Vector3d;

const double root_5 = std::sqrt(5.0);

// After a hold in which it was measured to go by 2 along y, told 4 along x, of which a half to all
// happens: the triangle of (0, 0), (0, 2) and (4, 0).
const TrackingSpan after_hold = TrackingSpan::after_hold({0.5, 1.0}, {0, 2, 0}, {4, 0, 0});

}  // namespace

TEST_CASE("G040 motions between standstill, what was measured and what was told are allowed") {
  for (const Point& point : {Point(0, 0, 0), Point(0, 2, 0), Point(4, 0, 0), Point(1, 1, 0),
                             Point(2, 0, 0), Point(0, 1, 0), Point(2, 1, 0)})
    CHECK(after_hold.distance(point) == 0.0);
}

TEST_CASE("G040 a motion beside the plane of the allowed ones is as far off as it is beside it") {
  CHECK(after_hold.distance({1, 1, 0.25}) == 0.25);
  CHECK(after_hold.distance({1, 0.5, -0.5}) == 0.5);
  CHECK(after_hold.distance({0, 0, 3}) == 3.0);
}

TEST_CASE("G040 a motion outside is as far off as the nearest side, or the nearest corner") {
  CHECK(after_hold.distance({-1, 1, 0}) == 1.0);
  CHECK(after_hold.distance({3, -0.5, 0}) == 0.5);
  CHECK(after_hold.distance({4, 2, 0}) == doctest::Approx(4.0 / root_5));
  CHECK(after_hold.distance({6, 0, 0}) == 2.0);
  CHECK(after_hold.distance({0, 5, 4}) == 5.0);
  CHECK(after_hold.distance({-3, -4, 0}) == 5.0);
}

TEST_CASE("G040 after a row: between the shares of both rows, no nearer to standstill") {
  // Shares of 2 along y: 1 to 2; of 4 along x: 2 to 4.
  const TrackingSpan span = TrackingSpan::after_row({0.5, 1.0}, {0, 2, 0}, {4, 0, 0});
  for (const Point& point : {Point(0, 1, 0), Point(0, 2, 0), Point(2, 0, 0), Point(4, 0, 0),
                             Point(1, 1, 0), Point(1, 0.5, 0), Point(2, 0.25, 0)})
    CHECK(span.distance(point) == doctest::Approx(0.0));
  CHECK(span.distance({0, 0, 0}) == doctest::Approx(2.0 / root_5));
  CHECK(span.distance({1, 1, 0.25}) == doctest::Approx(0.25));
  CHECK(span.distance({2, 0.25, 0.125}) == doctest::Approx(0.125));
}

TEST_CASE("G040 more than what was asked for may happen, by the upper share of either row") {
  const TrackingSpan span = TrackingSpan::after_row({0.5, 1.25}, {0, 2, 0}, {4, 0, 0});
  CHECK(span.distance({0, 2.5, 0}) == 0.0);
  CHECK(span.distance({0, 3.5, 0}) == 1.0);
  CHECK(span.distance({5, 0, 0}) == 0.0);
  CHECK(span.distance({6, 0, 0}) == 1.0);
}

TEST_CASE("G040 where all of what is told happens, a motion is as far off as the nearest end") {
  const TrackingSpan line = TrackingSpan::after_row({1.0, 1.0}, {0, 2, 0}, {4, 0, 0});
  CHECK(line.distance({2, 1, 0}) == doctest::Approx(0.0));
  CHECK(line.distance({6, -1, 0}) == doctest::Approx(root_5));
  CHECK(line.distance({-2, 3, 0}) == doctest::Approx(root_5));
}

TEST_CASE("G040 motions along one line leave no area: what counts is the line") {
  const TrackingSpan line = TrackingSpan::after_hold({0.5, 1.0}, {1, 0, 0}, {4, 0, 0});
  CHECK(line.distance({3, 0, 0}) == 0.0);
  CHECK(line.distance({3, 2, 0}) == 2.0);
  CHECK(line.distance({5, 0, 0}) == 1.0);
  const TrackingSpan rest = TrackingSpan::after_hold({0.5, 1.0}, {0, 0, 0}, {0, 0, 0});
  CHECK(rest.distance({0, 3, 4}) == 5.0);
}

TEST_CASE("G040 the size of the motions does not matter, not even one of a micrometre") {
  constexpr double small = 9.5367431640625e-07;  // 2^-20
  const TrackingSpan span =
      TrackingSpan::after_hold({0.5, 1.0}, {0, 2 * small, 0}, {4096 * small, 0, 0});
  CHECK(span.distance({small, small, small}) == small);
  CHECK(span.distance({small, small, 0}) == 0.0);
  const TrackingSpan tiny =
      TrackingSpan::after_hold({0.5, 1.0}, {0, 2 * small, 0}, {4 * small, 0, 0});
  CHECK(tiny.distance({small, 0.5 * small, 0}) == 0.0);
}

TEST_CASE("G040 a motion that is no number is nowhere") {
  for (Eigen::Index i = 0; i < 3; ++i) {
    Point point(1, 1, 0);
    point[i] = not_a_number;
    CHECK(std::isnan(after_hold.distance(point)));
    Point told(4, 0, 0);
    told[i] = not_a_number;
    CHECK(std::isnan(TrackingSpan::after_hold({0.5, 1.0}, {0, 2, 0}, told).distance({1, 1, 0})));
    Point before(0, 2, 0);
    before[i] = not_a_number;
    for (const TrackingSpan& span : {TrackingSpan::after_hold({0.5, 1.0}, before, {4, 0, 0}),
                                     TrackingSpan::after_row({0.5, 1.0}, before, {4, 0, 0})})
      CHECK(std::isnan(span.distance({1, 1, 0})));
  }
}
