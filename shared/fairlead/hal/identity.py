"""Which HAL this is: its robot, how it is deployed, and that it is the only one."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
import socket
import struct
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import BackendDescription, CommandCheck, Measurement
from fairlead.hal.core import Pacing
from fairlead.keys import Keys, last_chunk
from fairlead.messages import NO_HASH, FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config, source_digests
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Bus


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


LOOK_S = 0.7
"""Longer than a Zenoh session waits between two attempts to connect (0.5 s)."""
GO_S = 4.0
"""What a HAL that started at the same moment, or died with its host, gets to be gone."""
_PEER = struct.Struct("3i")  # process, user, group


def lock_state_folder(service: str, folder: Path) -> TextIO:
    """Hold a folder for this process; the lock ends with the process, however it ends.

    Raises:
        ConfigError: if another process holds it.
    """
    path = folder / "hal.lock"
    file = path.open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise ConfigError(
            f"{service}: another HAL still uses {folder}; see: fairlead ps, then: fairlead down"
        ) from None
    return file


def hold_robot(service: str, keys: Keys) -> socket.socket:
    """Hold a robot's id for this process, among this user's processes on this host.

    A HAL is found so even if it is paused and no link to it can form. The name is an abstract
    Unix socket's: the kernel frees it when the process ends, however it ends.

    Raises:
        ConfigError: naming the process that holds it, or why nobody can.
    """
    who = f"{os.getuid()}/{keys.namespace}/{keys.robot}"
    name = f"\0fairlead-hal/{hashlib.sha256(who.encode()).hexdigest()}"
    held = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        held.bind(name)
    except OSError as error:
        held.close()
        if error.errno == errno.EADDRINUSE:
            process, user = _holder(name)
            if user != os.getuid():
                raise ConfigError(
                    f"{service}: robot {keys.robot} cannot be held for this process: process "
                    f"{process} of another user (uid {user}) has taken its name; ask its owner, or "
                    "give this robot another `id`"
                ) from None
            raise _second_hal(service, keys, f"process {process}") from None
        raise ConfigError(
            f"{service}: robot {keys.robot} cannot be held for this process: {error}"
        ) from None
    held.listen()
    return held


def _holder(name: str) -> tuple[str, int]:
    """Process and user who listen behind a Unix socket's name; they need not answer."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asking:
        asking.setblocking(False)
        try:
            asking.connect(name)
        except OSError:  # it has just ended, or just begun
            return "unknown", os.getuid()
        found = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size)
        process, user, _ = _PEER.unpack(found)
        return str(process), int(user)


def _second_hal(service: str, keys: Keys, other: str) -> ConfigError:
    return ConfigError(
        f"{service}: robot {keys.robot} already has a HAL ({other}, which may still start or be "
        "paused); see: fairlead ps, then: fairlead down"
    )


def refuse_second_hal(service: str, bus: Bus, keys: Keys, session: int) -> None:
    """Announce this HAL, then look for others of the robot that its Zenoh session can reach.

    Whether they answer does not matter: one that is busy or still starts counts. Of several that
    start together the one with the smallest session goes on, once the others have ended.

    Raises:
        ConfigError: naming the session of another HAL.
    """
    own, others, changed = keys.hal_session(session), set[str](), threading.Condition()

    def on_token(key: str, alive: bool) -> None:
        with changed:
            (others.add if alive and key != own else others.discard)(key)
            changed.notify_all()

    def comes_first() -> bool:
        return min(others, default=own) < own

    token = bus.declare_token(own)
    watch = bus.watch_tokens(keys.every_hal_session, on_token)
    with changed:
        changed.wait_for(comes_first, LOOK_S)
        changed.wait_for(lambda: not others or comes_first(), GO_S)
        found = sorted(others)
    watch.undeclare()
    if found:
        token.undeclare()
        raise _second_hal(service, keys, f"session {last_chunk(found[0])}")
