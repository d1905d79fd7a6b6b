// A reason not to start: a configuration, argument or endpoint that the gate refuses.
#pragma once

#include <stdexcept>
#include <string>

namespace fairlead {

/// Exit status 2: the configuration or an argument does not fit.
class ConfigRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Exit status 1: the network or the state folder cannot be used.
class StartFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace fairlead
