"""Skills of a chain hand their parts to each other without a hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
import yaml

from fairlead.deploy.registry import Registry
from fairlead.messages import Acted, FloatArray, JointState, SafeChunk, decode, floats
from fairlead.paths import repo_root, rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

ORACLE = "oracle-counter-to-cabinet"
REACH = "panda-joint-reach"
ONE, TWO = ["runner"], ["runner", "second"]
STEPS = {
    "pick": {"last": "LIFT"},
    "drive": {"first": "TRANSPORT", "last": "TRANSPORT"},
    "place": {"first": "ENTER"},
}
TURN = """
import time

import numpy as np
from fairlead.policy import Done


class Policy:
    @classmethod
    def from_options(cls, skill, options):
        time.sleep(options["loading_s"])
        return cls()

    def reset(self):
        self.calls = 0

    def infer(self, observation):
        self.calls += 1
        if self.calls > 20:
            return Done("moved")
        rows = np.tile(np.append(observation.state[:7], 0.0), (60, 1))
        rows[:, 0] += 0.002 * np.arange(1, 61)
        return rows.astype(np.float32)
"""


def write_skill(folder: Path, model: str, changes: Mapping[str, object]) -> str:
    manifest = yaml.safe_load((rskill_dir(model) / "rskill.yaml").read_text(encoding="utf-8"))
    folder.mkdir(parents=True)
    text = yaml.safe_dump(manifest | {"id": folder.name} | changes)
    (folder / "rskill.yaml").write_text(text, encoding="utf-8")
    return folder.name


def write_chain(file: Path, skills: list[str], runners: list[str]) -> None:
    """Each goal with the next runner, round and round."""
    goals = [
        {"name": f"goal-{number}", "skill": skill, "deadline_ticks": 1200, "runner": runner}
        for number, (skill, runner) in enumerate(zip(skills, cycle(runners), strict=False))
    ]
    file.write_text(yaml.safe_dump({"goals": goals, "most_goals": 6}), encoding="utf-8")


class Watch:
    """What every part did in each tick, and what the gate released by then."""

    def __init__(self, robot: ScratchRobot, runners: Iterable[str]) -> None:
        self.acted: dict[int, tuple[Acted, ...]] = {}
        self.released: dict[int, SafeChunk] = {}
        bus, keys = robot.client.bus, robot.client.keys
        bus.subscribe(keys.joints, self._on_joints)
        for runner in runners:
            bus.subscribe(keys.safe(runner), self._on_safe)

    def _on_joints(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        self.acted[state.tick - 1] = state.acted

    def _on_safe(self, sample: Sample) -> None:
        chunk = decode(SafeChunk, sample.payload)
        self.released[chunk.verdict_id] = chunk

    def seam_steps(self, part: int) -> FloatArray:
        """From each chunk's last row that acted to the next one's first: changes of joint targets.

        That from one skill to the next is among them. ``[n, joints of the part]``.
        """
        steps = []
        for tick in sorted(self.acted):
            rows = [self.acted[one][part] for one in (tick - 1, tick) if one in self.acted]
            chunks = {row.verdict_id for row in rows if not row.hold}
            if len(chunks) == 2:
                before, after = (self._executed(part, row) for row in rows)
                steps.append(after - before)
        return np.array(steps)

    def _executed(self, part: int, acted: Acted) -> FloatArray:
        chunk = self.released[acted.verdict_id]
        (one,) = (one for one in chunk.parts if one.part == part)
        rows = floats(one.values).reshape(chunk.horizon, -1)
        return rows[acted.row, list(one.active)]

    def held_between_rows(self, part: int) -> list[int]:
        """Ticks after its first row and before its last in which the part held."""
        rows = [tick for tick, acted in self.acted.items() if not acted[part].hold]
        assert rows
        return [
            tick
            for tick, acted in sorted(self.acted.items())
            if rows[0] < tick < max(rows) and acted[part].hold
        ]


def run_chain(robot: ScratchRobot, file: Path) -> Watch:
    watch = Watch(robot, robot.scratch.deployment.services)
    place, registry = str(robot.scratch.file), robot.scratch.state_dir / "registry"
    done = fairlead("run", str(file), "--deployment", place, state=registry)
    assert done.returncode == 0, done.stdout + done.stderr
    return watch


@pytest.fixture
def skills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    return tmp_path / "skills"


@pytest.fixture
def robot(
    request: pytest.FixtureRequest, tmp_path: Path, skills: Path, registry: Registry
) -> Iterator[ScratchRobot]:
    """The deployment of compose/ that the test names, with its pacing and its runners."""
    name, pacing, runners = request.param
    deployment = yaml.safe_load((repo_root() / "compose" / f"{name}.yaml").read_text())
    services = deployment["services"]
    services |= dict.fromkeys(runners[1:], services["runner"])
    source = tmp_path / f"{name}.yaml"
    source.write_text(yaml.safe_dump(deployment), encoding="utf-8")
    scratch = make_scratch(source, tmp_path / "state", ScratchOptions(pacing=pacing))
    with scratch_robot(scratch, Registry(scratch.state_dir / "registry")) as running:
        yield running


@pytest.mark.parametrize(
    ("robot", "runners"),
    [(("panda_mobile_sim", "lockstep", TWO), TWO)],
    indirect=["robot"],
)
def test_pick_drive_and_place_as_three_skills_do_the_task_and_no_part_holds_between(
    robot: ScratchRobot, runners: list[str], skills: Path, tmp_path: Path
) -> None:
    names = [
        write_skill(
            skills / name,
            ORACLE,
            {"policy": {"backend": "oracle", "options": steps}}
            | ({} if name == "place" else {"decided_by": "policy"}),
        )
        for name, steps in STEPS.items()
    ]
    write_chain(tmp_path / "chain.yaml", names, runners)
    watch = run_chain(robot, tmp_path / "chain.yaml")
    held = [watch.held_between_rows(part) for part in range(len(watch.acted[1]))]
    assert not any(held), held


@pytest.mark.parametrize(
    ("robot", "runners"),
    [
        (("panda_mujoco", "realtime", ONE), ONE),
        pytest.param(("panda_mujoco", "realtime", TWO), TWO, marks=pytest.mark.thorough),
    ],
    indirect=["robot"],
)
def test_in_realtime_rows_act_until_those_of_a_policy_that_loads_for_4_s_do(
    robot: ScratchRobot, runners: list[str], skills: Path, tmp_path: Path
) -> None:
    """It is loaded while the goal before runs: its rows would have run out meanwhile."""
    options = {"file": "policy.py", "class": "Policy", "options": {"loading_s": 4.0}}
    own = {
        "policy": {"backend": "python", "options": options},
        "decided_by": "policy",
        "horizon": 60,
    }
    names = [write_skill(skills / name, REACH, own) for name in ("turn", "turn-on")]
    for name in names:
        (skills / name / "policy.py").write_text(TURN, encoding="utf-8")
    write_chain(tmp_path / "chain.yaml", names, runners)
    watch = run_chain(robot, tmp_path / "chain.yaml")
    assert watch.held_between_rows(0) == []
    limits = load_robot("panda").profile("sim").parts["arm"].joint_position
    assert limits is not None
    steps = watch.seam_steps(0)
    assert len(steps) and (abs(steps) <= limits.step_limits).all(), steps
