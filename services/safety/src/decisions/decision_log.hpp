// The decision log: everything the gate's core was given and what it decided, in a file that
// `fairlead-decisions judge` replays.
//
// The gate hands over bytes and goes on: they go into a ring of fixed size, from where a thread
// of its own writes them. Whatever the disk does, no decision waits for it. Records for which
// there was no room are counted, and the log says where and how many.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "decisions/record.hpp"
#include "process/log_writer.hpp"

namespace fairlead {

/// Ids as another source gives them, remembered until the step that drew them is recorded.
class DrawnIds final : public IdSource {
 public:
  explicit DrawnIds(IdSource& ids) : ids_(ids) {}
  std::uint64_t next_id() override;
  [[nodiscard]] std::span<const std::uint64_t> drawn() const {
    return {drawn_.begin(), drawn_.size()};
  }
  /// True if there were too many to remember: the step cannot be replayed.
  [[nodiscard]] bool overflowed() const { return overflowed_; }
  void forget();

 private:
  IdSource& ids_;
  IdList drawn_;
  bool overflowed_ = false;
};

struct DecisionLogPlace {
  std::filesystem::path folder;  // empty: no log is kept
  std::size_t files = 0;         // how many the folder keeps
  std::uint64_t max_bytes = 0;   // that all of them may have
};

class DecisionLog {
 public:
  /// `header`: what the first record says. A folder that cannot be written is a warning in
  /// `log`, no reason not to start. `log` must outlive this.
  DecisionLog(const DecisionLogPlace& place, std::string header, LogWriter& log);
  /// Writes what is queued, but waits at most 500 ms for a disk that is stuck.
  ~DecisionLog();
  DecisionLog(const DecisionLog&) = delete;
  DecisionLog& operator=(const DecisionLog&) = delete;

  // One call after each call of the core, from one thread at a time.
  void boot(std::uint64_t now_ns, const BootInfo& info, DrawnIds& ids, const Outputs& outputs);
  void step(std::uint64_t now_ns, const Event& event, DrawnIds& ids, const Outputs& outputs);

 private:
  class Disk;
  void record(const Record& record, DrawnIds& ids);

  std::shared_ptr<Disk> disk_;  // shared with the thread, which may be stuck and outlive this
  std::uint64_t lost_ = 0;      // since the last record there was room for
  std::thread writer_;
};

}  // namespace fairlead
