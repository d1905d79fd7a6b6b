"""Two runners on one robot: the base drives to poses, the arm works beside it."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL, Pacing
from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from fairlead.errors import ChunkRefusedError, ClaimLostError, ConfigError, RefusedError
from fairlead.messages import (
    GoalResult,
    Hold,
    JointState,
    TransformBatch,
    Verdict,
    decode,
    floats,
)
from fairlead.modes import ControlMode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.operate.runner_choice import choose_runner
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.system.mode_robot import ModeSkill, write_skills

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"
ROBOT = load_robot("panda_mobile")
ARM, GRIPPER, BASE, COMPOSITE = range(4)
DELTA = {
    "control_mode": "cartesian_delta", "ee": "gripper", "frame": "base_link",
    "scale": [0.05, 0.05, 0.05, 0.5, 0.5, 0.5],
}  # fmt: skip
ARM_ONLY = {"wiggle": ModeSkill((DELTA,), ((0.0, 0.0, 0.02, 0.0, 0.0, 0.0),))}
STATE = {"layout": "libero", "dim": 9}


class TwoRunners:
    """A robot with two runners: states, base poses and verdicts as they came."""

    def __init__(self, folder: Path, pacing: Pacing, registry: Registry) -> None:
        self.states: list[JointState] = []
        self.poses: dict[int, tuple[float, float, float]] = {}
        self.verdicts: list[Verdict] = []
        options = ScratchOptions(pacing=pacing, hal=LIGHT_HAL)
        self._robot = scratch_robot(make_scratch(SOURCE, folder, options), registry)

    def __enter__(self) -> TwoRunners:
        self.robot = self._robot.__enter__()
        self.client = self.robot.client
        bus, keys = self.client.bus, self.client.keys
        bus.subscribe(keys.joints, lambda s: self.states.append(decode(JointState, s.payload)))
        bus.subscribe(keys.tf("hal"), self._on_transforms)
        bus.subscribe(
            keys.every_verdict, lambda s: self.verdicts.append(decode(Verdict, s.payload))
        )
        return self

    def __exit__(self, *error: object) -> None:
        self._robot.__exit__(*error)  # type: ignore[arg-type]

    def _on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        for one in batch.transforms:
            if (one.parent, one.child) == ("odom", "base_link"):
                x, y, _ = floats(one.translation)
                _, _, z, w = floats(one.rotation_xyzw)
                self.poses[batch.tick] = float(x), float(y), 2 * math.atan2(z, w)

    def fresh(self) -> None:
        for stop_id in self.client.gate_status().stop_ids:
            self.client.reset(stop_id)
        self.client.disarm()
        self.client.reset_episode(0)
        self.client.arm()
        self.states.clear()
        self.verdicts.clear()

    def run(self, skill: str, prompt: str = "", deadline_ticks: int = 600) -> GoalResult:
        result = run_goal(self.client, GoalOptions(skill, prompt, deadline_ticks)).result
        assert result is not None
        return result

    def start(self, skill: str, prompt: str = "", deadline_ticks: int = 600) -> Future[GoalResult]:
        ended: Future[GoalResult] = Future()

        def follow() -> None:
            try:
                ended.set_result(self.run(skill, prompt, deadline_ticks))
            except BaseException as error:  # noqa: BLE001 - handed to whoever asks
                ended.set_exception(error)

        threading.Thread(target=follow, daemon=True).start()
        return ended

    def pose(self) -> tuple[float, float, float]:
        """Of the base, at the newest tick."""
        return self.poses[max(self.poses)]

    def ticks_of(self, *parts: int) -> list[int]:
        """Ticks after which every one of ``parts`` had executed a released row."""
        return sorted(
            {s.tick for s in self.states if all(s.acted[p].hold == Hold.NONE for p in parts)}
        )

    def cancel(self, runner: str) -> None:
        self.client.cancel(runner, self.client.goal_feedback(runner).goal_id)

    def is_claimed_by(self, runner: str) -> bool:
        return any(claim.source == runner for claim in self.client.gate_status().claims)


@pytest.fixture(scope="module", params=["lockstep", "realtime"])
def robot(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    registry: Registry,
) -> Iterator[TwoRunners]:
    skills = tmp_path_factory.mktemp("skills")
    write_skills(skills, ARM_ONLY, ROBOT, STATE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SKILLS_VARIABLE, str(skills))
        folder = tmp_path_factory.mktemp(request.param) / "state"
        with TwoRunners(folder, request.param, registry) as running:
            running.client.arm()
            yield running


def test_the_base_gets_to_a_pose_and_the_goal_succeeds_by_the_policys_word(
    robot: TwoRunners,
) -> None:
    robot.fresh()
    result = robot.run("go-to", "0.3 -0.2 0.7")
    assert (result.outcome, result.decided_by, result.kind) == ("succeeded", "policy", "")
    x, y, yaw = robot.pose()
    assert math.hypot(x - 0.3, y + 0.2) < 0.035
    assert abs(yaw - 0.7) < 0.035
    assert not any(verdict.code for verdict in robot.verdicts)
    assert result.detail.startswith("the base is at 0.")
    assert robot.ticks_of(ARM) == []
    assert {claim.source for claim in robot.client.gate_status().claims} == set()


@pytest.mark.parametrize(
    ("prompt", "kind", "said"),
    [
        ("", "bad_goal", "got 'x y yaw'"),
        ("1 2", "bad_goal", "in plain numbers, such as 0.5 -1 1.57, got '1 2'"),
        ("1 2 nan", "bad_goal", "got '1 2 nan'"),
        ("3.9 0 0", "goal_outside_zones", "0.05 m outside keep_in zone kitchen"),
    ],
)
def test_a_goal_that_cannot_be_meant_fails_before_the_base_moves(
    robot: TwoRunners, prompt: str, kind: str, said: str
) -> None:
    robot.fresh()
    result = robot.run("go-to", prompt)
    assert (result.outcome, result.decided_by, result.kind) == ("failed", "policy", kind)
    assert said in result.detail
    assert robot.ticks_of(BASE) == []


def test_the_arm_moves_while_the_base_drives(robot: TwoRunners) -> None:
    robot.fresh()
    wiggling = robot.start("wiggle", deadline_ticks=0)
    wait_for(lambda: len(robot.ticks_of(ARM)) > 3, "the arm moves")
    result = robot.run("go-to", "0.4 0.2 0")
    assert result.outcome == "succeeded", result
    assert not wiggling.done(), wiggling.result()
    robot.cancel("manipulation")
    assert wiggling.result(10.0).outcome == "cancelled"
    both = robot.ticks_of(ARM, BASE)
    assert len(both) >= 20
    assert not any(verdict.code for verdict in robot.verdicts)
    pacing = robot.client.deployment.pacing
    if pacing == "lockstep":  # the world waited for both, in each tick
        assert both == list(range(both[0], both[0] + len(both)))


def test_each_runner_says_how_its_own_goal_goes_and_a_cancel_ends_one(robot: TwoRunners) -> None:
    robot.fresh()
    driving = robot.start("go-to", "-1.5 1.5 0")
    wiggling = robot.start("wiggle", deadline_ticks=0)
    wait_for(
        lambda: len(robot.ticks_of(ARM, BASE)) > 3 and robot.is_claimed_by("manipulation"), "both"
    )
    goals = {one: robot.client.goal_feedback(one) for one in ("navigation", "manipulation")}
    assert {name: goal.skill for name, goal in goals.items()} == {
        "navigation": "go-to",
        "manipulation": "wiggle",
    }
    robot.client.cancel("navigation", goals["navigation"].goal_id)
    assert driving.result(10.0).outcome == "cancelled"
    claims = {claim.source: claim.parts for claim in robot.client.gate_status().claims}
    assert claims == {"manipulation": ("arm", "composite")}
    with pytest.raises(RefusedError, match="no goal"):
        robot.client.cancel("navigation", goals["manipulation"].goal_id)
    robot.client.cancel("manipulation", goals["manipulation"].goal_id)
    assert wiggling.result(10.0).outcome == "cancelled"
    ended = robot.client.goal_feedback("manipulation")
    assert ended.result is not None
    assert ended.result.outcome == "cancelled"


def test_which_runner_a_goal_is_for(robot: TwoRunners) -> None:
    deployment = robot.client.deployment
    assert choose_runner(deployment, "go-to") == "navigation"
    assert choose_runner(deployment, "go-to", "manipulation") == "manipulation"
    assert choose_runner(deployment, "wiggle") == "manipulation"
    with pytest.raises(ConfigError) as caught:
        choose_runner(deployment, "go-to", "runner")
    assert str(caught.value).endswith(
        "expected a runner, got 'runner' (valid: navigation, manipulation)"
    )


def test_a_client_of_ones_own_drives_the_base_through_the_gate_beside_a_runner(
    robot: TwoRunners,
) -> None:
    robot.fresh()
    wiggling = robot.start("wiggle", deadline_ticks=0)
    wait_for(lambda: len(robot.ticks_of(ARM)) > 3, "the arm moves")
    example = repo_root() / "docs" / "examples" / "go_to_client.py"
    words = [sys.executable, str(example), str(robot.robot.scratch.file), "0.2", "0.1", "-0.5"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    x, y, yaw = robot.pose()
    assert math.hypot(x - 0.2, y - 0.1) < 0.05
    assert abs(yaw + 0.5) < 0.05
    assert [verdict for verdict in robot.verdicts if verdict.code] == []
    assert len(robot.ticks_of(ARM, BASE)) > 20
    assert not wiggling.done(), wiggling.result()
    assert not robot.is_claimed_by("planner")
    robot.cancel("manipulation")
    wiggling.result(10.0)


def test_the_claim_of_a_client_is_what_a_goal_is_refused_for_and_by_name(
    robot: TwoRunners,
) -> None:
    robot.fresh()
    client = robot.client
    with client.claim(["base"], source="planner", task="drive") as claim:
        result = robot.run("go-to", "0 0 0")
        assert (result.outcome, result.kind) == ("failed", "claim_refused")
        assert "part base is held by planner (drive)" in result.detail
        assert result.detail.endswith(
            "try: fairlead cancel planner (if no runner: end it where it began)"
        )
        with (
            pytest.raises(RefusedError, match="held by planner"),
            client.claim(["base"], source="other"),
        ):
            pass
        client.disarm()
        with pytest.raises(ClaimLostError, match="claim of planner lost: the gate"):
            while True:
                claim.next_tick()


def test_what_a_client_sends_beyond_a_limit_is_refused_with_the_limit(robot: TwoRunners) -> None:
    robot.fresh()
    with (
        robot.client.claim(["base"], source="planner") as claim,
        pytest.raises(ChunkRefusedError, match=r"G020 limit: .* 0.5 m/s, limit 0.4 m/s") as refused,
    ):
        too_fast = claim.rows("base", ControlMode.BODY_TWIST, [[0.5, 0, 0, 0, 0, 0]] * 4)
        claim.send(claim.next_tick().number, too_fast)
    assert (refused.value.verdict.code, refused.value.verdict.part) == (20, "base")
    assert robot.ticks_of(BASE) == []
