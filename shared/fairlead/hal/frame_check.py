"""Whether a robot's description (URDF) and a model of it agree on where its frames are.

The gate, the capsules and the state vector all go by the description. Where that is wrong, so is
everything they decide, and nothing else would notice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fairlead.errors import ConfigError
from fairlead.hal.backend import FrameModel, FramePose
from fairlead.messages import FloatArray
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import Poses, link_poses, random_positions
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import FrameTolerance

RANDOM = 20
"""Configurations compared beside the one that the robot stands in."""


@dataclass(frozen=True)
class FrameError:
    """How far one frame is off in one configuration, by number: 0 is where the robot stands."""

    frame: str
    configuration: int
    distance_m: float
    angle_rad: float


def check_frames(
    robot: RobotManifest, model: FrameModel, here: FloatArray, who: str, *, stands: str
) -> str:
    """Compare where the robot stands, and at random positions within its limits.

    Args:
        here: positions of the measured joints where the robot stands, in wire order.
        who: what complains: a command, a HAL.
        stands: what the robot's own configuration is called, such as ``key home``.

    Returns:
        What was compared and how well it agrees, in words.

    Raises:
        ConfigError: naming each frame that is off, by how much and in which configuration.
    """
    errors, rows = frame_errors(robot, model, here, who)
    allowed = FrameTolerance() if robot.simulator is None else robot.simulator.frame_tolerance
    worst = _worst(errors, allowed)
    wrong = [one for one in worst if _in_tolerances(one, allowed) > 1.0]
    if wrong:
        raise ConfigError("\n".join(_complaint(robot, wrong, rows, allowed, who, stands)))
    everywhere = any(one.configuration for one in errors)
    compared = f"{stands} and at {RANDOM} random configurations" if everywhere else stands
    distance, angle = (
        max((getattr(one, name) for one in errors), default=0.0)
        for name in ("distance_m", "angle_rad")
    )
    return (
        f"{len(worst)} frames are where {robot.description} has them, at {compared}: within "
        f"{distance * 1e3:.3g} mm, {angle:.2g} rad"
    )


def frame_errors(
    robot: RobotManifest, model: FrameModel, here: FloatArray, who: str
) -> tuple[list[FrameError], list[FloatArray]]:
    """How far each frame is off in each configuration, and those configurations.

    Raises:
        ConfigError: the model tells the pose of something that is no link.
    """
    tree = description_tree(robot)
    columns = random_positions(robot, tree, RANDOM)
    rows = [here, *_rows(robot, here, columns)]
    expected_at = link_poses(tree, _columns(robot, rows, list(columns)))
    found = [model.frame_poses(None if number == 0 else row) for number, row in enumerate(rows)]
    errors = [
        _error(robot, pose, expected_at, number, who)
        for number, poses in enumerate(found)
        for pose in poses
    ]
    return errors, rows


def _rows(
    robot: RobotManifest, here: FloatArray, columns: dict[str, FloatArray]
) -> Iterator[FloatArray]:
    for sample in range(RANDOM):
        row = here.copy()
        for name, values in columns.items():
            row[robot.measured_joint_names.index(name)] = values[sample]
        yield row


def _columns(
    robot: RobotManifest, rows: Sequence[FloatArray], names: Sequence[str]
) -> dict[str, FloatArray]:
    table = np.stack(rows)
    return {name: table[:, robot.measured_joint_names.index(name)] for name in names}


def _error(
    robot: RobotManifest, pose: FramePose, expected_at: dict[str, Poses], number: int, who: str
) -> FrameError:
    if pose.parent != robot.base_frame or pose.child not in expected_at:
        raise ConfigError(
            f"{who}: expected the pose of a link of {robot.description} in {robot.base_frame}, got "
            f"{pose.child!r} in {pose.parent!r} (valid: {', '.join(expected_at)})"
        )
    described = expected_at[pose.child]
    index = min(number, len(described.translation) - 1)  # a description without joints has one
    off = described.rotation[index].T @ _matrix(pose.rotation_xyzw)
    # Of a rotation by `angle` the distance from none is 2 sqrt(2) sin(angle / 2).
    share = float(np.linalg.norm(off - np.eye(3))) / np.sqrt(8.0)
    angle_rad = 2.0 * float(np.arcsin(min(1.0, share)))
    distance_m = float(np.linalg.norm(pose.translation - described.translation[index]))
    if not np.isfinite(distance_m + angle_rad):
        distance_m = angle_rad = np.inf
    return FrameError(pose.child, number, distance_m, angle_rad)


def _matrix(xyzw: FloatArray) -> FloatArray:
    x, y, z, w = xyzw / np.linalg.norm(xyzw)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * w * across + 2.0 * across @ across)


def _in_tolerances(error: FrameError, allowed: FrameTolerance) -> float:
    return max(error.distance_m / allowed.distance_m, error.angle_rad / allowed.angle_rad)


def _worst(errors: Sequence[FrameError], allowed: FrameTolerance) -> list[FrameError]:
    """The worst configuration of each frame, frames in the order of the model."""
    worst: dict[str, FrameError] = {}
    for error in errors:
        known = worst.setdefault(error.frame, error)
        if _in_tolerances(error, allowed) > _in_tolerances(known, allowed):
            worst[error.frame] = error
    return list(worst.values())


def _complaint(
    robot: RobotManifest,
    wrong: Sequence[FrameError],
    rows: Sequence[FloatArray],
    allowed: FrameTolerance,
    who: str,
    stands: str,
) -> Iterator[str]:
    yield (
        f"{who}: expected each frame where {robot.description} has it, within "
        f"{allowed.distance_m * 1e3:g} mm and {allowed.angle_rad:g} rad, got"
    )
    for one in wrong:
        at = f"random configuration {one.configuration}" if one.configuration else stands
        yield (
            f"  frame {one.frame}: {one.distance_m * 1e3:.4g} mm and {one.angle_rad:.4g} rad off "
            f"at {at}"
        )
    for number in sorted({one.configuration for one in wrong}):
        at = f"random configuration {number}" if number else stands
        named = zip(robot.measured_joint_names, rows[number], strict=True)
        yield f"  {at}: " + ", ".join(f"{name} {value:.4f}" for name, value in named)
    yield (
        f"correct {robot.description}, or what simulator.joints and simulator.frames in robot.yaml "
        "take for the same"
    )
