#include "log_writer.hpp"

#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

namespace fairlead {
namespace {

constexpr int kLinesPerSecond = 20;
constexpr std::size_t kMaxQueued = 1000;
constexpr std::array<const char*, 3> kLevelNames = {"INFO", "WARNING", "ERROR"};

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

bool LogWriter::may_write(Level level) {
  const std::int64_t second = current_second();
  if (second != second_) {
    second_ = second;
    lines_this_second_ = 0;
  }
  if (queue_->lines.size() >= kMaxQueued) return false;
  return level != Level::info || ++lines_this_second_ <= kLinesPerSecond;
}

void LogWriter::write(Level level, std::string_view text) {
  {
    const std::lock_guard lock(queue_->mutex);
    if (!may_write(level)) {
      ++left_out_;
      return;
    }
    std::string line = kLevelNames[static_cast<std::size_t>(level)];
    line.append(" ").append(name_).append(": ").append(text);
    if (left_out_ > 0) line += " (" + std::to_string(left_out_) + " lines left out before this)";
    left_out_ = 0;
    queue_->lines.push_back(std::move(line) + "\n");
  }
  queue_->changed.notify_one();
}

}  // namespace fairlead
