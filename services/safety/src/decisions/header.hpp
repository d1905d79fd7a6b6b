// The first record of a decision log: which gate, which robot, which limits.
#pragma once

#include <memory>
#include <string>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

struct LogHeader {
  std::string robot;
  std::string profile;
  std::string gate;         // SHA-256 of the program that judged, in hex
  std::string started;      // UTC, for people; nothing is decided by it
  std::string config_file;  // where it was
  std::string config;       // its whole text
};

/// The header of this process, as JSON. Throws StartFailed if the file is no longer what
/// `limits` were read from.
std::string make_header(const Limits& limits, const std::string& config_file);

/// Throws ConfigRefused if it is not a header.
LogHeader read_header(const std::string& json);

/// The limits that decided. Throws ConfigRefused if this gate does not take such a file, as one of
/// another version may not.
std::unique_ptr<Limits> recorded_limits(const LogHeader& header);

/// SHA-256 of the running program, in hex; "" if it cannot be read.
std::string hash_of_this_gate();

}  // namespace fairlead
