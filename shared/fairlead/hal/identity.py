"""Which HAL this is: its robot, and how it is deployed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import Backend, BackendDescription, CommandCheck, Measurement
from fairlead.hal.core import Pacing
from fairlead.keys import Keys
from fairlead.messages import NO_HASH, FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config, source_digests
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.manifest import RobotManifest


@dataclass(frozen=True)
class HalIdentity:
    """Facts of one robot that the host publishes or decides by.

    standstill_velocity: rad/s or m/s per measured joint (commanded, then passive).
    commands: checks what a part is told.
    interpolation: between rows.
    limits: of `gate_limits`.
    """

    robot: str
    robot_hash: bytes
    period_ns: int
    joints: tuple[str, ...]
    passive_joints: tuple[str, ...]
    parts: tuple[str, ...]
    standstill_velocity: FloatArray
    commands: CommandCheck
    interpolation: Interpolation = "linear"
    limits: bytes = b""

    def measure(self, backend: Backend) -> Measurement:
        """Raises `ConfigError` where a backend did not measure an array of all joints."""
        measured, wanted = backend.read(), len(self.standstill_velocity)
        for what in ("positions", "velocities", "efforts"):
            value = getattr(measured, what)
            is_array = isinstance(value, np.ndarray)
            if not is_array or value.shape != (wanted,):
                joints = f"{what} as an array of {wanted} joints, commanded ones first"
                got = f"shape {list(value.shape)}" if is_array else type(value).__name__
                raise ConfigError(expected("read()", joints, got))
        return measured

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
        if self.interpolation != found.interpolation:
            wanted = f"interpolation {self.interpolation} as in robot.yaml"
            raise ConfigError(expected(f"hal of {self.robot}", wanted, found.interpolation))


def identity_of(manifest: RobotManifest, profile: str, robot: str) -> HalIdentity:
    """The identity of a robot by its manifest.

    Args:
        profile: safety profile whose standstill velocities and frames count.
        robot: the robot's id on the network.

    Raises:
        ConfigError: if the profile does not exist; as `gate_limits`.
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
        commands=CommandCheck(manifest, profile),
        interpolation=manifest.interpolation,
        limits=gate_limits(manifest, profile),
    )


def gate_limits(manifest: RobotManifest, profile: str) -> bytes:
    """Hash of the gate file that has the limits by which this HAL moves, as leases name it.

    Without the file here, of what it would be if it were compiled here; `NO_HASH`, which no gate
    has, if it could not be.

    Raises:
        ConfigError: it was made of other files than today's.
    """
    path = robot_dir(manifest.id) / f"gate.{profile}.json"
    if not path.is_file():
        try:
            return hashlib.sha256(compile_gate_config(manifest, profile).encode()).digest()
        except ConfigError:
            return NO_HASH
    try:
        content = path.read_bytes()
        made_of = json.loads(content)["compiled_from"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"hal of {manifest.id}: {path}: cannot be read: {error}") from None
    if made_of != source_digests(manifest):
        raise ConfigError(
            f"hal of {manifest.id}: {path.name} was made of other files than today's, so the gate "
            f"would judge by other limits; first: fairlead robot compile {manifest.id}"
        )
    return hashlib.sha256(content).digest()


@dataclass(frozen=True)
class HostSettings:
    """What every piece of the host has to know.

    service: its name in the deployment file, in keys and in log lines.
    session: a random number that is this run of the HAL.
    localiser: who says where ``odom`` is in ``map``; "" for this HAL.
    """

    service: str
    keys: Keys
    pacing: Pacing
    session: int
    localiser: str = ""

    @property
    def lockstep(self) -> bool:
        """Whether the world waits for the decision on its tick."""
        return self.pacing == "lockstep"
