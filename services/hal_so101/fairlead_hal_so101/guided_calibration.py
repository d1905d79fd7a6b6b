"""Calibration: a person moves each joint by hand to both ends of its range."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.robot.description import description_tree
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.tool_chain import ToolChain
from fairlead_hal_so101.calibration import (
    STEPS_PER_RAD,
    ZERO_STEPS,
    Arm,
    CalibratedServo,
    Calibration,
    calibration_path,
    save_calibration,
)
from fairlead_hal_so101.servo_bus import ServoBus

TURN = 4096
RANGE_TOLERANCE_RAD = 0.15
"""A range that differs by more from the robot's was not moved from end to end."""
_LEAST_WAY_M = 0.02
"""Per radian: a joint that moves the tool by less turns it."""
_TIMEOUT_S = 0.05


def calibrate(
    robot: RobotManifest, port: str, name: str, say: Callable[[str], None],
    pressed: Callable[[], bool], arm: Arm = "follower",
) -> Path:  # fmt: skip
    """Ask a person to move every joint, write servos and file.

    Args:
        robot: its joints, in order, have the servos 1, 2, ...
        name: of the calibration, or a path to its file.
        say: tells the person what to do.
        pressed: waits for a moment; whether the person has done it.
        arm: a leader's trigger has a way of its own, where the robot has its jaw.

    Returns:
        The file.

    Raises:
        ConfigError: the port or the servos are not those of the robot; a joint was not moved from
            end to end.
        HardwareError: a servo does not answer.
    """
    joints = dict(enumerate(robot.joints, start=1))
    bus = ServoBus(
        port, {one: joint.name for one, joint in joints.items()}, _TIMEOUT_S, "calibrate"
    )
    try:
        bus.check_servos()
        say("the arm goes limp: hold it")
        for servo_id in joints:
            _let_go(bus, servo_id)
        free = {tool.gripper_joint for tool in robot.end_effectors if arm == "leader"}
        found = [
            _calibrated(bus, one, robot, joint, say, pressed, joint.name in free)
            for one, joint in joints.items()
        ]
        calibration = Calibration(robot=robot.id, arm=arm, servos=tuple(found))
        path = calibration_path(name)
        save_calibration(path, calibration)
        for servo in found:
            _store(bus, servo)
    finally:
        bus.close()
    return path


def end_words(robot: RobotManifest, joint: Joint) -> tuple[str, str]:
    """Which way a joint's lower and its upper end are, for who stands behind the arm at home."""
    tool = next(one for one in robot.end_effectors if one.gripper_joint)
    if joint.name == tool.gripper_joint:
        return "the jaw closed", "the jaw open"
    chain = ToolChain(description_tree(robot), tool.tool_frame)
    home = {one.name: (one.lower + one.upper) / 2 for one in robot.joints}
    home |= robot.home.positions if robot.home else {}
    along = chain.jacobian(home, [joint.name])[:, 0]
    if np.linalg.norm(along[:3]) < _LEAST_WAY_M:
        ways = ("the tool turned anticlockwise, seen from behind", "the tool turned clockwise")
        return ways if along[3] > 0 else (ways[1], ways[0])
    axis = int(np.argmax(np.abs(along[:3])))
    ways = (("back", "ahead"), ("to the right", "to the left"), ("down", "up"))[axis]
    lower, upper = ways if along[axis] > 0 else (ways[1], ways[0])
    return f"the tool goes {lower}", f"the tool goes {upper}"


def _let_go(bus: ServoBus, servo_id: int) -> None:
    """Limp, and counting from 0 to 4095 as its encoder does."""
    for register, value in (
        ("torque_enable", 0),
        ("lock", 0),
        ("operating_mode", 0),
        ("homing_offset", 0),
        ("min_position_limit", 0),
        ("max_position_limit", TURN - 1),
    ):
        bus.put(servo_id, register, value)


def _calibrated(
    bus: ServoBus, servo_id: int, robot: RobotManifest, joint: Joint, say: Callable[[str], None],
    pressed: Callable[[], bool], has_own_way: bool,
) -> CalibratedServo:  # fmt: skip
    """Follow one joint from its lower to its upper end."""
    steps = bus.get(servo_id, "present_position")
    ends, words = [], end_words(robot, joint)
    told = zip(("lower", "upper"), (joint.lower, joint.upper), words, strict=True)
    for end, position_rad, where in told:
        say(
            f"{joint.name}: move it to its {end} end ({position_rad:+.2f} rad): {where}; then Enter"
        )
        while not pressed():
            steps += _turned(bus.get(servo_id, "present_position") - steps)
        steps += _turned(bus.get(servo_id, "present_position") - steps)
        ends.append(steps)
    lower, upper = ends
    span_rad, wanted_rad = abs(upper - lower) / STEPS_PER_RAD, joint.upper - joint.lower
    is_whole, what = abs(span_rad - wanted_rad) <= RANGE_TOLERANCE_RAD, f"{wanted_rad:.2f} rad"
    if has_own_way:
        is_whole, what = span_rad >= RANGE_TOLERANCE_RAD, f"{RANGE_TOLERANCE_RAD} rad or more"
    if not is_whole:
        what = f"a way of {what} from end to end"
        raise ConfigError(expected(f"calibrate: {joint.name}", what, f"{span_rad:.2f}"))
    direction = 1 if upper > lower else -1
    middle_rad = (joint.lower + joint.upper) / 2
    zero = round((lower + upper) / 2 - direction * middle_rad * STEPS_PER_RAD)
    offset = min(max(_turned(zero - ZERO_STEPS), 1 - TURN // 2), TURN // 2 - 1)
    reads = sorted(ZERO_STEPS + end - zero for end in ends)
    return CalibratedServo(
        joint=joint.name,
        id=servo_id,
        homing_offset_steps=offset,
        direction=1 if direction > 0 else -1,
        lower_steps=max(reads[0], 0),
        upper_steps=min(reads[1], TURN - 1),
    )


def _turned(steps: int) -> int:
    """The shorter way round."""
    return (steps + TURN // 2) % TURN - TURN // 2


def _store(bus: ServoBus, servo: CalibratedServo) -> None:
    """Into the servo's EEPROM, and locked; one that lost power meanwhile has locked itself."""
    bus.put(servo.id, "lock", 0)
    bus.put(servo.id, "homing_offset", servo.homing_offset_steps)
    bus.put(servo.id, "min_position_limit", servo.lower_steps)
    bus.put(servo.id, "max_position_limit", servo.upper_steps)
    bus.put(servo.id, "lock", 1)
