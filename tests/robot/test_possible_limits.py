"""A limit that nothing could ever exceed is refused: it is a wrong unit or a slipped digit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest
from tests.cli.command import fairlead_here as fairlead
from tests.shape.own_robot import NAME, own_robot

ARM = "parts.arm.cartesian_delta"
LEFT = "parts.left_arm"
MOBILE, DUAL = "panda_mobile", "dual_panda"
AT_ONCE = "all the part's joints at full speed, in half of all postures,"
IN_ONE_PERIOD = f"what {AT_ONCE} do in one period, by the largest share in gain"
# Robot, key, the absurd number (of a list: in its place), the most that is said, and why that is.
TABLE: list[tuple[str, str, Any, str, str]] = [
    (MOBILE, f"{ARM}.linear_limit_m", 0.8, "0.595", IN_ONE_PERIOD),
    (MOBILE, f"{ARM}.linear_limit_m", 8.67, "0.595", IN_ONE_PERIOD),
    (MOBILE, f"{ARM}.linear_limit_m", 400.0, "4.912",
     "from one end of the tool's reach to the other"),
    (MOBILE, f"{ARM}.angular_limit_rad", 8.67, "1.6", IN_ONE_PERIOD),
    (MOBILE, f"{ARM}.angular_limit_rad", 49.7, "3.142", "half a turn"),
    (MOBILE, f"{ARM}.linear_step_limit_m", 1.734, "0.1734", "a full reversal"),
    (MOBILE, f"{ARM}.angular_step_limit_rad", 17.34, "1.734", "a full reversal"),
    (MOBILE, f"{ARM}.linear_tracking_m", 1.5, "0.20", "against a full row"),
    (MOBILE, f"{ARM}.angular_tracking_rad", 3.5, "0.7", "against a full row"),
    (MOBILE, "parts.base.body_twist.linear_limit_m_s", 4.0, "1.414",
     "what all the base's joints make"),
    (MOBILE, "parts.base.body_twist.angular_limit_rad_s", 11.7, "1.5",
     "what all the base's joints make"),
    (MOBILE, "parts.base.body_twist.linear_step_limit_m_s", 8.0, "0.8", "a full reversal"),
    (MOBILE, "parts.base.body_twist.linear_tracking_m_s", 6.0, "1.814", "against a full row"),
    (MOBILE, "parts.composite.composite_mode.step_limit", 20.0, "2", "from -1 to 1"),
    (DUAL, f"{LEFT}.cartesian_twist.linear_limit_m_s", 500.0, "3.",
     f"what {AT_ONCE} make"),
    (DUAL, f"{LEFT}.cartesian_twist.angular_limit_rad_s", 500.0, "10.",
     f"what {AT_ONCE} make"),
    (DUAL, f"{LEFT}.cartesian_twist.linear_tracking_m_s", 50.0, "", "against a full row"),
    (DUAL, f"{LEFT}.cartesian_pose.upper_m", [900.0 / 10, 0.8, 1.6], "",
     "from one end of the tool's reach to the other"),
    (DUAL, f"{LEFT}.cartesian_pose.linear_step_limit_m", 50.0, "",
     "from one end of the tool's reach to the other"),
    (DUAL, f"{LEFT}.cartesian_pose.angular_step_limit_rad", 10.0, "3.142", "half a turn"),
    (DUAL, f"{LEFT}.cartesian_pose.linear_tracking_m", 50.0, "",
     "from one end of the tool's reach to the other"),
    (DUAL, f"{LEFT}.cartesian_pose.angular_tracking_rad", 10.0, "3.142", "half a turn"),
    (MOBILE, "measured.base_x.jump_per_tick", 10.0, "1", "the way of 20 periods at full speed"),
    (MOBILE, "measured.panda_joint1.jump_per_tick", 2.9, "2.175",
     "the way of 20 periods at full speed"),
    (MOBILE, "measured.panda_joint1.dead_band_per_tick", 0.2, "0.1087",
     "the way of one period at full speed"),
    (MOBILE, "measured.panda_joint1.encoder_step", 0.2, "0.1087",
     "the way of one period at full speed"),
    (MOBILE, "measured.panda_joint1.stop_lag_s", 5.0, "4", "protocol.stop_ramp_ms"),
    (MOBILE, "measured.panda_joint1.contact_limit", 840.0, "160", "twice the joint's effort limit"),
    (DUAL, "self_collision.clearance_m", 1.0, "", "the longest link"),
    (MOBILE, "workspace.volumes.0.upper_m", [9.5, 0.75, 1.7], "", "twice the robot's reach"),
    (MOBILE, "base.footprint_m", [[-550.0, -250.0], [150.0, -250.0], [150.0, 250.0]], "10",
     "a base in metres"),
    (MOBILE, "base.yaw_axis_m", [-210.0, 0.0], "10", "a base in metres"),
    (MOBILE, "base.zones.0.corners_m", [[-4000.0, -4.0], [4.0, -4.0], [4.0, 4.0]], "1000",
     "a site in metres"),
    (MOBILE, "base.reaction_s", 9.0, "4", "protocol.stop_ramp_ms"),
]  # fmt: skip


def spoiled(robot: str, key: str, value: Any) -> RobotManifest:
    document = yaml.safe_load((robot_dir(robot) / "robot.yaml").read_text())
    place = document["safety"]["sim"]
    *way, last = key.split(".")
    for step in way:
        place = place[int(step) if step.isdigit() else step]
    assert last in place
    # An anchor's block is one object for all who name it.
    place[last] = value
    return RobotManifest.model_validate(document)


@pytest.mark.parametrize(("robot", "key", "value", "most", "why"), TABLE)
def test_a_limit_beyond_what_the_robot_can_do_is_refused_by_value_bound_and_reason(
    robot: str, key: str, value: Any, most: str, why: str
) -> None:
    with pytest.raises(ConfigError) as error:
        compile_gate_config(spoiled(robot, key, value), "sim")
    named = key.replace("volumes.0", "volumes.reach").replace("zones.0.corners_m", "zones.kitchen")
    said = [
        line
        for line in str(error.value).splitlines()
        if f"safety.sim: {named}" in line and why in line
    ]
    assert said, str(error.value)
    assert f": expected up to {most}" in said[0]
    number = max((abs(n) for n in flat(value)), default=value) if isinstance(value, list) else value
    assert said[0].endswith(f"got {number:g}")


def flat(value: Any) -> list[float]:
    return [n for one in value for n in flat(one)] if isinstance(value, list) else [float(value)]


JOINTS: list[tuple[str, float, str]] = [
    ("velocity_rad_s", 217.5, "its whole range in one period"),
    ("velocity_rad_s", 70.0, "half a turn in one period"),
    ("acceleration_rad_s2", 1500.0, "a full reversal in one period"),
]


@pytest.mark.parametrize(("field", "value", "why"), JOINTS)
def test_a_joint_that_is_faster_than_any_is_refused(
    field: str, value: float, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    urdf = folder / "panda.urdf"
    urdf.write_text(urdf.read_text().replace('velocity="2.175"', 'velocity="999"'))
    document = yaml.safe_load((folder / "robot.yaml").read_text())
    document["joints"][0][field] = value
    with pytest.raises(ConfigError, match=why):
        compile_gate_config(RobotManifest.model_validate(document), "sim")


@pytest.mark.parametrize(
    ("kind", "lower", "upper", "said"),
    [
        ("keep_in", [-2.5, -2.5, -2.5], [2.5, 2.5, 2.5], "reach: keeps nothing in, no tool gets"),
        ("keep_out", [2.7, 2.7, 2.7], [2.8, 2.8, 2.8], "far: keeps nothing out, no link gets"),
    ],
)
def test_a_volume_that_keeps_nothing_in_or_out_is_refused(
    kind: str, lower: list[float], upper: list[float], said: str
) -> None:
    document = yaml.safe_load((robot_dir("panda") / "robot.yaml").read_text())
    volumes = document["safety"]["sim"]["workspace"]["volumes"]
    if kind == "keep_in":
        volumes[0] |= {"lower_m": lower, "upper_m": upper}
    else:
        volumes.append({"name": "far", "kind": kind, "lower_m": lower, "upper_m": upper})
    with pytest.raises(ConfigError, match=said):
        compile_gate_config(RobotManifest.model_validate(document), "sim")


def test_the_command_refuses_it_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = "          step_limit_m: 0.08\n"
    volume = ("lower_m: [-0.5, -0.8, 0.0]", "lower_m: [-500, -0.8, 0.0]")
    folder = own_robot(tmp_path, monkeypatch)
    manifest = folder / "robot.yaml"
    assert old in manifest.read_text()
    manifest.write_text(manifest.read_text().replace(*volume).replace("[-500", "[-5"))
    before = (folder / "gate.sim.json").read_bytes()
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "workspace.volumes.reach.lower_m x: expected up to " in done.stderr
    assert "twice the robot's reach, got 5" in done.stderr
    assert (folder / "gate.sim.json").read_bytes() == before


def test_more_frames_than_the_gate_has_room_for_are_refused() -> None:
    links = [f"panda_link{number}" for number in range(5)]
    with pytest.raises(ConfigError, match=r"cartesian_delta\.frames: expected at most 4, got 5"):
        compile_gate_config(spoiled(MOBILE, f"{ARM}.frames", links), "sim")
