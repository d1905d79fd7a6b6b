"""An arm whose joints turn without end (type continuous): compiled, judged and driven."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yaml

from bench.equipment.gate_scene import Scene
from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.messages import ActionPart, GateState, Outcome, Verdict, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.description import description_tree
from fairlead.robot.manifest import load_robot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions
from tests.cli.command import fairlead_here as fairlead
from tests.gate.link_poses import gate_links
from tests.shape.own_robot import NAME, own_robot

pytestmark = pytest.mark.processes

TURNING = tuple(f"panda_joint{number}" for number in (1, 3, 5, 7))
ARM = tuple(range(7))
TURN = 2.0 * np.pi
REST = np.array([0.3, -0.3, 0.2, -2.2, 0.1, 2.0, 0.7, 0.04, 0.02, -0.02])
DELTA = {
    "frames": ["base_link"],
    "linear_limit_m": 0.05,
    "angular_limit_rad": 0.3,
    "linear_step_limit_m": 0.1,
    "angular_step_limit_rad": 0.6,
    "gain": [0.9, 1.0],
    "linear_tracking_m": 0.1,
    "angular_tracking_rad": 0.5,
    "source": "a test",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of panda whose odd joints are continuous in URDF, model and robot.yaml; compiled."""
    with pytest.MonkeyPatch.context() as patch:
        tmp_path = tmp_path_factory.mktemp("turning")
        found = own_robot(tmp_path, patch)
        urdf, model, manifest = (found / name for name in ("panda.urdf", "mine.xml", "robot.yaml"))
        urdf_text, model_text = urdf.read_text(), model.read_text()
        for name in TURNING:
            urdf_text = re.sub(
                rf'(<joint name="{name}" type=")revolute(".*?<limit )lower="\S+" upper="\S+" ',
                r"\1continuous\2", urdf_text, flags=re.S,
            )  # fmt: skip
            bounded = rf'( name="{name}" [^>]*?) (ctrl)?range="[^"]*"'
            model_text = re.sub(bounded, r"\1", model_text)
        urdf.write_text(urdf_text)
        model.write_text(model_text)
        document = json.loads(json.dumps(yaml.safe_load(manifest.read_text())))
        for joint in document["joints"]:
            if joint["name"] in TURNING:
                joint["type"] = "continuous"
                del joint["lower_rad"], joint["upper_rad"]
                del document["safety"]["sim"]["measured"][joint["name"]]["tolerance"]
                del document["home"]["positions"][joint["name"]]
        document["parts"][0] |= {"end_effector": "gripper"}
        document["parts"][0]["modes"].append("cartesian_delta")
        document["safety"]["sim"]["parts"]["arm"] |= {
            "singularity_limit": 0.01, "cartesian_delta": DELTA
        }  # fmt: skip
        manifest.write_text(yaml.safe_dump(document, sort_keys=False))
        done = fairlead("robot", "compile", NAME, state=tmp_path)
        assert done.returncode == 0, done.stderr
        yield found


def test_it_is_compiled_with_no_bounds_by_declaration_and_shown_so(
    folder: Path, tmp_path: Path
) -> None:
    joints = json.loads((folder / "gate.sim.json").read_text())["joints"]
    assert {joint["name"] for joint in joints if joint["bounds"] is None} == set(TURNING)
    shown = fairlead("robot", "show", NAME, state=tmp_path)
    assert re.search(r"panda_joint1 +arm +continuous +none +2.175", shown.stdout), shown.stdout
    strict = fairlead("robot", "bounds", NAME, "--strict", state=tmp_path)
    assert strict.returncode == 0, strict.stdout[-500:]


def test_every_link_is_where_pinocchio_and_mujoco_have_it_after_any_number_of_turns(
    folder: Path,
) -> None:
    robot, config = load_robot(NAME), folder / "gate.sim.json"
    count, rng = 300, np.random.default_rng(3)
    positions = np.tile(REST, (count, 1))
    for column, joint in enumerate(robot.joints[:7]):
        ends = (joint.lower, joint.upper) if joint.has_bounds else (-20.0, 20.0)
        positions[:, column] = rng.uniform(*ends, count)
    ours = gate_links(config, positions, np.zeros_like(positions))
    links = [description_tree(robot).root, *(one.name for one in description_tree(robot).links)]
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    simulated = mujoco.MjModel.from_xml_path(str(folder / "mine.xml"))
    data, scene = model.createData(), mujoco.MjData(simulated)
    assert model.nq == model.nv + len(TURNING)
    for sample in range(count):
        q = pin.neutral(model)
        for name, value in zip(robot.measured_joint_names, positions[sample], strict=True):
            if model.existJointName(name):
                joint = model.joints[model.getJointId(name)]
                turned = [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
                q[joint.idx_q : joint.idx_q + joint.nq] = turned
                scene.qpos[simulated.joint(name).qposadr] = value
        pin.framesForwardKinematics(model, data, q)
        mujoco.mj_kinematics(simulated, scene)
        for index, link in enumerate(links):
            truth = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            row = ours[sample, index]
            turn = truth.rotation.T @ pin.Quaternion(row[3:7]).toRotationMatrix()
            assert np.abs(row[:3] - truth.translation).max() < 1e-9
            assert np.abs(pin.log3(turn)).max() < 1e-9
            body = mujoco.mj_name2id(simulated, mujoco.mjtObj.mjOBJ_BODY, link)
            if body > 0:
                assert np.abs(row[:3] - scene.xpos[body]).max() < 1e-9


class Arm:
    """The gate, an arm that stands where a test puts it, and rows for it."""

    def __init__(self, folder: Path, state: Path, first: float) -> None:
        self.scene = Scene(folder / "gate.sim.json", state, robot=NAME)
        self.scene.hal.positions = REST.copy()
        self.scene.hal.positions[0] = first
        self.scene.ready_to_move()

    def joints(self, mode: ControlMode, first: float, rows: int = 1) -> Verdict:
        """Rows of the first joint; the others stay where they are, or stand still."""
        row = np.zeros(8)
        if mode == ControlMode.JOINT_POSITION:
            row[:7] = self.scene.hal.positions[:7]
        row[0] = first
        values = pack_floats(np.tile(row, (rows, 1)))
        return self._send(mode, "", values, ARM, rows)

    def delta(self, metres: float, rows: int) -> Verdict:
        row = np.zeros((rows, 6))
        row[:, 0] = metres
        return self._send(ControlMode.CARTESIAN_DELTA, "base_link", pack_floats(row), (), rows)

    def _send(
        self, mode: ControlMode, frame: str, values: bytes, active: tuple[int, ...], rows: int
    ) -> Verdict:
        part = ActionPart(part=0, mode=mode, frame_id=frame, values=values, active=active)
        return self.scene.send(self.scene.chunk(rows, parts=(part,)))


@pytest.mark.parametrize("turns", [0, 1, -3])
def test_a_target_is_judged_in_the_turn_that_is_measured_and_has_no_end(
    folder: Path, tmp_path: Path, turns: int
) -> None:
    at = 3.1 + turns * TURN
    arm = Arm(folder, tmp_path, at)
    try:
        onwards = arm.joints(ControlMode.JOINT_POSITION, at + 0.05)
        assert onwards.outcome == Outcome.RELEASED, onwards
        back = arm.joints(ControlMode.JOINT_POSITION, at + 0.05 - TURN)
        assert (back.outcome, back.code) == (Outcome.REFUSED, 21), "a turn away"
        far = arm.joints(ControlMode.JOINT_POSITION, at + 0.2)
        assert (far.outcome, far.code) == (Outcome.REFUSED, 21)
    finally:
        arm.scene.close()


def test_speed_is_bounded_where_position_is_not_and_a_sensor_may_begin_a_turn_anew(
    folder: Path, tmp_path: Path
) -> None:
    arm = Arm(folder, tmp_path, 50.0)
    try:
        fast = arm.joints(ControlMode.JOINT_VELOCITY, 2.2)
        assert (fast.outcome, fast.code) == (Outcome.REFUSED, 20)
        assert arm.joints(ControlMode.JOINT_VELOCITY, 0.7, rows=8).outcome == Outcome.RELEASED
        for position in (50.1, 50.1 - 8 * TURN, 50.2 - 8 * TURN):  # no jump: the same place
            arm.scene.hal.positions[0] = position
            arm.scene.next_tick(arm.scene.hal.held())
        assert arm.scene.status().state == GateState.ARMED
        arm.scene.hal.positions[0] += 0.3
        arm.scene.next_tick(arm.scene.hal.held())
        assert arm.scene.wait_state(GateState.STOPPED).cause.startswith("stopped: G013")
    finally:
        arm.scene.close()


def test_a_tools_motion_is_judged_alike_whatever_the_turn(folder: Path, tmp_path: Path) -> None:
    found = []
    for turns in (0, 2, -5):
        arm = Arm(folder, tmp_path / str(turns), REST[0] + turns * TURN)
        try:
            short, long = arm.delta(0.01, 4), arm.delta(0.03, 40)
            found.append((short.outcome, long.outcome, long.code, long.row))
        finally:
            arm.scene.close()
    assert found[0][0] == Outcome.RELEASED
    assert found[0][1] != Outcome.RELEASED, "so far is out of reach"
    assert found == [found[0]] * 3


def test_the_simulator_turns_it_on_and_on(folder: Path) -> None:
    robot = load_robot(NAME)
    backend = MujocoBackend(robot, options=MujocoOptions(start_spread_rad=0.0))
    row = np.append(backend.read().positions[:7], 0.0)
    for _ in range(80):
        row[0] += 0.1
        backend.apply({"arm": PartCommand(ControlMode.JOINT_POSITION, "", row, ARM)})
    assert backend.read().positions[0] > 7.5, "more than a turn"
    assert np.abs(backend.read().positions[1:7] - row[1:7]).max() < 0.05


def test_a_model_or_a_description_that_ends_it_is_refused_by_name(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = (folder / "robot.yaml").read_text()
    other = own_robot(tmp_path, monkeypatch)
    (other / "robot.yaml").write_text(manifest)
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "joint 'panda_joint1': type: expected continuous, as in robot.yaml, got 'revo" in (
        done.stderr
    )
    (other / "panda.urdf").write_bytes((folder / "panda.urdf").read_bytes())
    with pytest.raises(ConfigError, match="joint panda_joint1: expected a joint without range"):
        MujocoBackend(load_robot(NAME))
    model = other / "mine.xml"
    model.write_text(re.sub(r'(class="arm") range="[^"]*"', r"\1", model.read_text()))
    with pytest.raises(ConfigError, match="panda_joint1: ctrlrange of its actuator: expected none"):
        MujocoBackend(load_robot(NAME))
