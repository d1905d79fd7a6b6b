"""What a stand-in gate grants and has released."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from fairlead.hal.backend import PartCommand
from fairlead.messages import ActionPart, GateState, Lease, pack_floats
from fairlead.robot.manifest import RobotManifest

Rows = Sequence[Mapping[str, PartCommand]]


@dataclass(frozen=True)
class Released:
    """A chunk that was sent: row k is for tick ``first + k``."""

    verdict: int
    first: int
    horizon: int
    sent_ns: int

    @property
    def end(self) -> int:
        """The first tick without a row."""
        return self.first + self.horizon


@dataclass
class Plan:
    """What the leases say. shape: changes each before it is sent; None as its result: not sent.

    waits: nothing is granted before rows are released, so that a world in lockstep stays.
    """

    epoch: int = 0
    seq: int = 0
    state: GateState = GateState.DISARMED
    claims: dict[int, int] = field(default_factory=dict)  # id: last tick granted
    stop_ids: tuple[int, ...] = ()
    waits: bool = False
    shape: Callable[[Lease], Lease | None] | None = None
    released: dict[int, list[Released]] = field(default_factory=dict)


def action_parts(robot: RobotManifest, rows: Rows) -> tuple[ActionPart, ...]:
    """Rows of the same parts and modes, as they go into a chunk."""
    found = []
    for name, command in rows[0].items():
        values = b"".join(pack_floats(row[name].values) for row in rows)
        found.append(
            ActionPart(
                part=robot.part_names.index(name),
                mode=int(command.mode),
                frame_id=command.frame_id,
                values=values,
                active=command.active,
            )
        )
    return tuple(sorted(found, key=lambda one: one.part))
