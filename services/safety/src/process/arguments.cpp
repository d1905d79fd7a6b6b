#include "process/arguments.hpp"

#include <map>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

// Peers do not forward for each other, so a gate that also listened beside its router would be
// heard twice by some and not at all by others.
void check_endpoints(const Endpoints& endpoints) {
  if (endpoints.listen.empty() == endpoints.router.empty()) {
    throw ConfigRefused("--listen or --router: expected one of them; see: fairlead-safety --help");
  }
  if (!endpoints.router.empty() && !endpoints.connect.empty()) {
    throw ConfigRefused("--connect: not with --router, whose client connects to it alone");
  }
}

std::uint64_t whole_number(const std::string& word, const std::string& text) {
  const bool digits =
      !text.empty() && text.size() < 8 && text.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || std::stoull(text) == 0)
    throw ConfigRefused(word + ": expected a whole number from 1 to 9999999, got '" + text + "'");
  return std::stoull(text);
}

}  // namespace

Arguments parse_arguments(const std::vector<std::string>& words) {
  Arguments arguments;
  arguments.name_space = "fl";
  arguments.service = "safety";
  std::string files = "20";
  std::string mib = "1024";
  Endpoints& endpoints = arguments.endpoints;
  const std::map<std::string, std::string*> texts = {{"--robot", &arguments.robot},
                                                     {"--namespace", &arguments.name_space},
                                                     {"--service", &arguments.service},
                                                     {"--config", &arguments.config},
                                                     {"--listen", &endpoints.listen},
                                                     {"--router", &endpoints.router},
                                                     {"--access", &endpoints.access},
                                                     {"--state-dir", &arguments.state_dir},
                                                     {"--decision-log", &arguments.decision_log},
                                                     {"--decision-log-files", &files},
                                                     {"--decision-log-mib", &mib}};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--help" || word == "-h") {
      arguments.help = true;
      return arguments;
    }
    if (word == "--new-state") {
      arguments.new_state = true;
      continue;
    }
    const auto text = texts.find(word);
    if (text == texts.end() && word != "--connect") {
      throw ConfigRefused("unknown argument '" + word + "'; see: fairlead-safety --help");
    }
    if (++i == words.size()) throw ConfigRefused(word + ": expected a value after it");
    if (text == texts.end()) {
      endpoints.connect.push_back(words[i]);
    } else {
      *text->second = words[i];
    }
  }
  for (const char* required : {"--robot", "--config", "--state-dir"}) {
    if (texts.at(required)->empty()) {
      throw ConfigRefused(std::string(required) + ": missing; see: fairlead-safety --help");
    }
  }
  check_endpoints(endpoints);
  arguments.decision_log_files = whole_number("--decision-log-files", files);
  arguments.decision_log_mib = whole_number("--decision-log-mib", mib);
  if (arguments.decision_log.empty()) arguments.decision_log = arguments.state_dir + "/decisions";
  if (arguments.decision_log == "none") arguments.decision_log.clear();
  return arguments;
}

std::string usage() {
  return R"(fairlead-safety: the gate between a policy and a robot.

It judges every row of every command chunk and is the only writer the robot obeys.
Not safety-rated; its stop is a protective stop request.

  --robot ID         the robot's id on the network
  --config FILE      compiled gate file, robots/<robot>/gate.<profile>.json
  --listen ENDPOINT  where others reach this process
  --connect ENDPOINT whom it connects to; may be repeated; tried for ever
  --router ENDPOINT  instead of these two: be a client of this router; tried for ever
  --access FILE      who this process is, and whom it lets do what: part of a Zenoh configuration, as
                     `fairlead up` writes it; without it whoever reaches the gate may do anything
  --state-dir DIR    folder for the latch and the clean mark
  --new-state        this state folder is new and that is right: without it a gate whose profile
                     is for hardware boots latched when its folder was never used before
  --decision-log DIR where what the gate was given and decided is recorded, in numbered files, or none
                     (default: decisions/ in the state folder); read it with: fairlead why, and
                     fairlead-decisions --help
  --decision-log-files N  how many files are kept there (default: 20)
  --decision-log-mib N    size of all of them together; the oldest go (default: 1024)
  --namespace NAME   first chunk of every key (default: fl)
  --service NAME     this process's name in keys and logs (default: safety)

fairlead-safety check FILE   whether a gate would start on this compiled file

Prints `ready` when it is up. SIGTERM and SIGINT disarm it and end it with status 0.
Exit status: 0 ended on request, 1 network or state folder unusable, 2 refused configuration.

example: fairlead-safety --robot panda_mobile --config robots/panda_mobile/gate.sim.json \
           --listen tcp/127.0.0.1:7502 --connect tcp/127.0.0.1:7501 --state-dir /tmp/gate
)";
}

}  // namespace fairlead
