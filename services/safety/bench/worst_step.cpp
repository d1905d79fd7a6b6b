#include "worst_step.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "attack.hpp"
#include "bench_gate.hpp"
#include "bench_robot.hpp"
#include "core/gate/hal_link.hpp"
#include "stopwatch.hpp"

namespace fairlead::bench {
namespace {

constexpr int climbs = 8;             // from different starts, before the best one goes on
constexpr int starts = 100;           // of each climb, the best is taken
constexpr int repetitions = 5;        // of the slowest, the quickest counts
constexpr double drift_share = 0.25;  // of the largest jump of a joint
constexpr std::array<const char*, max_parts> runners{"a", "b", "c", "d", "e", "f", "g", "h"};

struct Looked {
  std::size_t configurations = 0;
  double us = 0.0;
};

/// The parts of each claim: as many claims as the gate grants at once. Who has the switch of a
/// tool's motion has the tool.
std::vector<std::vector<std::size_t>> claims_of(const Limits& limits) {
  const auto is_switch = [](const PartLimits& part) { return part.modes.composite_mode.supported; };
  const bool switched = std::any_of(limits.parts.begin(), limits.parts.end(), is_switch);
  std::vector<std::vector<std::size_t>> claims;
  std::vector<std::size_t> together;
  for (std::size_t part = 0; part < limits.parts.size(); ++part)
    if (const PartLimits& robot = limits.parts[part];
        switched && (is_switch(robot) || moves_tool(robot.modes)))
      together.push_back(part);
    else
      claims.push_back({part});
  if (!together.empty()) claims.push_back(together);
  return claims;
}

/// What an attack costs one robot's gate.
class Target {
 public:
  explicit Target(const Limits& limits)
      : limits_(limits),
        model_(limits),
        claim_(claim_of(limits)),
        rows_(limits.protocol.horizon_max),
        state_(middle_of(limits)) {}

  /// One claim for all parts, one judgement.
  Looked look(const Attack& attack) {
    const AttackRows rows = rows_of(attack, model_, rows_);
    stand(attack, false);
    ActionChunk chunk;
    chunk.horizon = rows_;
    chunk.obs_tick = chunk.oldest_tick = chunk.start_tick = state_.tick;
    for (const ActionPart& action : rows.actions) (void)chunk.parts.push_back(action);
    const std::size_t certified = HalLink::granted_ticks(limits_.period_ns) + 1;
    const std::uint64_t start = busy_ns();
    const Judgement found = judge_rows(room_, model_, claim_, state_, chunk,
                                       JudgedRows{0, rows_, certified}, RowBefore{}, {});
    return {found.configurations, static_cast<double>(busy_ns() - start) * 1e-3};
  }

  /// As many claims as may be: all chunks, a state, once more.
  AttackedSteps step(const Attack& attack) {
    const AttackRows rows = rows_of(attack, model_, rows_);
    BenchGate gate(limits_, false);
    AttackedSteps steps;
    stand(attack, false);
    gate.next_state(state_);
    gate.arm();
    const std::vector<std::vector<std::size_t>> claims = claims_of(limits_);
    std::vector<std::uint64_t> ids;
    for (std::size_t i = 0; i < claims.size(); ++i)
      ids.push_back(gate.claim(runners[i], claims[i]));
    for (int round = 0; round < 2; ++round) {
      double tick_us = 0.0;
      const auto note = [&tick_us](StepTime time, double& most_us) {
        tick_us += time.busy_ns * 1e-3;
        most_us = std::max(most_us, time.busy_ns * 1e-3);
      };
      for (std::size_t i = 0; i < claims.size(); ++i) {
        FixedVec<ActionPart, max_parts> parts;
        for (const std::size_t part : claims[i]) (void)parts.push_back(rows.actions[part]);
        note(gate.send_chunk(runners[i], ids[i], rows_, parts), steps.chunk_us);
      }
      stand(attack, true);
      note(gate.next_state(state_), steps.state_us);
      steps.tick_us = std::max(steps.tick_us, tick_us);
    }
    return steps;
  }

 private:
  void stand(const Attack& attack, bool drifts) {
    if (!drifts) state_.positions = attack.at;
    const double period_s = static_cast<double>(limits_.period_ns) * 1e-9;
    for (std::size_t j = 0; j < limits_.joints.size(); ++j) {
      const double way =
          drifts ? drift_share * limits_.joints[j].jump_limit * attack.drift[j] : 0.0;
      state_.positions[j] += way;
      state_.velocities[j] = way / period_s;
    }
  }

  const Limits& limits_;
  const RobotModel model_;
  PathRoom room_;
  const ClaimLimits claim_;
  const std::uint32_t rows_;
  MeasuredState state_;
};

/// The attack with the highest score, found in a time of the processor's.
template <class Score>
class Climb {
 public:
  Climb(const Limits& limits, Lots& lots, const Score& score)
      : limits_(limits), lots_(lots), score_(score) {}

  void run(double seconds) {
    const std::uint64_t began = busy_ns();
    const auto end_of = [&](double share) {
      return began + static_cast<std::uint64_t>(share * seconds * 1e9);
    };
    Attack best;
    double best_score = -1.0;
    for (int i = 0; i < climbs; ++i) {
      begin();
      climb_until(end_of(0.6 * (i + 1) / climbs));
      if (at_score_ <= best_score) continue;
      best = at_;
      best_score = at_score_;
    }
    at_ = best;
    at_score_ = best_score;
    climb_until(end_of(1.0));
  }
  [[nodiscard]] const Attack& best() const { return at_; }
  [[nodiscard]] std::size_t tried() const { return tried_; }

 private:
  void begin() {
    at_score_ = -1.0;
    for (int i = 0; i < starts; ++i) try_out(any_attack(limits_, lots_));
  }
  void climb_until(std::uint64_t end_ns) {
    while (busy_ns() < end_ns) try_out(varied(at_, limits_, lots_));
  }
  // Twice, or what interrupted it once would count.
  void try_out(const Attack& next) {
    ++tried_;
    double score = score_(next);
    if (score > at_score_) score = std::min(score, score_(next));
    if (score <= at_score_) return;
    at_ = next;
    at_score_ = score;
  }

  const Limits& limits_;
  Lots& lots_;
  const Score& score_;
  Attack at_;
  double at_score_ = -1.0;
  std::size_t tried_ = 0;
};

}  // namespace

WorstStep find_worst_step(const Limits& limits, double seconds) {
  Lots lots;
  const auto target = std::make_unique<Target>(limits);
  WorstStep worst;
  const auto looks = [&](const Attack& attack) {
    return static_cast<double>(target->look(attack).configurations);
  };
  Climb by_looks(limits, lots, looks);
  by_looks.run(0.5 * seconds);
  const auto time = [&](const Attack& attack) { return target->step(attack).longest_us(); };
  Climb by_time(limits, lots, time);
  by_time.run(0.5 * seconds);
  worst.attacks = by_looks.tried() + by_time.tried();
  worst.most_configurations_us = worst.steps.chunk_us = worst.steps.state_us = 1e300;
  for (int i = 0; i < repetitions; ++i) {
    const Looked looked = target->look(by_looks.best());
    worst.most_configurations = looked.configurations;
    worst.most_configurations_us = std::min(worst.most_configurations_us, looked.us);
    const AttackedSteps steps = target->step(by_time.best());
    if (i == 0 || steps.longest_us() < worst.steps.longest_us()) worst.steps = steps;
  }
  return worst;
}

}  // namespace fairlead::bench
