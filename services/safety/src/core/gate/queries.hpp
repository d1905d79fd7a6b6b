// Queries: each gets exactly one reply or one refusal with the command that would fix it.
#pragma once

#include "core/gate/admission.hpp"
#include "core/gate/publisher.hpp"
#include "core/gate/robot_events.hpp"
#include "core/monitor/self_monitor.hpp"

namespace fairlead {

class Queries {
 public:
  /// All must outlive it.
  Queries(const Limits& limits, const HalLink& hal, ClaimTable& claims, PartHistory& history,
          SelfMonitor& self, MotionMonitor& motion, StateMachine& machine, const RobotEvents& robot,
          Publisher& publisher, Outbox& outbox)
      : limits_(limits),
        hal_(hal),
        claims_(claims),
        history_(history),
        self_(self),
        motion_(motion),
        machine_(machine),
        robot_(robot),
        publisher_(publisher),
        outbox_(outbox) {}

  void on_arm(Bytes frame);
  void on_disarm(Bytes frame);
  void on_reset(Bytes frame);
  void on_claim(Bytes frame);
  void on_release(Bytes frame);
  void on_status(Bytes frame);

 private:
  [[nodiscard]] Objection object_to_arming() const;
  [[nodiscard]] Objection object_to_latch_reset() const;
  Objection object_to_one_person(const Reset& request);
  [[nodiscard]] Objection wrong_state(std::string_view wanted) const;
  template <class Message>
  bool read_query(Bytes frame, Message& message);
  LiveClaim* take_offered(const LiveClaim& next);
  void refuse_query(const Objection& objection);
  template <class Message>
  void reply(const Message& message);

  const Limits& limits_;
  const HalLink& hal_;
  ClaimTable& claims_;
  PartHistory& history_;
  SelfMonitor& self_;
  MotionMonitor& motion_;
  StateMachine& machine_;
  const RobotEvents& robot_;
  Publisher& publisher_;
  Outbox& outbox_;
  Reset first_reset_;  // of the latch, by a person who waits for a second one; by "": nobody does
  std::uint64_t first_reset_ns_ = 0;
  Claim claim_request_;  // room: too big for the stack of a thread that Zenoh made
};

}  // namespace fairlead
