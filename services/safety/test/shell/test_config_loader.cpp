#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "config/config_loader.hpp"
#include "config/sha256.hpp"
#include "config/strict_json.hpp"
#include "process/refusal.hpp"

using namespace fairlead;

namespace {

std::string panda_mobile() {
  std::ifstream file(FAIRLEAD_ROBOTS_DIR "/panda_mobile/gate.sim.json", std::ios::binary);
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old.size(), by);
}

}  // namespace

TEST_CASE("the committed simulator profile loads with the values it states") {
  const std::string text = panda_mobile();
  const auto limits = parse_limits(text);
  CHECK(limits->robot == "panda_mobile");
  CHECK(limits->profile == "sim");
  CHECK(limits->lockstep_allowed);
  CHECK(limits->period_ns == 50'000'000);
  CHECK(limits->config_hash ==
        sha256(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size())));
  REQUIRE(limits->joints.size() == 11);
  REQUIRE(limits->passive_joints.size() == 3);
  REQUIRE(limits->parts.size() == 4);

  const JointLimits& base_x = limits->joints[0];
  CHECK(base_x.name == "base_x");
  CHECK(base_x.part == 2);
  CHECK_FALSE(base_x.bounded);
  const JointLimits& joint1 = limits->joints[3];
  CHECK(joint1.part == 0);
  CHECK(joint1.bounded);
  CHECK(joint1.bounds.upper == 2.8973);
  CHECK(joint1.velocity_limit == 2.175);

  const PartLimits& base = limits->parts[2];
  CHECK(base.modes.joint_velocity.supported);
  CHECK(base.modes.joint_velocity.step_limit[2] == 1.5);
  CHECK(std::isnan(base.modes.joint_velocity.step_limit[3]));
  CHECK(base.modes.body_twist.free_axes == std::array{true, true, false, false, false, true});
  CHECK_FALSE(base.modes.joint_position.supported);
  CHECK(limits->parts[3].modes.composite_mode.lower == -1.0);
  CHECK(limits->parts[3].modes.composite_mode.upper == 1.0);
}

TEST_CASE("the steps of a part are filed under the robot's joints, in the part's order") {
  const auto swapped = [](const std::string& text, const std::string& indent) {
    return replaced(text, "[\n" + indent + "\"base_x\",\n" + indent + "\"base_y\"",
                    "[\n" + indent + "\"base_y\",\n" + indent + "\"base_x\"");
  };
  const std::string text = swapped(swapped(panda_mobile(), "        "), "      ");
  const std::string marked = replaced(text, "[2.0, 2.0, 1.5]", "[1.25, 2.0, 1.5]");
  const auto limits = parse_limits(marked);
  const auto& steps = limits->parts[2].modes.joint_velocity.step_limit;
  CHECK(limits->joints[1].name == "base_y");
  CHECK(steps[1] == 1.25);
  CHECK(steps[0] == 2.0);
}

TEST_CASE("one changed byte changes the configuration's hash") {
  const std::string text = panda_mobile();
  CHECK(parse_limits(text + "\n")->config_hash != parse_limits(text)->config_hash);
}

TEST_CASE("a fault in the text names its place") {
  CHECK_THROWS_WITH_AS(parse_strictly(R"({"a": [1, {"b": 2, "b": 3}]})"), "a[1].b: duplicate key",
                       ConfigRefused);
  CHECK_THROWS_WITH_AS(parse_strictly(R"({"a": 1, "a": 1})"), "a: duplicate key", ConfigRefused);
  const auto nested = [](std::size_t deep) {
    return std::string(deep, '[') + "1" + std::string(deep, ']');
  };
  CHECK_NOTHROW(parse_strictly(R"({"a": )" + nested(31) + "}"));
  CHECK_THROWS_WITH_AS(parse_strictly(R"({"a": )" + nested(100'000) + "}"),
                       "a: expected values up to 32 deep, got more", ConfigRefused);
  CHECK_THROWS_WITH_AS(parse_strictly(nested(33)),
                       "the file: expected values up to 32 deep, got more", ConfigRefused);
  for (const char* text : {R"({"a": {"b": NaN}})", R"({"a": {"b": 1e999}})", R"({"a": {"b": }})"}) {
    try {
      parse_strictly(text);
      FAIL("accepted ", text);
    } catch (const ConfigRefused& refusal) {
      CHECK(std::string(refusal.what()).starts_with("a.b: expected JSON with finite numbers"));
    }
  }
}

TEST_CASE("a file that is not an object is refused") {
  CHECK_THROWS_WITH_AS(parse_limits("[]"), "the file: expected an object, got []", ConfigRefused);
  CHECK_THROWS_AS(parse_limits(""), ConfigRefused);
}
