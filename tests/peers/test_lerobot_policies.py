"""Small policies that lerobot itself made and saved: our skill's rows are lerobot's own."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.registry import Registry
from fairlead.errors import PolicyError
from fairlead.messages import GateState
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import deployment_path
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policy_worker import LOAD_TIMEOUT_S, PolicyWorker
from fairlead_skill_runner.trace import read_trace
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.cli.command import fairlead
from tests.peers.environment import by_lerobot, lerobot
from tests.peers.make_lerobot import SEED
from tests.runner.lerobot_skill import EYE, HORIZON, install

pytestmark = [pytest.mark.processes, pytest.mark.timeout(900)]
DELTAS = {"diffusion": (-1, 0)}
CAMERAS = "ur5e_robosuite_cameras"
renders = pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine")


@pytest.fixture(scope="module")
def checkpoints(tmp_path_factory: pytest.TempPathFactory) -> Path:
    lerobot()
    folder = tmp_path_factory.mktemp("lerobot")
    by_lerobot(folder, "make_lerobot", folder)
    return folder


@pytest.fixture
def skills(tmp_path: Path, checkpoints: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    monkeypatch.setenv("HF_HOME", str(checkpoints / "hf"))
    return tmp_path / "skills"


def made(skills: Path, checkpoints: Path, kind: str, clip: float | None = 0.28) -> SkillManifest:
    return install(
        skills, Path(lerobot()), DELTAS.get(kind, (0,)), f"lerobot-{kind}", clip,
        checkpoint=str(checkpoints / kind), seed=SEED,
    )  # fmt: skip


def worker_of(skill: SkillManifest) -> PolicyWorker:
    return PolicyWorker(POLICIES.find("lerobot"), skill, skill.policy.options)


@pytest.mark.asyncio
@pytest.mark.parametrize("kind", ["act", "diffusion"])
async def test_the_rows_are_lerobot_s_own_bit_for_bit(
    skills: Path, checkpoints: Path, kind: str
) -> None:
    with np.load(checkpoints / f"{kind}.npz") as file:
        states, eyes, wanted = file["states"], file["eyes"], file["rows"]
    worker = worker_of(made(skills, checkpoints, kind))
    await worker.load(2 * LOAD_TIMEOUT_S)
    frames = {EYE: eyes} if len(eyes) > 1 else {}
    seen = Observation(5, states[-1], "go", {EYE: eyes[-1]}, frames=frames, earlier=states[:-1])
    for _ in range(2):
        await worker.reset()
        rows = await worker.infer(seen)
        assert isinstance(rows, np.ndarray)
        assert len(wanted) > HORIZON, "the rest is not used"
        np.testing.assert_array_equal(rows, wanted[:HORIZON])
    await worker.close()


@pytest.mark.asyncio
@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("unknown", "\n  action: was normalised in training, but the processors have no stat"),
        ("nan", "expected actions as finite float32 numbers, got nan in row 0 dimension 3"),
    ],
)
async def test_what_lerobot_would_run_silently_is_refused_before_any_claim(
    skills: Path, checkpoints: Path, kind: str, text: str
) -> None:
    with pytest.raises(PolicyError) as caught:
        await worker_of(made(skills, checkpoints, kind)).load(2 * LOAD_TIMEOUT_S)
    assert text in str(caught.value)


@renders
@pytest.mark.simulator
@pytest.mark.parametrize("kind", ["act", "diffusion"])
def test_deployed_it_sees_and_says_what_it_does_in_one_process(
    skills: Path, checkpoints: Path, tmp_path: Path, kind: str
) -> None:
    """Fails where loading takes 30 s: the gate has disarmed then."""
    skill = made(skills, checkpoints, kind)
    done = fairlead(
        "parity", "--json", "--policy", "-d", CAMERAS, "--skill", skill.id,
        "--ticks", "24", "--out", str(tmp_path / "out"), state=tmp_path / "registry",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads(done.stdout)
    assert report["same"] and report["policy"][2]["deployed"] == 24 / HORIZON


@renders
@pytest.mark.simulator
def test_deployed_what_the_gate_releases_moves_the_hand_and_what_is_beyond_limits_is_refused(
    skills: Path, checkpoints: Path, tmp_path: Path
) -> None:
    options = ScratchOptions(options={"runner": {"trace": True}})
    scratch = make_scratch(deployment_path(CAMERAS), tmp_path / "state", options)
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        for kind in ("act", "diffusion", "wild"):
            skill = made(skills, checkpoints, kind, None if kind == "wild" else 0.28)
            for _ in range(2):  # where loading takes long, the gate has disarmed meanwhile
                robot.client.reset_episode(0)
                robot.client.arm()
                result = run_goal(robot.client, GoalOptions(skill.id, deadline_ticks=40)).result
                if robot.client.gate_status().state == GateState.ARMED:
                    robot.client.disarm()
            assert result is not None
            if kind == "wild":
                assert re.search("40 of 40 chunks refused.* G02", result.detail), result.detail
                continue
            assert result.outcome == "deadline", result
            assert "refused" not in result.detail
            calls = list(read_trace(tmp_path / "state" / "runner" / "trace.jsonl"))
            assert len(calls) >= 40 / HORIZON
            moved_m = calls[-1].state[:3] - calls[0].state[:3]
            told_m = 0.05 * sum(
                call.actions[: later.tick - call.tick, :3].sum(0) for call, later in pairwise(calls)
            )
            way_m = float(np.linalg.norm(moved_m))
            assert way_m > 0.01, moved_m
            assert moved_m @ told_m > 0.8 * way_m * np.linalg.norm(told_m), (moved_m, told_m)
