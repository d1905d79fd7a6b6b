// Two arms, two claims, chunks at random, in realtime: a HAL that goes by leases and SafeChunks
// alone executes them, and the arms keep their distance. Claims end and the gate is disarmed while
// they move; no message is lost.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "two_claims.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::two_arms;

namespace {

constexpr double braking = 4.0, fastest = 1.5;  // rad/s^2, rad/s
constexpr double clearance = 0.02;              // m
constexpr double between_rows = 0.005;          // m: by how much a distance may be below it
constexpr int ticks = 500;

// Rows of an arm that the gate has released.
struct ReleasedRows {
  std::uint64_t claim_id, epoch, verdict_id, first_tick;
  Acted after;
  std::vector<double> targets;

  [[nodiscard]] bool has_row_for(std::uint64_t tick) const {
    return tick >= first_tick && tick - first_tick < targets.size();
  }
};

// What the HAL knows and does of one arm.
struct FollowedArm {
  std::map<std::uint64_t, ReleasedRows> pending;  // by verdict
  std::optional<ReleasedRows> active;
  Acted did;
  std::optional<double> target;

  void decide(std::uint64_t tick, const Lease& lease) {
    std::optional<ReleasedRows> next;
    for (const auto& [verdict_id, rows] : pending)
      if (rows.first_tick == tick && is_granted(rows, tick, lease) && goes_on(rows)) next = rows;
    if (!next && active && active->has_row_for(tick) && is_granted(*active, tick, lease))
      next = active;
    std::erase_if(pending, [&](const auto& item) { return item.second.first_tick <= tick; });
    active = next;
    did = next ? Acted{0, next->verdict_id, static_cast<std::uint32_t>(tick - next->first_tick)}
               : Acted{};
    target = next ? std::optional(next->targets[tick - next->first_tick]) : std::nullopt;
  }

 private:
  static bool is_granted(const ReleasedRows& rows, std::uint64_t tick, const Lease& lease) {
    if (lease.state != static_cast<std::uint8_t>(GateState::armed)) return false;
    for (const Grant& grant : lease.grants)
      if (grant.claim_id == rows.claim_id)
        return lease.epoch == rows.epoch && grant.until_tick >= tick;
    return false;
  }
  [[nodiscard]] bool goes_on(const ReleasedRows& rows) const {
    if (active && rows.verdict_id <= active->verdict_id) return false;
    return rows.after.hold != 0 ? did.hold != 0 : same_act(rows.after, did);
  }
};

class Followed : TwoClaims {
 public:
  explicit Followed(unsigned seed) : TwoClaims(0.0, 0.0, braking, 0.1), chance_(seed) { listen(); }

  /// The least distance that the arms come to [m], and how many rows they execute.
  std::pair<double, int> run() {
    for (int n = 0; n < ticks; ++n) {
      move();
      const Acted left_did = arms_[left].did, right_did = arms_[right].did;
      for (FollowedArm& arm : arms_) arm.decide(tick + 1, lease_);
      next_tick_of({left_did, right_did, Acted{}});
      listen();
      for (const FollowedArm& arm : arms_) executed_ += arm.target ? 1 : 0;
      const GateState state = gate->state();
      CHECK((state == GateState::armed || state == GateState::disarmed));
      disturb();
      for (const std::uint8_t arm : {left, right})
        if (claims[arm] != 0 && draw(3) == 0) send_random_rows(arm);
      timer(20 * ms);
      listen();
      now_ns = now_ns / limits.period_ns * limits.period_ns;
    }
    return {least_, executed_};
  }

 private:
  int draw(int below) { return static_cast<int>(chance_() % static_cast<unsigned>(below)); }

  // A tick's motion: to the target, or braking.
  void move() {
    const double from_left = positions[left_1], from_right = positions[right_1];
    const double period = static_cast<double>(limits.period_ns) * 1e-9;
    for (const std::uint8_t arm : {left, right}) {
      double &at = positions[arm], &speed = velocities[arm];
      if (arms_[arm].target) {
        speed = std::clamp((*arms_[arm].target - at) / period, -fastest, fastest);
        at = *arms_[arm].target;
        continue;
      }
      const double time = std::min(period, std::abs(speed) / braking);
      at += speed * time - std::copysign(0.5 * braking * time * time, speed);
      speed -= std::copysign(braking * time, speed);
      if (std::abs(speed) < 1e-12) speed = 0.0;
    }
    for (const double part : {0.25, 0.5, 0.75, 1.0})
      least_ = std::min(least_, distance(from_left + part * (positions[left_1] - from_left),
                                         from_right + part * (positions[right_1] - from_right)));
  }

  // Between the capsules; of points on one axis from the other.
  static double distance(double at_left, double at_right) {
    double least = 1.0;
    for (const bool is_right : {false, true})
      for (int i = 0; i <= 80; ++i) {
        const double along = 0.1 + 0.4 * i / 80.0, side = is_right ? 1.0 : -1.0;
        const double own = is_right ? at_right : at_left, other = is_right ? at_left : at_right;
        const double x = along * std::cos(own), y = along * std::sin(own) - 0.6 * side;
        const double foot = std::clamp(x * std::cos(other) + y * std::sin(other), 0.1, 0.5);
        least = std::min(least, std::hypot(x - foot * std::cos(other), y - foot * std::sin(other)));
      }
    return least - 0.1;
  }

  // Who has no claim takes one; one is given back; the gate is disarmed, and armed again.
  void disturb() {
    for (const std::uint8_t arm : {left, right})
      if (claims[arm] != 0) send_and_listen(EventKind::heartbeat, Heartbeat{claims[arm]}, arm);
    if (gate->state() == GateState::disarmed) {
      epoch = arm_gate();
      claims[left] = claims[right] = 0;
    }
    for (const std::uint8_t arm : {left, right}) {
      if (claims[arm] != 0 || draw(3) != 0) continue;
      take_claim_of(arm);
      listen();
    }
    const auto arm = static_cast<std::uint8_t>(draw(2));
    if (claims[arm] != 0 && draw(25) == 0) {
      send_and_listen(EventKind::release, Release{source(arm), claims[arm]}, arm);
      claims[arm] = 0;
    }
    if (draw(80) == 0) send_and_listen(EventKind::disarm, Disarm{"test"}, left);
  }

  std::uint64_t arm_gate() {
    const std::uint64_t armed = arm().epoch;
    listen();
    return armed;
  }

  // Towards the other arm more often than not.
  void send_random_rows(std::uint8_t arm) {
    double at = arms_[arm].target.value_or(positions[arm]), speed = 0.0;
    Row targets;
    for (int rows = 1 + draw(10); rows > 0; --rows) {
      if (targets.empty() || draw(3) == 0)
        speed = std::clamp(0.014 * (draw(201) - (arm == left ? 130 : 70)), -1.4, 1.4);
      at += speed * 0.05;
      targets.push_back(at);
    }
    if (gate->state() != GateState::armed) return;
    (void)send_rows(arm, targets);
    listen();
  }

  void send_and_listen(EventKind kind, const auto& message, std::uint8_t arm) {
    send(kind, message, source(arm));
    listen();
  }

  // What the gate has just said to the HAL.
  void listen() {
    for (const Output& output : out->items()) {
      const Bytes payload = out->payload(output);
      if (output.kind == OutputKind::lease) REQUIRE(decode(payload, lease_) == FrameFault::none);
      if (output.kind != OutputKind::safe_chunk) continue;
      SafeChunk safe;
      REQUIRE(decode(payload, safe) == FrameFault::none);
      const std::uint8_t arm = safe.parts[0].part;
      if (safe.first_tick <= tick) continue;  // that tick has been decided
      ReleasedRows rows{safe.claim_id,   safe.epoch, safe.verdict_id,
                        safe.first_tick, safe.after, {}};
      for (std::size_t row = 0; row < safe.horizon; ++row)
        rows.targets.push_back(safe.parts[0].values[row * two_arms::joint_count + arm]);
      arms_[arm].pending.emplace(rows.verdict_id, rows);
    }
  }

  std::mt19937 chance_;
  FollowedArm arms_[2];
  Lease lease_;
  double least_ = 1.0;
  int executed_ = 0;
};

}  // namespace

TEST_CASE("random rows of two claims keep their arms apart") {
  const char* more = std::getenv("FAIRLEAD_FOLLOWED_RUNS");
  const unsigned runs = more == nullptr ? 30 : static_cast<unsigned>(std::atoi(more));
  double nearest = 1.0;
  for (unsigned seed = 0; seed < runs; ++seed) {
    CAPTURE(seed);
    const auto [least, executed] = Followed(seed).run();
    CHECK(least > clearance - between_rows);
    CHECK(executed > ticks / 10);
    nearest = std::min(nearest, least);
  }
  CHECK(nearest < clearance + between_rows);  // else nothing was tried
}
