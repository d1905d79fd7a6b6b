// What of the candidates gets a turn at the gate: a flood of them must not keep the gate from the
// chunks it waits for, nor fill its decision log.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/gate.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// So much a second, and at once what was left unused, up to `burst`.
class Budget {
 public:
  constexpr Budget(double per_second, double burst)
      : per_second_(per_second), burst_(burst), left_(burst) {}

  /// `now_ns` never decreases.
  void refill(std::uint64_t now_ns);
  [[nodiscard]] bool has(double amount) const { return left_ >= amount; }
  void take(double amount) { left_ -= amount; }

 private:
  double per_second_;
  double burst_;
  double left_;
  std::uint64_t filled_ns_ = 0;
};

/// A frame is a claim's by the key it came on and the session, epoch and claim id that it begins
/// with: others may know these, but have other keys. The claims of a source have a budget of their
/// own, and a smaller one for copies of its newest frame; all else shares one.
/// Any thread may call.
class Intake {
 public:
  /// A claim was granted to a source. Its earlier claims that are among the grants of the newest
  /// lease, `live`, keep their turns.
  void expect(const std::string& source, std::uint64_t session, std::uint64_t epoch,
              std::uint64_t claim_id, const FixedVec<Grant, max_claims>& live);
  /// It holds no claim any more.
  void forget(const std::string& source);
  /// Whether a candidate, whose source is that of its key, gets a turn.
  bool admits(const Event& candidate) {
    return admits(candidate.source, candidate.payload, candidate.received_ns);
  }
  bool admits(std::string_view source, Bytes frame, std::uint64_t now_ns);

  struct LeftOut {
    std::uint64_t strangers = 0;
    std::uint64_t copies = 0;
    std::uint64_t excess = 0;  // of a source with claims
    [[nodiscard]] std::uint64_t sum() const { return strangers + copies + excess; }
  };
  /// Since it was asked last.
  LeftOut take_left_out();

 private:
  struct Claimed {
    std::uint64_t session = 0, epoch = 0;
    std::vector<std::uint64_t> claim_ids;  // the newest last
    std::string newest;                    // frame admitted
    Budget frames{1000.0, 200.0};
    Budget copies{50.0, 20.0};
  };
  Claimed* claim_of(std::string_view source, Bytes frame);

  std::mutex mutex_;
  std::uint64_t now_ns_ = 0;
  std::map<std::string, Claimed, std::less<>> claims_;  // by source
  Budget stranger_frames_{100.0, 100.0};
  Budget stranger_bytes_{16e3, 1e6};
  LeftOut left_out_;
};

}  // namespace fairlead
