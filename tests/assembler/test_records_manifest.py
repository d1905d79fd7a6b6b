"""The founding record's own manifest loads and runs, and others of its kind are refused."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.messages import LayoutState, decode, floats
from fairlead.paths import rskill_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_state_assembler import ForwardKinematics
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView
from tests.assembler.robot_feed import SKILL, RobotFeed
from tests.repo.tree import ROOT

RECORD = """
layout: human300_16d
dim: 16
bindings:
  eef_frame: panda_hand_tcp
  base_frame: base_link
  world_frame: odom
  gripper_qpos_joints: [panda_gripper]
  quaternion_convention: xyzw
"""


class Checkout:
    """A checkout with this one's robots and a skill ``record`` of one's own."""

    def __init__(self, root: Path) -> None:
        (root / "robots").symlink_to(ROOT / "robots")
        self._folder = root / "rskills" / "record"
        self._folder.mkdir(parents=True)
        self._plain = yaml.safe_load((rskill_dir(SKILL) / "rskill.yaml").read_text())

    def skill(self, state_contract: str) -> SkillManifest:
        data = self._plain | {"id": "record", "state_contract": yaml.safe_load(state_contract)}
        (self._folder / "rskill.yaml").write_text(yaml.safe_dump(data))
        return load_skill("record")


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Checkout:
    made = Checkout(tmp_path)
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    return made


def answer(robot: RobotManifest, feed: RobotFeed) -> LayoutState:
    """What the assembler publishes for skill ``record`` at tick 1."""
    core = AssemblerCore(robot, Publishers())
    core.want(SkillView("record"))
    core.on_transforms(feed.static(1), "hal")
    core.on_transforms(feed.moving(1), "hal")
    outputs = [*core.on_joints(feed.joints(1)), *core.on_joints(feed.joints(2))]
    return next(decode(LayoutState, out.payload) for out in outputs if out.skill == "record")


@pytest.mark.parametrize("layout", ["human300_16d", "rc365"])
def test_the_records_manifest_is_admitted_and_assembled(
    checkout: Checkout, robot: RobotManifest, feed: RobotFeed, layout: str
) -> None:
    skill = checkout.skill(RECORD.replace("human300_16d", layout))
    assert admission_problems(skill, robot) == []
    state = answer(robot, feed)
    assert (state.tick, state.layout, state.fault) == (1, layout, None)
    assert state.values is not None
    kinematics = ForwardKinematics(robot)
    poses = kinematics.poses(np.array(feed.positions(1)))
    tcp = pin.SE3ToXYZQUAT(poses[kinematics.frames["panda_hand_tcp"]])
    opening = feed.positions(1)[robot.measured_joint_names.index("panda_gripper")]
    wanted = [
        *tcp[:3],
        *(tcp[3:] if tcp[6] >= 0 else -tcp[3:]),
        *(0.1, 0.5, 0.0),
        *(0.0, 0.0, 0.6, 0.8),
        *(opening, -opening),
    ]
    assert np.allclose(floats(state.values), wanted, atol=1e-12)


def test_every_missing_field_is_named_in_one_error_when_the_manifest_is_loaded(
    checkout: Checkout,
) -> None:
    with pytest.raises(ConfigError) as error:
        checkout.skill("{layout: rc365, dim: 16, bindings: {world_frame: odom}}")
    (line,) = str(error.value).splitlines()[1:]
    assert line.endswith(
        "state_contract: bindings: layout rc365 also needs eef_frame, base_frame, "
        "gripper_qpos_joints"
    )


def test_gr1_with_its_bindings_is_dropped_and_faults_for_want_of_an_assembler(
    checkout: Checkout, robot: RobotManifest, feed: RobotFeed
) -> None:
    skill = checkout.skill(RECORD.replace("human300_16d", "gr1"))
    assert admission_problems(skill, robot) == [
        "layout gr1: no assembler; those that have one: fairlead layout ls"
    ]
    state = answer(robot, feed)
    assert state.values is None
    assert state.fault is not None
    assert (state.fault.kind, state.fault.name) == ("no_assembler", "gr1")


def test_gr1_without_bindings_is_refused_when_it_is_loaded(checkout: Checkout) -> None:
    with pytest.raises(ConfigError, match="layout gr1 also needs eef_frame, base_frame, gripper"):
        checkout.skill("{layout: gr1, dim: 39}")


def test_aloha_unbound_is_dropped_on_a_robot_that_measures_as_many_other_joints(
    checkout: Checkout, robot: RobotManifest
) -> None:
    skill = checkout.skill("{layout: aloha, dim: 14}")
    assert len(robot.measured_joint_names) == 14
    problems = admission_problems(skill, robot)
    assert len(problems) == 14
    assert problems[0].startswith(
        "joint_names: robot panda_mobile measures no joint 'left_waist' (valid: base_x, base_y"
    )


def test_libero_unbound_runs_on_this_robots_franka_arm(
    checkout: Checkout, robot: RobotManifest, feed: RobotFeed
) -> None:
    assert admission_problems(checkout.skill("{layout: libero, dim: 9}"), robot) == []
    state = answer(robot, feed)
    assert state.values is not None
    measured = dict(zip(robot.measured_joint_names, feed.positions(1), strict=True))
    names = [f"panda_joint{n}" for n in range(1, 8)]
    names += ["panda_finger_joint1", "panda_finger_joint2"]
    assert floats(state.values).tolist() == [measured[name] for name in names]
