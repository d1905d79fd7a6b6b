// Pairs that come near and go: a ball of 0.5 m on the column of the free arm, 4 m ahead, and one
// that stands; their middles may be 1.5 m apart.

#include <doctest/doctest.h>

#include <cmath>

#include "core/geometry/shape_check.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// The ball that stands, at an angle of the column's turn.
Limits ball_at(double angle) {
  Limits limits = free_arm::limits();
  const std::array<double, 3> there{4.0 * std::cos(angle), 4.0 * std::sin(angle), 0.0};
  limits.workspace.volumes.clear();
  limits.collision.capsules[0] = {0, there, there, 0.5};
  limits.collision.capsules[1] = {1, {4, 0, 0}, {4, 0, 0}, 0.5};
  limits.collision.clearance = 0.5;
  return limits;
}

Joints turned_to(double angle) {
  Joints joints{};
  joints[turn_z] = angle;
  return joints;
}

// One look after the other, each at an angle from where the column turns by as much as `way`.
class Looks {
 public:
  explicit Looks(const Limits& limits) : model_(limits), check_(model_, only(turn_z)) {}

  // What is at fault, else how many pairs are near.
  std::uint32_t at(double angle, double way = 0.001) {
    FramePoses here, far_away;
    here.place(model_, turned_to(angle));
    far_away.place(model_, turned_to(3.0));
    Clearance found;
    const DisplacementBound bound(model_, turned_to(angle), turned_to(angle + way));
    const Evidence evidence = check_.check(here, far_away, bound, found);
    return evidence.ok() ? static_cast<std::uint32_t>(found.near_count) : evidence.code;
  }

 private:
  RobotModel model_;
  ShapeCheck check_;
};

}  // namespace

TEST_CASE("G032 a pair that was far apart is met where it comes near, however it gets there") {
  const Limits limits = ball_at(1.0);
  // The middles are 1.5 m apart at 0.377 rad from each other.
  Looks at_once(limits);
  CHECK(at_once.at(0.0) == 0);
  CHECK(at_once.at(0.5) == 0);
  CHECK(at_once.at(0.63) == 32);
  Looks in_steps(limits);
  for (double angle = 0.0; angle < 0.615; angle += 0.01) CHECK(in_steps.at(angle) == 0);
  CHECK(in_steps.at(0.63) == 32);
  CHECK(in_steps.at(0.0) == 0);
  CHECK(in_steps.at(1.37) == 32);
}

TEST_CASE("G032 how far a pair has come nearer counts from where all were looked at last") {
  const Limits limits = ball_at(-0.387);
  Looks looks(limits);
  CHECK(looks.at(0.0) == 0);
  CHECK(looks.at(1.0) == 0);
  CHECK(looks.at(-0.015) == 32);
}

TEST_CASE("G032 from one side to the other is far, too") {
  const Limits limits = ball_at(-0.75);
  Looks looks(limits);
  CHECK(looks.at(0.75) == 0);
  CHECK(looks.at(-0.75) == 32);
}

TEST_CASE("G032 a short finger that turns far comes as near as a long arm that turns little") {
  // It reaches 0.3 m down from its palm, and 2.5 rad further round is a ball on the palm.
  Limits limits = two_arms::limits();
  limits.workspace.volumes.clear();
  const std::array<double, 3> there{0.0, 0.02 + 0.3 * std::sin(2.5), -0.3 * std::cos(2.5)};
  limits.collision.capsules[0] = {4, there, there, 0.05};
  limits.collision.capsules[1] = {5, {0, 0, -0.3}, {0, 0, -0.3}, 0.05};
  const RobotModel model(limits);
  ShapeCheck check(model, only(two_arms::finger_1));
  FramePoses start, here;
  start.place(model, Joints{});
  Joints turned{};
  turned[two_arms::finger_1] = 2.5;
  here.place(model, turned);
  Clearance found;
  const DisplacementBound bound(model, Joints{}, Joints{});
  CHECK(check.check(start, start, bound, found).ok());
  CHECK(check.check(here, start, bound, found).code == 32);
}

TEST_CASE("a pair that is too far to count for a short way counts for a long one") {
  const Limits limits = ball_at(0.5);  // 1.98 m between the middles
  Looks looks(limits);
  CHECK(looks.at(0.0, 0.001) == 0);
  CHECK(looks.at(0.0, 0.25) == 1);
  CHECK(looks.at(0.0, 0.5) == 1);
  CHECK(looks.at(0.0, 0.001) == 0);
}

TEST_CASE("G032 a pair that is nowhere is a hit, also after it was far apart") {
  const Limits limits = ball_at(1.0);
  Looks looks(limits);
  CHECK(looks.at(0.0) == 0);
  CHECK(looks.at(not_a_number) == 32);
}
