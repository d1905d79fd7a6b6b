// The gate's log: one line per event on standard output, from a thread of its own, because a
// reader that stops reading must not stop the gate.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

namespace fairlead {

class LogWriter {
 public:
  enum class Level { info, warning, error };

  /// `name` is the service's, as in `INFO safety: ready`.
  explicit LogWriter(std::string name);
  /// Writes what is queued, but waits at most 200 ms for a reader that is stuck.
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Queue a line. At most 20 lines a second; the next line says how many were left out.
  /// Warnings and errors are always queued while there is room.
  void write(Level level, std::string_view text);
  void info(std::string_view text) { write(Level::info, text); }
  void warning(std::string_view text) { write(Level::warning, text); }

 private:
  struct Queue;
  bool may_write(Level level);

  std::string name_;
  std::shared_ptr<Queue> queue_;  // shared with the thread, which may be stuck and outlive this
  std::int64_t second_ = -1;
  int lines_this_second_ = 0;
  int left_out_ = 0;
  std::thread writer_;
};

}  // namespace fairlead
