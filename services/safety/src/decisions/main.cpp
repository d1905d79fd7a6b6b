// fairlead-decisions: reads what gates have recorded. A program of its own, so that nothing of it
// runs in the process that guards a robot.
#include <iostream>
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

}  // namespace

int main(int count, char** words) {
  try {
    return run({words + 1, words + count});
  } catch (const ConfigRefused& refusal) {
    std::cout << "ERROR fairlead-decisions: " << refusal.what() << std::endl;
    return 2;
  } catch (const std::exception& error) {
    std::cout << "ERROR fairlead-decisions: " << error.what() << std::endl;
    return 1;
  }
}
