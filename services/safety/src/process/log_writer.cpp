#include "process/log_writer.hpp"

#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

#include "core/wire/phrase.hpp"
#include "process/utc_time.hpp"

namespace fairlead {
namespace {

constexpr std::size_t kMaxQueued = 1000;
constexpr std::array<const char*, 3> kLevels = {"INFO", "INFO", "WARNING"};

std::int64_t current_second() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void write_out(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
    if (count <= 0) return;  // nobody reads any more: the log is lost, the gate is not
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

}  // namespace

struct LogWriter::Queue {
  std::mutex mutex;
  std::condition_variable changed;
  std::condition_variable drained;
  std::deque<std::string> lines;
  bool stopping = false;
  bool abandoned = false;

  void write_lines() {
    std::unique_lock lock(mutex);
    while (!abandoned) {
      changed.wait(lock, [this] { return stopping || !lines.empty(); });
      if (lines.empty()) break;
      const std::string line = std::move(lines.front());
      lock.unlock();
      write_out(line);
      lock.lock();
      lines.pop_front();
    }
    drained.notify_all();
  }
};

LogWriter::LogWriter(std::string name)
    : name_(std::move(name)),
      queue_(std::make_shared<Queue>()),
      writer_([queue = queue_] { queue->write_lines(); }) {}

LogWriter::~LogWriter() {
  std::unique_lock lock(queue_->mutex);
  queue_->stopping = true;
  queue_->changed.notify_one();
  const bool drained = queue_->drained.wait_for(lock, std::chrono::milliseconds(200),
                                                [this] { return queue_->lines.empty(); });
  queue_->abandoned = !drained;
  lock.unlock();
  if (drained) {
    writer_.join();
  } else {
    writer_.detach();  // stuck in a write; the process is about to end
  }
}

bool LogWriter::may_write(Allowance& allowance) const {
  const std::int64_t second = current_second();
  if (second != allowance.second) {
    allowance.second = second;
    allowance.used = 0;
  }
  if (queue_->lines.size() >= kMaxQueued) return false;
  return ++allowance.used <= allowance.lines_per_second;
}

void LogWriter::write(Kind kind, std::string_view text) {
  const auto index = static_cast<std::size_t>(kind);
  {
    const std::lock_guard lock(queue_->mutex);
    Allowance& allowance = allowances_[index];
    if (!may_write(allowance)) {
      ++allowance.left_out;
      return;
    }
    std::string line = utc_now();
    line.append(" ").append(kLevels[index]).append(" ").append(name_).append(": ");
    append_printable(line, text);
    if (allowance.left_out > 0) {
      line += " (" + std::to_string(allowance.left_out) + " like it left out before)";
    }
    allowance.left_out = 0;
    queue_->lines.push_back(std::move(line) + "\n");
  }
  queue_->changed.notify_one();
}

}  // namespace fairlead
