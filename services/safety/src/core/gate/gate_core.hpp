// The gate's memory and its rules; `Gate` is the face of it. Spread over files by topic:
// gate.cpp (steps, deadlines), gate_candidates.cpp (chunks), gate_verdicts.cpp (answers to them),
// gate_states.cpp (robot, heartbeats, stops), gate_queries.cpp (queries), gate_transitions.cpp
// (state machine), gate_publish.cpp, gate_motion.cpp (modes in which parts move, rows that are
// about to act), gate_tracking.cpp (what rows did, and what is left of them), gate_ramp.cpp (what
// may no longer move), gate_own.cpp (the gate's own time and memory).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/chunk/evidence.hpp"
#include "core/chunk/judge_rows.hpp"
#include "core/gate/admission.hpp"
#include "core/gate/hal_link.hpp"
#include "core/gate/sent_leases.hpp"
#include "core/gate/stop_book.hpp"
#include "core/modes/row_view.hpp"
#include "core/monitor/grasp_watch.hpp"
#include "core/monitor/memory_guard.hpp"
#include "core/monitor/ramp_watch.hpp"
#include "core/monitor/stuck_watch.hpp"
#include "core/release/claim_table.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/gate.hpp"

namespace fairlead {

class Gate::Core {
 public:
  Core(const Limits& limits, IdSource& ids);

  void boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs);
  void step(std::uint64_t now_ns, const Event& event, Outputs& outputs);
  [[nodiscard]] GateState state() const { return state_; }

 private:
  void handle(const Event& event);
  void check_deadlines();

  // Candidates
  void on_candidate(const Event& event);
  Evidence check_identity(const ActionChunk& chunk, const Name& source, LiveClaim*& claim);
  Evidence check_sequence(const LiveClaim& claim, const ActionChunk& chunk) const;
  Evidence check_ticks(const LiveClaim& claim, const ActionChunk& chunk) const;
  Evidence check_past(const ActionChunk& chunk) const;
  [[nodiscard]] bool is_waited_for(const LiveClaim& claim) const;
  Evidence check_rate(LiveClaim& claim);
  void take_chunk(const ActionChunk& chunk, Bytes frame, const Name& source,
                  std::uint64_t received_ns);
  void judge_chunk(LiveClaim& claim, const ActionChunk& chunk, Bytes frame,
                   std::uint64_t received_ns);
  void judge_again(LiveClaim& claim);
  Judgement judge_from(const LiveClaim& claim, const ActionChunk& chunk, std::size_t first_row);
  [[nodiscard]] RowBefore row_before(const LiveClaim& claim) const;
  FixedVec<Companion, max_claims> companions_of(const LiveClaim& claim) const;
  void answer_again(LiveClaim& claim);
  void note_bad_frame(const Name& source, const Event& event);
  Released make_release(const LiveClaim& claim, const Judgement& judgement,
                        std::uint64_t verdict_id) const;
  void give_verdict(LiveClaim& claim, const ActionChunk& chunk, Bytes frame,
                    const Judgement& judgement, std::uint64_t verdict_id,
                    std::uint64_t received_ns);
  void refuse_stranger(const ActionChunk& chunk, const Name& source, const Evidence& evidence,
                       std::uint64_t received_ns);
  Verdict make_verdict(const ActionChunk& chunk, const Name& source, const Judgement& judgement,
                       std::uint64_t verdict_id, std::uint64_t received_ns);
  [[nodiscard]] std::uint64_t first_open_tick() const;
  [[nodiscard]] Acted act_before(const LiveClaim& claim) const;
  [[nodiscard]] Acted acted_of(const LiveClaim& claim) const;
  [[nodiscard]] bool knows_act_before(const LiveClaim& claim) const;

  // What still moves (gate_motion.cpp)
  void begin_memories();
  void update_memories(const MeasuredState& before);
  [[nodiscard]] Setpoint acted_row(std::size_t part) const;
  [[nodiscard]] Switch switched() const;
  [[nodiscard]] Pose tool_of(std::size_t part, const MeasuredState& state) const;
  void note_goal(std::size_t part, const Setpoint& row, Switch switched,
                 const MeasuredState& before);
  void keep_memories(const LiveClaim& claim);
  void note_released(const LiveClaim& claim);
  void forget_held();
  [[nodiscard]] bool may_have_acted(std::size_t part) const;
  Evidence check_live_rows() const;

  // What rows did, and what those left will do (gate_tracking.cpp)
  Evidence watch_part(std::size_t part, const MeasuredState& before);
  Evidence watch_motion(const MeasuredState& before);
  void begin_tick_of(LiveClaim& claim);
  void judge_live();
  bool is_cut(LiveClaim& claim, bool drops);
  void judge_rest(LiveClaim& claim, bool drops);
  void release_rest(LiveClaim& claim, const Judgement& judgement);
  void revoke_from(LiveClaim& claim, std::uint64_t tick);

  // The robot
  void on_joint_state(const Event& event);
  void on_new_tick(const JointState& message, std::uint64_t received_ns);
  void on_hal_status(Bytes frame);
  void on_heartbeat(const Event& event);
  void on_stop_level(Bytes frame);
  void on_lease(Bytes frame);
  void on_session_news(HalLink::News news);
  [[nodiscard]] Text hal_change() const;
  void on_rival_state(const JointState& message);
  void repeat_verdicts();
  void note_unmoved_joints();
  Evidence check_leap(std::uint64_t tick);
  void refuse_first();
  [[nodiscard]] std::uint64_t receipt_of(const Event& event) const;

  // No longer permitted to move (gate_ramp.cpp)
  void begin_ramps();
  void begin_ramps_of(const LiveClaim& claim);
  void watch_ramps();
  void check_ramps();
  [[nodiscard]] Evidence find_unstopped(std::size_t index) const;
  void latch_unstopped(const Evidence& evidence);

  // The gate itself (gate_own.cpp)
  void check_own(const Event& event);
  void check_step_time(std::uint32_t previous_step_ns);
  void check_memory();
  [[nodiscard]] bool read_memory();
  [[nodiscard]] const MemoryGuard* find_changed() const;
  static Evidence memory_fault(const MemoryGuard& guard);

  // Queries
  void on_arm(Bytes frame);
  void on_disarm(Bytes frame);
  void on_reset(Bytes frame);
  void on_claim(Bytes frame);
  void on_release(Bytes frame);
  void on_status(Bytes frame);
  [[nodiscard]] Objection object_to_arming() const;
  [[nodiscard]] Text two_hals() const;
  [[nodiscard]] Objection object_to_latch_reset() const;
  [[nodiscard]] Objection wrong_state(std::string_view wanted) const;
  template <class Message>
  bool read_query(Bytes frame, Message& message);
  void refuse_query(const Objection& objection);
  template <class Message>
  void reply(const Message& message);

  // Transitions
  void become_disarmed(const Text& cause);
  void disarm(const Text& cause);
  void raise_stop(const Evidence& evidence);
  static Text words_of(const Evidence& evidence);
  void hold_stop(std::uint64_t id, const Text& cause);
  void ignore_copy(std::uint64_t id);
  void latch(const Text& cause);
  void end_claim(LiveClaim& claim, std::string_view reason);
  void end_claims(std::string_view reason);
  void begin_epoch();
  void set_state(GateState state, const Text& cause);

  // Publishing
  void finish();
  void publish_lease();
  void publish_safe_chunk(LiveClaim& claim);
  void publish_status(OutputKind kind);
  void fill_status();
  [[nodiscard]] Text fix() const;
  [[nodiscard]] Grant grant_for(const LiveClaim& claim) const;
  void count(std::uint32_t code);
  std::uint64_t new_id();
  void log(const Text& line) { out_->add_log(line.view()); }

  const Limits limits_;
  MemoryGuard guard_;  // of limits_
  const PathPlan path_plan_;
  MemoryGuard plan_guard_;  // of path_plan_
  IdSource& ids_;
  HalLink hal_;
  ClaimTable claims_;
  StopBook stops_;

  GateState state_ = GateState::boot;
  Text cause_ = "starting";
  std::uint64_t epoch_ = 0;
  SentLeases leases_;  // any other is another gate's
  std::uint64_t latch_id_ = 0;
  std::uint64_t good_states_ = 0;  // in a row since the latch or the last bad one
  std::uint64_t next_verdict_ = 0;
  std::uint64_t claimless_since_ns_ = 0;
  std::uint64_t armed_ns_ = 0;
  std::uint64_t ignored_ns_ = 0;                   // when the last ignored stop was logged
  std::array<bool, max_measured> said_outside_{};  // which joints were outside their limits
  std::uint64_t counted_rival_ = 0;         // G002: the announced session whose state was counted
  Text frame_fault_;                        // G001 of the step in progress
  Text status_fault_;                       // why the newest hal/status could not be read
  PartMemories memories_;                   // G025, G026: what acted last, and may still move
  std::uint64_t seen_tick_ = 0;             // of the state before the newest, 0: none
  std::array<RampWatch, max_parts> ramps_;  // G043: since each part's permission ended
  TickWindow<4> overruns_;    // G050: when steps took too long, by the gate's clock [ns]
  bool said_first_ = false;   // that this session's first state cannot be
  bool jump_memory_ = false;  // G013: the newest state may be compared with the next
  StuckWatch stuck_watch_;
  GraspWatch grasp_watch_;

  std::uint64_t lease_ns_ = 0;  // when the last lease was published
  std::uint64_t status_ns_ = 0;
  bool lease_due_ = true;
  bool status_due_ = true;
  bool clean_mark_due_ = false;     // after the lease that says disarmed
  bool persist_latch_due_ = false;  // after the lease that says latched: the hold goes out first

  std::array<std::uint64_t, 64> code_counts_{};
  std::uint64_t released_ = 0, truncated_ = 0, refused_ = 0, copies_ = 0, resets_refused_ = 0,
                stops_ignored_ = 0;

  // Of the step in progress.
  std::uint64_t now_ns_ = 0;
  Outputs* out_ = nullptr;
  FixedVec<Verdict, 4 * max_claims + 2> verdicts_;  // published last: the HAL waits for the lease

  // Room for what is too big for the stack of a thread that Zenoh made.
  PathRoom path_room_;
  ActionChunk chunk_;
  JointState joint_state_;
  HalStatus hal_status_;
  Claim claim_request_;
  SafeChunk safe_chunk_;
  Lease heard_lease_;
  GateStatus status_;
};

}  // namespace fairlead
