// What systemd is told that started this process with `Type=notify`: sd_notify(3)'s datagrams.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace fairlead {

class ServiceManager {
 public:
  /// From the environment; without NOTIFY_SOCKET nobody is told anything.
  ServiceManager();

  /// It has started.
  void say_ready() const { tell("READY=1"); }
  /// Still at work: call it often, from the thread that must not hang. Told four times in the
  /// time after which systemd ends the process (WatchdogSec). Waits for nothing.
  void say_alive(std::uint64_t now_ns);

 private:
  void tell(std::string_view state) const;

  std::string socket_;
  std::uint64_t period_ns_ = 0;  // 0: no watchdog
  std::uint64_t said_ns_ = 0;
};

}  // namespace fairlead
