"""Where a robot rests: the block ``home`` of robot.yaml."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fairlead.robot.joint import Joint
from fairlead.robot.mode_limits import Finite, SafetyBlock
from fairlead.robot.safety_rules import same_names


class HomePose(SafetyBlock):
    """positions: of every joint with position limits, commanded or passive [rad or m]."""

    positions: dict[str, Finite]
    source: str


def home_problems(joints: Sequence[Joint], home: HomePose) -> Iterator[str]:
    """Joints without a place to rest, with one that is none, and names of no such joint."""
    bounded = {joint.name: joint for joint in joints if joint.has_bounds}
    yield from same_names("home.positions", bounded, home.positions)
    for name, position in home.positions.items():
        if name in bounded and not bounded[name].lower <= position <= bounded[name].upper:
            lower, upper = bounded[name].lower, bounded[name].upper
            yield (
                f"home: joint {name!r}: expected a position from {lower} to {upper}, got {position}"
            )
