// fairlead-decisions: reads what gates have recorded. A program of its own, so that nothing of it
// runs in the process that guards a robot.
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "decisions/explain_command.hpp"
#include "decisions/judge_command.hpp"
#include "process/refusal.hpp"

namespace {

using namespace fairlead;

constexpr const char* usage = R"(fairlead-decisions: reads the decision logs of gates.

fairlead-decisions judge LOG    judges a decision log again; see: fairlead-decisions judge --help
fairlead-decisions explain LOG  what `fairlead why` puts into words

example: fairlead-decisions judge ~/.local/state/fairlead/panda_mobile/safety/decisions
)";

int run(const std::vector<std::string>& words) {
  const std::string command = words.empty() ? "" : words[0];
  if (command == "--help" || command == "-h") {
    std::cout << usage;
    return 0;
  }
  if (command == "judge") return judge_command({words.begin() + 1, words.end()});
  if (command == "explain") return explain_command({words.begin() + 1, words.end()});
  throw ConfigRefused("expected judge or explain, got '" + command +
                      "'; see: fairlead-decisions --help");
}

// A refusal goes where scripts look for one: with --json to stdout, in the form of `fairlead`.
int refuse(const std::vector<std::string>& words, const char* kind, const char* why, int status) {
  if (std::find(words.begin(), words.end(), "--json") == words.end()) {
    std::cerr << "ERROR fairlead-decisions: " << why << std::endl;
    return status;
  }
  const nlohmann::ordered_json error = {{"kind", kind}, {"message", why}, {"fix", ""}};
  std::cout << nlohmann::ordered_json{{"error", error}}.dump(
                   2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
            << std::endl;
  return status;
}

}  // namespace

int main(int count, char** given) {
  const std::vector<std::string> words(given + 1, given + count);
  try {
    return run(words);
  } catch (const ConfigRefused& refusal) {
    return refuse(words, "ConfigError", refusal.what(), 2);
  } catch (const std::exception& error) {
    return refuse(words, "FairleadError", error.what(), 1);
  }
}
