// Sessions of real gates, from test/corpus: what each was given, and what it answered.
//
// `python -m bench.recorded_sessions` records them anew.
#pragma once

#include <doctest/doctest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "decisions/header.hpp"
#include "decisions/log_reader.hpp"

namespace fairlead::test {

/// A record that owns what its views point to.
class RecordedStep {
 public:
  explicit RecordedStep(const Record& read) : body_(room_for(read)) {
    body_.resize(encode_record(read, body_));
    REQUIRE(decode_record(read.type, body_, record_));
  }
  RecordedStep(RecordedStep&&) = default;
  [[nodiscard]] const Record& record() const { return record_; }

 private:
  std::vector<std::uint8_t> body_;
  Record record_;
};

/// From a gate's boot to where its log was cut.
using RecordedSession = std::vector<RecordedStep>;

struct RecordedRobot {
  std::string name;
  std::unique_ptr<Limits> limits;
  std::vector<RecordedSession> sessions;
};

inline RecordedRobot recorded_robot(const std::filesystem::path& path) {
  LogReader log(path);
  RecordedRobot robot{path.stem().string(), recorded_limits(read_header(log.header())), {}};
  for (Record record; log.next(record);) {
    if (record.type == RecordType::boot) robot.sessions.emplace_back();
    if (record.type != RecordType::end) robot.sessions.back().emplace_back(record);
  }
  REQUIRE(log.end() == LogEnd::complete);
  REQUIRE(!robot.sessions.empty());
  return robot;
}

/// One for each log of real runs; judged_*.decisions are test_judged_sessions.cpp's.
inline std::vector<RecordedRobot> recorded_robots() {
  std::vector<RecordedRobot> robots;
  for (const char* name : {"panda", "dual_panda", "panda_mobile"})
    robots.push_back(
        recorded_robot(std::string(FAIRLEAD_SESSIONS_DIR) + "/" + name + ".decisions"));
  return robots;
}

}  // namespace fairlead::test
