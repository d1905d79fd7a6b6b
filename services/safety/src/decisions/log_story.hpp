// A decision log as people ask about it: each decision with what it was about.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "decisions/record.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {

/// One answer to a chunk, or one stop or latch.
struct Moment {
  std::uint64_t step = 0;  // number of the record, counted from 1
  std::uint64_t tick = 0;  // newest state when it was made
  bool is_verdict = true;
  bool of_candidate = false;  // made when the chunk came, not with a later state
  bool again = false;         // the chunk has had a verdict before
  Verdict verdict;
  bool has_chunk = false;  // the three that follow are known
  std::uint64_t start_tick = 0;
  std::uint64_t horizon = 0;
  nlohmann::json chunk;   // who asked for what
  nlohmann::json status;  // of a stop or latch: the gate's

  [[nodiscard]] bool is_about(std::uint64_t asked) const {
    return tick == asked || (has_chunk && start_tick <= asked && asked < start_tick + horizon);
  }
};

/// Reads records in order; `take` returns what was decided in the newest.
class LogStory {
 public:
  explicit LogStory(const Limits& limits) : limits_(limits) {}

  std::vector<Moment> take(const Record& record);

  [[nodiscard]] std::uint64_t tick() const { return tick_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// Positions of the newest state.
  [[nodiscard]] const std::vector<double>& measured() const { return measured_; }
  /// The newest status as JSON; null before the first.
  [[nodiscard]] const nlohmann::json& status() const { return status_; }

 private:
  struct Remembered {
    std::string source;
    std::uint64_t seq = 0, start_tick = 0, horizon = 0;
    bool has_verdict = false;
    nlohmann::json chunk;
  };
  void take_event(const Event& event);
  void take_claim(const Record& record);
  void remember_chunk(const Event& event);
  Moment moment_of(const Record& record, const Verdict& verdict);
  bool take_status(Bytes payload);

  const Limits& limits_;
  std::uint64_t steps_ = 0;
  std::uint64_t tick_ = 0;
  std::uint64_t newest_verdict_ = 0;
  std::vector<double> measured_;
  std::map<std::uint64_t, std::string> skills_;  // by claim id
  std::deque<Remembered> chunks_;                // newest last
  nlohmann::json status_;
  std::uint8_t state_ = 0;
  GateStatus room_;
  ActionChunk chunk_;
};

}  // namespace fairlead
