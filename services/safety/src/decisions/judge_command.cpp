#include "decisions/judge_command.hpp"

#include <iostream>
#include <memory>
#include <set>
#include <string>

#include "config/config_loader.hpp"
#include "config/sha256.hpp"
#include "decisions/header.hpp"
#include "decisions/log_choice.hpp"
#include "decisions/log_reader.hpp"
#include "decisions/log_words.hpp"
#include "decisions/replay.hpp"
#include "decisions/verdict_document.hpp"
#include "decisions/what_if.hpp"
#include "process/refusal.hpp"
#include "process/verdict_text.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

/// What a run through a log found.
struct Findings {
  std::uint64_t steps = 0, lost = 0, verdicts = 0;
  std::array<std::uint64_t, 3> outcomes{};  // by Outcome
  std::uint64_t newest_verdict = 0;
  std::uint64_t tick = 0;
  json difference;  // null: none

  /// It begins in the middle of a run: nothing in it can be judged.
  [[nodiscard]] bool goes_on() const { return lost > 0 && steps == 0; }
  void take(const Record& record);
};

void Findings::take(const Record& record) {
  lost += record.lost;
  if (record.type == RecordType::step && record.event.kind == EventKind::joint_state) {
    JointState state;
    if (decode(record.event.payload, state) == FrameFault::none) tick = state.tick;
  }
  for (const RecordedOutput& output : record.outputs) {
    Verdict verdict;
    if (output.kind != OutputKind::verdict || decode(output.payload, verdict) != FrameFault::none ||
        verdict.verdict_id <= newest_verdict || verdict.outcome >= outcomes.size())
      continue;
    newest_verdict = verdict.verdict_id;
    ++verdicts;
    ++outcomes[verdict.outcome];
  }
}

json first_difference(const Record& record, const Replay& replay, const Findings& findings) {
  json difference = {{"step", findings.steps},
                     {"tick", findings.tick},
                     {"outputs_recorded", record.output_count},
                     {"outputs_now", replay.outputs().items().size()}};
  for (const RecordedOutput& output : record.outputs) {
    Verdict verdict;
    if (output.kind == OutputKind::verdict && decode(output.payload, verdict) == FrameFault::none)
      difference["recorded"].push_back(verdict_document(verdict));
  }
  for (const Output& output : replay.outputs().items()) {
    Verdict verdict;
    if (output.kind == OutputKind::verdict &&
        decode(replay.outputs().payload(output), verdict) == FrameFault::none)
      difference["now"].push_back(verdict_document(verdict));
  }
  return difference;
}

// The same limits: every output of every step must be the recorded one. A gap ends it, since
// what the gate knew then is gone.
Findings judge_again(LogReader& log, const Limits& limits) {
  Findings findings;
  Replay replay(limits);
  Record record;
  while (findings.difference.is_null() && findings.lost == 0 && log.next(record)) {
    findings.take(record);
    if (record.type == RecordType::gap || record.type == RecordType::end) continue;
    ++findings.steps;
    replay.feed(record);
    if (!replay.same_as(record)) findings.difference = first_difference(record, replay, findings);
  }
  return findings;
}

Findings judge_otherwise(LogReader& log, WhatIf& what_if) {
  Findings findings;
  Record record;
  while (findings.lost == 0 && log.next(record)) {
    findings.take(record);
    if (record.type == RecordType::gap || record.type == RecordType::end) continue;
    ++findings.steps;
    what_if.feed(record, findings.tick);
  }
  return findings;
}

std::string how_far(const LogReader& log, const Findings& findings) {
  if (findings.goes_on())
    return "nothing judged: it goes on from a file before, and only the first of a run can be "
           "judged";
  if (findings.lost > 0)
    return "judged up to a gap of " + std::to_string(findings.lost) +
           " records that could not be written";
  if (!findings.difference.is_null()) return "judged up to the first difference";
  return log.end_text();
}

json document_of(const LogReader& log, const LogHeader& header, const Findings& findings,
                 const std::filesystem::path& path) {
  return {{"log", path.string()},
          {"robot", header.robot},
          {"profile", header.profile},
          {"started", header.started},
          {"same_program", header.gate == hash_of_this_gate()},
          {"read", how_far(log, findings)},
          {"damaged", log.end() == LogEnd::damaged},
          {"lost", findings.lost},
          {"steps", findings.steps},
          {"chunks", findings.verdicts},
          {"released", findings.outcomes[0]},
          {"truncated", findings.outcomes[1]},
          {"refused", findings.outcomes[2]}};
}

void print_head(const json& found) {
  const auto text = [&found](const char* key) { return found.at(key).get<std::string>(); };
  const auto count = [&found](const char* key) {
    return std::to_string(found.at(key).get<std::uint64_t>());
  };
  std::cout << "log     " << text("log") << "\n        " << text("robot") << ", profile "
            << text("profile") << ", begun " << text("started")
            << (found.at("same_program") ? "" : ", by another build of the gate") << "\nread    "
            << text("read") << "\njudged  " << count("steps") << " steps, " << count("chunks")
            << " verdicts: " << count("released") << " released, " << count("truncated")
            << " truncated, " << count("refused") << " refused\n";
}

void print_difference(const json& difference) {
  std::cout << "DIFFERENT at step " << difference.at("step") << " (tick " << difference.at("tick")
            << "): recorded " << difference.at("outputs_recorded") << " outputs, now "
            << difference.at("outputs_now") << "\n";
  for (const char* which : {"recorded", "now"}) {
    for (const json& verdict : difference.value(which, json::array()))
      std::cout << "  " << which << ": " << verdict.dump() << "\n";
  }
}

int report_again(const LogWords& words, json found, const Findings& findings) {
  const bool identical = findings.difference.is_null() && !findings.goes_on();
  found["identical"] = identical;
  found["first_difference"] = findings.difference;
  if (words.has("--json")) {
    std::cout << found.dump(2) << "\n";
  } else {
    print_head(found);
    if (identical) {
      std::cout << "identical: this gate gives every output bit for bit as recorded\n";
    } else if (!findings.difference.is_null()) {
      print_difference(findings.difference);
    }
  }
  if (!findings.difference.is_null()) return 1;
  return identical && !found.at("damaged") ? 0 : 2;
}

// Where a limit comes from may be a page of text: it is said once.
std::string in_words(const Verdict& verdict, std::set<std::string>& said) {
  if (verdict.outcome == static_cast<std::uint8_t>(Outcome::released)) return "released";
  const std::string source(verdict.limit_source.view());
  const bool is_news = has_magnitude(verdict) && said.emplace(source).second;
  return verdict_text(verdict) + (is_news ? " (" + source + ")" : "");
}

constexpr const char* kOpenLoop =
    "open loop: states are as recorded; rows that would not have been released count as holds, "
    "but the robot was where they had moved it";

json changes_of(const WhatIf& what_if) {
  json changes = json::array();
  for (const ChangedVerdict& change : what_if.changed())
    changes.push_back({{"tick", change.tick},
                       {"recorded", verdict_document(change.recorded)},
                       {"instead", verdict_document(change.instead)}});
  return changes;
}

int report_otherwise(const LogWords& words, json found, const Limits& limits, bool goes_on,
                     const WhatIf& what_if) {
  const std::string config = words.value("--config");
  if (words.has("--json")) {
    found["config"] = config;
    found["config_hash"] = to_hex(limits.config_hash);
    found["changed"] = changes_of(what_if);
    found["unjudged"] = what_if.unjudged();
    found["notes"] = what_if.notes();
    found["open_loop"] = kOpenLoop;
    std::cout << found.dump(2) << "\n";
  } else {
    print_head(found);
    std::cout << "under   " << config << " hash " << to_hex(limits.config_hash) << "\n";
    std::set<std::string> said;
    for (const ChangedVerdict& change : what_if.changed())
      std::cout << "  tick " << change.tick << ": chunk " << change.recorded.seq << " of "
                << change.recorded.source.view() << " was " << outcome_name(change.recorded.outcome)
                << "; instead: " << in_words(change.instead, said) << "\n";
    for (const std::string& note : what_if.notes()) std::cout << "  " << note << "\n";
    std::cout << what_if.changed().size() << " of " << found.at("chunks").get<std::uint64_t>()
              << " verdicts change";
    if (what_if.unjudged() > 0)
      std::cout << "; " << what_if.unjudged() << " chunks not judged: the gate had no such claim";
    std::cout << "\n" << kOpenLoop << "\n";
  }
  if (!what_if.changed().empty() || what_if.unjudged() > 0 || !what_if.notes().empty()) return 1;
  return found.at("damaged") || goes_on ? 2 : 0;
}

}  // namespace

std::string judge_usage() {
  return R"(fairlead-decisions judge LOG [--config FILE] [--json]: judge recorded steps again.

  LOG            a *.decisions file, or a folder of them: its newest
  --config FILE  another compiled gate file of the same robot: which chunks would have come to
                 another outcome under its limits
  --json         one JSON document

Exit status: 0 identical (with --config: no outcome changes), 1 different, 2 nothing to judge, not
readable, or damaged: what is before the damage is judged and found identical.

example: fairlead-decisions judge ~/.local/state/fairlead/panda_mobile/safety/decisions
)";
}

int judge_command(const std::vector<std::string>& given) {
  const LogWords words = parse_log_words("judge", given, {"--config"}, {"--json"});
  if (words.help) {
    std::cout << judge_usage();
    return 0;
  }
  const std::filesystem::path path = choose_log(words.log);
  LogReader log(path);
  const LogHeader header = read_header(log.header());
  const std::string config = words.value("--config");
  if (config.empty()) {
    const std::unique_ptr<Limits> limits = recorded_limits(header);
    const Findings findings = judge_again(log, *limits);
    return report_again(words, document_of(log, header, findings, path), findings);
  }
  const std::unique_ptr<Limits> limits = load_limits(config);
  if (limits->robot != Name(header.robot))
    throw ConfigRefused("judge: the log is of the robot " + header.robot + ", " + config + " of " +
                        std::string(limits->robot.view()));
  WhatIf what_if(*limits);
  const Findings findings = judge_otherwise(log, what_if);
  return report_otherwise(words, document_of(log, header, findings, path), *limits,
                          findings.goes_on(), what_if);
}

}  // namespace fairlead
