#include "decisions/explain_command.hpp"

#include <iostream>
#include <memory>
#include <optional>

#include "config/config_loader.hpp"
#include "decisions/header.hpp"
#include "decisions/log_choice.hpp"
#include "decisions/log_reader.hpp"
#include "decisions/log_story.hpp"
#include "decisions/log_words.hpp"
#include "decisions/verdict_document.hpp"
#include "decisions/what_passes.hpp"
#include "process/refusal.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

constexpr std::size_t kMostDecisions = 8;  // about one tick; the newest

struct Request {
  std::optional<std::uint64_t> tick;  // none: the last refusal or truncation
  std::string source;
};

std::uint64_t parse_tick(const std::string& text) {
  if (text.empty() || text.size() > 19 || text.find_first_not_of("0123456789") != std::string::npos)
    throw ConfigRefused("explain: --tick: expected a whole number, got '" + text + "'");
  return std::stoull(text);
}

Request request_of(const LogWords& words) {
  Request request;
  if (words.has("--tick")) request.tick = parse_tick(words.value("--tick"));
  request.source = words.value("--source");
  return request;
}

bool matches(const Request& request, const Moment& moment) {
  if (!request.source.empty() &&
      (!moment.is_verdict || !(moment.verdict.source == request.source.c_str())))
    return false;
  if (request.tick.has_value()) return moment.is_about(*request.tick);
  return !moment.is_verdict ||
         moment.verdict.outcome != static_cast<std::uint8_t>(Outcome::released);
}

/// What a first reading finds; decisions oldest first.
struct Reading {
  std::vector<Moment> decisions;
  std::uint64_t verdicts = 0;
  std::uint64_t lost = 0;
  std::uint64_t tick = 0;
  json status;
  std::string end;
};

// `last` is the newest step that refused or cut something, and what stopped the gate since.
void keep(const Request& request, const Moment& moment, std::vector<Moment>& kept) {
  const bool is_newer = moment.is_verdict && !kept.empty() && kept.back().step != moment.step;
  if (!request.tick.has_value() && is_newer) kept.clear();
  kept.push_back(moment);
  if (kept.size() > kMostDecisions) kept.erase(kept.begin() + 1);
}

Reading read_through(const std::filesystem::path& path, const Limits& limits,
                     const Request& request) {
  Reading reading;
  LogReader log(path);
  LogStory story(limits);
  Record record;
  while (log.next(record)) {
    reading.lost += record.lost;
    for (const Moment& moment : story.take(record)) {
      reading.verdicts += moment.is_verdict ? 1U : 0U;
      if (matches(request, moment)) keep(request, moment, reading.decisions);
    }
  }
  reading.tick = story.tick();
  reading.status = story.status();
  reading.end = log.end_text();
  return reading;
}

json document_of(const Moment& moment) {
  if (!moment.is_verdict) {
    json document = moment.status;
    document["kind"] = moment.status.at("state") == "latched" ? "latch" : "stop";
    document["tick"] = moment.tick;
    return document;
  }
  json document = verdict_document(moment.verdict);
  document["kind"] = "verdict";
  document["tick"] = moment.tick;
  document["judged_again"] = moment.again;
  document["chunk"] = moment.has_chunk ? moment.chunk : json();
  return document;
}

// The gate as it was just before: asked about other chunks than the one that came.
void ask_the_gate(Replay& replay, const Record& record, const Limits& limits, const LogStory& story,
                  const Moment& moment, json& document) {
  ChunkProbe probe(replay, record, limits);
  if (moment.verdict.outcome == static_cast<std::uint8_t>(Outcome::released)) {
    document["nearest"] = nearest_limits(probe, limits, story.measured());
  } else {
    document["would_pass"] = what_would_pass(probe, moment.verdict, limits, story.measured());
  }
}

json explained(const std::filesystem::path& path, const Limits& limits, const Reading& reading) {
  json documents = json::array();
  for (const Moment& moment : reading.decisions) documents.push_back(document_of(moment));
  if (reading.decisions.empty()) return documents;
  LogReader log(path);
  LogStory story(limits);
  Replay replay(limits);
  Record record;
  while (story.steps() < reading.decisions.back().step && log.next(record)) {
    if (record.type == RecordType::gap) break;  // what the gate knew from here on is lost
    (void)story.take(record);
    for (std::size_t i = 0; i < documents.size(); ++i) {
      const Moment& moment = reading.decisions[i];
      if (moment.step == story.steps() && moment.is_verdict && moment.of_candidate &&
          moment.has_chunk)
        ask_the_gate(replay, record, limits, story, moment, documents[i]);
    }
    replay.feed(record);
    if (!replay.same_as(record)) break;  // another gate than this one decided
  }
  return documents;
}

}  // namespace

std::string explain_usage() {
  return R"(fairlead-decisions explain LOG [--tick N] [--source S]: why, as one JSON document.

  LOG         a *.decisions file, or a folder of them: its newest
  --tick N    decisions made at this tick or about a row for it; without it: the last refusal or
              truncation, and stops and latches since
  --source S  only chunks of this runner

`fairlead why` puts it into words.
Exit status: 0, also if there is no such decision; 2 not readable.
)";
}

int explain_command(const std::vector<std::string>& given) {
  const LogWords words = parse_log_words("explain", given, {"--tick", "--source"}, {});
  if (words.help) {
    std::cout << explain_usage();
    return 0;
  }
  const Request request = request_of(words);
  const std::filesystem::path path = choose_log(words.log);
  const LogHeader header = read_header(LogReader(path).header());
  const std::unique_ptr<Limits> limits = recorded_limits(header);
  const Reading reading = read_through(path, *limits, request);
  const json document = {{"log", path.string()},
                         {"robot", header.robot},
                         {"profile", header.profile},
                         {"started", header.started},
                         {"config_file", header.config_file},
                         {"read", reading.end},
                         {"lost", reading.lost},
                         {"tick", reading.tick},
                         {"verdicts", reading.verdicts},
                         {"status", reading.status},
                         {"decisions", explained(path, *limits, reading)}};
  std::cout << document.dump(2) << std::endl;
  return 0;
}

}  // namespace fairlead
