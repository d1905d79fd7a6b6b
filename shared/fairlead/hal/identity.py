"""What the HAL host has to know about its robot, however the manifest is written."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import BackendDescription, Measurement
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest


@dataclass(frozen=True)
class HalIdentity:
    """Facts of one robot that the host publishes or decides by.

    standstill_velocity: rad/s or m/s per measured joint (commanded, then passive).
    """

    robot: str
    robot_hash: bytes
    period_ns: int
    joints: tuple[str, ...]
    passive_joints: tuple[str, ...]
    parts: tuple[str, ...]
    standstill_velocity: FloatArray

    def is_still(self, now: Measurement, before: Measurement | None) -> bool:
        """Whether every joint is slower than its standstill velocity, by velocity and position.

        before: measured a tick earlier; None in an episode's first, where velocities decide.
        """
        speeds = np.abs(now.velocities)
        if before is not None:
            moved = np.abs(now.positions - before.positions)
            speeds = np.maximum(speeds, moved / (self.period_ns * 1e-9))
        return bool(np.all(speeds < self.standstill_velocity))

    def check(self, found: BackendDescription) -> None:
        """Compare with what the backend found.

        Raises:
            ConfigError: naming the first list that differs, with both.
        """
        found_parts = tuple(part.name for part in found.parts)
        for what, declared, got in (
            ("joints", self.joints, found.joints),
            ("passive joints", self.passive_joints, found.passive_joints),
            ("parts", self.parts, found_parts),
        ):
            if declared != got:
                raise ConfigError(
                    expected(f"hal of {self.robot}", f"{what} {list(declared)}", list(got))
                )


def identity_of(manifest: RobotManifest, profile: str, robot: str) -> HalIdentity:
    """The identity of a robot by its manifest.

    Args:
        profile: safety profile whose standstill velocities count.
        robot: the robot's id on the network.

    Raises:
        ConfigError: if the profile does not exist.
    """
    measured = manifest.profile(profile).measured
    return HalIdentity(
        robot=robot,
        robot_hash=manifest.robot_hash,
        period_ns=manifest.tick_period_ns,
        joints=manifest.joint_names,
        passive_joints=manifest.passive_joint_names,
        parts=manifest.part_names,
        standstill_velocity=np.array(
            [measured[name].standstill_per_s for name in manifest.measured_joint_names]
        ),
    )
