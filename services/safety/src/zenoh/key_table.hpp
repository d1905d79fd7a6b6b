// Every Zenoh key expression the gate uses, built in one place.
//
// Grammar: <namespace>/<robot>/<group>/<noun>[/<source>], lower snake case, singular nouns.
// Worked example, namespace fl, robot panda_mobile, runner "runner":
//
//   KeyTable keys("fl", "panda_mobile");
//   keys.candidate("runner")  ->  "fl/panda_mobile/action/candidate/runner"
//
// The Python services have their own copy of this grammar (fairlead/keys.py); both are tested
// against tests/golden/keys.json.
#pragma once

#include <string>
#include <string_view>

namespace fairlead {

class KeyTable {
 public:
  /// Throws ConfigRefused if either cannot be a chunk of a key.
  KeyTable(std::string_view name_space, std::string_view robot);

  std::string joints() const { return key("state/joints"); }
  std::string candidate(std::string_view source) const { return key("action/candidate", source); }
  std::string every_candidate() const { return key("action/candidate/*"); }
  std::string safe(std::string_view source) const { return key("action/safe", source); }
  std::string lease() const { return key("safety/lease"); }
  std::string verdict(std::string_view source) const { return key("safety/verdict", source); }
  std::string gate_status() const { return key("safety/status"); }
  std::string stop() const { return key("safety/stop"); }
  std::string gate_command(std::string_view verb) const { return key("safety/cmd", verb); }
  std::string gate_command_of_any(std::string_view verb) const {
    return key("safety/cmd", verb) + "/*";
  }
  std::string every_claim() const { return key("safety/cmd/claim/*"); }
  std::string every_claim_of_any() const { return every_claim() + "/*"; }
  std::string every_release() const { return key("safety/cmd/release/*"); }
  std::string hal_status() const { return key("hal/status"); }
  std::string every_heartbeat() const { return key("skill/*/heartbeat"); }
  std::string alive(std::string_view service) const { return key("alive", service); }

 private:
  std::string key(std::string_view rest) const;
  std::string key(std::string_view group, std::string_view last) const;

  std::string prefix_;
};

/// Whether a name is 1 to 64 of a-z 0-9 _ . - and starts with a letter or digit.
bool is_key_chunk(std::string_view name);

}  // namespace fairlead
