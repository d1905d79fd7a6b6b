"""Dispatch: flat float32 rows become typed parts, and nothing is lost on the way."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.candidate import dispatch

ROBOT = load_robot("panda_mobile")
SKILL = load_skill("oracle-counter-to-cabinet")
ROUTES = resolve_routes(SKILL.action_contract, ROBOT)


def random_actions(rows: int = 8, dim: int = 12) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (rows, dim)).astype(np.float32)


def test_each_dimension_lands_in_its_part_in_si_units() -> None:
    actions = np.zeros((1, 12), dtype=np.float32)
    actions[0] = [1, -1, 0.5, 1, 0, -1, 1, 1, -1, 1, 0.7, -1]
    arm, gripper, base, composite = dispatch(ROUTES, actions, 12)
    assert [p.part for p in (arm, gripper, base, composite)] == [0, 1, 2, 3]
    assert arm.mode == ControlMode.CARTESIAN_DELTA
    assert arm.frame_id == "base_link"
    np.testing.assert_array_equal(floats(arm.values, 6), [[0.05, -0.05, 0.025, 0.5, 0, -0.5]])
    assert gripper.mode == ControlMode.GRIPPER_POSITION
    np.testing.assert_array_equal(floats(gripper.values, 1), [[0.0]])
    assert base.mode == ControlMode.JOINT_VELOCITY
    np.testing.assert_array_equal(floats(base.values, 11), [[1, -1, 1.5] + [0] * 8])
    assert composite.mode == ControlMode.COMPOSITE_MODE
    np.testing.assert_array_equal(floats(composite.values, 1), [[-1]])


def test_only_joint_modes_have_a_mask_and_it_names_every_commanded_joint() -> None:
    parts = dispatch(ROUTES, random_actions(), 12)
    assert [part.active for part in parts] == [(), (), (0, 1, 2), ()]


def test_gripper_minus_one_is_fully_open() -> None:
    actions = -np.ones((1, 12), dtype=np.float32)
    assert floats(dispatch(ROUTES, actions, 12)[1].values)[0] == 0.08


def test_undoing_the_scale_gives_the_policys_own_bits_back() -> None:
    actions = random_actions(rows=1000)
    arm, _, base, composite = dispatch(ROUTES, actions, 12)
    back = floats(arm.values, 6) / np.asarray([0.05] * 3 + [0.5] * 3)
    assert back.astype(np.float32).tobytes() == actions[:, 0:6].tobytes()
    back = floats(base.values, 11)[:, :3] / np.asarray([1.0, 1.0, 1.5])
    assert back.astype(np.float32).tobytes() == actions[:, 7:10].tobytes()
    assert floats(composite.values).astype(np.float32).tobytes() == actions[:, 11].tobytes()


def test_every_routed_dimension_changes_the_parts_and_a_discarded_one_does_not() -> None:
    actions = random_actions(rows=2)
    before = dispatch(ROUTES, actions, 12)
    for index in range(12):
        changed = actions.copy()
        changed[1, index] = 0.123
        assert (dispatch(ROUTES, changed, 12) != before) == (index != 10), index


def test_a_subset_of_the_base_commands_only_its_own_joint() -> None:
    data = SKILL.model_dump(mode="json")
    data["action_contract"]["slots"][2:4] = [
        {"range": [7, 7], "control_mode": "joint_velocity", "joint_names": ["base_yaw"]},
        {"range": [8, 10], "discard": True},
    ]
    routes = resolve_routes(SkillManifest.model_validate(data).action_contract, ROBOT)
    base = dispatch(routes, np.ones((1, 12), dtype=np.float32), 12)[2]
    assert base.active == (2,)
    np.testing.assert_array_equal(floats(base.values, 11), [[0, 0, 1] + [0] * 8])


@pytest.mark.parametrize(
    ("actions", "got"),
    [
        (np.zeros((8, 11), dtype=np.float32), "float32 [8, 11]"),
        (np.zeros(12, dtype=np.float32), "float32 [12]"),
        (np.zeros((0, 12), dtype=np.float32), "float32 [0, 12]"),
        (np.zeros((1, 12)), "float64 [1, 12]"),
    ],
)
def test_a_vector_of_another_shape_or_type_is_refused(actions: np.ndarray, got: str) -> None:
    with pytest.raises(ConfigError) as caught:
        dispatch(ROUTES, actions, 12)
    assert str(caught.value) == f"dispatch: expected float32 [H >= 1, 12], got {got}"
