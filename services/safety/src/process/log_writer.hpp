// The gate's log: one line per event on standard output, from a thread of its own, because a
// reader that stops reading must not stop the gate.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

namespace fairlead {

class LogWriter {
 public:
  /// What a line is about; each has its own allowance of lines a second, so that a flood of
  /// refusals cannot push out what happened to the gate itself. Warnings have no limit.
  enum class Kind { event, refusal, warning };

  /// `name` is the service's, as in `2026-11-23T07:54:00.123Z INFO safety: ready`.
  explicit LogWriter(std::string name);
  /// Writes what is queued, but waits at most 200 ms for a reader that is stuck.
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Queue a line; beyond the allowance it is left out, and the next one of its kind says so.
  void write(Kind kind, std::string_view text);
  void info(std::string_view text) { write(Kind::event, text); }
  void warning(std::string_view text) { write(Kind::warning, text); }

 private:
  struct Queue;
  struct Allowance {
    int lines_per_second;
    std::int64_t second = -1;
    int used = 0;
    int left_out = 0;
  };
  bool may_write(Allowance& allowance) const;

  std::string name_;
  std::shared_ptr<Queue> queue_;  // shared with the thread, which may be stuck and outlive this
  std::array<Allowance, 3> allowances_{{{20}, {5}, {1000}}};  // by Kind
  std::thread writer_;
};

}  // namespace fairlead
