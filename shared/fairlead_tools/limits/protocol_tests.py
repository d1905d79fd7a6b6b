"""The tests that prove the limits of the protocol, by the limit's name."""

from __future__ import annotations

from collections.abc import Mapping

from fairlead_tools.limits.bound_tests import Enforcement, core_test

_HEARTBEAT = core_test(
    "end of the claim",
    "test_candidates",
    "heartbeats keep a claim, their loss ends it, and only its own source's count",
)
PROTOCOL_TESTS: Mapping[str, Enforcement] = {
    "horizon_max": core_test(
        "G007", "test_shape", "G007 the horizon lies between 1 and the claim's maximum"
    ),
    "age_max_ticks": core_test(
        "G006",
        "test_ticks",
        "G006 ages at the limit, beyond it, and inputs newer than the observation",
    ),
    "chunk_rate_max_hz": core_test(
        "G010",
        "test_ticks",
        "G010 the excess over the declared rate is refused, counted in ticks",
    ),
    "seq_jump_max": core_test(
        "G005", "test_candidates", "G005 seq is strictly increasing and jumps at most 1,000"
    ),
    "state_timeout_ms": core_test(
        "G011", "test_stops", "G011 no new state for 250 ms stops an armed gate in realtime"
    ),
    "heartbeat_timeout_realtime_ms": _HEARTBEAT,
    "heartbeat_timeout_lockstep_ms": _HEARTBEAT,
    "lease_interval_ms": core_test(
        "leases", "test_arming", "leases come with every state and at least every 25 ms"
    ),
    "idle_disarm_s": core_test(
        "disarming", "test_arming", "armed without a claim for 30 s disarms, in lockstep too"
    ),
    "stops_to_latch": core_test(
        "latch", "test_latch", "three stops of the gate's own within 60 s of ticks latch"
    ),
    "stop_window_s": core_test(
        "latch",
        "test_latch",
        "stops spread wider than the window do not latch, nor do an operator's",
    ),
    "bad_frames_limit": core_test(
        "G001",
        "test_candidates",
        "G001 an unreadable frame is refused; five in 20 ticks end the claim",
    ),
    "bad_frames_window_ticks": core_test(
        "G001",
        "test_candidates",
        "G001 bad frames far apart, on another key, or that do not cite it leave the claim alone",
    ),
}
