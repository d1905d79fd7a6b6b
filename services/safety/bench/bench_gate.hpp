// A gate of its own for a bench, that plays robot, operator and runners to it.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/chunk/judgement.hpp"
#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/gate.hpp"
#include "stopwatch.hpp"

namespace fairlead::bench {

class BenchGate {
 public:
  /// Booted, follows a HAL that has said nothing yet but who it is. `limits` must outlive it.
  BenchGate(const Limits& limits, bool lockstep);

  /// One period later: the robot is so. Claims' heartbeats come before it.
  StepTime next_state(const MeasuredState& state);
  void arm();
  /// Of those parts, for a runner of that name; its claim id, 0 if it was refused.
  std::uint64_t claim(const char* source, const std::vector<std::size_t>& parts);
  /// Addressed to the newest state and the next tick; `parts` is the caller's.
  StepTime send_chunk(const char* source, std::uint64_t claim_id, std::uint32_t rows,
                      const FixedVec<ActionPart, max_parts>& parts);
  /// Of the newest chunk.
  Verdict verdict() { return answer<Verdict>(OutputKind::verdict); }

 private:
  struct Runner {
    const char* source;
    std::uint64_t claim_id;
  };
  class CountingIds final : public IdSource {
   public:
    std::uint64_t next_id() override { return ++last_; }

   private:
    std::uint64_t last_ = 1000;
  };

  StepTime step(EventKind kind, const std::vector<std::uint8_t>& frame, const char* source = "");
  [[nodiscard]] HalStatus hal_status() const;
  [[nodiscard]] std::string refusal() const;
  template <class Message>
  Message answer(OutputKind kind) {
    Message message;
    for (const Output& output : out_->items())
      if (output.kind == kind && decode(out_->payload(output), message) == FrameFault::none)
        return message;
    throw std::runtime_error("the gate did not answer as it should: " + refusal());
  }

  const Limits& limits_;
  const bool lockstep_;
  CountingIds ids_;
  Gate gate_;
  std::unique_ptr<Outputs> out_ = std::make_unique<Outputs>();
  std::vector<Runner> runners_;
  std::uint64_t now_ns_ = 1'000'000'000'000;
  std::uint64_t tick_ = 0, epoch_ = 0, seq_ = 0;
};

}  // namespace fairlead::bench
