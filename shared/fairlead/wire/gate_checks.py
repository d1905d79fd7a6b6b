"""Every check of the gate, once: what it is about, what to do."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GateCheck:
    """One check; its hazard, rule and outcome are in docs/safety-checks.md.

    Attributes:
        title: what it is about, in a few words.
        hint: what to do about it.
        counts: it compares counts, ticks or names; else a real number.
    """

    title: str
    hint: str
    counts: bool = False


CHECKS = {
    1: GateCheck(
        title="not a well-formed chunk",
        hint="what sends this writes another message, or another version: docs/wire-format.md",
        counts=True,
    ),
    2: GateCheck(
        title="other HAL session or robot",
        hint="whoever sent it follows another robot or HAL session: start the goal again",
        counts=True,
    ),
    3: GateCheck(
        title="old arm epoch",
        hint="fairlead arm, then start the goal again: chunks from before an arming never run",
        counts=True,
    ),
    4: GateCheck(
        title="no such claim, or parts it does not cover",
        hint="start the goal again: its claim has ended, or never covered these parts",
        counts=True,
    ),
    5: GateCheck(
        title="sequence number not increasing",
        hint="count sequence numbers up by one, from 1 with each claim",
        counts=True,
    ),
    6: GateCheck(
        title="observation too new or too old",
        hint="answer from newer states; `age_max_ticks` of the skill says how old they may be",
        counts=True,
    ),
    7: GateCheck(
        title="horizon or width",
        hint="fairlead skill check: the horizon or a width is not what the robot takes",
        counts=True,
    ),
    8: GateCheck(
        title="number not finite or too large",
        hint="find the NaN, infinity or huge number of the policy, then reset the stop",
    ),
    9: GateCheck(
        title="mode, mask or padding",
        hint="fairlead skill show: a part has another mode, frame or mask than the robot declares",
        counts=True,
    ),
    10: GateCheck(
        title="too many chunks",
        hint="send fewer chunks, or declare a higher `chunk_rate_hz` in the skill",
        counts=True,
    ),
    11: GateCheck(
        title="measured state",
        hint="bring the joint back inside its limits, or mend the sensor",
    ),
    12: GateCheck(
        title="every row is past",
        hint="answer sooner, or with more rows: every row was for a tick that had passed",
        counts=True,
    ),
    13: GateCheck(
        title="measured jump",
        hint="mend the sensor, or whatever moved the robot",
    ),
    20: GateCheck(
        title="limit",
        hint="ask for less; a limit that is wrong for the robot is changed where it is declared",
    ),
    21: GateCheck(
        title="does not start where the robot is",
        hint="begin a chunk where the robot is and with the motion it is in",
    ),
    22: GateCheck(
        title="jump between rows",
        hint="take smaller steps from row to row",
    ),
    23: GateCheck(
        title="does not continue the released rows",
        hint="begin a chunk with the motion that the released rows are in",
    ),
    24: GateCheck(
        title="cannot brake before a limit",
        hint="slow down before the limit: braking would end beyond it",
    ),
    25: GateCheck(
        title="mode switch not allowed",
        hint=(
            "hold until the robot stands still; `transitions` and `switching` in robot.yaml say "
            "which change it may make then"
        ),
        counts=True,
    ),
    26: GateCheck(
        title="a joint too fast for what the tool is told",
        hint="move the tool less in a row: its joints would be too fast, or are",
    ),
    30: GateCheck(
        title="nobody can say where it leads",
        hint="ask for a motion that the tool can make from where it is",
        counts=True,
    ),
    31: GateCheck(
        title="outside the workspace",
        hint="stay inside the volumes of robot.yaml, braking included",
    ),
    32: GateCheck(
        title="too near to itself",
        hint="keep the robot's links apart",
    ),
    33: GateCheck(
        title="too near to a singular pose",
        hint="keep the arm away from singular poses; leaving one is always allowed",
    ),
    34: GateCheck(
        title="base outside its zones",
        hint="stay inside the zones of robot.yaml, reaction and braking included",
    ),
    40: GateCheck(
        title="the robot does not do what was released",
        hint="find out why the robot does not follow, then reset the stop",
    ),
    41: GateCheck(
        title="a sensor that does not change",
        hint="mend the sensor, then reset the stop",
        counts=True,
    ),
    42: GateCheck(
        title="contact, or an object lost",
        hint="look what the robot touches or has lost, then reset the stop",
    ),
    43: GateCheck(
        title="did not stop in time",
        hint="find out why the robot did not stop, before anything else",
        counts=True,
    ),
    50: GateCheck(
        title="the gate itself: too slow, or changed in memory",
        hint="give the gate a processor of its own; changed memory: replace the computer",
        counts=True,
    ),
}
"""By number: 24 for G024."""
