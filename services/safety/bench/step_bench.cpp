#include "step_bench.hpp"

#include <memory>
#include <stdexcept>

#include "bench_robot.hpp"
#include "fairlead_safety/codec.hpp"
#include "stopwatch.hpp"

namespace fairlead::bench {
namespace {

constexpr std::uint64_t session = 7;

class CountingIds final : public IdSource {
 public:
  std::uint64_t next_id() override { return ++last_; }

 private:
  std::uint64_t last_ = 1000;
};

template <class Message>
std::vector<std::uint8_t> frame_of(const Message& message) {
  std::vector<std::uint8_t> frame(2 * max_frame_bytes);
  frame.resize(encode(message, frame));
  return frame;
}

NumberView view_of(const double* numbers, std::size_t count) {
  return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers), count * sizeof(double)));
}

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
      : limits_(limits), kind_(kind), state_(middle_of(limits)), gate_(limits, ids_) {
    gate_.boot(now_ns_, BootInfo{true, false, {}, true}, *out_);
    step(EventKind::hal_status, frame_of(hal_status()));
    next_state();
    step(EventKind::arm, frame_of(Arm{"bench"}));
    epoch_ = answer<ArmReply>(OutputKind::reply).epoch;
    step(EventKind::claim, frame_of(claim_request()));
    claim_id_ = answer<ClaimReply>(OutputKind::reply).claim_id;
  }

  StepTime next_state() {
    ++tick_;
    now_ns_ += limits_.period_ns;
    step(EventKind::heartbeat, frame_of(Heartbeat{claim_id_}), "runner");
    JointState message;
    message.session = session;
    message.tick = tick_;
    message.positions = view_of(state_.positions.data(), state_.count);
    message.velocities = view_of(state_.velocities.data(), state_.count);
    message.efforts = view_of(state_.efforts.data(), state_.count);
    message.acted = state_.acted;
    message.robot_hash = limits_.robot_hash;
    return step(EventKind::joint_state, frame_of(message));
  }
  StepTime next_chunk() {
    return step(EventKind::candidate, frame_of(chunk(kind_.rows)), "runner");
  }
  Verdict verdict() { return answer<Verdict>(OutputKind::verdict); }

 private:
  StepTime step(EventKind kind, const std::vector<std::uint8_t>& frame, const char* source = "") {
    const std::uint64_t wall = bench::now_ns(), busy = busy_ns();
    gate_.step(now_ns_, Event{kind, source, frame, now_ns_}, *out_);
    const auto busy_time = static_cast<double>(busy_ns() - busy);
    return {static_cast<double>(bench::now_ns() - wall), busy_time};
  }
  template <class Message>
  Message answer(OutputKind kind) {
    Message message;
    for (const Output& output : out_->items())
      if (output.kind == kind && decode(out_->payload(output), message) == FrameFault::none)
        return message;
    throw std::runtime_error("the gate did not answer as it should: " + refusal());
  }
  std::string refusal() {
    Refusal refusal;
    for (const Output& output : out_->items())
      if (output.kind == OutputKind::refusal) (void)decode(out_->payload(output), refusal);
    return std::string(refusal.reason.view());
  }
  HalStatus hal_status() const {
    HalStatus status;
    status.session = session;
    status.robot = limits_.robot;
    status.robot_hash = limits_.robot_hash;
    status.pacing = kind_.lockstep ? "lockstep" : "realtime";
    status.period_ns = limits_.period_ns;
    status.state = "ready";
    for (const JointLimits& joint : limits_.joints) (void)status.joints.push_back(joint.name);
    for (const PassiveLimits& joint : limits_.passive_joints)
      (void)status.passive_joints.push_back(joint.name);
    return status;
  }
  Claim claim_request() const {
    Claim claim;
    claim.source = "runner";
    claim.skill = "bench";
    claim.skill_hash.fill(1);
    claim.robot_hash = limits_.robot_hash;
    claim.period_ns = limits_.period_ns;
    for (const PartLimits& part : limits_.parts) (void)claim.parts.push_back(part.name);
    claim.chunk_rate_hz = limits_.protocol.chunk_rate_max_hz;
    claim.horizon_max = limits_.protocol.horizon_max;
    claim.age_max_ticks = limits_.protocol.age_max_ticks;
    return claim;
  }
  ActionChunk chunk(std::uint32_t rows) {
    ActionChunk chunk;
    chunk.robot_hash = limits_.robot_hash;
    chunk.session = session;
    chunk.epoch = epoch_;
    chunk.claim_id = claim_id_;
    chunk.source = "runner";
    chunk.seq = ++seq_;
    chunk.obs_tick = chunk.oldest_tick = tick_;
    chunk.start_tick = kind_.lockstep ? tick_ : tick_ + 1;
    chunk.horizon = rows;
    numbers_.clear();
    for (std::size_t part = 0; part < limits_.parts.size(); ++part) {
      numbers_.push_back(rows_for(limits_, state_, part, rows, kind_.moving));
      (void)chunk.parts.push_back(action_of(limits_, part, numbers_.back()));
    }
    return chunk;
  }

  const Limits& limits_;
  const StepKind kind_;
  MeasuredState state_;
  CountingIds ids_;
  Gate gate_;
  std::unique_ptr<Outputs> out_ = std::make_unique<Outputs>();
  std::uint64_t now_ns_ = 1'000'000'000'000;
  std::uint64_t tick_ = 0, epoch_ = 0, claim_id_ = 0, seq_ = 0;
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
