// A file of the decision log, and the folder that keeps the newest ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "decisions/frame.hpp"

namespace fairlead {

/// They are numbered: 000001.decisions, 000002.decisions, ...; the newest has the highest number.
std::vector<std::filesystem::path> decision_logs_in(const std::filesystem::path& folder);

class LogFile {
 public:
  /// Starts the next file in `folder`. The oldest go: beyond `files` in all, and while those before
  /// it have more than `max_bytes` together. `fault` is why that was not possible, else "".
  LogFile(const std::filesystem::path& folder, std::size_t files, std::uint64_t max_bytes,
          std::string& fault);
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Append one frame; "" or why that is not possible. After a failure the file ends with the
  /// last whole frame, and the next call tries again.
  std::string append(RecordType type, Bytes body);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

 private:
  std::string write_from_end(Bytes data);

  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;  // of the whole frames
  std::uint32_t crc_ = 0;   // of the whole frames
  std::vector<std::uint8_t> frame_;
};

}  // namespace fairlead
