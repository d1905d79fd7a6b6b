"""A good gate file of panda_mobile, spoiled in one place each, and what the gate must say.

A refusal names the key, what was expected
and what was found; of a missing or unknown key there is nothing else to say.
"""

from __future__ import annotations

from tests.gate.file_edits import Change, again, drop, put

ARM, GRIPPER, BASE, COMPOSITE = (f"parts.{index}" for index in range(4))
DELTA = f"{ARM}.modes.cartesian_delta"
OPENING = f"{GRIPPER}.modes.gripper_position"
SPEED, TWIST = f"{BASE}.modes.joint_velocity", f"{BASE}.modes.body_twist"
SWITCH = f"{COMPOSITE}.modes.composite_mode"
JOINT, FIRST = "joints.3", "collision.capsules.0"
ROOM, HALL = "workspace.volumes.0", "base.zones.0"
TO_TWIST = ["joint_velocity", "body_twist"]

SHAPE: dict[str, tuple[Change, str]] = {
    "no shape": (drop("collision"), "collision: missing"),
    "no clearance": (drop("collision.clearance"), "collision.clearance: missing"),
    "clearance 0": (
        put("collision.clearance", 0.0),
        "collision.clearance: expected a finite number above 0, got 0",
    ),
    "no capsules": (put("collision.capsules", []), "collision.capsules: expected at least one"),
    "too many capsules": (
        put(
            "collision.capsules",
            [{"link": "torso", "a": [0, 0, 0], "b": [0, 0, 1], "radius": 0.1}] * 49,
        ),
        "collision.capsules[48]: more than 48",
    ),
    "capsule on no link": (
        put(f"{FIRST}.link", "tail"),
        'collision.capsules[0].link: expected the name of a link of `kinematics`, got "tail"',
    ),
    "capsule of radius 0": (
        put(f"{FIRST}.radius", 0.0),
        "collision.capsules[0].radius: expected a finite number above 0, got 0",
    ),
    "capsule end of two numbers": (
        put(f"{FIRST}.a", [0.0, 0.0]),
        "collision.capsules[0].a: expected 3 numbers, got [0.0,0.0]",
    ),
    "unknown key of a capsule": (
        put(f"{FIRST}.colour", "red"),
        "collision.capsules[0].colour: unknown key (valid: a, b, link, radius)",
    ),
    "no pairs": (
        put("collision.pairs", []),
        "collision.pairs: expected at least one for a robot with a tool",
    ),
    "pair of one": (
        put("collision.pairs.0", [0]),
        "collision.pairs[0]: expected two indices of `capsules`, got [0]",
    ),
    "pair backwards": (
        put("collision.pairs.0", [2, 0]),
        "collision.pairs[0]: expected two capsules in ascending order below ",
    ),
    "pair with itself": (
        put("collision.pairs.0", [1, 1]),
        "collision.pairs[0]: expected two capsules in ascending order below ",
    ),
    "pair beyond the capsules": (put("collision.pairs.0", [0, 47]), ", got 0 and 47"),
    "pair beyond any capsule": (
        put("collision.pairs.0", [0, 48]),
        "collision.pairs[0]: expected two indices of `capsules`, got [0,48]",
    ),
    "pair twice": (again("collision.pairs"), " are there twice"),
}

SURROUNDINGS: dict[str, tuple[Change, str]] = {
    "no workspace": (drop("workspace"), "workspace: missing"),
    "no volumes": (
        put("workspace.volumes", []),
        "workspace.volumes: expected one of kind keep_in, got none, and there is a tool",
    ),
    "nothing to keep in": (
        put(f"{ROOM}.kind", "keep_out"),
        "workspace.volumes: expected one of kind keep_in, got none",
    ),
    "volume of another kind": (
        put(f"{ROOM}.kind", "keep"),
        'workspace.volumes[0].kind: expected keep_in or keep_out, got "keep"',
    ),
    "volume inside out": (put(f"{ROOM}.upper.2", -9.0), " z: expected finite lower < upper, got "),
    "volume twice": (again("workspace.volumes"), " is there twice"),
    "too many volumes": (
        put(
            "workspace.volumes",
            [
                {"name": f"v{i}", "kind": "keep_in", "lower": [0, 0, 0], "upper": [1, 1, 1]}
                for i in range(9)
            ],
        ),
        "workspace.volumes[8]: more than 8",
    ),
    "no base": (drop("base"), "base: missing"),
    "base null": (
        put("base", None),
        'joints[0].zones: expected a joint of base.joints, got "base_x"',
    ),
    "base of two joints": (
        put("base.joints", ["base_x", "base_y"]),
        "base.joints: expected the names of 3 joints: x, y and yaw, got ",
    ),
    "base of an unknown joint": (
        put("base.joints.2", "wheel"),
        'base.joints[2]: expected the name of one of `joints`, got "wheel"',
    ),
    "base whose yaw slides": (
        put("base.joints", ["base_x", "base_yaw", "base_y"]),
        "base.joints: expected two that slide and one that turns, got base_yaw",
    ),
    "base told in no known frame": (
        put("base.command_frame", "base_link"),
        'base.command_frame: expected odom or against_yaw, got "base_link"',
    ),
    "base told in no frame": (drop("base.command_frame"), "base.command_frame: missing"),
    "base that turns about one number": (
        put("base.yaw_axis", [0.0]),
        "base.yaw_axis: expected 2 numbers, got [0.0]",
    ),
    "base that reacts at once": (
        put("base.reaction_s", 0.0),
        "base.reaction_s: expected a finite number above 0, got 0",
    ),
    "footprint clockwise": (
        put("base.footprint", [[0, 0], [0, 1], [1, 1], [1, 0]]),
        "base.footprint: expected 3 or more corners of a convex polygon, counter-clockwise, got 4",
    ),
    "footprint of two corners": (
        put("base.footprint", [[0, 0], [1, 0]]),
        "base.footprint: expected 3 or more corners of a convex polygon, counter-clockwise, got 2",
    ),
    "corner of three numbers": (
        put("base.footprint.0", [0, 0, 0]),
        "base.footprint[0]: expected two numbers, got [0,0,0]",
    ),
    "zone with a dent": (
        put(f"{HALL}.corners", [[0, 0], [2, 0], [1, 0.5], [1, 2]]),
        ".corners: expected 3 or more corners of a convex polygon, counter-clockwise, got 4",
    ),
    "zone of nine corners": (
        put(f"{HALL}.corners", [[i, i * i] for i in range(9)]),
        "base.zones[0].corners[8]: more than 8",
    ),
    "no zones": (put("base.zones", []), "base.zones: expected one of kind keep_in, got none"),
    "zone without a name": (
        put(f"{HALL}.name", ""),
        "base.zones[0].name: expected text of 1 to 64 bytes",
    ),
}

TRACKING: dict[str, tuple[Change, str]] = {
    "no contact limit": (drop(f"{JOINT}.contact_limit"), "joints[3].contact_limit: missing"),
    "contact limit null": (
        put(f"{JOINT}.contact_limit", None),
        "joints[3].contact_limit: expected a number, got null",
    ),
    "encoder step 0": (
        put(f"{JOINT}.encoder_step", 0.0),
        "joints.panda_joint1.encoder_step: expected a finite number above 0, got 0",
    ),
    "dead band below 0": (
        put(f"{JOINT}.dead_band", -0.1),
        "joints.panda_joint1.dead_band: expected a finite number above 0, got -0.1",
    ),
    "no stop lag": (drop(f"{JOINT}.stop_lag"), "joints[3].stop_lag: missing"),
    "stop lag below 0": (
        put(f"{JOINT}.stop_lag", -0.1),
        "joints.panda_joint1.stop_lag: expected a finite number of at least 0, got -0.1",
    ),
    "speed of a gripper": (
        put("joints.10.velocity_limit", 0.1),
        "joints.panda_gripper.velocity_limit, acceleration_limit: expected null, a gripper "
        "is not told how fast, got 0.1 and nan",
    ),
    "no gain": (drop(f"{DELTA}.gain"), "parts[0].modes.cartesian_delta.gain: missing"),
    "gain of one number": (
        put(f"{DELTA}.gain", [0.3]),
        "parts[0].modes.cartesian_delta.gain: expected 2 numbers, got [0.3]",
    ),
    "gain backwards": (
        put(f"{DELTA}.gain", [0.3, 0.2]),
        "parts.arm.modes.cartesian_delta.gain: expected 0 <= lower <= upper <= 1.5 and upper "
        "above 0, got 0.3 and 0.2",
    ),
    "gain below 0": (
        put(f"{SPEED}.gain", [-0.1, 1.0]),
        "parts.base.modes.joint_velocity.gain: expected 0 <= lower",
    ),
    "gain above 1 beside a composite switch": (
        put(f"{DELTA}.gain", [0.3, 1.1]),
        "parts.arm.modes.cartesian_delta.gain: expected at most 1, as the robot has a composite",
    ),
    "gain above 1.5": (
        put(f"{TWIST}.gain", [0.5, 1.6]),
        "parts.base.modes.body_twist.gain: expected 0 <= lower <= upper <= 1.5",
    ),
    "gain that moves nothing": (
        put(f"{TWIST}.gain", [0.0, 0.0]),
        "parts.base.modes.body_twist.gain: expected 0 <= lower",
    ),
    "tracking of two joints": (
        put(f"{SPEED}.tracking", [1.0, 1.0]),
        "parts[2].modes.joint_velocity.tracking: expected 3 numbers, one per joint of the "
        "part, got [1.0,1.0]",
    ),
    "tracking 0": (
        put(f"{SPEED}.tracking.1", 0.0),
        "parts.base.modes.joint_velocity.tracking of base_y: expected a finite number above "
        "0, got 0",
    ),
    "no tracking of a turn": (
        drop(f"{DELTA}.angular_tracking"),
        "parts[0].modes.cartesian_delta.angular_tracking: missing",
    ),
    "slip 0": (
        put(f"{OPENING}.slip_limit", 0.0),
        "parts.gripper.modes.gripper_position.slip_limit: expected a number above 0 or null, got 0",
    ),
    "no slip": (
        drop(f"{OPENING}.slip_limit"),
        "parts[1].modes.gripper_position.slip_limit: missing",
    ),
    "opening beyond the joint": (
        put(f"{OPENING}.upper", 0.09),
        "parts.gripper.modes.gripper_position: expected lower and upper inside the bounds of "
        "panda_gripper, 0 and 0.08, got 0 and 0.09",
    ),
    "a switch beside other modes": (
        put(
            f"{BASE}.modes.composite_mode",
            {"step_limit": 2.0, "switching": "anywhere", "source": "x"},
        ),
        "parts.base.modes: expected composite_mode alone, got joint_velocity beside it",
    ),
    "switching somewhere": (
        put(f"{SWITCH}.switching", "sometimes"),
        "parts[3].modes.composite_mode.switching: expected anywhere or at_standstill, got "
        '"sometimes"',
    ),
    "no singularity limit": (
        put(f"{ARM}.singularity_limit", None),
        "parts[0].singularity_limit: expected a number, got null",
    ),
    "singularity limit without a tool": (
        put(f"{BASE}.singularity_limit", 0.1),
        "parts[2].singularity_limit: expected null for a part without cartesian modes, got 0.1",
    ),
    "no transitions": (drop(f"{BASE}.transitions"), "parts[2].transitions: missing"),
    "transition to a foreign mode": (
        put(f"{BASE}.transitions", [["joint_velocity", "cartesian_delta"]]),
        "parts[2].transitions[0][1]: expected a mode of the part (valid: joint_velocity, "
        'body_twist), got "cartesian_delta"',
    ),
    "transition to itself": (
        put(f"{BASE}.transitions", [["body_twist", "body_twist"]]),
        "parts[2].transitions[0]: expected two modes that differ, got ",
    ),
    "transition twice": (
        put(f"{BASE}.transitions", [TO_TWIST, TO_TWIST]),
        "parts[2].transitions[1]: expected each pair once, got ",
    ),
    "transition of one mode": (
        put(f"{BASE}.transitions", [["body_twist"]]),
        "parts[2].transitions[0]: expected two modes: from, to, got ",
    ),
    "stuck after no tick": (
        put("protocol.stuck_ticks", 0),
        "protocol.stuck_ticks: expected a whole number from 1 to ",
    ),
    "a ramp of an hour": (
        put("protocol.stop_ramp_ms", 3_600_000),
        "protocol.stop_ramp_ms: expected 1 to 60000, got 3600000",
    ),
    "no deadline": (drop("protocol.step_deadline_us"), "protocol.step_deadline_us: missing"),
}

BAD = {**SHAPE, **SURROUNDINGS, **TRACKING}
