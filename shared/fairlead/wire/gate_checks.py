"""Every check of the gate, once: what it asks, what follows, what to do.

The list of docs/safety-checks.md is made of it, and ``fairlead why G020`` prints one of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Example:
    """What a check may find: the fields of a ``Verdict`` that its words are made of."""

    part: str
    axis: str
    value: float = 0.0
    limit: float = 0.0
    margin: float = 0.0
    unit: str = ""
    limit_source: str = ""
    code: int = 0  # of no check: their table knows


@dataclass(frozen=True)
class GateCheck:
    """One check.

    Attributes:
        title: what it is about, in a few words.
        hazard: what it is for.
        rule: what passes, as a formula where it has one.
        units: that its magnitudes may have, "1": plain numbers; none: it has rules only.
        outcome: what the gate does.
        example: of what it finds.
        hint: what to do about it.
        section: where docs/safety-checks.md says more; "" if nowhere.
        counts: it compares counts, ticks or names; else a real number.
    """

    title: str
    hazard: str
    rule: str
    units: tuple[str, ...]
    outcome: str
    example: Example
    hint: str
    section: str = ""
    counts: bool = False


def _number(part: str, axis: str, value: float, limit: float, unit: str) -> Example:
    return Example(part, axis, value, limit, -abs(value - limit), unit)


def _rule(part: str, axis: str, needs: str) -> Example:
    return Example(part, axis, limit_source=needs)


CHECKS = {
    1: GateCheck(
        title="not a well-formed chunk",
        hazard="bytes that are no command",
        rule="size <= 64 KiB; type, version and exact length",
        units=(),
        outcome="refuse; repeated: the claim ends",
        example=_rule("", "", "a chunk, got another version, at byte 2 of 211"),
        hint="what sends this writes another message, or another version: docs/wire-format.md",
        counts=True,
    ),
    2: GateCheck(
        title="other HAL session or robot",
        hazard="commands for another robot",
        rule="robot hash and session of the HAL that was armed",
        units=(),
        outcome="refuse",
        example=_rule("", "", "the HAL session the gate follows"),
        hint="whoever sent it follows another robot or HAL session: start the goal again",
        counts=True,
    ),
    3: GateCheck(
        title="old arm epoch",
        hazard="a recording moves the robot",
        rule="epoch of the last arming",
        units=(),
        outcome="refuse",
        example=_rule("", "", "the current arm epoch"),
        hint="fairlead arm, then start the goal again: chunks from before an arming never run",
        counts=True,
    ),
    4: GateCheck(
        title="no such claim, or parts it does not cover",
        hazard="two programs drive one part",
        rule="a live claim of the sender that covers every part",
        units=(),
        outcome="refuse",
        example=_rule("arm", "part", "a part of the claim"),
        hint="start the goal again: its claim has ended, or never covered these parts",
        counts=True,
    ),
    5: GateCheck(
        title="sequence number not increasing",
        hazard="an old message acts again",
        rule="last < seq <= last + 1,000; a copy of the newest chunk gets its answer",
        units=("1",),
        outcome="refuse",
        example=_number("", "seq", 5000.0, 1000.0, "1"),
        hint="count sequence numbers up by one, from 1 with each claim",
        counts=True,
    ),
    6: GateCheck(
        title="observation too new or too old",
        hazard="an outdated view of the world",
        rule=(
            "oldest_tick <= obs_tick <= newest tick; newest - oldest_tick <= age_max_ticks; "
            "start_tick <= newest (realtime: + 1)"
        ),
        units=("ticks",),
        outcome="refuse; five too far ahead within 20 ticks: stop",
        example=_number("", "age", 20.0, 10.0, "ticks"),
        hint="answer from newer states; `age_max_ticks` of the skill says how old they may be",
        counts=True,
    ),
    7: GateCheck(
        title="horizon or width",
        hazard="one joint's numbers read as another's",
        rule="1 <= rows <= horizon_max; values = rows x width of the mode",
        units=("rows",),
        outcome="refuse",
        example=_number("", "horizon", 80.0, 64.0, "rows"),
        hint="fairlead skill check: the horizon or a width is not what the robot takes",
        counts=True,
    ),
    8: GateCheck(
        title="number not finite or too large",
        hazard="a policy emits NaN or 1e308",
        rule="|value| <= 1e6, in past rows too",
        units=("1",),
        outcome="refuse and stop",
        example=_number("arm", "cartesian_delta", math.nan, 1000000.0, "1"),
        hint="find the NaN, infinity or huge number of the policy, then reset the stop",
    ),
    9: GateCheck(
        title="mode, mask or padding",
        hazard="a part moves that nobody meant",
        rule=(
            "mode and active joints of the part (slides commanded in the base's frame: both or "
            "none); other numbers 0; no part twice"
        ),
        units=(),
        outcome="refuse",
        example=_rule("arm", "panda_joint1", "0.0 where not active"),
        hint="fairlead skill show: a part has another mode, frame or mask than the robot declares",
        counts=True,
    ),
    10: GateCheck(
        title="too many chunks",
        hazard="a runaway sender crowds out others",
        rule=(
            "chunks in W <= ceil(1.2 W chunk_rate_hz) + 1, W = max(250 ms, 2 / chunk_rate_hz); "
            "those refused here do not count"
        ),
        units=("1",),
        outcome="refuse the excess",
        example=_number("", "chunks", 8.0, 7.0, "1"),
        hint="send fewer chunks, or declare a higher `chunk_rate_hz` in the skill",
        counts=True,
    ),
    11: GateCheck(
        title="measured state",
        hazard="a sensor dead, silent or out of range",
        rule=(
            "finite, lower - tolerance <= q <= upper + tolerance; armed in realtime: age of the "
            "state <= state_timeout_ms"
        ),
        units=("rad", "m", "rad/s", "m/s", "ms"),
        outcome="stop; joint outside: only rows that lead back",
        example=_number("", "state age", 300.0, 250.0, "ms"),
        section="Measured states: G011, G013",
        hint="bring the joint back inside its limits, or mend the sensor",
    ),
    12: GateCheck(
        title="every row is past",
        hazard="rows that act too late",
        rule="start_tick + rows > next open tick",
        units=("ticks",),
        outcome="refuse",
        example=_number("", "last row's tick", 41.0, 42.0, "ticks"),
        hint="answer sooner, or with more rows: every row was for a tick that had passed",
        counts=True,
    ),
    13: GateCheck(
        title="measured jump",
        hazard="an encoder slips, joints are swapped",
        rule="|q - q before| <= jump_per_tick x ticks; ticks <= periods that can have passed",
        units=("rad", "m", "ticks"),
        outcome="stop",
        example=_number("", "base_x", 1.25, 1.0, "m"),
        section="Measured states: G011, G013",
        hint="mend the sensor, or whatever moved the robot",
    ),
    20: GateCheck(
        title="limit",
        hazard="told to go too far or too fast",
        rule="lower <= number <= upper, or norm <= limit, in every row, by mode",
        units=("rad", "m", "rad/s", "m/s", "1"),
        outcome="truncate",
        example=_number("arm", "linear", 0.09, 0.0867, "m"),
        section="Rules by mode",
        hint="ask for less; a limit that is wrong for the robot is changed where it is declared",
    ),
    21: GateCheck(
        title="does not start where the robot is",
        hazard="a jump at the start of a chunk",
        rule=(
            "|first row - measured| <= step_limit + tolerance, |first row - row before| <= "
            "step_limit, by mode"
        ),
        units=("rad", "m", "rad/s", "m/s", "1"),
        outcome="refuse",
        example=_number("arm", "panda_joint1", 0.5, 0.25, "rad"),
        section="Rules by mode",
        hint="begin a chunk where the robot is and with the motion it is in",
    ),
    22: GateCheck(
        title="jump between rows",
        hazard="a jump within a chunk",
        rule="|row - row before| <= step_limit, by mode",
        units=("rad", "m", "rad/s", "m/s", "1"),
        outcome="truncate",
        example=_number("arm", "linear", 0.3, 0.1, "m"),
        section="Rules by mode",
        hint="take smaller steps from row to row",
    ),
    23: GateCheck(
        title="does not continue the released rows",
        hazard="a jump between two chunks",
        rule=(
            "realtime: |first row - released row before| <= step_limit, until a state shows "
            "that row"
        ),
        units=("rad", "m", "rad/s", "m/s", "1"),
        outcome="refuse",
        example=_number("base", "base_x", 2.5, 2.0, "m/s"),
        section="Rules by mode",
        hint="begin a chunk with the motion that the released rows are in",
    ),
    24: GateCheck(
        title="cannot brake before a limit",
        hazard="no braking before the end stop",
        rule="lower <= q + v wait + v|v| / 2a <= upper after each row",
        units=("rad", "m"),
        outcome="truncate",
        example=_number("arm", "panda_joint4", -3.1, -3.0718, "rad"),
        section="Prediction",
        hint="slow down before the limit: braking would end beyond it",
    ),
    25: GateCheck(
        title="mode switch not allowed",
        hazard="a controller switched in motion",
        rule="mode, frame, composite switch change while each joint's |v| < standstill_per_s",
        units=("rad/s", "m/s"),
        outcome="refuse; later row: truncate",
        example=_number("arm", "panda_joint1", 0.2, 0.05, "rad/s"),
        section="Changes: G025",
        hint=(
            "hold until the robot stands still; `transitions` and `switching` in robot.yaml say "
            "which change it may make then"
        ),
        counts=True,
    ),
    26: GateCheck(
        title="a tool motion too fast for a joint",
        hazard="a tool motion makes a joint race",
        rule="tool motions need |v| <= velocity limit of each joint",
        units=("rad/s", "m/s"),
        outcome="truncate",
        example=_number("arm", "panda_joint2", 2.9, 2.175, "rad/s"),
        section="Prediction",
        hint="move the tool less in a row: its joints would be too fast, or are",
    ),
    30: GateCheck(
        title="nobody can say where it leads",
        hazard="nobody knows where a row leads",
        rule=(
            "|pose - pose found| <= 1e-6; joints get there in 12 steps, almost straight; "
            "configurations <= 512"
        ),
        units=("m", "rad", "1"),
        outcome="refuse; later row: truncate",
        example=_number("arm", "tool position", 0.04, 1e-06, "m"),
        section="Prediction",
        hint="ask for a motion that the tool can make from where it is",
        counts=True,
    ),
    31: GateCheck(
        title="outside the workspace",
        hazard="tool or arm leaves its workspace",
        rule="tools inside keep-in boxes; tools and moved capsules outside keep-out boxes",
        units=("m",),
        outcome="truncate",
        example=_number("arm", "tool z / table", 0.65, 0.6, "m"),
        section="Prediction",
        hint="stay inside the volumes of robot.yaml, braking included",
    ),
    32: GateCheck(
        title="too near to itself",
        hazard="the robot hits or clamps itself",
        rule="distance of each declared pair of capsules >= clearance",
        units=("m",),
        outcome="truncate",
        example=_number("arm", "base_link / panda_hand", 0.015, 0.02, "m"),
        section="Prediction",
        hint="keep the robot's links apart",
    ),
    33: GateCheck(
        title="too near to a singular pose",
        hazard="joints race near a singular pose",
        rule="cartesian rows end at a smallest singular value >= singularity_limit, begin at half",
        units=("1",),
        outcome="truncate",
        example=_number("arm", "singular value", 0.04, 0.05, "1"),
        section="Prediction",
        hint="keep the arm away from singular poses; leaving one is always allowed",
    ),
    34: GateCheck(
        title="base outside its zones",
        hazard="the base leaves its area",
        rule="footprint inside keep-in zones, outside keep-out zones",
        units=("m",),
        outcome="truncate",
        example=_number("base", "kitchen", -0.05, 0.0, "m"),
        section="Prediction",
        hint="stay inside the zones of robot.yaml, reaction and braking included",
    ),
    40: GateCheck(
        title="the robot does not do what was released",
        hazard="the robot does something else",
        rule="distance of measured motion to gain x executed row <= tracking",
        units=("rad", "m", "rad/s", "m/s"),
        outcome="revoke and stop",
        example=_number("arm", "panda_joint3", 0.5, 0.125, "rad"),
        section="Execution: G040 to G043",
        hint="find out why the robot does not follow, then reset the stop",
    ),
    41: GateCheck(
        title="a sensor that does not change",
        hazard="a frozen sensor hides motion",
        rule=(
            "commanded motion beyond dead_band moves the joint by more than encoder_step within "
            "stuck_ticks rows"
        ),
        units=("rad", "m"),
        outcome="stop",
        example=_number("arm", "panda_joint1", 0.0, 0.001, "rad"),
        section="Execution: G040 to G043",
        hint="mend the sensor, then reset the stop",
        counts=True,
    ),
    42: GateCheck(
        title="contact, or an object lost",
        hazard="it pushes, or drops what it holds",
        rule="|effort| <= contact_limit; what a gripper holds slips <= slip_limit",
        units=("N m", "N", "rad", "m"),
        outcome="stop",
        example=_number("arm", "panda_joint3", 50.0, 40.0, "N m"),
        section="Execution: G040 to G043",
        hint="look what the robot touches or has lost, then reset the stop",
    ),
    43: GateCheck(
        title="did not stop in time",
        hazard="it goes on after a stop",
        rule=(
            "|v| < standstill_per_s in three states within stop_ramp_ms after permission to "
            "move ended"
        ),
        units=("rad/s", "m/s", "ms", "1"),
        outcome="latch",
        example=_number("arm", "panda_joint1", 0.2, 0.05, "rad/s"),
        section="Execution: G040 to G043",
        hint="find out why the robot did not stop, before anything else",
        counts=True,
    ),
    50: GateCheck(
        title="the gate itself: too slow, or changed in memory",
        hazard="slow gate, or its memory changed",
        rule=(
            "each step <= step_deadline_us (realtime, armed); CRC-32 of the limits in memory as "
            "loaded"
        ),
        units=("us",),
        outcome="third slow step in 60 s, or memory: stop",
        example=_number("", "step", 2500.0, 2000.0, "us"),
        section="Execution: G040 to G043",
        hint="give the gate a processor of its own; changed memory: replace the computer",
        counts=True,
    ),
}
"""By number: 24 for G024."""
