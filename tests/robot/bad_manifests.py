"""A good robot.yaml of panda_mobile, spoiled in one place each, and the whole complaint.

The place is a path of keys and indices with dots between them, below ``safety.sim`` where it
begins with a dot.
"""

from __future__ import annotations

import math
from typing import Any

from tests.gate.file_edits import Change, again, drop, put

SIM = "safety.sim"
ARM, GRIPPER, BASE = (f"{SIM}.parts.{part}" for part in ("arm", "gripper", "base"))
MEASURED = f"{SIM}.measured.panda_joint1"
ROOM, HALL = f"{SIM}.workspace.volumes.0", f"{SIM}.base.zones.0"


def turning_jaw(data: dict[str, Any]) -> None:
    """The gripper's joint turns; its numbers stay."""
    (jaw,) = (joint for joint in data["joints"] if joint["name"] == "panda_gripper")
    units = {"_m": "_rad", "_m_s": "_rad_s", "_m_s2": "_rad_s2", "effort_n": "effort_nm"}
    for key in list(jaw):
        for slides, turns in units.items():
            if key.endswith(slides):
                jaw[key.removesuffix(slides) + turns] = jaw.pop(key)
    jaw["type"] = "revolute"


def second_switch(data: dict[str, Any]) -> None:
    """The base has a composite switch beside its own modes."""
    (base,) = (part for part in data["parts"] if part["name"] == "base")
    base["modes"].append("composite_mode")
    parts = data["safety"]["sim"]["parts"]
    parts["base"]["composite_mode"] = parts["composite"]["composite_mode"]


BAD: dict[str, tuple[Change, str]] = {
    "no capsules": (drop("capsules"), "capsules: is missing"),
    "a joint twice in a part": (
        again("parts.2.joints"),
        "part 'base': joint 'base_x' is declared 2 times",
    ),
    "gripper of seven joints": (
        put("parts.0.modes", ["gripper_binary"]),
        "part 'arm': gripper_binary: expected exactly one joint, with position limits, got "
        "['panda_joint1', 'panda_joint2',",
    ),
    "a jaw that turns, with limits in m": (
        turning_jaw,
        "part 'gripper': gripper_position: expected limits in rad, as 'panda_gripper' is revolute, "
        "got lower_m",
    ),
    "home beyond a limit": (
        put("home.positions.panda_joint4", 0.1),
        "home: joint 'panda_joint4': expected a position from -3.0718 to -0.0698, got 0.1",
    ),
    "a joint without a home": (
        drop("home.positions.torso_height"),
        "home.positions: missing torso_height",
    ),
    "a base at home": (
        put("home.positions.base_x", 0.0),
        "home.positions: joint 'base_x' has no position limits, so no home: leave it out",
    ),
    "home is nowhere": (put("home.positions.panda_joint1", math.nan), "home.positions."),
    "home from nowhere": (put("home.source", " "), "home.source: "),
    "no contact limit": (
        drop(f"{MEASURED}.contact_limit"),
        "safety.sim: measured: joint 'panda_joint1': contact_limit is missing",
    ),
    "contact limit of a passive joint": (
        put(f"{SIM}.measured.torso_height.contact_limit", 5.0),
        "measured: joint 'torso_height': contact_limit is given for a joint that is not commanded",
    ),
    "encoder step 0": (
        put(f"{MEASURED}.encoder_step", 0),
        "measured.panda_joint1.encoder_step: ",
    ),
    "no stop lag": (
        drop(f"{MEASURED}.stop_lag_s"),
        "safety.sim: measured: joint 'panda_joint1': stop_lag_s is missing",
    ),
    "stop lag below 0": (
        put(f"{MEASURED}.stop_lag_s", -0.01),
        "measured.panda_joint1.stop_lag_s: ",
    ),
    "dead band as text": (
        put(f"{MEASURED}.dead_band_per_tick", "small"),
        "measured.panda_joint1.dead_band_per_tick: ",
    ),
    "gain backwards": (
        put(f"{ARM}.cartesian_delta.gain", [0.3, 0.2]),
        "gain: expected 0 <= lower <= upper, and upper from 0.1 to 1.5, got [0.3, 0.2]",
    ),
    "gain above 1 beside a composite switch": (
        put(f"{ARM}.cartesian_delta.gain", [0.3, 1.1]),
        "part 'arm': cartesian_delta.gain: expected at most 1, as the robot has a composite switch",
    ),
    "gain above 1.5": (
        put(f"{BASE}.joint_velocity.gain", [0.3, 1.6]),
        "gain: expected 0 <= lower <= upper, and upper from 0.1 to 1.5, got [0.3, 1.6]",
    ),
    "tracking of two joints": (
        put(f"{BASE}.joint_velocity.tracking_limits", [1.0, 1.0]),
        "part 'base': tracking_limits: expected one per joint, 3, got 2",
    ),
    "no slip": (
        drop(f"{GRIPPER}.gripper_position.slip_limit_m"),
        "parts.gripper.gripper_position: gripper_position: missing slip_limit_m",
    ),
    "an opening in m and rad": (
        put(f"{GRIPPER}.gripper_position.upper_rad", 0.8),
        "parts.gripper.gripper_position: gripper_position: upper_rad beside lower_m",
    ),
    "opening beyond the joint": (
        put(f"{GRIPPER}.gripper_position.upper_m", 0.09),
        "part 'gripper': gripper_position: expected lower_m and upper_m inside the limits of "
        "'panda_gripper', 0.0 and 0.08, got 0.0 and 0.09",
    ),
    "no singularity limit": (
        drop(f"{ARM}.singularity_limit"),
        "part 'arm': singularity_limit is missing",
    ),
    "singularity limit of a base": (
        put(f"{BASE}.singularity_limit", 0.1),
        "part 'base': singularity_limit is given without a cartesian mode",
    ),
    "no transitions": (drop(f"{ARM}.transitions"), "parts.arm.transitions: is missing"),
    "transition to a foreign mode": (
        put(f"{BASE}.transitions", [["body_twist", "cartesian_delta"]]),
        "part 'base': transitions: expected two different modes of the part, got ['body_twist', "
        "'cartesian_delta'] (valid: joint_velocity, body_twist)",
    ),
    "transition twice": (
        put(f"{BASE}.transitions", [["body_twist", "joint_velocity"]] * 2),
        "part 'base': transitions: ['body_twist', 'joint_velocity'] is there 2 times",
    ),
    "a switch beside other modes": (
        second_switch,
        "part 'base' modes: expected composite_mode alone, got joint_velocity, body_twist beside",
    ),
    "switching somewhere": (
        put(f"{SIM}.parts.composite.composite_mode.switching", "sometimes"),
        "composite_mode.switching: ",
    ),
    "volume inside out": (
        put(f"{ROOM}.lower_m", [9.0, 9.0, 9.0]),
        "inverted limits along x, lower_m 9.0 is not below upper_m ",
    ),
    "nothing to keep in": (
        put(f"{ROOM}.kind", "keep_out"),
        "workspace.volumes: expected one of kind keep_in for the robot's tools, got ",
    ),
    "no margin": (drop(f"{SIM}.workspace.margin_m"), f"{SIM}.workspace.margin_m: is missing"),
    "volume twice": (again(f"{SIM}.workspace.volumes"), "is declared 2 times"),
    "no base": (drop(f"{SIM}.base"), "base: missing; zones bound base_x, base_y, base_yaw"),
    "base told in no known frame": (
        put(f"{SIM}.base.command_frame", "base_link"),
        "command_frame",
    ),
    "no zone to be in": (
        put(f"{HALL}.kind", "keep_out"),
        "zones: expected one of kind keep_in, got ['keep_out'",
    ),
    "zone with a dent": (
        put(f"{HALL}.corners_m", [[0, 0], [2, 0], [1, 0.5], [1, 2]]),
        "corners_m: expected a convex polygon, counter-clockwise, got ((0.0, 0.0), ",
    ),
    "footprint clockwise": (
        put(f"{SIM}.base.footprint_m", [[0, 0], [0, 1], [1, 1], [1, 0]]),
        "footprint_m: expected a convex polygon, counter-clockwise, got ((0.0, 0.0), ",
    ),
    "no deadline": (
        drop(f"{SIM}.protocol.step_deadline_us"),
        "safety.sim.protocol.step_deadline_us: is missing",
    ),
}
