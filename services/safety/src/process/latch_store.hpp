// What the gate remembers across a restart: a clean mark and its latch.
//
// In the state folder: `clean_mark` exists while leaving would be clean (disarmed), `latch`
// holds the core's record while latched, `gate.lock` keeps a second gate out. Files are
// replaced whole (write, fsync, rename, fsync of the folder). A folder that was used before
// and has no clean mark means an unclean exit; removing a mark works on a full disk too.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

/// What is, or should be, on disk.
struct StoredState {
  bool clean_mark = false;
  std::vector<std::uint8_t> latch;  // empty: not latched

  friend bool operator==(const StoredState&, const StoredState&) = default;
};

/// The state folder and the thread that writes it, so that nothing on the command path waits
/// for a disk. A write that fails is reported once and tried again every second.
class LatchStore {
 public:
  using FaultHandler = std::function<void(const std::string&)>;

  /// Locks and reads the folder. Throws StartFailed if it cannot be used or another gate has it.
  LatchStore(std::filesystem::path folder, FaultHandler on_fault);
  /// Writes what is still pending, then unlocks.
  ~LatchStore();
  LatchStore(const LatchStore&) = delete;
  LatchStore& operator=(const LatchStore&) = delete;

  /// True if no gate has used this folder before.
  bool first_start() const { return first_start_; }
  /// As found when the folder was opened.
  const StoredState& found() const { return found_; }

  void set_clean_mark(bool clean);
  void set_latch(Bytes record);  // empty: forget it
  /// Remove the clean mark before returning; "" or why that is not possible.
  std::string clear_clean_mark_now();
  /// Whether the clean mark is there, or about to be.
  bool is_marked();

 private:
  std::string apply(const StoredState& wanted);
  [[nodiscard]] bool is_behind() const { return is_unsure_ || wanted_ != written_; }
  void run();

  std::filesystem::path folder_;
  FaultHandler on_fault_;
  int lock_file_ = -1;
  bool first_start_ = false;
  StoredState found_;

  std::mutex disk_;   // one writer at a time; taken before mutex_, never after it
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  StoredState wanted_;
  StoredState written_;
  bool is_unsure_ = false;  // a write failed half-way: the disk may have neither
  bool stopping_ = false;
  std::thread writer_;
};

}  // namespace fairlead
