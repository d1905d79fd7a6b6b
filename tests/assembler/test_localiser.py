"""Who says where ``odom`` is in ``map``: a real localiser beside real services.

A policy writes down where it saw the base. It saw one truth, or the goal failed.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import pytest
import yaml

from bench.equipment.light_hal import LIGHT_HAL, Pacing
from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from fairlead.messages import GoalResult, LayoutState, TransformBatch, decode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

ROOT = repo_root()
SOURCE = ROOT / "compose" / "panda_mobile_sim.yaml"
LOCALISER = ROOT / "docs" / "examples" / "localiser.py"
CALLS = 11
PACINGS = ["lockstep", pytest.param("realtime", marks=pytest.mark.thorough)]
X_M = 5.0
SKILL, WATCHED = "where-am-i", "watched"
MANIFEST = {
    "version": "0.1.0", "licence": "Apache-2.0", "model_family": "test",
    "policy": {
        "backend": "python", "options": {"file": "policy.py", "class": "WhereAmI", "probe": False},
    },
    "embodiments": ["panda_mobile"], "prompt": "look",
    "state_contract": {
        "layout": "human300_16d", "dim": 16,
        "bindings": {
            "eef_frame": "grip_site", "base_frame": "base_link", "world_frame": "map",
            "gripper_qpos_joints": ["panda_finger_joint1", "panda_finger_joint2"],
        },
    },
    "action_contract": {
        "dim": 1,
        "slots": [
            {"range": [0, 0], "control_mode": "gripper_position", "ee": "gripper",
             "scale": 0.04, "offset": 0.04}
        ],
    },
    "rate_hz": 20.0, "horizon": 4, "execute_steps": 1, "age_max_ticks": 10,
    "inference_timeout_s": 5.0,
}  # fmt: skip
POLICY = """
import numpy as np
from pathlib import Path
from typing import Literal

class WhereAmI:
    @classmethod
    def from_options(cls, skill, options):
        return cls()

    def reset(self):
        pass

    def infer(self, observation):
        with open(Path(__file__).with_name("seen.txt"), "a") as seen:
            print(observation.state[7], file=seen)
        return np.tile([observation.state[14] * 2 / 0.04 - 1.0], (4, 1)).astype(np.float32)
"""


class Scene:
    """A running robot, localisers beside it, and the layout that the assembler puts out.

    hal_frames: what the HAL has placed so far.
    """

    def __init__(self, robot: ScratchRobot, seen: Path) -> None:
        self._robot, self._seen = robot, seen
        self._processes: list[subprocess.Popen[bytes]] = []
        self._newest: LayoutState | None = None
        self.hal_frames: set[str] = set()
        bus, keys = robot.client.bus, robot.client.keys
        bus.subscribe(keys.tf("hal"), self._on_transforms)
        bus.subscribe(keys.layout(WATCHED), self._on_layout)
        self._wanted = bus.declare_token(keys.want_layout(WATCHED))

    def _on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        self.hal_frames.update(one.child for one in batch.transforms)

    def _on_layout(self, sample: Sample) -> None:
        self._newest = decode(LayoutState, sample.payload)

    def localise(self, name: str, x_m: float = X_M, fault: str = "") -> None:
        """Start one, and wait until the assembler shows that it has heard of it."""
        words = [str(LOCALISER), str(self._robot.scratch.file), name, str(x_m), "0"]
        self._processes.append(subprocess.Popen([sys.executable, *words]))
        wait_for(lambda: self._fault_of_a_new_answer() == fault, f"{name} is heard")

    def _fault_of_a_new_answer(self) -> str:
        """What is wrong with the layout now; "" for nothing. A tick's answer is for good."""
        bus, keys = self._robot.client.bus, self._robot.client.keys
        self._wanted.undeclare()
        self._newest = None
        self._wanted = bus.declare_token(keys.want_layout(WATCHED))
        wait_for(lambda: self._newest is not None, "a layout")
        assert self._newest is not None
        return self._newest.fault.kind if self._newest.fault else ""

    def run(self) -> tuple[GoalResult, list[float]]:
        """One goal of as many ticks as calls: its result, and where the policy saw the base."""
        self._seen.unlink(missing_ok=True)
        client = self._robot.client
        client.disarm()
        client.arm()
        result = run_goal(client, GoalOptions(SKILL, deadline_ticks=CALLS)).result
        assert result is not None
        lines = self._seen.read_text().split() if self._seen.exists() else []
        return result, [float(line) for line in lines]

    def close(self) -> None:
        for process in self._processes:
            process.terminate()
        for process in self._processes:
            process.wait(20.0)


@contextmanager
def scene(
    folder: Path, pacing: Pacing, localiser: str, access: Literal["closed", "open"] = "closed"
) -> Iterator[Scene]:
    """Closed, nobody hears a localiser that the deployment does not name."""
    options = ScratchOptions(pacing=pacing, hal=LIGHT_HAL, localiser=localiser, access=access)
    scratch = make_scratch(SOURCE, folder / "state", options)
    with scratch_robot(scratch, Registry(folder / "registry")) as robot:
        write_skill(folder, WATCHED)  # the runner, which has started, does not know it
        running = Scene(robot, folder / "rskills" / SKILL / "seen.txt")
        try:
            yield running
        finally:
            running.close()


def write_skill(folder: Path, name: str) -> None:
    skill = folder / "rskills" / name
    skill.mkdir(parents=True)
    (skill / "rskill.yaml").write_text(yaml.safe_dump({"id": name, **MANIFEST}))
    (skill / "policy.py").write_text(POLICY)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_skill(tmp_path, SKILL)
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path / "rskills"))
    return tmp_path


@pytest.mark.parametrize("pacing", PACINGS)
def test_named_localiser_is_what_every_call_sees_and_its_absence_is_a_fault_with_its_name(
    folder: Path, pacing: Pacing
) -> None:
    with scene(folder, pacing, "amcl") as running:
        result, seen = running.run()
        assert (result.outcome, result.kind, seen) == ("failed", "layout_missing_frame", []), result
        assert "amcl has not sent 'odom' (tf/amcl)" in result.detail
        assert running.hal_frames == {"base_link", "object", "goal"}
        running.localise("amcl")
        result, seen = running.run()
        assert (result.outcome, set(seen)) == ("deadline", {X_M}), result
        assert len(seen) == CALLS or pacing == "realtime"


@pytest.mark.parametrize("pacing", PACINGS)
def test_open_another_localiser_beside_the_named_one_is_a_fault_with_both_names(
    folder: Path, pacing: Pacing
) -> None:
    with scene(folder, pacing, "amcl", "open") as running:
        running.localise("amcl")
        running.localise("stray", x_m=1.0, fault="contested_frame")
        result, seen = running.run()
        assert (result.outcome, result.kind) == ("failed", "layout_contested_frame")
        assert "amcl sends map -> odom (every tick), stray sends map -> odom" in result.detail
        assert set(seen) <= {X_M}


@pytest.mark.parametrize("pacing", PACINGS)
def test_open_a_localiser_that_the_deployment_does_not_name_is_a_fault_with_both_names(
    folder: Path, pacing: Pacing
) -> None:
    with scene(folder, pacing, "", "open") as running:
        result, seen = running.run()
        assert (result.outcome, set(seen)) == ("deadline", {0.0})
        running.localise("stray", fault="contested_frame")
        result, seen = running.run()
        assert (result.outcome, result.kind) == ("failed", "layout_contested_frame")
        assert result.detail.endswith(
            "frame 'odom' is contested: hal sends map -> odom (static), stray sends map -> odom "
            "(every tick); only hal may send it"
        )
        assert set(seen) <= {0.0}
