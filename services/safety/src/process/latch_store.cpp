#include "process/latch_store.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

namespace fs = std::filesystem;

std::string system_error(const std::string& what) { return what + ": " + std::strerror(errno); }

/// An open file descriptor that closes itself.
class File {
 public:
  File(const fs::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
  ~File() {
    if (fd_ >= 0) ::close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  bool is_open() const { return fd_ >= 0; }
  bool sync() const { return ::fsync(fd_) == 0; }
  bool write_all(Bytes data) const {
    while (!data.empty()) {
      const ssize_t count = ::write(fd_, data.data(), data.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      data = data.subspan(static_cast<std::size_t>(count));
    }
    return true;
  }

 private:
  int fd_;
};

std::string sync_folder(const fs::path& folder) {
  const File handle(folder, O_RDONLY | O_DIRECTORY);
  return handle.is_open() && handle.sync() ? "" : system_error("cannot sync " + folder.string());
}

std::string replace_file(const fs::path& path, Bytes data) {
  const fs::path next = path.string() + ".next";
  const File file(next, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.is_open() || !file.write_all(data) || !file.sync()) {
    return system_error("cannot write " + next.string());
  }
  if (::rename(next.c_str(), path.c_str()) != 0) {
    return system_error("cannot replace " + path.string());
  }
  return sync_folder(path.parent_path());
}

std::string remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT)
    return system_error("cannot remove " + path.string());
  // Also where it was gone: the sync of an earlier attempt may have failed.
  return sync_folder(path.parent_path());
}

// Who may write there could make the gate forget that it has to latch.
void require_own(const fs::path& folder) {
  struct stat found {};
  if (::stat(folder.c_str(), &found) != 0) return;  // what is opened in it says why
  const bool is_own = found.st_uid == ::geteuid() || found.st_uid == 0;
  if (is_own && (found.st_mode & S_IWOTH) == 0) return;
  throw StartFailed("state folder: " + folder.string() + " can be written by others; make it uid " +
                    std::to_string(::geteuid()) + "'s own: chmod o-w, chown");
}

}  // namespace

LatchStore::LatchStore(fs::path folder, FaultHandler on_fault)
    : folder_(std::move(folder)), on_fault_(std::move(on_fault)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  require_own(folder_);
  const fs::path lock = folder_ / "gate.lock";
  first_start_ = !fs::exists(lock, error);
  lock_file_ = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_file_ < 0)
    throw StartFailed(system_error("state folder: cannot write " + lock.string()));
  if (::flock(lock_file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_file_);
    throw StartFailed("state folder: another gate already uses " + folder_.string() +
                      "; see: fairlead ps");
  }
  found_.clean_mark = fs::exists(folder_ / "clean_mark", error);
  std::ifstream latch(folder_ / "latch", std::ios::binary);
  found_.latch.assign(std::istreambuf_iterator<char>(latch), std::istreambuf_iterator<char>());
  wanted_ = written_ = found_;
  writer_ = std::thread([this] { run(); });
}

LatchStore::~LatchStore() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  writer_.join();
  ::close(lock_file_);
}

void LatchStore::set_clean_mark(bool clean) {
  {
    const std::lock_guard lock(mutex_);
    wanted_.clean_mark = clean;
  }
  changed_.notify_one();
}

void LatchStore::set_latch(Bytes record) {
  {
    const std::lock_guard lock(mutex_);
    wanted_.latch.assign(record.begin(), record.end());
  }
  changed_.notify_one();
}

bool LatchStore::is_marked() {
  const std::lock_guard lock(mutex_);
  return wanted_.clean_mark || written_.clean_mark;
}

std::string LatchStore::clear_clean_mark_now() {
  const std::lock_guard disk(disk_);
  bool before = false;
  {
    const std::lock_guard lock(mutex_);
    before = std::exchange(wanted_.clean_mark, false);
  }
  std::string fault = remove_file(folder_ / "clean_mark");
  const std::lock_guard lock(mutex_);
  if (fault.empty()) {
    written_.clean_mark = false;
  } else {
    wanted_.clean_mark = before;  // nobody arms
    is_unsure_ = true;
    changed_.notify_one();
  }
  return fault;
}

// In the order that is safe to be interrupted in: the mark goes first and comes last.
std::string LatchStore::apply(const StoredState& wanted) {
  std::string fault;
  const auto keep = [&fault](std::string next) {
    if (fault.empty()) fault = std::move(next);
  };
  if (!wanted.clean_mark) keep(remove_file(folder_ / "clean_mark"));
  keep(wanted.latch.empty() ? remove_file(folder_ / "latch")
                            : replace_file(folder_ / "latch", wanted.latch));
  if (wanted.clean_mark && fault.empty()) keep(replace_file(folder_ / "clean_mark", Bytes()));
  return fault;
}

void LatchStore::run() {
  std::string reported;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || is_behind(); });
    if (!is_behind()) return;
    lock.unlock();
    std::string fault;
    {
      const std::lock_guard disk(disk_);
      lock.lock();
      const StoredState wanted = wanted_;
      lock.unlock();
      fault = apply(wanted);
      lock.lock();
      is_unsure_ = !fault.empty();
      if (fault.empty()) written_ = wanted;
      lock.unlock();
    }
    if (fault != reported) on_fault_(fault.empty() ? "state folder: can be written again" : fault);
    reported = fault;
    lock.lock();
    if (fault.empty()) continue;
    if (stopping_) return;
    changed_.wait_for(lock, std::chrono::seconds(1), [this] { return stopping_; });
  }
}

}  // namespace fairlead
