"""Whether the servos of a model follow as fast as robot.yaml lets joints be told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits
from fairlead_tools.draft.joints import gravity_efforts, gravity_sags, servo_lag_s
from fairlead_tools.draft.source_model import load_source
from fairlead_tools.shape.robot_model import RobotModel

_PROFILE = "sim"


def servo_findings(robot: RobotManifest, model: RobotModel) -> Iterator[tuple[str, str]]:
    """Of each joint that is told targets what comes of its load and its servo's lag; the fix."""
    source = load_source(Path(model.name))
    sags, safety = gravity_sags(source), robot.profile(_PROFILE)
    efforts = gravity_efforts(source)
    for part in robot.parts:
        told = safety.parts[part.name].joint_position
        for index, name in enumerate(part.joints if told is not None else ()):
            number = source.model.joint(robot.simulator_joints(name)[0]).id
            joint, measured = robot.joint(name), safety.measured[name]
            assert told is not None, "no joint is looked at else"
            if measured.contact_limit is not None and efforts[number] > measured.contact_limit:
                unit = "N m" if joint.unit == "rad" else "N"
                needs = f"{name}: gravity and friction take up to {efforts[number]:.3g} {unit}"
                most = f"contact_limit {measured.contact_limit:g}"
                yield needs, f"G042 stops it ({most}): correct its effort and that limit"
            step = told.step_limits[index]
            speed = min(profile_limits(joint, safety)[0], step / (robot.tick_period_ns * 1e-9))
            lag_s, sag = servo_lag_s(source, number), sags.get(number, 0.0)
            lag = speed * lag_s + sag
            tracking = told.tracking_limits[index]
            if lag > tracking:
                yield (
                    _late(joint, speed, lag),
                    (
                        f"G040 stops it (tracking_limits {tracking:g}): stiffer servos, or a lower "
                        "velocity in tighter_joints"
                    ),
                )
            elif joint.has_bounds and lag > (measured.tolerance or 0.0):
                follows = max(0.0, (measured.tolerance or 0.0) - sag) / max(lag_s, 1e-9)
                yield (
                    _late(joint, speed, lag),
                    (
                        "G021 refuses a new chunk in the midst of such a motion: stay below "
                        f"{follows:.3g} {joint.unit}/s, or measure again and raise tolerance"
                    ),
                )


def _late(joint: Joint, speed: float, lag: float) -> str:
    unit = joint.unit
    return f"{joint.name}: at {speed:.3g} {unit}/s its servo is {lag:.3g} {unit} behind"
