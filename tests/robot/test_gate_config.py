"""The compiled gate file: current, complete, readable by the gate."""

import json
import math

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import gate_config, robot_ids
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.limits.bounds import robot_bounds
from fairlead_tools.limits.effective_limits import effective_limits


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("panda_mobile")


@pytest.mark.parametrize("name", robot_ids())
def test_committed_gate_file_is_what_the_manifest_compiles_to(name: str) -> None:
    robot = load_robot(name)
    for profile in robot.safety:
        text = compile_gate_config(robot, profile)
        if robot.open_numbers(profile):
            continue
        assert gate_config(name, profile).read_text(encoding="utf-8") == text, (
            f"robots/{name}/gate.{profile}.json is out of date: run fairlead robot compile {name}"
        )


def test_compiled_joints_are_in_wire_order_with_every_limit(robot: RobotManifest) -> None:
    config = json.loads(compile_gate_config(robot, "sim"))
    assert [joint["name"] for joint in config["joints"]] == list(robot.joint_names)
    assert [joint["name"] for joint in config["passive_joints"]] == list(robot.passive_joint_names)
    for joint in config["joints"]:
        assert ("bounds" in joint) != ("zones" in joint), joint["name"]
        for name in ("effort_limit", "jump_limit", "contact_limit", "encoder_step", "dead_band"):
            assert joint[name] > 0, joint["name"]
        assert joint["stop_lag"] == 0.0, joint["name"]
        for name in ("velocity_limit", "acceleration_limit"):
            assert (joint[name] is None) == (joint["name"] == "panda_gripper")
        assert joint["source"]


def test_compiled_identity_is_the_robots(robot: RobotManifest) -> None:
    config = json.loads(compile_gate_config(robot, "sim"))
    assert config["format"] == "fairlead-gate-1"
    assert config["robot_hash"] == robot.robot_hash.hex()
    assert config["period_ns"] == 50_000_000
    assert [part["name"] for part in config["parts"]] == ["arm", "gripper", "base", "composite"]


def test_sim_limits_admit_full_scale_on_every_axis_and_reversals_but_of_yaw(
    robot: RobotManifest,
) -> None:
    modes = {
        part["name"]: part["modes"]
        for part in json.loads(compile_gate_config(robot, "sim"))["parts"]
    }
    delta = modes["arm"]["cartesian_delta"]
    assert math.sqrt(3) * 0.05 <= delta["linear_limit"] < 0.09
    assert math.sqrt(3) * 0.5 <= delta["angular_limit"] < 0.9
    assert 2 * math.sqrt(3) * 0.05 <= delta["linear_step_limit"]
    assert 2 * math.sqrt(3) * 0.5 <= delta["angular_step_limit"]
    assert modes["base"]["joint_velocity"]["step_limit"] == [2.0, 2.0, 1.5]
    assert modes["gripper"]["gripper_position"]["lower"] == 0.0
    assert modes["gripper"]["gripper_position"]["upper"] == 0.08
    assert modes["gripper"]["gripper_position"]["step_limit"] == 0.08
    assert modes["composite"]["composite_mode"]["step_limit"] == 2.0


def test_the_two_armed_robots_limits_stay_within_what_its_maker_allows() -> None:
    """The Franka Control Interface's limits, written again by hand, over one 50 ms period."""
    config = json.loads(compile_gate_config(load_robot("dual_panda"), "sim"))
    modes = {part["name"]: part["modes"] for part in config["parts"]}
    efforts = {joint["name"]: joint["effort_limit"] for joint in config["joints"]}
    for side in ("left", "right"):
        of_arm = [efforts[f"{side}_joint{index}"] for index in range(1, 8)]
        assert of_arm == [87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0]
        pose, twist = (
            modes[f"{side}_arm"]["cartesian_pose"],
            modes[f"{side}_arm"]["cartesian_twist"],
        )
        assert pose["linear_step_limit"] <= 1.7 * 0.05
        assert pose["angular_step_limit"] <= 2.5 * 0.05
        assert twist["linear_limit"] <= 1.7
        assert twist["angular_limit"] <= 2.5
        assert twist["linear_step_limit"] <= 13.0 * 0.05
        assert twist["angular_step_limit"] <= 25.0 * 0.05
    assert set(modes["left_gripper"]["gripper_binary"]) == {"source"}


def test_compiling_an_undeclared_profile_lists_the_declared_ones(robot: RobotManifest) -> None:
    with pytest.raises(ConfigError) as error:
        compile_gate_config(load_robot("panda"), "hardware")
    assert str(error.value) == (
        "robot panda: expected a safety profile, got 'hardware' (valid: sim)"
    )


def test_effective_limits_show_every_number_of_the_compiled_file(robot: RobotManifest) -> None:
    rows = {(row.where, row.name): (row.value, row.unit) for row in effective_limits(robot)}
    assert rows[("joint panda_joint4", "upper")] == (-0.0698, "rad")
    assert rows[("joint base_yaw", "velocity_limit")] == (1.5, "rad/s")
    assert ("joint base_yaw", "upper") not in rows
    assert rows[("part arm cartesian_delta", "linear_limit")] == (0.0867, "m")
    assert rows[("part base joint_velocity", "step_limit")] == ((2.0, 2.0, 1.5), "m/s, rad/s")
    assert rows[("part base body_twist", "angular_limit")] == (1.17, "rad/s")
    assert rows[("part composite composite_mode", "step_limit")] == (2.0, "1")


def numbers_and_choices(node: object) -> int:
    """Keys of a compiled block that bound something: a number, some numbers, a word or null."""
    identity = {"name", "part", "kind", "frames", "free_axes", "source", "joints", "tool_frame"}
    if not isinstance(node, dict):
        return 1
    kept = [value for key, value in node.items() if key not in identity]
    return sum(map(numbers_and_choices, kept))


def test_every_number_and_choice_of_the_compiled_file_is_listed(robot: RobotManifest) -> None:
    config = json.loads(compile_gate_config(robot, "sim"))
    count = sum(map(numbers_and_choices, config["joints"] + config["passive_joints"]))
    count -= 3  # base_x, base_y and base_yaw: the frame of their zones
    count -= 2  # the gripper's speeds, null
    for part in config["parts"]:
        count += sum(map(numbers_and_choices, part["modes"].values()))
    count += 1 + 1  # the arm's singularity_limit; transitions of the base, which has two modes
    count += len(config["protocol"])
    count += 2 * len(config["workspace"]["volumes"]) + 2  # clearance and pairs
    count += 5 + len(config["base"]["zones"])  # footprint, yaw axis, reaction, two drifts
    assert len(effective_limits(robot)) == count


def test_effective_limits_name_the_source_of_each_number(robot: RobotManifest) -> None:
    sources = {(row.where, row.name): row.source for row in effective_limits(robot)}
    assert sources[("joint panda_joint1", "upper")].startswith("Franka Emika Panda FCI limits")
    assert sources[("joint panda_joint1", "jump_limit")].startswith("measured 57 mrad")
    assert sources[("part gripper gripper_position", "upper")].startswith("robosuite GRIP")


def test_a_second_person_is_asked_for_only_where_the_profile_says_so(
    robot: RobotManifest,
) -> None:
    assert "second_person_s" not in json.loads(compile_gate_config(robot, "sim"))["protocol"]
    document = robot.model_dump(mode="json", exclude_unset=True)
    document["safety"]["sim"]["protocol"]["second_person_s"] = 60
    careful = RobotManifest.model_validate(document)
    assert json.loads(compile_gate_config(careful, "sim"))["protocol"]["second_person_s"] == 60
    [bound] = [one for one in robot_bounds(careful) if one.limit.name == "second_person_s"]
    assert (bound.limit.value, bound.limit.unit) == (60.0, "s")
    assert [by.check for by in bound.enforced_by] == ["latch"]
