#include "decisions/log_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fairlead_safety/crc32.hpp"

namespace fairlead {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".decisions";

std::string system_error(const fs::path& path) {
  return "cannot write " + path.string() + ": " + std::strerror(errno);
}

int number_of(const fs::path& path) { return std::atoi(path.stem().c_str()); }

fs::path path_of(const fs::path& folder, int number) {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%06d", number);
  return folder / (std::string(name.data()) + kExtension);
}

// The oldest first, until the rest is few and small enough.
void remove_oldest(const std::vector<fs::path>& kept, std::size_t files, std::uint64_t max_bytes) {
  std::error_code error;
  std::uint64_t bytes = 0;
  std::size_t count = 0;
  for (auto path = kept.rbegin(); path != kept.rend(); ++path) {
    const std::uintmax_t size = fs::file_size(*path, error);
    bytes += error ? 0 : size;
    if (++count > files || bytes > max_bytes) fs::remove(*path, error);
  }
}

}  // namespace

std::vector<fs::path> decision_logs_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == kExtension && number_of(entry.path()) > 0)
      found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end(),
            [](const fs::path& a, const fs::path& b) { return number_of(a) < number_of(b); });
  return found;
}

LogFile::LogFile(const fs::path& folder, std::size_t files, std::uint64_t max_bytes,
                 std::string& fault) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::vector<fs::path> kept = decision_logs_in(folder);
  int number = kept.empty() ? 1 : number_of(kept.back()) + 1;
  do {
    path_ = path_of(folder, number++);
    fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  } while (fd_ < 0 && errno == EEXIST);
  if (fd_ < 0) {
    fault = system_error(path_);
    return;
  }
  remove_oldest(kept, files - 1, max_bytes);
  const Bytes magic(reinterpret_cast<const std::uint8_t*>(decisions_magic.data()),
                    decisions_magic.size());
  fault = write_from_end(magic);
  if (fault.empty()) crc_ = crc32(magic);
}

LogFile::~LogFile() {
  if (fd_ >= 0) ::close(fd_);
}

std::string LogFile::append(RecordType type, Bytes body) {
  const FrameHead head = frame_head(type, body.size());
  frame_.assign(head.begin(), head.end());
  frame_.insert(frame_.end(), body.begin(), body.end());
  const std::uint32_t crc = crc32(frame_, crc_);
  std::array<std::uint8_t, sizeof crc> tail{};
  std::memcpy(tail.data(), &crc, sizeof crc);
  frame_.insert(frame_.end(), tail.begin(), tail.end());
  std::string fault = write_from_end(frame_);
  // Carried on without the tail: data followed by its own CRC always comes to the same number.
  if (fault.empty()) crc_ = crc;
  return fault;
}

std::string LogFile::write_from_end(Bytes data) {
  std::uint64_t end = size_;
  while (!data.empty()) {
    const ssize_t count = ::pwrite(fd_, data.data(), data.size(), static_cast<off_t>(end));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const std::string fault = system_error(path_);
      // What cannot be cut off is written over by the next frame, or read as a torn end.
      if (::ftruncate(fd_, static_cast<off_t>(size_)) != 0) return fault;
      return fault;
    }
    data = data.subspan(static_cast<std::size_t>(count));
    end += static_cast<std::uint64_t>(count);
  }
  size_ = end;
  return "";
}

}  // namespace fairlead
