"""A robot's messages as its HAL would send them, at made-up joint positions."""

from __future__ import annotations

import numpy as np

from fairlead.messages import (
    HELD,
    NO_HASH,
    JointState,
    LayoutState,
    Lease,
    Transform,
    TransformBatch,
    decode,
    pack_floats,
)
from fairlead.robot.manifest import RobotManifest
from fairlead_state_assembler.core import Output

SKILL = "oracle-counter-to-cabinet"


class RobotFeed:
    """Joint states and transform batches of one session."""

    def __init__(self, robot: RobotManifest, session: int = 11) -> None:
        self.robot = robot
        self.session = session
        self.episode_tick = 1

    def positions(self, tick: int) -> list[float]:
        """Every measured joint a little further each tick."""
        return [
            0.01 * index + 0.001 * tick for index in range(len(self.robot.measured_joint_names))
        ]

    def joints(self, tick: int) -> JointState:
        positions = self.positions(tick)
        still = pack_floats(np.zeros(len(positions)))
        return JointState(
            session=self.session,
            tick=tick,
            episode_tick=self.episode_tick,
            stamp_ns=0,
            positions=pack_floats(positions),
            velocities=still,
            efforts=still,
            acted=(HELD,) * len(self.robot.parts),
            robot_hash=self.robot.robot_hash,
        )

    def moving(self, tick: int, *children: str) -> TransformBatch:
        """``odom -> child`` for base_link, object and goal, or only those named."""
        links = children or ("base_link", "object", "goal")
        return self._batch(tick, False, [("odom", child, 0.1 * tick) for child in links])

    def lease(self, state_tick: int = 1) -> Lease:
        """What a gate that follows this session and permits nothing says."""
        return Lease(
            session=self.session,
            epoch=1,
            lease_seq=1,
            config_hash=NO_HASH,
            state=0,
            state_tick=state_tick,
            grants=(),
            stop_ids=(),
        )

    def looped(self, tick: int) -> TransformBatch:
        """``odom -> base_link``; object and goal hang on each other."""
        links = [("odom", "base_link"), ("goal", "object"), ("object", "goal")]
        return self._batch(tick, False, [(parent, child, 0.1 * tick) for parent, child in links])

    def static(self, tick: int) -> TransformBatch:
        """``map -> odom``."""
        return self._batch(tick, True, [("map", "odom", 2.0)])

    def _batch(
        self, tick: int, is_static: bool, links: list[tuple[str, str, float]]
    ) -> TransformBatch:
        return TransformBatch(
            session=self.session,
            tick=tick,
            is_static=is_static,
            transforms=tuple(
                Transform(
                    parent=parent,
                    child=child,
                    translation=pack_floats([x, 0.5, 0.0]),
                    rotation_xyzw=pack_floats([0.0, 0.0, 0.6, 0.8]),
                )
                for parent, child, x in links
            ),
        )


def layouts(outputs: list[Output]) -> list[LayoutState]:
    """The oracle's state vectors among what the assembler puts out."""
    return [decode(LayoutState, item.payload) for item in outputs if item.skill == SKILL]
