"""The HAL contract: what a simulator or a robot driver must provide, and nothing more.

The host in this package owns the keys, the tick, the execution guard and the hold
decision; a backend reads, applies one set of commands per tick, and describes itself.
It never sees a key, a chunk, a lease or a clock.

What only some robots have stands below it: cameras, a trace, frames of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, FairleadError, expected
from fairlead.messages import FloatArray, HalCamera, HalPart, Image, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.command_ranges import command_range
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part


@dataclass(frozen=True)
class Measurement:
    """Joint state at the start of a period, commanded joints then passive ones.

    positions [rad or m], velocities [rad/s or m/s], efforts [N m or N]: shape ``[n]``.
    """

    positions: FloatArray
    velocities: FloatArray
    efforts: FloatArray


@dataclass(frozen=True)
class FramePose:
    """T_parent_child: translation xyz [m], rotation as a quaternion xyzw."""

    parent: str
    child: str
    translation: FloatArray
    rotation_xyzw: FloatArray


@dataclass(frozen=True)
class TaskReading:
    """A simulator's own success check and the metrics behind it (SI)."""

    success: bool
    metrics: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class PartCommand:
    """One row of one part, SI: ``values`` has the mode's width.

    active: joint modes only, indices into the robot's commanded joints; every other
    entry of ``values`` is exactly 0.0 and must be ignored.
    """

    mode: ControlMode
    frame_id: str
    values: FloatArray
    active: tuple[int, ...]


class NotCarriedOutError(FairleadError):
    """A driver could not tell its robot this tick's rows, as where a bus lost a packet.

    From `Backend.apply`, having told nothing: no fault, the tick counts as held.
    """


@dataclass(frozen=True)
class BackendDescription:
    """What the backend found when it looked at its robot (introspected, not assumed).

    interpolation: how it goes from row to row; the gate's file is made for robot.yaml's.
    """

    joints: tuple[str, ...]
    passive_joints: tuple[str, ...]
    parts: tuple[HalPart, ...]
    simulator_order: tuple[str, ...]
    cameras: tuple[HalCamera, ...]
    has_task: bool
    interpolation: Interpolation = "linear"


class Backend(Protocol):
    """One robot or simulator. Called from one thread only.

    On hardware the driver, or better the robot's own controller, needs a watchdog: without
    an ``apply`` for a few periods (this process stopped, killed or stuck in a call) it must
    brake and hold by itself, for nothing else can then.
    """

    def describe(self) -> BackendDescription:
        """What was found on the robot: joints, parts, command ranges, cameras. Called once."""

    def read(self) -> Measurement:
        """Measure every joint, commanded ones in wire order, then passive ones.

        With the URDF's signs and zeros; positions of a ``continuous`` joint count its turns. To
        raise if a joint was not measured: that is a fault.
        """

    def transforms(self) -> Sequence[FramePose]:
        """Measured transforms only this HAL can know (``odom -> base_link``, objects)."""

    def static_transforms(self) -> Sequence[FramePose]:
        """Transforms that never change in this episode (``map -> odom``)."""

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """Act for one period: exactly one bus write or simulator step.

        The gate judges the tool of a cartesian row, not the joints that move it: keeping each
        of them within its speed and position limits is up to this method.

        Args:
            commands: by part name. A part that is absent holds by its declared hold law.

        Raises:
            ConfigError: for a value the part cannot carry out (a twist beyond what the base
                reaches), before any part was commanded. The host, which has checked part, mode,
                width, joints, frame and that values are finite, then calls ``apply({})`` for this
                period, so that every part holds, records the tick as held, and raises a stop that
                an operator has to reset; ticks go on.
            NotCarriedOutError: the robot could not be told, and goes on with what it was told
                before; the tick is recorded as held, and the rows after it are judged anew.
                Any other exception is a fault: no more ticks until the process is started
                again, a stop, and ``apply({})`` once a period for as long as it runs.
        """

    def task(self) -> TaskReading | None:
        """The simulator's success check; None where there is no task."""

    def reset(self, seed: int) -> None:
        """Start a new simulated episode.

        Raises:
            ConfigError: on hardware, which has no episodes.
        """

    def snapshot(self) -> bytes:
        """State from which the camera process can render; b"" without cameras."""

    def close(self) -> None:
        """Let go of the robot or simulator; nothing is called afterwards."""


class CameraFeed(Protocol):
    """Renders snapshots of the backend somewhere else (a process, a device)."""

    @property
    def failure(self) -> str:
        """Why there will be no more frames; "" while all is well."""

    def request(self, session: int, tick: int, cameras: Sequence[str], snapshot: bytes) -> bool:
        """Ask for frames of ``tick``. False if the feed is still busy and will not."""

    def take(self, timeout_s: float) -> Image | None:
        """The next finished frame; None if there is none in time, or no feed any more."""

    def close(self) -> None:
        """End the renderer; frames still under way are lost."""


class FrameModel(Protocol):
    """The robot's own model: a simulator's, or that of an arm's controller.

    The host compares it with the description before the first tick.
    """

    def frame_poses(self, positions: FloatArray | None) -> Sequence[FramePose]:
        """T_base_frame of every frame it knows under the description's name.

        Args:
            positions: of the measured joints in wire order, shape ``[n]`` [rad or m]; None: where
                the robot stands now.

        Returns:
            Poses in the robot's ``base_frame``. Nothing for positions it cannot answer for: an
            arm's controller knows its tool's pose only where the arm is.
        """


@runtime_checkable
class ContactModel(Protocol):
    """A backend that knows what its robot touches: a simulator's."""

    def contacts(self) -> Sequence[str]:
        """Each thing of the robot that touches something, in words; [] if nothing does.

        Now, or at any moment since it was last asked or the episode began.
        """


class TraceSource(Protocol):
    """A view into the simulator behind a backend; read in the tick loop's thread."""

    def packed(self) -> npt.NDArray[np.float32]:
        """Copy of the vector given to the simulator's last step."""

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """Copies of the simulator's qpos and qvel now."""


def describe_part(robot: RobotManifest, part: Part, profile: str) -> HalPart:
    """The part with the limits of a safety profile as its command ranges."""
    limits = robot.profile(profile).parts[part.name]
    ranges = []
    for mode in part.control_modes:
        lower, upper = command_range(robot, part, mode, limits)
        ranges.append(ModeRange(mode=mode, lower=pack_floats(lower), upper=pack_floats(upper)))
    return HalPart(
        name=part.name,
        simulator_part=part.simulator_part,
        joints=part.joints,
        ranges=tuple(ranges),
    )


QUATERNION_TOLERANCE = 1e-6
"""How far a pose's quaternion may be from length 1; the gate's bound as well."""


class CommandCheck:
    """Part, mode, width, joints, frame and the values with a form of their own.

    Args:
        robot: its manifest.
        profile: safety profile that declares the frames of cartesian modes.
    """

    def __init__(self, robot: RobotManifest, profile: str) -> None:
        self._robot = robot
        limits = robot.profile(profile).parts
        self._frames: dict[tuple[str, ControlMode], tuple[str, ...]] = {  # a profile has all modes
            (part.name, mode): getattr(limits[part.name], mode.yaml_name).frames
            for part in robot.parts
            for mode in part.control_modes
            if mode.is_tool_mode
        }
        number = {name: index for index, name in enumerate(robot.joint_names)}
        self._joints = {part.name: [number[joint] for joint in part.joints] for part in robot.parts}

    def check(self, name: str, command: PartCommand) -> None:
        """Raises `ConfigError` with what was expected and what came.

        Args:
            name: of the part.
        """
        part, mode = self._robot.part(name), command.mode
        who = f"hal: part {name}"
        if mode not in part.control_modes:
            raise ConfigError(expected(who, "a mode", mode.yaml_name, part.modes))
        width = mode.width(self._robot.n_dof)
        if command.values.shape != (width,):
            what = f"{width} value(s) of {mode.yaml_name}"
            raise ConfigError(expected(who, what, f"shape {list(command.values.shape)}"))
        if not np.isfinite(command.values).all():
            raise ConfigError(expected(who, "finite values", command.values.tolist()))
        own = self._joints[name]
        if not set(command.active).issubset(own):
            what = f"active joints out of {own}"
            raise ConfigError(expected(who, what, list(command.active)))
        if mode.is_tool_mode:
            frames = self._frames[name, mode]
            if command.frame_id not in frames:
                what = f"a frame of {mode.yaml_name}"
                raise ConfigError(expected(who, what, repr(command.frame_id), frames))
        _check_values(who, command)


def _check_values(who: str, command: PartCommand) -> None:
    if command.mode is ControlMode.CARTESIAN_POSE:
        length = float(np.linalg.norm(command.values[3:]))
        if abs(length - 1.0) > QUATERNION_TOLERANCE:
            raise ConfigError(expected(who, "a quaternion of length 1", f"length {length:g}"))
    if command.mode is ControlMode.GRIPPER_BINARY and command.values[0] not in (0.0, 1.0):
        raise ConfigError(expected(who, "0 (open) or 1 (closed)", command.values[0]))
