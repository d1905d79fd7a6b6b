// fairlead-safety-bench: how long the gate's core takes, as numbers for bench/gate_core.py.
//
//   fairlead-safety-bench CONFIG [--rounds N] [--rows N] [--ticks N] [--worst SECONDS]
//   fairlead-safety-bench CONFIG --case NAME --calls N
#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/config_loader.hpp"
#include "judge_cases.hpp"
#include "step_bench.hpp"
#include "stopwatch.hpp"
#include "worst_step.hpp"

namespace {

using namespace fairlead;
using namespace fairlead::bench;
using nlohmann::json;

constexpr std::size_t most_pairs = 60;
constexpr std::string_view usage = R"(fairlead-safety-bench CONFIG [options]

How long the gate's core takes with a gate file, as JSON; bench/gate_core.py makes tables of it.

  --rounds N        batches of each short case (200)
  --rows N          rows of a chunk in whole steps (64)
  --ticks N         whole steps of each kind (20000)
  --worst SECONDS   only search for the slowest step that a hostile policy can make, for so long
  --case NAME --calls N   only run one short case, for a profiler

  fairlead-safety-bench robots/panda_mobile/gate.sim.json --worst 60
)";
constexpr double batch_ns = 200'000.0;  // long beside the clock's own cost, short beside a tick
constexpr double step_aim_ns = 200'000.0;

using Cases = std::vector<std::unique_ptr<Case>>;

Cases all_cases(const Limits& robot) {
  Cases cases;
  for (const std::uint32_t rows : {1U, 16U, 50U}) {
    const std::string suffix = " H=" + std::to_string(rows);
    cases.push_back(std::make_unique<CopyAndCompare>("yardstick" + suffix, robot, rows));
    cases.push_back(std::make_unique<LimitRows>("limits" + suffix, robot, rows));
    cases.push_back(std::make_unique<WholeRows>("all checks" + suffix, robot, rows));
  }
  return cases;
}

double timed_ns(Case& one, std::size_t calls) {
  const std::uint64_t start = now_ns();
  one.run(calls);
  return static_cast<double>(now_ns() - start) / static_cast<double>(calls);
}

std::size_t calls_of(Case& one) {
  std::size_t calls = 1;
  while (timed_ns(one, calls) * static_cast<double>(calls) < batch_ns) calls *= 2;
  return calls;
}

json time_all(Cases& cases, std::size_t rounds) {
  std::vector<std::size_t> calls;
  std::vector<std::vector<double>> times(cases.size());
  for (const auto& one : cases) calls.push_back(calls_of(*one));
  for (std::size_t round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < cases.size(); ++i)
      times[i].push_back(timed_ns(*cases[i], calls[i]));
  json found = json::object();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::sort(times[i].begin(), times[i].end());
    found[cases[i]->name()] = {{"least_ns", times[i].front()},
                               {"median_ns", times[i][times[i].size() / 2]}};
  }
  return found;
}

std::string option(const std::vector<std::string>& words, const std::string& name,
                   const std::string& otherwise) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == name) return words[i + 1];
  return otherwise;
}

json spread(const std::vector<StepTime>& steps, double StepTime::*clock) {
  std::vector<double> times;
  for (const StepTime& step : steps) times.push_back(step.*clock);
  std::sort(times.begin(), times.end());
  const auto at = [&times](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  return {{"p50_ns", at(0.5)}, {"p99_ns", at(0.99)}, {"p999_ns", at(0.999)}, {"max_ns", at(1.0)}};
}

json both_clocks(const std::vector<StepTime>& steps) {
  return {{"wall", spread(steps, &StepTime::wall_ns)}, {"busy", spread(steps, &StepTime::busy_ns)}};
}

void add_whole_steps(json& found, const std::string& robot_name, const Limits& robot,
                     std::uint32_t rows, std::size_t ticks) {
  for (const bool moving : {false, true})
    for (const bool lockstep : {true, false}) {
      const StepTimes times = time_steps(robot, {lockstep, moving, rows}, ticks);
      const std::string kind = robot_name + (lockstep ? ", lockstep" : ", realtime") +
                               (moving ? ", rows that oscillate" : ", rows that hold");
      if (!times.refused.empty())
        throw std::runtime_error(kind + ": a chunk was not released: " + times.refused);
      found[kind] = {{"chunk", both_clocks(times.chunks)}, {"state", both_clocks(times.states)}};
    }
}

/// The same little work over and over, each time as long as a whole step may take: what the machine
/// adds to that, now and then.
json control(const Limits& robot, std::size_t ticks) {
  CopyAndCompare work("", robot, 50);
  const auto calls = static_cast<std::size_t>(step_aim_ns / timed_ns(work, calls_of(work)));
  std::vector<StepTime> times;
  while (times.size() < ticks) times.push_back(time_of([&] { work.run(calls); }));
  return both_clocks(times);
}

json worst_step(const Limits& robot, double seconds) {
  const WorstStep worst = find_worst_step(robot, seconds);
  return {{"most_configurations", worst.most_configurations},
          {"most_configurations_us", worst.most_configurations_us},
          {"chunk_us", worst.steps.chunk_us},
          {"state_us", worst.steps.state_us},
          {"tick_us", worst.steps.tick_us},
          {"step_deadline_us", robot.protocol.step_deadline_us},
          {"attacks", worst.attacks}};
}

void run(const std::vector<std::string>& words) {
  if (words.empty() || words[0] == "--help" || words[0] == "-h") {
    std::cout << usage;
    return;
  }
  const auto shipped = load_limits(words[0]);
  const std::string seconds = option(words, "--worst", "");
  if (!seconds.empty()) {
    std::cout << worst_step(*shipped, std::stod(seconds)).dump(2) << "\n";
    return;
  }
  const auto robot = std::make_unique<Limits>(one_part_of(*shipped, most_pairs));
  Cases cases = all_cases(*robot);
  const std::string only = option(words, "--case", "");
  if (only.empty()) {
    const std::size_t rounds = std::stoul(option(words, "--rounds", "200"));
    const auto rows = static_cast<std::uint32_t>(std::stoul(option(words, "--rows", "64")));
    const std::size_t ticks = std::stoul(option(words, "--ticks", "20000"));
    json steps = json::object();
    add_whole_steps(steps, "joint targets", *robot, rows, ticks);
    add_whole_steps(steps, "all parts", *shipped, rows, ticks);
    std::cout << json{{"joints", robot->joints.size()},
                      {"pairs", robot->collision.pairs.size()},
                      {"cases", time_all(cases, rounds)},
                      {"rows", rows},
                      {"ticks", ticks},
                      {"steps", steps},
                      {"control", control(*robot, ticks)}}
                     .dump(2)
              << "\n";
    return;
  }
  for (const auto& one : cases)
    if (one->name() == only) return one->run(std::stoul(option(words, "--calls", "1")));
  throw std::runtime_error("no case is called '" + only + "'");
}

}  // namespace

int main(int count, char** words) {
  try {
    run({words + 1, words + count});
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ERROR fairlead-safety-bench: " << error.what() << "\n";
    return 2;
  }
}
