#include "step_bench.hpp"

#include <memory>
#include <numeric>
#include <string>

#include "bench_robot.hpp"

namespace fairlead::bench {
namespace {

constexpr const char* runner = "runner";

std::string describe(const Verdict& verdict) {
  std::string text("G");
  text += std::to_string(verdict.code);
  for (const std::string_view word :
       {verdict.part.view(), verdict.axis.view(), verdict.limit_source.view()})
    text.append(" ").append(word);
  return text;
}

/// Robot, runner and operator of one gate.
class Bench {
 public:
  Bench(const Limits& limits, StepKind kind)
      : limits_(limits), kind_(kind), state_(middle_of(limits)), gate_(limits, kind.lockstep) {
    gate_.next_state(state_);
    gate_.arm();
    std::vector<std::size_t> parts(limits.parts.size());
    std::iota(parts.begin(), parts.end(), 0U);
    claim_id_ = gate_.claim(runner, parts);
  }

  StepTime next_state() { return gate_.next_state(state_); }
  StepTime next_chunk() {
    FixedVec<ActionPart, max_parts> parts;
    numbers_.clear();
    for (std::size_t part = 0; part < limits_.parts.size(); ++part) {
      numbers_.push_back(rows_for(limits_, state_, part, kind_.rows, kind_.moving));
      (void)parts.push_back(action_of(limits_, part, numbers_.back()));
    }
    return gate_.send_chunk(runner, claim_id_, kind_.rows, parts);
  }
  Verdict verdict() { return gate_.verdict(); }

 private:
  const Limits& limits_;
  const StepKind kind_;
  MeasuredState state_;
  BenchGate gate_;
  std::uint64_t claim_id_ = 0;
  std::vector<std::vector<double>> numbers_;
};

}  // namespace

StepTimes time_steps(const Limits& limits, StepKind kind, std::size_t ticks) {
  const auto bench = std::make_unique<Bench>(limits, kind);
  StepTimes times;
  times.chunks.reserve(ticks);
  times.states.reserve(ticks);
  for (std::size_t i = 0; i < ticks; ++i) {
    times.chunks.push_back(bench->next_chunk());
    const Verdict verdict = bench->verdict();
    if (verdict.outcome != static_cast<std::uint8_t>(Outcome::released))
      times.refused = describe(verdict);
    times.states.push_back(bench->next_state());
  }
  return times;
}

}  // namespace fairlead::bench
