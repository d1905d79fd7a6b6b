// Reads a decision log from its beginning to the first byte that cannot be trusted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "decisions/frame.hpp"

namespace fairlead {

/// How a log ends, as far as it could be read.
enum class LogEnd : std::uint8_t {
  complete,  // with a record that says why
  open,      // between two records: the gate still runs, or was killed
  torn,      // inside a record: the gate was killed, or the disk was full
  damaged,   // a record is not what was written
};

class LogReader {
 public:
  /// Throws ConfigRefused if the file cannot be read or does not begin as a decision log.
  explicit LogReader(const std::filesystem::path& path);

  /// The next record, false at the end. Its views are valid until the next call.
  bool next(Record& record);

  LogEnd end() const { return end_; }
  /// In words, with the place.
  std::string end_text() const;
  /// The text of the first record.
  const std::string& header() const { return header_; }

 private:
  bool read(std::uint8_t* to, std::size_t size);
  bool stop(LogEnd end);

  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;  // end of the last whole record
  std::uint32_t crc_ = 0;
  std::vector<std::uint8_t> frame_;
  std::string header_;
  std::string end_reason_;
  LogEnd end_ = LogEnd::open;
};

}  // namespace fairlead
