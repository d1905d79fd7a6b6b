// A gate on a bench: the test plays robot, runner and operator, and reads what comes out.
#pragma once

#include <doctest/doctest.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "fairlead_safety/gate.hpp"

namespace fairlead::test {

inline constexpr std::uint64_t ms = 1'000'000;
inline constexpr std::uint64_t hal_session = 0xABCD;

class CountingIds : public IdSource {
 public:
  std::uint64_t next_id() override { return ++last_; }

 private:
  std::uint64_t last_ = 1000;
};

class GateRig {
 public:
  std::uint64_t now_ns = 10'000 * ms;
  std::uint64_t tick = 100;
  bool lockstep;
  std::vector<double> positions = std::vector<double>(measured_count, 0.0);
  std::vector<double> velocities = std::vector<double>(measured_count, 0.0);
  std::vector<double> efforts = std::vector<double>(measured_count, 0.0);
  Acted acted;  // of every part that its chunk addressed; starts as a hold
  std::size_t part_count = 4;
  Limits limits = test_limits();
  std::unique_ptr<Outputs> out = std::make_unique<Outputs>();
  std::unique_ptr<Gate> gate;

  explicit GateRig(bool in_lockstep = false) : lockstep(in_lockstep) {
    positions[gripper_joint] = 0.04;
    restart(BootInfo{true, false, {}});
  }
  void restart(const BootInfo& info) {
    gate = std::make_unique<Gate>(limits, ids_);
    gate->boot(now_ns, info, *out);
  }

  // --- the robot ---
  HalStatus hal_status(std::uint64_t of_session = hal_session) const {
    HalStatus status;
    status.session = of_session;
    status.robot = "test_robot";
    status.robot_hash = hash_of(7);
    status.pacing = lockstep ? "lockstep" : "realtime";
    status.period_ns = limits.period_ns;
    status.state = "ready";
    for (const JointLimits& item : limits.joints) (void)status.joints.push_back(item.name);
    for (const PassiveLimits& item : limits.passive_joints)
      (void)status.passive_joints.push_back(item.name);
    return status;
  }
  void send_hal_status(std::uint64_t of_session = hal_session) {
    send(EventKind::hal_status, hal_status(of_session));
  }
  void send_state() {
    std::vector<Acted> every(part_count, acted);
    const auto sent = addressed_.find(acted.verdict_id);
    for (std::size_t i = 0; sent != addressed_.end() && i < part_count; ++i)
      if ((sent->second >> i & 1U) == 0) every[i] = Acted{static_cast<std::uint8_t>(Hold::no_row)};
    send_state_of(every);
  }
  void send_state_of(const std::vector<Acted>& each) {
    JointState state;
    state.session = session;
    state.tick = tick;
    state.positions = view(positions);
    state.velocities = view(velocities);
    state.efforts = view(efforts);
    for (const Acted& act : each) (void)state.acted.push_back(act);
    state.robot_hash = hash_of(7);
    send(EventKind::joint_state, state);
  }
  /// One period later: a new state that says what acted meanwhile.
  void next_tick(const Acted& did = Acted{}) {
    ++tick;
    now_ns += limits.period_ns;
    acted = did;
    send_state();
  }
  /// Periods pass of which the gate hears nothing.
  void pass(std::uint64_t ticks) {
    tick += ticks;
    now_ns += ticks * limits.period_ns;
  }
  /// One period later, where parts did different things.
  void next_tick_of(const std::vector<Acted>& each) {
    ++tick;
    now_ns += limits.period_ns;
    send_state_of(each);
  }
  std::uint64_t session = hal_session;

  // --- operator and runner ---
  ArmReply arm() {
    send(EventKind::arm, Arm{"test"});
    return reply<ArmReply>();
  }
  void connect_and_arm() {
    send_hal_status();
    send_state();
    epoch = arm().epoch;
  }
  Claim claim_request(std::initializer_list<const char*> parts = {"arm", "gripper", "base",
                                                                  "composite"}) const {
    Claim claim;
    claim.source = "runner";
    claim.skill = "test-skill";
    claim.skill_hash = hash_of(3);
    claim.robot_hash = hash_of(7);
    claim.period_ns = limits.period_ns;
    for (const char* name : parts) (void)claim.parts.push_back(name);
    claim.chunk_rate_hz = 20.0;
    claim.horizon_max = 64;
    claim.age_max_ticks = 5;
    return claim;
  }
  std::uint64_t take_claim() {
    send(EventKind::claim, claim_request());
    claim_id = reply<ClaimReply>().claim_id;
    return claim_id;
  }
  void ready() {
    connect_and_arm();
    take_claim();
  }
  /// A chunk from the newest state, addressed correctly; the test then spoils what it wants.
  ChunkBuilder chunk(const Row& base_speeds = {0.5, 0.5, 0.5, 0.5}) {
    ChunkBuilder builder;
    builder.joint(base, Mode::joint_velocity, base_x, base_speeds);
    builder.chunk.session = session;
    builder.chunk.epoch = epoch;
    builder.chunk.claim_id = claim_id;
    builder.chunk.seq = ++seq;
    builder.chunk.obs_tick = builder.chunk.oldest_tick = builder.chunk.start_tick = tick;
    return builder;
  }
  Verdict send_chunk(const ChunkBuilder& builder, const char* key_source = "runner") {
    send_frame(EventKind::candidate, builder.frame(), key_source);
    return verdict();
  }
  /// A row whose numbers the gate has forgotten: four later chunks have replaced its own.
  Acted forgotten_row(const std::function<ChunkBuilder()>& make) {
    const std::uint64_t verdict_id = send_chunk(make()).verdict_id;
    for (int later = 0; later < 4; ++later) REQUIRE(send_chunk(make()).code == 0);
    return Acted{0, verdict_id, 0};
  }
  Acted forgotten_row() {
    return forgotten_row([this] { return chunk(); });
  }
  void send_heartbeat() { send(EventKind::heartbeat, Heartbeat{claim_id}, "runner"); }
  void reset(std::uint64_t id) { send(EventKind::reset, Reset{"test", id}); }
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  std::uint64_t seq = 0;

  // --- events and outputs ---
  void send(EventKind kind, const auto& message, const char* source = "") {
    send_frame(kind, frame_of(message), source);
  }
  void send_frame(EventKind kind, const std::vector<std::uint8_t>& frame, const char* source = "") {
    gate->step(now_ns, Event{kind, source, frame, now_ns}, *out);
    CHECK_FALSE(out->overflowed());
    note_addressed();
  }
  void timer(std::uint64_t later_ns = 0) {
    now_ns += later_ns;
    gate->step(now_ns, Event{}, *out);
  }
  std::size_t count(OutputKind kind) const {
    std::size_t found = 0;
    for (const Output& output : out->items()) found += output.kind == kind ? 1U : 0U;
    return found;
  }
  template <class Message>
  std::optional<Message> find(OutputKind kind) const {
    std::optional<Message> found;
    for (const Output& output : out->items()) {
      if (output.kind != kind) continue;
      Message message;
      REQUIRE(decode(out->payload(output), message) == FrameFault::none);
      found = message;
    }
    return found;
  }
  /// The payload of the first output of this kind that is a message of this type.
  std::optional<Bytes> find_first(OutputKind kind, std::uint8_t type_id) const {
    for (const Output& output : out->items()) {
      const Bytes payload = out->payload(output);
      if (output.kind == kind && payload.size() > 1 && payload[1] == type_id) return payload;
    }
    return std::nullopt;
  }
  template <class Message>
  Message get(OutputKind kind) const {
    const std::optional<Message> found = find<Message>(kind);
    REQUIRE(found.has_value());
    return *found;
  }
  template <class Message>
  Message reply() const {
    return get<Message>(OutputKind::reply);
  }
  Refusal refusal() const { return get<Refusal>(OutputKind::refusal); }
  Lease lease() const { return get<Lease>(OutputKind::lease); }
  Verdict verdict() const { return get<Verdict>(OutputKind::verdict); }
  SafeChunk safe_chunk() const { return get<SafeChunk>(OutputKind::safe_chunk); }
  GateStatus status() {
    send(EventKind::status, StatusQuery{});
    return reply<GateStatus>();
  }
  std::uint64_t counter(const char* name) {
    for (const Counter& item : status().counters)
      if (item.name == name) return item.count;
    return 0;
  }

 private:
  void note_addressed() {
    for (const Output& output : out->items()) {
      SafeChunk safe;
      if (output.kind != OutputKind::safe_chunk) continue;
      REQUIRE(decode(out->payload(output), safe) == FrameFault::none);
      std::uint32_t parts = 0;
      for (const ActionPart& part : safe.parts) parts |= 1U << part.part;
      addressed_[safe.verdict_id] = parts;
    }
  }
  static NumberView view(const std::vector<double>& numbers) {
    return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                            numbers.size() * sizeof(double)));
  }
  CountingIds ids_;
  std::map<std::uint64_t, std::uint32_t> addressed_;  // parts of each SafeChunk, a bit for each
};

}  // namespace fairlead::test
