// The gate's core in a process: one event at a time, its outputs carried out in order.
//
// Zenoh's threads and the timer thread all come through here; one mutex serialises them and
// is held until the outputs of a step are sent, so that nothing overtakes. Nothing in there
// waits: publishing drops on congestion; disk, log and decision log have their own threads.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "decisions/decision_log.hpp"
#include "fairlead_safety/gate.hpp"
#include "fairlead_safety/query_messages.hpp"
#include "process/intake.hpp"
#include "process/latch_store.hpp"
#include "process/log_writer.hpp"
#include "process/outlet.hpp"
#include "process/service_manager.hpp"

namespace fairlead {

/// CLOCK_MONOTONIC in nanoseconds.
std::uint64_t monotonic_ns();

class GateProcess {
 public:
  /// All arguments must outlive the process. `config_file` is hashed again at each arm.
  GateProcess(const Limits& limits, std::string config_file, LatchStore& store, LogWriter& log,
              DecisionLog& decisions, Outlet& outlet, ServiceManager& manager);
  ~GateProcess();

  /// Leave boot and start the timer. `new_state`: the operator says that a state folder which
  /// was never used before is right.
  void start(bool new_state);
  /// Handle one event from any thread. `answer` is null unless the event is a query.
  void handle(const Event& event, Answer* answer);
  /// Stop the timer and disarm; the last lease says so. No events may follow.
  void shut_down();

 private:
  bool prepare_to_arm(Answer* answer);
  void handle_claim(const Event& event, Answer* answer);
  void make_room();
  [[nodiscard]] bool is_granted(std::string_view source) const;
  void note_granted(const Claim& claim);
  void say_left_out();
  void refuse(Answer* answer, const char* reason, const char* fix);
  void step(const Event& event, Answer* answer);
  void carry_out(Answer* answer);
  void log_refusal(Bytes verdict);
  [[nodiscard]] bool was_refused() const;
  void run_timer();

  const Limits& limits_;
  std::string config_file_;
  LatchStore& store_;
  LogWriter& log_;
  DecisionLog& decisions_;
  Outlet& outlet_;
  ServiceManager& manager_;  // told by the timer's thread
  std::unique_ptr<IdSource> random_ids_;
  DrawnIds ids_;  // remembered for the decision log

  Intake intake_;
  std::mutex claims_mutex_;         // one claim at a time; taken before mutex_
  std::deque<std::string> served_;  // sources that were granted a claim, oldest first
  std::mutex mutex_;                // guards gate_, outputs_, newest_lease_, stopping_
  Gate gate_;
  std::unique_ptr<Outputs> outputs_ = std::make_unique<Outputs>();
  std::vector<std::uint8_t> newest_lease_;
  std::uint64_t said_left_out_ns_ = 0;
  std::uint64_t logged_verdict_ = 0;    // the newest whose refusal was logged
  std::uint32_t previous_step_ns_ = 0;  // G050: until its outputs were sent
  bool stopping_ = false;
  std::condition_variable stop_timer_;
  std::thread timer_;
};

}  // namespace fairlead
