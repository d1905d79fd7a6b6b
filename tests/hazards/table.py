"""What could go wrong, and which check of the gate is there for it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hazard:
    """One check.

    Attributes:
        code: 24 for G024.
        hazard: what happens to people or the robot without the check.
        check: what is asked, in a few words.
        outcome: what becomes of chunk, rows or motion.
        counts: it compares counts, ticks or names; else a real number, of which a test comes as
            close to the limit as numbers can.
    """

    code: int
    hazard: str
    check: str
    outcome: str
    counts: bool = False


HAZARDS = (
    Hazard(
        1,
        "bytes that are no command are read as one",
        "frame: size, type, version, exact length, nothing behind the end",
        "refuse; repeated: the claim ends",
        counts=True,
    ),
    Hazard(
        2,
        "commands for another robot, or for one that was restarted, move this one",
        "HAL session and robot hash are the armed ones",
        "refuse",
        counts=True,
    ),
    Hazard(
        3,
        "a recording, or what was sent before a stop was reset, moves the robot",
        "the epoch is the current arming's",
        "refuse",
        counts=True,
    ),
    Hazard(
        4,
        "two programs drive the same part, or a stranger drives one",
        "the claim is live, the sender's own, and covers every part",
        "refuse",
        counts=True,
    ),
    Hazard(
        5,
        "an old or doubled message moves the robot again",
        "sequence number rises, jump at most 1,000",
        "refuse",
        counts=True,
    ),
    Hazard(
        6,
        "a policy acts on a world that has gone",
        "age of the observation; nothing from the future",
        "refuse; repeatedly far ahead: stop",
        counts=True,
    ),
    Hazard(
        7,
        "numbers of one joint are read as another's",
        "horizon, and exactly horizon x width numbers",
        "refuse",
        counts=True,
    ),
    Hazard(
        8,
        "a broken policy emits NaN or 1e308",
        "every number finite and at most 1e6",
        "refuse and stop",
    ),
    Hazard(
        9,
        "a part moves that nobody meant, or in a mode it does not have",
        "mode, frame, mask and padding; each part once",
        "refuse",
        counts=True,
    ),
    Hazard(
        10,
        "a runaway sender crowds out everybody else",
        "chunks within the claimed rate",
        "refuse the excess",
        counts=True,
    ),
    Hazard(
        11,
        "the gate judges from a sensor that is dead, silent or outside its range",
        "measured state: complete, finite, fresh, inside its limits",
        "stop; outside: only rows that lead back",
    ),
    Hazard(
        12,
        "rows act later than they were meant to",
        "at least one row is not yet past",
        "refuse",
        counts=True,
    ),
    Hazard(
        13,
        "an encoder slips, or two joints are swapped",
        "measured jump within what the robot can move",
        "stop",
    ),
    Hazard(
        20,
        "a joint, tool, base or gripper is told to go too far or too fast",
        "absolute limits of every row, by mode",
        "truncate",
    ),
    Hazard(
        21,
        "a chunk begins with a jump from where the robot is",
        "first row against the measured state and what was executed",
        "refuse",
    ),
    Hazard(
        22,
        "a jump within the chunk throws the arm",
        "change from row to row",
        "truncate",
    ),
    Hazard(
        23,
        "a jump between one chunk and the next",
        "first row against the released row that acts before it and is not measured yet",
        "refuse",
    ),
    Hazard(
        24,
        "a joint runs into its end stop because it cannot brake any more",
        "where braking from each row ends is inside the joint's bounds",
        "truncate",
    ),
    Hazard(
        25,
        "a controller is switched while the robot moves",
        "listed changes of mode only, at standstill; composite switch as declared",
        "refuse",
        counts=True,
    ),
    Hazard(
        26,
        "a tool's motion throws a joint faster than it may be",
        "joint speeds that a tool's row asks for, and those that are measured",
        "truncate",
    ),
    Hazard(
        30,
        "nobody knows where a row leads",
        "each row's configuration can be computed from the measured state",
        "refuse",
        counts=True,
    ),
    Hazard(
        31,
        "tool or arm leaves its workspace, or enters a forbidden box",
        "workspace volumes, at the row and where braking ends",
        "truncate",
    ),
    Hazard(
        32,
        "the robot hits or clamps itself",
        "distance of capsule pairs, at the row and where braking ends",
        "truncate",
    ),
    Hazard(
        33,
        "joints race near a singular pose",
        "smallest singular value of the tool's Jacobian while it falls",
        "truncate",
    ),
    Hazard(
        34,
        "the base drives out of its area or into a forbidden one",
        "footprint against zones, over reaction and braking",
        "truncate",
    ),
    Hazard(
        40,
        "the robot does something else than what was released",
        "measured against the rows that acted",
        "revoke and stop",
    ),
    Hazard(
        41,
        "a frozen sensor hides motion",
        "commanded motion without any measured change",
        "stop",
        counts=True,
    ),
    Hazard(
        42,
        "the robot pushes against something, or drops what it holds",
        "measured effort; opening lost by a closed gripper",
        "stop; the gripper keeps its command",
    ),
    Hazard(
        43,
        "the robot goes on after it was stopped, or its rows ended",
        "standstill within the declared ramp",
        "latch",
        counts=True,
    ),
    Hazard(
        50,
        "the gate itself is too slow, or its limits change in memory",
        "own step time; CRC of the limits each second",
        "stop",
        counts=True,
    ),
)
"""In the order of the codes."""
