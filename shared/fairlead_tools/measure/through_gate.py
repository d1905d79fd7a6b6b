"""A robot that runs, driven through its gate: nothing moves that the gate did not release."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fairlead.errors import ChunkRefusedError, ConfigError, expected
from fairlead.hal.backend import BackendDescription, FramePose, Measurement, PartCommand
from fairlead.messages import ActionPart, floats, pack_floats
from fairlead.operate.blocking import BlockingClaim
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import RobotManifest

STILL_TICKS = 3
ROWS = 2
"""Each row is sent twice: where the next one comes late, it goes on for a tick."""


class ThroughGate:
    """Implements `fairlead.hal.backend.Backend` on a claim of all parts; realtime only.

    Attributes:
        refused: chunks that the gate refused: the robot held instead.

    Raises:
        ConfigError: the robot runs in lockstep.
    """

    def __init__(self, client: RobotClient, robot: RobotManifest, claim: BlockingClaim) -> None:
        self._robot, self._claim, self._hal = robot, claim, client.hal_status()
        if self._hal.pacing != "realtime":
            who = f"robot measure: deployment {client.deployment.id}"
            raise ConfigError(expected(who, "pacing realtime", self._hal.pacing))
        profile = robot.profile(client.deployment.profile)
        self._rest_ticks = -(-profile.protocol.stop_ramp_ms * 1_000_000 // robot.tick_period_ns)
        measured = [profile.measured[name] for name in robot.measured_joint_names]
        self._standstill = np.array([one.standstill_per_s for one in measured])
        self.refused = 0
        self._tick = claim.next_tick()

    def describe(self) -> BackendDescription:
        """What the running HAL said at its start."""
        robot, parts = self._robot, tuple(self._hal.parts)
        return BackendDescription(
            robot.joint_names, robot.passive_joint_names, parts, (), (), has_task=False
        )

    def read(self) -> Measurement:
        """The newest joint state."""
        state = self._tick.joints
        return Measurement(*(floats(x) for x in (state.positions, state.velocities, state.efforts)))

    def transforms(self) -> Sequence[FramePose]:
        """``odom`` to the base frame, as the HAL sent it."""
        base = self._robot.base_frame
        found = self._tick.transforms["odom", base]
        where, turned = floats(found.translation), floats(found.rotation_xyzw)
        return [FramePose("odom", base, where, turned)]

    def static_transforms(self) -> Sequence[FramePose]:
        """Nobody asks for them."""
        return []

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """Propose a row, and wait for the next tick."""
        parts = [self._part(name, command) for name, command in commands.items()]
        if parts:
            try:
                self._claim.send(self._tick.number, *parts)
            except ChunkRefusedError:
                self.refused += 1
        self._tick = self._claim.next_tick()

    def _part(self, name: str, command: PartCommand) -> ActionPart:
        return ActionPart(
            part=self._robot.part_names.index(name),
            mode=int(command.mode),
            frame_id=command.frame_id,
            values=pack_floats(np.tile(command.values, (ROWS, 1))),
            active=tuple(command.active),
        )

    def task(self) -> None:
        """None."""

    def reset(self, seed: int) -> None:
        """A robot has no episodes: it comes to rest where it is."""
        still = 0
        for _ in range(self._rest_ticks):
            self.apply({})
            still = still + 1 if np.all(np.abs(self.read().velocities) < self._standstill) else 0
            if still == STILL_TICKS:
                return

    def snapshot(self) -> bytes:
        """Nothing to render."""
        return b""

    def close(self) -> None:
        """The claim ends by its own block."""
