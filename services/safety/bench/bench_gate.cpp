#include "bench_gate.hpp"

#include "stopwatch.hpp"

namespace fairlead::bench {
namespace {

constexpr std::uint64_t session = 7;

template <class Message>
std::vector<std::uint8_t> frame_of(const Message& message) {
  std::vector<std::uint8_t> frame(2 * max_frame_bytes);
  frame.resize(encode(message, frame));
  return frame;
}

NumberView view_of(const double* numbers, std::size_t count) {
  return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers), count * sizeof(double)));
}

}  // namespace

BenchGate::BenchGate(const Limits& limits, bool lockstep)
    : limits_(limits), lockstep_(lockstep), gate_(limits, ids_) {
  gate_.boot(now_ns_, BootInfo{true, false, {}, true}, *out_);
  step(EventKind::hal_status, frame_of(hal_status()));
}

StepTime BenchGate::next_state(const MeasuredState& state) {
  ++tick_;
  now_ns_ += limits_.period_ns;
  for (const Runner& runner : runners_)
    step(EventKind::heartbeat, frame_of(Heartbeat{runner.claim_id}), runner.source);
  JointState message;
  message.session = session;
  message.tick = tick_;
  message.positions = view_of(state.positions.data(), state.count);
  message.velocities = view_of(state.velocities.data(), state.count);
  message.efforts = view_of(state.efforts.data(), state.count);
  message.acted = state.acted;
  message.robot_hash = limits_.robot_hash;
  return step(EventKind::joint_state, frame_of(message));
}

void BenchGate::arm() {
  step(EventKind::arm, frame_of(Arm{"bench"}));
  epoch_ = answer<ArmReply>(OutputKind::reply).epoch;
}

std::uint64_t BenchGate::claim(const char* source, const std::vector<std::size_t>& parts) {
  Claim claim;
  claim.source = source;
  claim.skill = "bench";
  claim.skill_hash.fill(1);
  claim.robot_hash = limits_.robot_hash;
  claim.period_ns = limits_.period_ns;
  for (const std::size_t part : parts) (void)claim.parts.push_back(limits_.parts[part].name);
  claim.chunk_rate_hz = limits_.protocol.chunk_rate_max_hz;
  claim.horizon_max = limits_.protocol.horizon_max;
  claim.age_max_ticks = limits_.protocol.age_max_ticks;
  step(EventKind::claim, frame_of(claim));
  runners_.push_back({source, answer<ClaimReply>(OutputKind::reply).claim_id});
  return runners_.back().claim_id;
}

StepTime BenchGate::send_chunk(const char* source, std::uint64_t claim_id, std::uint32_t rows,
                               const FixedVec<ActionPart, max_parts>& parts) {
  ActionChunk chunk;
  chunk.robot_hash = limits_.robot_hash;
  chunk.session = session;
  chunk.epoch = epoch_;
  chunk.claim_id = claim_id;
  chunk.source = source;
  chunk.seq = ++seq_;
  chunk.obs_tick = chunk.oldest_tick = tick_;
  chunk.start_tick = lockstep_ ? tick_ : tick_ + 1;
  chunk.horizon = rows;
  chunk.parts = parts;
  return step(EventKind::candidate, frame_of(chunk), source);
}

StepTime BenchGate::step(EventKind kind, const std::vector<std::uint8_t>& frame,
                         const char* source) {
  return time_of([&] { gate_.step(now_ns_, Event{kind, source, frame, now_ns_}, *out_); });
}

std::string BenchGate::refusal() const {
  Refusal refusal;
  for (const Output& output : out_->items())
    if (output.kind == OutputKind::refusal) (void)decode(out_->payload(output), refusal);
  return std::string(refusal.reason.view());
}

HalStatus BenchGate::hal_status() const {
  HalStatus status;
  status.session = session;
  status.robot = limits_.robot;
  status.robot_hash = limits_.robot_hash;
  status.pacing = lockstep_ ? "lockstep" : "realtime";
  status.period_ns = limits_.period_ns;
  status.state = "ready";
  for (const JointLimits& joint : limits_.joints) (void)status.joints.push_back(joint.name);
  for (const PassiveLimits& joint : limits_.passive_joints)
    (void)status.passive_joints.push_back(joint.name);
  return status;
}

}  // namespace fairlead::bench
