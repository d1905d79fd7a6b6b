// Shape and surroundings that contradict themselves or the robot are no configuration.
#include <doctest/doctest.h>

#include <functional>
#include <limits>
#include <string>

#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

std::string fault_in(Limits limits, const std::function<void(Limits&)>& spoil) {
  spoil(limits);
  return std::string(check_limits(limits).view());
}

std::string fault_after(const std::function<void(Limits&)>& spoil) {
  return fault_in(test_limits(), spoil);
}

void set_pair(Limits& limits, std::uint8_t first, std::uint8_t second) {
  limits.collision.pairs[0] = {first, second};
}

FixedVec<Corner, max_corners> polygon(std::initializer_list<Corner> corners) {
  FixedVec<Corner, max_corners> all;
  for (const Corner& corner : corners) (void)all.push_back(corner);
  return all;
}

std::string fault_of_footprint(std::initializer_list<Corner> corners) {
  return fault_after([&](Limits& l) { l.base.footprint = polygon(corners); });
}

}  // namespace

TEST_CASE("the two armed test robot's configuration has no fault") {
  CHECK(check_limits(two_arms::limits()).empty());
}

TEST_CASE("capsules are finite and on links there are") {
  const auto fault = [](auto field, auto value) {
    return fault_after([=](Limits& l) { l.collision.capsules[1].*field = value; });
  };
  CHECK(fault(&Capsule::link, std::size_t{5}) == "collision.capsules[1].link: no such link");
  CHECK(fault(&Capsule::link, std::size_t{4}) == "");
  for (const double bad : {unset, endless, -endless}) {
    CHECK(fault(&Capsule::a, std::array{0.0, bad, 0.0}) ==
          "collision.capsules[1].a: expected finite numbers");
    CHECK(fault(&Capsule::b, std::array{0.0, 0.0, bad}) ==
          "collision.capsules[1].b: expected finite numbers");
  }
  for (const double bad : {unset, endless, 0.0, -0.1}) {
    CHECK(fault(&Capsule::radius, bad)
              .starts_with("collision.capsules[1].radius: expected a finite number above 0"));
    CHECK(fault_after([=](Limits& l) {
            l.collision.clearance = bad;
          }).starts_with("collision.clearance: expected a finite number above 0"));
  }
  CHECK(fault_after([](Limits& l) { l.collision.capsules[0].link = 5; }) ==
        "collision.capsules[0].link: no such link");
  CHECK(fault_after([](Limits& l) { l.collision.capsules.clear(); }) ==
        "collision.capsules: expected at least one");
}

TEST_CASE("pairs are of two capsules of two links, in order, each once") {
  const auto fault = [](std::uint8_t first, std::uint8_t second) {
    return fault_after([=](Limits& l) { set_pair(l, first, second); });
  };
  CHECK(fault(1, 0) ==
        "collision.pairs[0]: expected two capsules in ascending order below 2, got 1 and 0");
  CHECK(fault(0, 0) ==
        "collision.pairs[0]: expected two capsules in ascending order below 2, got 0 and 0");
  CHECK_FALSE(fault(0, 2).empty());
  CHECK_FALSE(fault(max_capsules, max_capsules).empty());
  CHECK(fault_after([](Limits& l) { l.collision.capsules[0].link = 3; }) ==
        "collision.pairs[0]: expected capsules of two links, got 0 and 1 of one");
  CHECK(fault_after([](Limits& l) { (void)l.collision.pairs.push_back({0, 1}); }) ==
        "collision.pairs[1]: 0 and 1 are there twice");
  CHECK(fault_after([](Limits& l) {
          Capsule other = l.collision.capsules[0];
          other.link = 1;
          (void)l.collision.capsules.push_back(other);
          (void)l.collision.pairs.push_back({0, 2});
          (void)l.collision.pairs.push_back({1, 2});
        }) == "");
}

TEST_CASE("a robot with a tool keeps capsules apart and its tools in a volume") {
  const auto without_tools = [](Limits& l) {
    for (PartLimits& part : l.parts) {
      part.tool = no_link;
      part.modes.cartesian_pose.supported = false;
      part.modes.cartesian_delta.supported = false;
      part.modes.cartesian_twist.supported = false;
    }
  };
  CHECK(fault_after([](Limits& l) { l.collision.pairs.clear(); }) ==
        "collision.pairs: expected at least one for a robot with a tool");
  CHECK(fault_after([](Limits& l) { l.workspace.volumes.clear(); }) ==
        "workspace.volumes: expected one of kind keep_in, got none, and there is a tool");
  CHECK_FALSE(fault_after([](Limits& l) { l.workspace.volumes[0].keep_out = true; }).empty());
  CHECK(fault_after([&](Limits& l) {
          without_tools(l);
          l.collision.pairs.clear();
          l.workspace.volumes.clear();
        }) == "");
}

TEST_CASE("volumes have a name of their own and a size along every axis") {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double bad : {unset, endless, vast})
      CHECK(fault_after([=](Limits& l) { l.workspace.volumes[0].lower[axis] = bad; })
                .starts_with(std::string("workspace.volumes.everywhere ") + "xyz"[axis] +
                             ": expected finite lower < upper, got "));
  for (std::size_t axis = 0; axis < 3; ++axis)
    CHECK(fault_after([=](Limits& l) {
            l.workspace.volumes[0].upper[axis] = -vast;
          }).starts_with(std::string("workspace.volumes.everywhere ") + "xyz"[axis] + ": "));
  CHECK(fault_after([](Limits& l) { l.workspace.volumes[0].name.clear(); }) ==
        "workspace.volumes: a volume without a name");
  CHECK(fault_after([](Limits& l) {
          (void)l.workspace.volumes.push_back(l.workspace.volumes[0]);
        }) == "workspace.volumes: everywhere is there twice");
}

TEST_CASE("joints without bounds are the base's, and zones bound them") {
  CHECK(fault_after([](Limits& l) { l.parts[base].joints.erase_at(0); }) ==
        "joints.base_x: base does not list it among its joints");
  CHECK(fault_after([](Limits& l) { l.base.present = false; }) ==
        "base: expected zones for joint base_x, which has no bounds");
  CHECK(fault_after([](Limits& l) { l.base.joints[2] = base_y; }) ==
        "base.joints: expected two that slide and one that turns, got base_y");
  CHECK(fault_after([](Limits& l) {
          l.base.joints = {base_y, base_x, base_yaw};
          l.parts[base].modes.body_twist.supported = false;
        }) == "");
  CHECK(fault_after([](Limits& l) { l.base.joints = {base_yaw, base_x, base_y}; }) ==
        "base.joints: expected two that slide and one that turns, got base_yaw");
  CHECK(fault_after([](Limits& l) { l.base.joints = {base_x, base_yaw, base_y}; }) ==
        "base.joints: expected two that slide and one that turns, got base_yaw");
  const auto two_armed = [](std::size_t x, std::size_t y, std::size_t yaw) {
    return fault_in(two_arms::limits(), [=](Limits& l) {
      l.base = wide_base(x, y, yaw);
      l.joints[0].kind = JointKind::prismatic;
      l.kinematics.links[1].motion = LinkMotion::slide;
    });
  };
  CHECK(two_armed(0, 0, 2) == "base.joints: left_1 is there twice");
  CHECK(two_armed(4, 0, 2) == "base.joints: no such joint");
}

TEST_CASE("a body twist is that of the base's own joints, on a flat floor") {
  const std::string expected = ".modes.body_twist: expected a part of base.joints, in their order";
  CHECK(fault_after([](Limits& l) { l.base.joints = {base_y, base_x, base_yaw}; }) ==
        "parts.base" + expected);
  CHECK(fault_after([](Limits& l) {
          l.parts[arm].modes.body_twist = l.parts[base].modes.body_twist;
        }) == "parts.arm" + expected);
  for (const std::size_t axis : {2U, 3U, 4U})
    CHECK(fault_after([=](Limits& l) { l.parts[base].modes.body_twist.free_axes[axis] = true; }) ==
          "parts.base.modes.body_twist.free_axes: expected none but 0, 1 and 5");
  // One joint of the three that is another's.
  const auto borrowed = [](std::size_t place, std::size_t other) {
    return fault_after([=](Limits& l) {
      for (const std::size_t j : {base_x, base_y, base_yaw}) l.joints[j].bounded = true;
      for (const std::size_t j : {base_x, base_y, base_yaw}) l.joints[j].bounds = {-1, 1, 0.1};
      l.base.joints[place] = other;
    });
  };
  CHECK(borrowed(0, gripper_joint) == "parts.base" + expected);
  CHECK(borrowed(1, gripper_joint) == "parts.base" + expected);
  CHECK(borrowed(2, arm_1) == "parts.base" + expected);
}

TEST_CASE("a base has an axis it turns about, a time to react and a zone to be in") {
  for (const double bad : {unset, endless}) {
    CHECK(fault_after([=](Limits& l) { l.base.yaw_axis = {0.0, bad}; }) ==
          "base.yaw_axis: expected finite numbers");
    CHECK(fault_after([=](Limits& l) {
            l.base.reaction_s = bad;
          }).starts_with("base.reaction_s: expected a finite number above 0"));
  }
  CHECK_FALSE(fault_after([](Limits& l) { l.base.reaction_s = 0.0; }).empty());
  CHECK(fault_after([](Limits& l) { l.base.zones[0].keep_out = true; }) ==
        "base.zones: expected one of kind keep_in, got none");
  CHECK(fault_after([](Limits& l) { l.base.zones.clear(); }) ==
        "base.zones: expected one of kind keep_in, got none");
  CHECK(fault_after([](Limits& l) { l.base.zones[0].name.clear(); }) ==
        "base.zones: a zone without a name");
  CHECK(fault_after([](Limits& l) { (void)l.base.zones.push_back(l.base.zones[0]); }) ==
        "base.zones: everywhere is there twice");
  CHECK(fault_after(
            [](Limits& l) { (void)l.base.zones.push_back({"pillar", true, square(1.0)}); }) == "");
  CHECK(fault_after([](Limits& l) { l.base.zones[0].corners[1][0] = unset; }) ==
        "base.zones.everywhere.corners[1]: expected finite numbers");
  CHECK(fault_after([](Limits& l) { l.base.zones[0].corners[0][1] = endless; }) ==
        "base.zones.everywhere.corners[0]: expected finite numbers");
}

TEST_CASE("a footprint and a zone are convex and go counter-clockwise") {
  CHECK(fault_of_footprint({{0, 0}, {1, 0}, {0, 1}}) == "");
  CHECK(fault_of_footprint({{0, 0}, {1, 0}}) ==
        "base.footprint: expected 3 or more corners of a convex polygon, counter-clockwise, got 2 "
        "that are none");
  CHECK_FALSE(fault_of_footprint({{0, 0}, {0, 1}, {1, 0}}).empty());            // clockwise
  CHECK_FALSE(fault_of_footprint({{0, 0}, {1, 0}, {2, 0}, {1, 1}}).empty());    // in a line
  CHECK_FALSE(fault_of_footprint({{0, 0}, {1, 0}, {1, 0}, {0, 1}}).empty());    // twice
  CHECK_FALSE(fault_of_footprint({{0, 0}, {2, 0}, {1, 0.5}, {1, 2}}).empty());  // a dent
  CHECK_FALSE(fault_of_footprint(                                               // a star
                  {{0, 1}, {-0.59, -0.81}, {0.95, 0.31}, {-0.95, 0.31}, {0.59, -0.81}})
                  .empty());
}

TEST_CASE("a dent at any corner of a footprint is found") {
  const std::array<Corner, 5> whole{{{0, 0}, {4, 1}, {5, 4}, {2, 6}, {-1, 3}}};
  const auto with = [&](std::size_t dented) {
    return fault_after([&](Limits& l) {
      l.base.footprint.clear();
      for (std::size_t i = 0; i < whole.size(); ++i)
        (void)l.base.footprint.push_back(i == dented ? Corner{2, 3} : whole[i]);
    });
  };
  CHECK(with(whole.size()) == "");
  for (std::size_t i = 0; i < whole.size(); ++i) CHECK_FALSE(with(i).empty());
}

TEST_CASE("three corners on a grid go counter-clockwise or not, as their area says") {
  for (int code = 0; code < 4096; ++code) {
    std::array<double, 6> n{};
    for (int i = 0; i < 6; ++i) n[static_cast<std::size_t>(i)] = (code >> (2 * i)) & 3;
    const auto [ax, ay, bx, by, cx, cy] = n;
    const double area = ax * (by - cy) + bx * (cy - ay) + cx * (ay - by);
    CHECK(fault_of_footprint({{ax, ay}, {bx, by}, {cx, cy}}).empty() == (area > 0.0));
  }
}

TEST_CASE("a joint, a part and a name at the first index that is none are refused") {
  CHECK(fault_after([](Limits& limits) { limits.joints[arm_1].part = 4; }) ==
        "joints.arm_1.part: no such part");
  CHECK(fault_after([](Limits& limits) {
          (void)limits.parts[composite].joints.push_back(joint_count);
        }) == "parts.composite.joints: a joint that is not this part's");
  CHECK(fault_after([](Limits& limits) {
          (void)limits.passive_joints.push_back(limits.passive_joints[0]);
        }) == "passive_joints: torso is there twice");
  CHECK(fault_after([](Limits& limits) { limits.joints[1].name = limits.joints[0].name; }) ==
        "joints: base_x is there twice");
}

TEST_CASE("each axis of a pose's box has its own range") {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool lower_end : {true, false}) {
      const std::string fault = fault_after([=](Limits& limits) {
        PoseLimits& box = limits.parts[arm].modes.cartesian_pose;
        (lower_end ? box.lower : box.upper)[axis] = unset;
      });
      CHECK(fault.find(std::string("parts.arm.modes.cartesian_pose ") + "xyz"[axis]) == 0);
    }
}

TEST_CASE("what a base carries drifts by a finite distance, or by none") {
  const auto fault = [](double BaseLimits::*field, double value) {
    return fault_after([=](Limits& l) { l.base.*field = value; });
  };
  for (const auto& [name, field] :
       {std::pair{"base.tool_drift", &BaseLimits::tool_drift},
        std::pair{"base.clearance_drift", &BaseLimits::clearance_drift}}) {
    CHECK(fault(field, 0.0).empty());
    CHECK(fault(field, 0.25).empty());
    for (const double bad : {-0.001, endless, unset}) CHECK(fault(field, bad).starts_with(name));
  }
}
