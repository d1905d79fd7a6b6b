"""What could go wrong, and which check of the gate is there for it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hazard:
    """One check; its rule and outcome are in docs/safety-checks.md.

    Attributes:
        code: 24 for G024.
        hazard: what happens to people or the robot without the check.
        counts: it compares counts, ticks or names; else a real number, of which a test comes as
            close to the limit as numbers can.
    """

    code: int
    hazard: str
    counts: bool = False


HAZARDS = (
    Hazard(1, "bytes that are no command are read as one", counts=True),
    Hazard(
        2,
        "commands for another robot, or for one that was restarted, move this one",
        counts=True,
    ),
    Hazard(3, "a recording, or a chunk from before a stop was reset, moves the robot", counts=True),
    Hazard(4, "two programs drive the same part, or a stranger drives one", counts=True),
    Hazard(5, "an old or doubled message moves the robot again", counts=True),
    Hazard(6, "a policy acts on an outdated view of the world", counts=True),
    Hazard(7, "numbers of one joint are read as another's", counts=True),
    Hazard(8, "a broken policy emits NaN or 1e308"),
    Hazard(9, "a part moves that nobody meant, or in a mode it does not have", counts=True),
    Hazard(10, "a runaway sender crowds out everybody else", counts=True),
    Hazard(11, "the gate judges from a sensor that is dead, silent or outside its range"),
    Hazard(12, "rows act later than they were meant to", counts=True),
    Hazard(13, "an encoder slips, or two joints are swapped"),
    Hazard(20, "a joint, tool, base or gripper is told to go too far or too fast"),
    Hazard(21, "a chunk begins with a jump from where the robot is"),
    Hazard(22, "a jump within the chunk throws the arm"),
    Hazard(23, "a jump between one chunk and the next"),
    Hazard(24, "a joint runs into its end stop because it cannot brake in time"),
    Hazard(25, "a controller is switched while the robot moves", counts=True),
    Hazard(26, "a tool's motion throws a joint faster than it may be"),
    Hazard(30, "nobody knows where a row leads", counts=True),
    Hazard(31, "tool or arm leaves its workspace, or enters a forbidden box"),
    Hazard(32, "the robot hits or clamps itself"),
    Hazard(33, "joints race near a singular pose"),
    Hazard(34, "the base drives out of its area or into a forbidden one"),
    Hazard(40, "the robot does something else than what was released"),
    Hazard(41, "a frozen sensor hides motion", counts=True),
    Hazard(42, "the robot pushes against something, or drops what it holds"),
    Hazard(43, "the robot goes on after it was stopped, or its rows ended", counts=True),
    Hazard(50, "the gate is too slow, or its limits change in memory", counts=True),
)
"""In the order of the codes."""
