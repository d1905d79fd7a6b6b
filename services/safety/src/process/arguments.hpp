// The command line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "zenoh/zenoh_config.hpp"

namespace fairlead {

struct Arguments {
  std::string robot;       // the robot's id in keys
  std::string name_space;  // first chunk of every key
  std::string service;     // this process's name in keys and logs
  std::string config;      // compiled gate file
  Endpoints endpoints;     // a peer's, or the router of a client
  std::string state_dir;
  std::string decision_log;  // folder of the decision logs; empty: none is kept
  std::uint64_t decision_log_files = 20;
  std::uint64_t decision_log_mib = 1024;  // of all of them
  bool new_state = false;                 // a state folder never used before is right
  bool help = false;
};

/// Throws ConfigRefused naming the argument and the valid ones.
Arguments parse_arguments(const std::vector<std::string>& words);

/// What --help prints.
std::string usage();

}  // namespace fairlead
