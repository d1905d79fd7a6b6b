#include "decisions/log_reader.hpp"

#include <algorithm>
#include <cstring>

#include "fairlead_safety/crc32.hpp"
#include "process/refusal.hpp"

namespace fairlead {
namespace {

// Why a file with such a first line is not read. The last character but the newline is the layout.
std::string foreign_log(std::string_view first_line) {
  constexpr std::size_t number = decisions_magic.size() - 2;
  const std::string ours(decisions_magic.substr(0, number + 1));
  if (first_line.substr(0, number) == decisions_magic.substr(0, number))
    return "it has layout " + std::string(first_line.substr(number, 1)) + ", this gate reads " +
           "layout " + ours.substr(number) + " only: judge it with the gate that wrote it";
  return "expected its first line to be " + ours;
}

}  // namespace

LogReader::LogReader(const std::filesystem::path& path)
    : path_(path), stream_(path, std::ios::binary) {
  std::error_code error;
  size_ = std::filesystem::file_size(path, error);
  std::array<std::uint8_t, decisions_magic.size()> magic{};
  if (error || !stream_ || !std::filesystem::is_regular_file(path)) {
    throw ConfigRefused("decision log " + path.string() + ": cannot be read");
  }
  const bool whole = read(magic.data(), magic.size());
  if (!whole || !std::equal(magic.begin(), magic.end(), decisions_magic.begin()))
    throw ConfigRefused("decision log " + path.string() + ": " +
                        foreign_log({reinterpret_cast<const char*>(magic.data()), magic.size()}));
  crc_ = crc32(magic);
  at_ = magic.size();
  Record first;
  if (!next(first) || first.type != RecordType::header) {
    throw ConfigRefused("decision log " + path.string() + ": its first record, the header, is " +
                        (end_ == LogEnd::damaged ? "damaged" : "missing"));
  }
  header_ = std::string(first.text);
}

bool LogReader::read(std::uint8_t* to, std::size_t size) {
  stream_.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(size));
  return static_cast<std::size_t>(stream_.gcount()) == size;
}

bool LogReader::stop(LogEnd end) {
  end_ = end;
  return false;
}

bool LogReader::next(Record& record) {
  if (end_ != LogEnd::open) return false;
  FrameHead head{};
  if (at_ >= size_) return stop(LogEnd::open);
  if (!read(head.data(), head.size())) return stop(LogEnd::torn);
  RecordType type{};
  std::size_t length = 0;
  if (!read_head(head, type, length)) return stop(LogEnd::damaged);
  frame_.assign(head.begin(), head.end());
  frame_.resize(head.size() + length);
  std::array<std::uint8_t, 4> tail{};
  if (!read(frame_.data() + head.size(), length) || !read(tail.data(), tail.size()))
    return stop(LogEnd::torn);
  std::uint32_t written = 0;
  std::memcpy(&written, tail.data(), sizeof written);
  const std::uint32_t crc = crc32(frame_, crc_);
  if (crc != written || !decode_record(type, Bytes(frame_).subspan(head.size()), record))
    return stop(LogEnd::damaged);
  crc_ = crc;
  at_ += frame_.size() + tail.size();
  if (type == RecordType::end) {
    end_reason_ = std::string(record.text);
    end_ = LogEnd::complete;
  }
  return true;
}

std::string LogReader::end_text() const {
  const std::string place = "byte " + std::to_string(at_) + " of " + std::to_string(size_);
  switch (end_) {
    case LogEnd::complete:
      if (at_ < size_) return "complete at " + place + ", bytes after it are not of this log";
      return "complete: " + end_reason_;
    case LogEnd::open:
      return "has no end: the gate still runs, or did not end by itself";
    case LogEnd::torn:
      return "cut off in a record after " + place + ": the gate was killed or the disk was full";
    case LogEnd::damaged:
      return "damaged in the record after " + place + ": it is not what was written";
  }
  return "";
}

}  // namespace fairlead
