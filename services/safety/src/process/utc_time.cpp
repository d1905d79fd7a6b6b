#include "process/utc_time.hpp"

#include <array>
#include <cstdio>
#include <ctime>

namespace fairlead {

std::string utc_now() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  std::tm parts{};
  ::gmtime_r(&now.tv_sec, &parts);
  std::array<char, 32> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(&text[length], text.size() - length, ".%03ldZ", now.tv_nsec / 1'000'000);
  return text.data();
}

}  // namespace fairlead
