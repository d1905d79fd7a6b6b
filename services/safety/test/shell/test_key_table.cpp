#include <doctest/doctest.h>

#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "process/refusal.hpp"
#include "zenoh/key_table.hpp"

using namespace fairlead;

namespace {

using Builder = std::function<std::string(const KeyTable&, const std::string&)>;

// A key of a family: its last chunk is a wildcard.
std::string family_of(std::string family, const std::string& name) {
  family.pop_back();
  return family + name;
}

// The gate's part of the shared table; the other keys are none of its business.
const std::map<std::string, Builder> kBuilders = {
    {"joints", [](const KeyTable& k, const std::string&) { return k.joints(); }},
    {"candidate", [](const KeyTable& k, const std::string& a) { return k.candidate(a); }},
    {"every_candidate", [](const KeyTable& k, const std::string&) { return k.every_candidate(); }},
    {"safe", [](const KeyTable& k, const std::string& a) { return k.safe(a); }},
    {"lease", [](const KeyTable& k, const std::string&) { return k.lease(); }},
    {"verdict", [](const KeyTable& k, const std::string& a) { return k.verdict(a); }},
    {"gate_status", [](const KeyTable& k, const std::string&) { return k.gate_status(); }},
    {"stop", [](const KeyTable& k, const std::string&) { return k.stop(); }},
    {"gate_command", [](const KeyTable& k, const std::string& a) { return k.gate_command(a); }},
    {"claim",
     [](const KeyTable& k, const std::string& a) { return family_of(k.every_claim(), a); }},
    {"release",
     [](const KeyTable& k, const std::string& a) { return family_of(k.every_release(), a); }},
    {"hal_status", [](const KeyTable& k, const std::string&) { return k.hal_status(); }},
    {"every_heartbeat", [](const KeyTable& k, const std::string&) { return k.every_heartbeat(); }},
    {"alive", [](const KeyTable& k, const std::string& a) { return k.alive(a); }},
};

}  // namespace

TEST_CASE("every key the gate uses is the one in the shared golden table") {
  std::ifstream file(FAIRLEAD_GOLDEN_DIR "/keys.json");
  REQUIRE(file);
  std::map<std::string, int> checked;
  for (const auto& entry : nlohmann::json::parse(file)) {
    const auto builder = kBuilders.find(entry.at("method").get<std::string>());
    if (builder == kBuilders.end()) continue;
    const KeyTable keys(entry.at("namespace").get<std::string>(),
                        entry.at("robot").get<std::string>());
    CHECK(builder->second(keys, entry.at("argument").get<std::string>()) ==
          entry.at("key").get<std::string>());
    ++checked[builder->first];
  }
  CHECK(checked.size() == kBuilders.size());
}

TEST_CASE("a robot id or namespace that cannot be a key chunk is refused by name") {
  CHECK_THROWS_WITH_AS(KeyTable("fl", "Panda"),
                       "robot id: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or "
                       "digit, got 'Panda'",
                       ConfigRefused);
  CHECK_THROWS_AS(KeyTable("f/l", "panda"), ConfigRefused);
  CHECK_THROWS_AS(KeyTable("", "panda"), ConfigRefused);
  CHECK_FALSE(is_key_chunk("*"));
  CHECK_FALSE(is_key_chunk("_a"));
  CHECK_FALSE(is_key_chunk(std::string(65, 'a')));
  CHECK(is_key_chunk(std::string(64, 'a')));
  CHECK(is_key_chunk("left.arm-2"));
}

TEST_CASE("behind a command's key is a chunk for each person") {
  CHECK(KeyTable("fl", "panda").gate_command_of_any("arm") == "fl/panda/safety/cmd/arm/*");
  CHECK(KeyTable("fl", "panda").every_claim_of_any() == "fl/panda/safety/cmd/claim/*/*");
}
