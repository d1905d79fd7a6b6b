// Which configurations of a motion are queried, and by how much they are clear: few queries are
// what makes G031, G032 and G034 quick, and enough of them what makes them safe.

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/kinematics/robot_model.hpp"
#include "core/trajectory/certify.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

struct Asked {
  Joints joints;
  double need;
};

// Finds everything clear by the same share, and notes what it is asked. From where joint 0 is
// beyond `fault_at` on, something is at fault.
struct Finding {
  double whole;  // what anything moves on the whole motion
  double share;
  std::vector<Asked>& asked;
  double fault_at = 1e9;

  [[nodiscard]] double longest() const { return whole; }
  Evidence query(const Joints& joints, double need, double& clear) const {
    asked.push_back({joints, need});
    clear = share;
    if (joints[0] < fault_at) return {};
    return above(code::collision, "", joints[0], 0.0, "m", "");
  }
};

// The places that are queried of one joint's row from 0 to 1, on which anything goes `longest`.
struct Queried {
  Evidence evidence;
  std::vector<double> places;
};

Queried queried(double longest, double at_ends, double between = 0.0, double fault_at = 2.0) {
  Branch branch{};
  branch.now[0] = 1.0;
  std::vector<Asked> asked;
  Queried found;
  found.evidence = certify(StraightMotion{branch.before, branch.now},
                           Finding{longest, between, asked, fault_at}, at_ends, at_ends);
  for (const Asked& one : asked) found.places.push_back(one.joints[0]);
  return found;
}

// The slides brake at 5 m/s2: x, at 1 m/s, in 0.2 s and 0.1 m; y, at -0.5 m/s, in 0.1 s and 25 mm.
struct Slowing {
  Slowing() {
    for (const std::size_t j : {slide_x, slide_y}) limits.joints[j].acceleration_limit = 5.0;
    branch.now[slide_x] = -0.05;  // half of its way is on either side of zero
    branch.speed[slide_x] = 1.0;
    branch.speed[slide_y] = -0.5;
  }
  Limits limits = free_arm::limits();
  RobotModel model{limits};
  Branch branch{};
  JointSet moving = only(turn_z) | only(slide_x) | only(slide_y);
  [[nodiscard]] Braking braking() const { return {model, branch, moving, 0}; }
};

}  // namespace

TEST_CASE("joints of a set come one by one, by their index") {
  const auto listed = [](JointSet set) {
    std::vector<std::size_t> joints;
    for (const std::size_t joint : JointsIn(set)) joints.push_back(joint);
    return joints;
  };
  CHECK(listed(0).empty());
  CHECK(listed(only(0)) == std::vector<std::size_t>{0});
  CHECK(listed(only(63) | only(0) | only(3)) == std::vector<std::size_t>{0, 3, 63});
}

TEST_CASE("a motion is queried every 10 mm of its longest") {
  CHECK(queried(0.01, 0.0).places.empty());
  CHECK(queried(0.02, 0.0).places == std::vector{0.5});
  CHECK(queried(0.04, 0.0).places == std::vector{0.5, 0.25, 0.75});
}

TEST_CASE("a motion is halved until nothing goes further than 10 mm, however long it is") {
  CHECK(queried(0.64, 0.0).places.size() == 63);
  CHECK(queried(2.56, 0.0).places.size() == 255);
  CHECK(queried(40.96, 0.0).places.size() == 4095);
  CHECK(queried(not_a_number, 0.0, 2.0).places.size() == 1);
}

TEST_CASE("G032 a wall on the way of a joint that brakes soon is met, while another brakes long") {
  for (const double deceleration : {20.0, 1.0, 0.3}) {
    for (double y = 0.1; y < 0.26; y += 0.002) {
      CAPTURE(deceleration);
      CAPTURE(y);
      Limits limits = free_arm::limits();
      limits.joints[slide_x].acceleration_limit = deceleration;
      limits.joints[slide_y].acceleration_limit = 15.0;
      limits.joints[slide_y].stop_lag = 0.06;
      for (const std::size_t j : {slide_x, slide_y}) {
        limits.joints[j].velocity_limit = 2.0;
        limits.joints[j].bounds = {-9.0, 9.0, 0.1};
      }
      limits.collision.capsules[0] = {0, {-3, y, 0.5}, {9, y, 0.5}, 0.002};
      limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.002};
      limits.collision.clearance = 0.001;
      Row row(6, 0.0);
      row[slide_x] = 1.0;
      row[slide_y] = 2.0;
      ChunkBuilder chunk;
      chunk.add(arm, Mode::joint_velocity, {row}, {slide_x, slide_y});
      CHECK(free_arm::judge(limits, chunk.chunk).evidence.code == 32);
    }
  }
}

TEST_CASE("a motion whose ends are clear by all of it together is clear") {
  CHECK(queried(100.0, 0.5).places.empty());
  CHECK(queried(100.0, 0.49).places.size() > 1);
  CHECK(queried(100.0, 0.25, 0.25).places == std::vector{0.5});  // both halves are, then
}

TEST_CASE("a motion ends at the first fault that is found, in the first half or in the second") {
  CHECK(queried(0.04, 0.0, 0.0, 0.5).places == std::vector{0.5});
  const Queried late = queried(0.04, 0.0, 0.0, 0.7);
  CHECK(late.places == std::vector{0.5, 0.25, 0.75});
  CHECK(late.evidence.value == 0.75);
}

TEST_CASE("a row's way: from its middle on, all joints at the same share of theirs") {
  Branch branch{};
  branch.before[0] = -1.0;
  branch.now[0] = 3.0;
  branch.before[1] = branch.now[1] = 0.5;
  std::vector<Asked> asked;
  // Clear by 0.3 and 0.69 of the way at its ends: not all of it. The middle, by 0.25, closes both
  // halves.
  CHECK(certify(StraightMotion{branch.before, branch.now}, Finding{4.0, 0.25, asked}, 0.3, 0.69)
            .ok());
  REQUIRE(asked.size() == 1);
  CHECK(asked[0].joints[0] == 1.0);
  CHECK(asked[0].joints[1] == 0.5);
  CHECK(asked[0].need == 1.0);
  asked.clear();
  CHECK(certify(StraightMotion{branch.before, branch.now}, Finding{4.0, 0.0, asked}, 0.3, 0.7)
            .ok());  // covered
  CHECK(asked.empty());
  CHECK(certify(StraightMotion{branch.before, branch.now}, Finding{0.01, 0.0, asked}, 0.0, 0.0)
            .ok());  // 1 cm
  CHECK(asked.empty());
}

TEST_CASE("a row's way that nothing covers: every centimetre of it") {
  Branch branch{};
  branch.before[0] = -1.0;
  branch.now[0] = 3.0;
  std::vector<Asked> asked;
  CHECK(
      certify(StraightMotion{branch.before, branch.now}, Finding{0.04, 0.0, asked}, 0.0, 0.0).ok());
  REQUIRE(asked.size() == 3);
  CHECK(asked[0].joints[0] == 1.0);
  CHECK(asked[1].joints[0] == 0.0);
  CHECK(asked[2].joints[0] == 2.0);
  CHECK(asked[1].need == 0.5);
  CHECK(asked[2].need == 0.5);
  asked.clear();
  CHECK(
      certify(StraightMotion{branch.before, branch.now}, Finding{4.0, 0.0, asked}, 0.0, 0.0).ok());
  CHECK(asked.size() == 511);
  CHECK(certify(StraightMotion{branch.before, branch.now}, Finding{4.0, 0.0, asked, 2.9}, 0.0, 0.0)
            .code == 32);
}

TEST_CASE(
    "between two points of the way of braking, the largest share of its own that a joint goes") {
  const Slowing slowing;
  const Braking braking = slowing.braking();
  Joints half{};
  braking.at(0.5, half);  // 0.1 s: 75 mm, and all of the 25 mm
  CHECK(half[slide_x] == doctest::Approx(0.025));
  CHECK(half[slide_y] == doctest::Approx(-0.025));
  CHECK(braking.largest_share(slowing.branch.now, braking.end()) == doctest::Approx(1.0));
  CHECK(braking.largest_share(slowing.branch.now, half) == doctest::Approx(1.0));  // of y
  CHECK(braking.largest_share(half, braking.end()) == doctest::Approx(0.25));      // of x
  CHECK(braking.largest_share(braking.end(), braking.end()) == 0.0);
  Joints back = slowing.branch.now;
  back[slide_x] = -0.05 + 0.1 * 0.4;
  CHECK(braking.largest_share(back, slowing.branch.now) == doctest::Approx(0.4));
}

TEST_CASE("a share that is no number is the largest, whatever comes before and after it") {
  for (const std::size_t lost : {turn_z, slide_x, slide_y}) {
    Slowing slowing;
    slowing.branch.speed[lost] = unset;
    const Braking braking = slowing.braking();
    CHECK(std::isnan(braking.largest_share(slowing.branch.now, braking.end())));
  }
}

TEST_CASE("the way of braking is looked at from half of its time on") {
  const Slowing slowing;
  const Braking braking = slowing.braking();
  std::vector<Asked> asked;
  CHECK(certify(braking, Finding{1.0, 0.5, asked}, 0.6, 0.3).ok());
  REQUIRE(asked.size() == 1);
  CHECK(asked[0].joints[slide_x] == doctest::Approx(0.025));
  CHECK(asked[0].need == doctest::Approx(1.0));
  asked.clear();
  CHECK(certify(braking, Finding{1.0, 0.0, asked}, 0.6, 0.4).ok());
  CHECK(asked.empty());
}

TEST_CASE("a look at shapes says which share of their way they are clear by") {
  // A ball of 0.05 m and a post, 0.3 m apart where the arm rests, 0.2 m more than they have to be.
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {0, {1.1, 0, 0.3}, {1.1, 0, 0.7}, 0.05};
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.clearance = 0.1;
  const RobotModel model(limits);
  ShapeCheck check(model, only(slide_x));
  Joints there{};
  there[slide_x] = 0.4;
  const DisplacementBound bound(model, Joints{}, there);
  FramePoses rest, room;
  rest.place(model, Joints{});
  QueryBudget budget;
  const ShapeConstraint look{model, check, rest, bound, room, budget};
  double free = unset;
  CHECK(look.query(Joints{}, 1.0, free).ok());
  CHECK(free == doctest::Approx(0.5));
  CHECK(look.query(there, 1.0, free).code == 32);
  there[slide_x] = 0.1;
  CHECK(look.query(there, 1.0, free).ok());
  CHECK(free == doctest::Approx(0.25));
  Clearance found;
  CHECK(check.check(rest, rest, bound, found).ok());
  CHECK(found.others == doctest::Approx(0.4));  // as far as the slide goes, and no further
  CHECK(budget.taken() == 3);
}

TEST_CASE("a look at zones says which share of its way the footprint is clear by") {
  // A square of 1 m; the way ahead ends 0.4 m before it.
  Limits limits = test_limits();
  limits.base.zones[0].corners = square(0.9);
  const RobotModel model(limits);
  Joints joints{};
  const Joints before{};
  QueryBudget budget;
  const BaseOff on_place;
  const ZoneConstraint look{model, before, 0.8, on_place, budget};
  double free = unset;
  CHECK(look.query(joints, 1.0, free).ok());
  CHECK(free == doctest::Approx(0.5));
  joints[base_x] = -0.2;
  CHECK(look.query(joints, 1.0, free).ok());
  CHECK(free == doctest::Approx(0.25));
  joints[base_x] = 0.5;
  CHECK(look.query(joints, 1.0, free).code == 34);
  CHECK(budget.taken() == 3);
}
