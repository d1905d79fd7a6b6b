"""Skills that see through three cameras: real pictures reach a real policy server, or none does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from PIL import Image as Pillow

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.registry import Registry
from fairlead.messages import GateState
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_hal_sim.task.scene import COUNTER_HEIGHT_M
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from fairlead_tools.supervisor.this_host import free_ports
from tests.cli.command import fairlead_here as fairlead
from tests.runner.policy_servers import (
    OpenpiServer,
    RldxServer,
    openpi_actions,
    read_npy,
    read_openpi_array,
    rldx_actions,
    rldx_rows,
)

pytestmark = [
    pytest.mark.processes,
    pytest.mark.simulator,
    pytest.mark.timeout(300),
    pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine"),
]

GROOT = "gr00t-robocasa"
PI05, RLDX, SERVERLESS = "pi05-robocasa365-human300-nf4", "rldx1-ft-rc365-nf4", "rldx-robocasa"
LEFT, RIGHT, HAND = "robot0_agentview_left", "robot0_agentview_right", "robot0_eye_in_hand"
SIZE_PX, SEED, DEADLINE_TICKS = 256, 0, 24
STILL = np.zeros((15, 12), dtype=np.float32)
"""So many rows that goals end at ticks at which no camera is due."""
Picture = np.ndarray[Any, np.dtype[np.uint8]]


class Landmark(NamedTuple):
    """A point that a camera must show, and how its colour [0 to 255] is known."""

    camera: str
    world_m: tuple[float, float, float]
    is_seen: Callable[[int, int, int], bool]


class CameraRobot(NamedTuple):
    """A robot with its cameras on, and the servers of two of its skills."""

    robot: ScratchRobot
    registry: Path
    openpi: OpenpiServer
    rldx: RldxServer
    rows: np.ndarray[Any, np.dtype[np.float32]]
    """The openpi server's answer."""

    def run(self, skill: str, seed: int | None = SEED) -> str:
        """One goal to its deadline, in a new episode unless told; returns its outcome."""
        client = self.robot.client
        if seed is not None:
            client.reset_episode(seed)
        client.arm()
        progress = run_goal(client, GoalOptions(skill, deadline_ticks=DEADLINE_TICKS))
        client.disarm()
        assert progress.result is not None
        return f"{progress.result.outcome} {progress.result.detail}"


@pytest.fixture(scope="module")
def camera_robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CameraRobot]:
    folder = tmp_path_factory.mktemp("cameras")
    rows = STILL.copy()
    openpi = OpenpiServer(lambda request, n: openpi_actions(rows))
    rldx = RldxServer(lambda request, n: rldx_actions(rldx_rows(STILL)))
    servers = {
        PI05: openpi.address,
        RLDX: rldx.address,
        GROOT: rldx.address,
        SERVERLESS: f"tcp://127.0.0.1:{free_ports(1)[0]}",
    }
    scratch = make_scratch(
        repo_root() / "compose" / "panda_mobile_sim_cameras.yaml",
        folder / "state",
        ScratchOptions(options={"runner": {"servers": servers}}),
    )
    try:
        with scratch_robot(scratch, Registry(folder / "registry")) as robot:
            yield CameraRobot(robot, folder / "registry", openpi, rldx, rows)
    finally:
        openpi.close()
        rldx.close()


def check_pictures(pictures: dict[str, Picture]) -> None:
    """Each of the three shows what its camera must see, upright, unmirrored, in RGB."""
    backend = RobosuiteBackend(SimulatorOptions())
    backend.reset(SEED)
    sim, scene = backend.env.sim, backend.env.scene
    can = tuple(sim.data.body_xpos[sim.model.body_name2id(backend.env.can.root_body)])
    counter_end = (*scene.counter.at(0.3, -0.5), COUNTER_HEIGHT_M)
    landmarks = [
        Landmark(LEFT, can, lambda r, g, b: r > 3 * g and r > 3 * b),
        Landmark(RIGHT, counter_end, lambda r, g, b: r > g + 20 > b + 40),
        Landmark(RIGHT, (*scene.counter.at(0.0, -0.3), 0.5), lambda r, g, b: b > r + 10),
        Landmark(HAND, (*scene.counter.at(0.0, -0.3), 0.5), lambda r, g, b: b > r + 10),
        Landmark(HAND, (0.4, 0.3, 0.0), lambda r, g, b: min(r, g, b) > 140 > max(r, g, b) - 60),
    ]
    for camera, point, is_seen in landmarks:
        assert pictures[camera].shape == (SIZE_PX, SIZE_PX, 3)
        row, column = pixel_of(backend, camera, point)
        red, green, blue = (int(value) for value in pictures[camera][row, column])
        assert is_seen(red, green, blue), (camera, row, column, (red, green, blue))
    backend.close()


def pixel_of(
    backend: RobosuiteBackend, camera: str, world_m: tuple[float, float, float]
) -> tuple[int, int]:
    """Row and column where a camera shows a point, by a pinhole's geometry."""
    sim = backend.env.sim
    index = sim.model.camera_name2id(camera)
    rotation = sim.data.cam_xmat[index].reshape(3, 3)
    right, up, back = rotation.T @ (np.array(world_m) - sim.data.cam_xpos[index])
    focal_px = SIZE_PX / 2 / np.tan(np.radians(sim.model.cam_fovy[index]) / 2)
    return (
        int(SIZE_PX / 2 + focal_px * up / back),
        int(SIZE_PX / 2 - focal_px * right / back),
    )


def test_what_a_camera_sees_is_saved_as_a_picture(
    camera_robot: CameraRobot, tmp_path: Path
) -> None:
    scratch, state = camera_robot.robot.scratch, camera_robot.registry
    on = ("-d", str(scratch.file))
    camera_robot.robot.client.reset_episode(SEED)
    pictures: dict[str, Picture] = {}
    for camera in (LEFT, RIGHT, HAND):
        file = tmp_path / f"{camera}.png"
        done = fairlead("topic", "echo", f"camera/{camera}", "--save", str(file), *on, state=state)
        assert (done.returncode, done.stderr) == (0, f"wrote {file}\n")
        assert f"camera: {camera}," in done.stdout and "data: 196608 bytes" in done.stdout
        with Pillow.open(file) as saved:
            assert saved.format == "PNG"
            pictures[camera] = np.asarray(saved)
    check_pictures(pictures)
    for words, said in {
        ("state/joints", "a.png"): "expected a camera's key, such as camera/*, got 'state/joints'",
        ("camera/*", "a.jpg"): "expected a file that ends in .png, got a.jpg",
        ("camera/*", "a.png", "--count", "2"): "expected one picture, got --count 2",
    }.items():
        key, name, *more = words
        refused = fairlead("topic", "echo", key, "--save", name, *more, *on, state=state)
        assert (refused.returncode, refused.stderr) == (1, f"ERROR topic echo --save: {said}\n")


def test_an_openpi_server_gets_all_three_pictures(camera_robot: CameraRobot) -> None:
    assert camera_robot.run(PI05).startswith("deadline not done after")
    warm_up, first, *later = camera_robot.openpi.requests
    names = {LEFT: "observation/image", RIGHT: "observation/right_image",
             HAND: "observation/wrist_image"}  # fmt: skip
    assert not any(read_openpi_array(warm_up[name]).any() for name in names.values())
    pictures = {camera: read_openpi_array(first[name]) for camera, name in names.items()}
    assert {picture.dtype for picture in pictures.values()} == {np.dtype(np.uint8)}
    check_pictures(pictures)
    assert later, "it is asked again, and again with pictures"
    assert all(read_openpi_array(request[name]).any() for request in later
               for name in names.values())  # fmt: skip
    scratch = camera_robot.robot.scratch
    said = (scratch.state_dir / "logs" / "runner.log").read_text(encoding="utf-8")
    for camera in names:
        key = scratch.deployment.keys.camera(camera)
        assert f"{key}: frames come through shared memory" in said


def test_a_policy_s_overshoot_is_clipped_as_in_training_and_said_instead_of_refused(
    camera_robot: CameraRobot,
) -> None:
    refused = dict(camera_robot.robot.client.gate_status().counters).get("G020", 0)
    beyond = STILL.copy()
    beyond[0, 2] = 1.02  # a short way up
    beyond[:, [6, 7, 11]] = [1.01, 0.02, -1.01]
    camera_robot.rows[:] = beyond
    try:
        said = camera_robot.run(PI05)
    finally:
        camera_robot.rows[:] = STILL
    assert said.startswith("deadline not done after")
    assert "slot [0, 5] cartesian_delta: " in said
    assert "clipped, farthest 1.02; slot [6, 6] gripper_position: " in said
    assert "slot [7, 9]" not in said
    assert "refused" not in said
    assert dict(camera_robot.robot.client.gate_status().counters).get("G020", 0) == refused


def test_an_rldx_server_gets_all_three_pictures(camera_robot: CameraRobot) -> None:
    assert camera_robot.run(RLDX).startswith("deadline not done after")
    _, first, second = [
        {name: read_npy(request["observation"][f"video.{name}"]) for name in (LEFT, RIGHT, HAND)}
        for request in camera_robot.rldx.requests[:3]
    ]
    assert {frames.shape for frames in first.values()} == {(1, 4, SIZE_PX, SIZE_PX, 3)}
    check_pictures({name: frames[0, -1] for name, frames in first.items()})
    assert all((frames == frames[:, :1]).all() for frames in first.values()), "nothing before it"
    assert all(frames[0, -1].any() for frames in second.values())


def test_a_gr00t_server_gets_its_five_states_and_one_frame_a_picture(
    camera_robot: CameraRobot,
) -> None:
    assert camera_robot.run(GROOT).startswith("deadline not done after")
    asked = camera_robot.rldx.requests[-1]["observation"]
    state = {
        name.removeprefix("state."): read_npy(packed)[0, 0]
        for name, packed in asked.items()
        if name.startswith("state.")
    }
    assert {name: len(values) for name, values in state.items()} == {
        "end_effector_position_relative": 3, "end_effector_rotation_relative": 4,
        "base_position": 3, "base_rotation": 4, "gripper_qpos": 2,
    }  # fmt: skip
    for name in ("end_effector_rotation_relative", "base_rotation"):
        assert np.linalg.norm(state[name]) == pytest.approx(1.0, abs=1e-6)
    assert read_npy(asked["video.res256_image_side_0"]).shape == (1, 1, SIZE_PX, SIZE_PX, 3)


@pytest.mark.parametrize("seed", [SEED, None])
def test_goals_in_a_row_all_see_the_frame_that_was_due_last(
    camera_robot: CameraRobot, seed: int | None
) -> None:
    for _ in range(2):
        assert camera_robot.run(PI05, seed).startswith("deadline not done after")


def test_without_its_server_a_skill_fails_with_address_and_how_to_start_one(
    camera_robot: CameraRobot,
) -> None:
    client, scratch = camera_robot.robot.client, camera_robot.robot.scratch
    before = dict(client.gate_status().counters)
    done = fairlead(
        "run", SERVERLESS, "--deployment", str(scratch.file), state=camera_robot.registry
    )
    assert done.returncode == 1
    address = scratch.deployment.services["runner"].options["servers"][SERVERLESS]
    assert f"ERROR runner refused: skill {SERVERLESS} is not loaded: " in done.stderr
    assert f"rldx policy: no policy server at {address}: no answer within 4 s\n" in done.stderr
    assert "  start one: uv run python rldx/eval/run_rldx_server.py " in done.stderr
    assert f"    servers: {{{SERVERLESS}: ADDRESS}}\n" in done.stderr
    gate = client.gate_status()
    assert (gate.state, gate.claims) == (GateState.DISARMED, ())
    assert dict(gate.counters) == before, "nothing was armed, claimed or judged"
