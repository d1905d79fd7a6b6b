"""``fairlead robot measure``: any robot with a simulator, and what it says of bad ones."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry
from fairlead.deploy.service_spec import ServiceSpec
from fairlead.messages import GateState
from fairlead.modes import ControlMode
from fairlead.paths import deployment_path, repo_root, robot_dir
from fairlead.robot.manifest import load_robot
from fairlead_tools.measure.driven_robot import DrivenRobot, simulated_deployment
from fairlead_tools.measure.drives import modes_of, together
from fairlead_tools.measure.joints import watched_ticks
from fairlead_tools.measure.measurement import measure_gently
from fairlead_tools.measure.report import document
from fairlead_tools.measure.rotations import exponential, quaternion_of, rotation_of
from fairlead_tools.measure.rows import FullScaleRows
from fairlead_tools.measure.tracking import hull_distances
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.cli.command import fairlead_here as fairlead
from tests.draft.drafting import EXAMPLE

SHORT = ("--random", "80", "--stops", "1")


def measured(robot: str, state: Path, *options: str) -> dict[str, Any]:
    done = fairlead("robot", "measure", robot, *SHORT, "--json", *options, state=state)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def own_robot(tmp_path: Path, old: str, new: str) -> tuple[Path, Path]:
    """A copy of panda whose model differs: where robots are, and its deployment."""
    folder = tmp_path / "robots" / "mine"
    shutil.copytree(robot_dir("panda"), folder)
    for file in folder.iterdir():
        file.rename(folder / file.name.replace("panda", "mine"))
    robot = folder / "robot.yaml"
    text = robot.read_text(encoding="utf-8").replace("id: panda\n", "id: mine\n", 1)
    robot.write_text(text.replace("panda.urdf", "mine.urdf"), encoding="utf-8")
    model = folder / "mine.xml"
    text = model.read_text(encoding="utf-8")
    assert old in text
    model.write_text(text.replace(old, new), encoding="utf-8")
    deployment = tmp_path / "mine.yaml"
    text = (repo_root() / "compose" / "panda_mujoco.yaml").read_text(encoding="utf-8")
    deployment.write_text(text.replace("robot: panda ", "robot: mine "), encoding="utf-8")
    return folder.parent, deployment


def test_a_robot_that_ships_is_measured_into_limits_with_their_source(tmp_path: Path) -> None:
    found = measured("kinova3", tmp_path)
    assert found["findings"] == [] and found["contacts_at_rest"] == []
    joint = found["joints"]["joint_1"]
    assert 0.8 * joint["told_per_s"] < joint["speed_per_s"] and joint["effort_free"] > 0.0
    limits = found["proposed"]["parts"]["arm"]
    assert len(limits["joint_position"]["tracking_limits"]) == 7
    low, high = limits["cartesian_delta"]["gain"]
    assert 0.0 <= low < high <= 1.5 and limits["cartesian_delta"]["linear_tracking_m"] > 0.0
    block = found["proposed"]["measured"]["finger_joint"]
    assert set(block) == {"jump_per_tick", "tolerance", "standstill_per_s", "contact_limit",
                          "encoder_step", "dead_band_per_tick", "source"}  # fmt: skip
    assert block["source"].startswith("measured: fairlead robot measure kinova3")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("old", "new", "finding"),
    [
        (
            'class="proximal">\n      <position kp="4000" kv="250"',
            'class="proximal">\n      <position kp="200" kv="250"',
            "panda_joint1: its servo cannot follow: told 2.17 rad/s, got to ",
        ),
        (
            '<geom type="box" size="0.03 0.1 0.03" pos="0 0 0.03" mass="0.7"/>',
            '<geom type="box" size="0.03 0.1 0.8" pos="0 0 0.03" mass="0.7"/>',
            "contact at rest: ",
        ),
    ],
    ids=["weak servos", "touching the floor"],
)
def test_what_the_numbers_cannot_tell_is_said(
    old: str, new: str, finding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robots, deployment = own_robot(tmp_path, old, new)
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(robots))
    found = measured("mine", tmp_path / "state", "--deployment", str(deployment))
    assert any(one.startswith(finding) for one in found["findings"]), found["findings"]


@pytest.mark.thorough
@pytest.mark.processes
def test_a_robot_that_runs_is_measured_slowly_through_its_gate(tmp_path: Path) -> None:
    source = repo_root() / "compose" / "so101_mujoco.yaml"
    options = ScratchOptions(options={"runner": {"skills": ["so101-reach"]}})
    scratch = make_scratch(source, tmp_path / "state", options)
    words = ("robot", "measure", "so101", "--running", "--json", "--share", "0.2", "-d")
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        done = fairlead(*words, str(scratch.file), state=tmp_path)
        after = robot.client.gate_status()
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert after.state == GateState.DISARMED and not after.claims
    assert 0.2 < found["joints"]["elbow_flex"]["told_per_s"] < 0.9
    assert len(found["proposed"]["parts"]["arm"]["joint_position"]["tracking_limits"]) == 5


def test_after_a_gentle_drive_no_limit_is_tighter_than_declared() -> None:
    """Nobody saw what full scale does; and a stop is watched for as long as it may take."""
    driven = DrivenRobot("so101", load_deployment(deployment_path("so101_mujoco")))
    hal = ServiceSpec(command=("python", "./arm.py"))  # as a robot that runs may have one
    driven.deployment = driven.deployment.model_copy(
        update={"services": driven.deployment.services | {driven.deployment.hal: hal}}
    )
    found = document(measure_gently(driven, 0.1, lambda text: None))
    declared = driven.robot.profile(driven.profile)
    for name, block in found["proposed"]["measured"].items():
        limits = declared.measured[name]
        for key, proposed in block.items():
            if key != "source":
                assert proposed >= (getattr(limits, key) or 0.0), (name, key)
        assert ", so101, python ./arm.py, at 0.1 of full scale" in block["source"]
    arm = found["proposed"]["parts"]["arm"]["joint_position"]["tracking_limits"]
    mode = declared.parts["arm"].joint_position
    assert mode is not None and list(arm) >= list(mode.tracking_limits)
    assert found["proposed"]["protocol"]["stop_ramp_ms"] >= declared.protocol.stop_ramp_ms
    assert any(text.startswith("driven at 0.1 of full scale") for text in found["findings"])
    assert watched_ticks(driven) * driven.period_s >= 2e-3 * declared.protocol.stop_ramp_ms


def test_an_impact_within_a_tick_is_not_the_servos_lag() -> None:
    """The wrist hits the table and is off it again before the tick ends."""
    driven, lags, free = DrivenRobot("ur5e"), list[float](), list[bool]()
    for tick in together(driven, 692):
        command = tick.commands["arm"]
        assert command.mode is ControlMode.JOINT_POSITION
        lags.append(float(np.abs(command.values[:6] - tick.after.positions[:6]).max()))
        free.append(tick.is_free)
    assert max(lags) > 0.2
    assert max(lag for lag, is_free in zip(lags, free, strict=True) if is_free) < 0.13


@pytest.mark.simulator
def test_robosuites_contacts_are_those_of_every_physics_step() -> None:
    """Compared with what MuJoCo has at each step, read here."""
    driven = DrivenRobot("ur5e", load_deployment(deployment_path("ur5e_robosuite")))
    env = driven.backend.env  # type: ignore[attr-defined]
    seen, go_on = set[str](), env._pre_action

    def look(*words: Any, **named: Any) -> None:
        seen.update(_touching(env.sim))
        go_on(*words, **named)

    env._pre_action = look
    now, short = driven.reset(3), 0
    driven.contacts()
    part, mode = next(pair for pair in modes_of(driven) if pair[1] is ControlMode.CARTESIAN_DELTA)
    rows = FullScaleRows(driven.robot, part, mode, profile=driven.profile)
    down = np.array([0.3, 0.0, -1.0, 0.0, 0.0, 0.0])
    for tick in range(120):
        seen.clear()
        wish = down if tick % 40 < 30 else -down
        driven.backend.apply({part: rows.row(wish, now)})
        now, last = driven.look(), _touching(env.sim)
        assert set(driven.contacts()) == seen | last
        short += len(seen - last)
    assert short > 0, "something touched and was off again within a tick"


def _touching(sim: Any) -> set[str]:
    model, found = sim.model._model, set[str]()
    for one in sim.data._data.contact:
        names = [model.body(model.geom_bodyid[geom]).name for geom in (one.geom1, one.geom2)]
        if one.dist < 0 and any(name.startswith(("robot0_", "gripper0_")) for name in names):
            found.add(" and ".join(name or "an unnamed body" for name in names))
    return found


def test_a_robot_that_has_both_is_driven_in_its_simulator() -> None:
    assert load_deployment(deployment_path("so101")).profile == "hardware"
    assert simulated_deployment("so101").profile == "sim"


def test_a_robot_without_a_simulator_is_refused(tmp_path: Path) -> None:
    other = repo_root() / "compose" / "panda_mujoco.yaml"
    done = fairlead("robot", "measure", "ur5e", "--deployment", str(other), state=tmp_path)
    assert done.returncode != 0 and "Traceback" not in done.stderr
    assert "robot measure: deployment panda: expected robot ur5e, got panda" in done.stderr


def test_the_distance_to_a_mixture_of_corners_is_that_of_many_mixtures() -> None:
    rng = np.random.default_rng(2)
    points, corners = rng.normal(size=(20, 3)), rng.normal(size=(20, 4, 3))
    corners[:5, 3] = corners[:5, 2]
    found = hull_distances(points, corners)
    shares = rng.dirichlet(np.full(4, 0.4), size=20_000)
    for point, own, distance in zip(points, corners, found, strict=True):
        nearest = float(np.linalg.norm(shares @ own - point, axis=1).min())
        assert distance - 1e-9 <= nearest <= distance + 0.1


def test_rotations_go_there_and_back() -> None:
    rng = np.random.default_rng(3)
    for vector in [*rng.normal(size=(20, 3)), np.zeros(3), np.array([np.pi, 0.0, 0.0])]:
        turn = exponential(vector)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(turn @ vector, vector, atol=1e-12)
        np.testing.assert_allclose(rotation_of(quaternion_of(turn)), turn, atol=1e-12)


@pytest.mark.thorough
def test_a_drafted_robot_is_measured_by_the_file_that_is_here_and_without_physics_that_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path / "robots"))
    monkeypatch.chdir(tmp_path)
    drafted = fairlead("robot", "new", "mine", "--mjcf", str(EXAMPLE), state=tmp_path)
    assert drafted.returncode == 0, drafted.stderr
    with_physics = measured("mine", tmp_path)
    declared = load_robot("mine").profile("sim").measured["lift"].tolerance
    proposed = with_physics["proposed"]["measured"]["lift"]["tolerance"]
    assert 0.05 < proposed <= declared  # what lets a chunk begin while the servo is behind
    file = tmp_path / "mine.yaml"
    file.write_text(file.read_text().replace("hal_mujoco}", "hal_kinematic}"))
    assert measured("mine", tmp_path)["findings"] == [
        "no joint reported an effort: without physics no number here is the robot's own"
    ]
