// Which leases this gate sent, and which somebody else sends in its name.

#include "core/gate/outbox.hpp"

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Lease send_next(SentLeases& sent, std::uint64_t state_tick) {
  Lease& lease = sent.next();
  lease.state_tick = state_tick;
  return lease;
}

// Latched by this one, with it as the cause.
void check_forged(GateRig& rig, const Lease& lease) {
  rig.send(EventKind::lease, lease);
  CHECK(rig.gate->state() == GateState::latched);
  const std::string cause(rig.status().cause.view());
  CHECK(cause.starts_with("latched: two gates serve this robot: lease "));
  CHECK(cause.ends_with(", which this one did not send"));
}

}  // namespace

TEST_CASE("leases are numbered from 1 in each epoch") {
  SentLeases sent;
  sent.begin_epoch(7);
  CHECK(send_next(sent, 0).lease_seq == 1);
  CHECK(send_next(sent, 0).lease_seq == 2);
  sent.begin_epoch(8);
  const Lease first = send_next(sent, 0);
  CHECK(first.epoch == 8);
  CHECK(first.lease_seq == 1);
}

TEST_CASE("a lease that was sent is known, in whatever order and however late it comes") {
  SentLeases sent;
  std::vector<Lease> all;
  for (std::uint64_t epoch = 1; epoch <= SentLeases::epochs_known; ++epoch) {
    sent.begin_epoch(epoch);
    for (std::uint64_t i = 0; i < SentLeases::leases_kept + 1; ++i)
      all.push_back(send_next(sent, 100 * epoch + i));
  }
  for (const Lease& lease : all) CHECK(sent.holds(lease));
  for (std::size_t i = all.size(); i > 0; --i) CHECK(sent.holds(all[i - 1]));
}

TEST_CASE("a number that was never sent is unknown, in any epoch") {
  SentLeases sent;
  CHECK_FALSE(sent.holds(Lease{}));
  sent.begin_epoch(7);
  Lease lease = send_next(sent, 5);
  sent.begin_epoch(8);
  CHECK_FALSE(sent.holds(Lease{}));
  lease.lease_seq = 2;
  CHECK_FALSE(sent.holds(lease));
  lease.epoch = 8;
  lease.lease_seq = 1;
  CHECK_FALSE(sent.holds(lease));
  lease.lease_seq = 0;
  CHECK_FALSE(sent.holds(lease));
}

TEST_CASE("a number that was sent with something else in it is unknown while that is kept") {
  SentLeases sent;
  sent.begin_epoch(7);
  const Lease first = send_next(sent, 5);
  Lease other = first;
  other.state_tick = 6;
  CHECK_FALSE(sent.holds(other));
  other = first;
  (void)other.grants.push_back(Grant{"runner", 1, 2, 3, 4});
  CHECK_FALSE(sent.holds(other));
  sent.begin_epoch(8);
  other.state_tick = 6;
  CHECK_FALSE(sent.holds(other));
  while (send_next(sent, 9).lease_seq % SentLeases::leases_kept != 1) {
  }
  CHECK(sent.holds(first));
  CHECK(sent.holds(other));
}

TEST_CASE("one other number anywhere in it makes another lease") {
  Lease lease;
  (void)lease.grants.push_back(Grant{"runner", 1, 2, 3, 4});
  (void)lease.stop_ids.push_back(5);
  const auto differs = [&](const auto& change) {
    Lease other = lease;
    change(other);
    return other != lease;
  };
  CHECK_FALSE(differs([](Lease&) {}));
  CHECK(differs([](Lease& l) { ++l.session; }));
  CHECK(differs([](Lease& l) { ++l.epoch; }));
  CHECK(differs([](Lease& l) { ++l.lease_seq; }));
  CHECK(differs([](Lease& l) { l.config_hash.back() ^= 1U; }));
  CHECK(differs([](Lease& l) { ++l.state; }));
  CHECK(differs([](Lease& l) { ++l.state_tick; }));
  CHECK(differs([](Lease& l) { ++l.stop_ids[0]; }));
  CHECK(differs([](Lease& l) { l.stop_ids.clear(); }));
  CHECK(differs([](Lease& l) { l.grants.clear(); }));
  CHECK(differs([](Lease& l) { l.grants[0].source = "other"; }));
  CHECK(differs([](Lease& l) { ++l.grants[0].claim_id; }));
  CHECK(differs([](Lease& l) { ++l.grants[0].until_tick; }));
  CHECK(differs([](Lease& l) { ++l.grants[0].decision; }));
  CHECK(differs([](Lease& l) { ++l.grants[0].verdict_id; }));
}

TEST_CASE("a lease of this gate's epoch that it did not send latches: nobody else sends any") {
  {
    GateRig rig;  // the next number already
    rig.ready();
    Lease ahead = rig.lease();
    ++ahead.lease_seq;
    check_forged(rig, ahead);
  }
  {
    GateRig rig;  // the newest number, with more in it
    rig.ready();
    Lease looser = rig.lease();
    looser.grants[0].until_tick += 1000;
    check_forged(rig, looser);
  }
  {
    GateRig rig;  // the epoch before this arming
    rig.send_hal_status();
    Lease old = rig.lease();
    rig.send_state();
    rig.arm();
    old.lease_seq += 100;
    check_forged(rig, old);
  }
}

TEST_CASE("this gate's own leases never latch it, in order, late or twice") {
  GateRig rig;
  std::vector<Lease> all;
  const auto keep = [&] {
    if (rig.count(OutputKind::lease) == 1) all.push_back(rig.lease());
  };
  rig.send_hal_status();
  keep();
  for (int arming = 0; arming < 3; ++arming) {
    rig.next_tick();
    keep();
    rig.epoch = rig.arm().epoch;
    keep();
    rig.take_claim();
    keep();
    for (int i = 0; i < 5; ++i) {
      rig.next_tick();
      keep();
      rig.send(EventKind::lease, all.back());
      keep();
    }
    rig.send(EventKind::disarm, Disarm{"test"});
    keep();
  }
  REQUIRE(all.size() > 20);
  for (const Lease& lease : all) rig.send(EventKind::lease, lease);
  for (std::size_t i = all.size(); i > 0; --i) rig.send(EventKind::lease, all[i - 1]);
  CHECK(rig.gate->state() == GateState::disarmed);
}
