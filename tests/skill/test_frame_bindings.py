"""Frames in bindings are the robot's, the world's or a tracker's: others are refused early."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from fairlead.paths import SKILLS_VARIABLE, repo_root, rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import state_problems
from fairlead.skill.manifest import load_skill
from fairlead_tools.supervisor.before_start import dropped_skills
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import fairlead_here as fairlead

NAME = "lost-eef"
SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
OTHERS = "odom, map, object, goal; what others publish is named in tracked_frames of robot.yaml)"


@pytest.fixture
def skill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The expert's manifest with a frame that nobody has, among the user's skills."""
    shipped = rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml"
    manifest = yaml.safe_load(shipped.read_text()) | {"id": NAME}
    manifest["state_contract"]["bindings"]["eef_frame"] = "no_such_frame"
    folder = tmp_path / "rskills" / NAME
    folder.mkdir(parents=True)
    (folder / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    monkeypatch.setenv(SKILLS_VARIABLE, str(folder.parent))
    return folder


@pytest.mark.parametrize("binding", ["eef_frame", "base_frame", "world_frame", "goal_frame"])
def test_each_frame_is_checked_and_the_valid_ones_listed(binding: str) -> None:
    robot = load_robot("panda_mobile")
    contract = load_skill("oracle-counter-to-cabinet").state_contract
    assert state_problems(contract, robot) == []
    lost = contract.bindings.model_copy(update={binding: "shelf"})
    [problem] = state_problems(contract.model_copy(update={"bindings": lost}), robot)
    assert problem.startswith(f"{binding}: robot panda_mobile has no frame 'shelf' (valid: ")
    assert problem.endswith(OTHERS)


def test_tracked_frame_of_another_robots_scene_is_refused() -> None:
    contract = load_skill("oracle-counter-to-cabinet").state_contract
    problems = state_problems(contract, load_robot("panda"))
    assert [one.split(":")[0] for one in problems] == [
        "eef_frame", "base_frame", "object_frame", "goal_frame",
    ]  # fmt: skip


@pytest.mark.processes
def test_up_drops_it_with_the_reason_and_refuses_to_start_for_it(
    skill: Path, tmp_path: Path
) -> None:
    scratch = make_scratch(SOURCE, tmp_path / "all", ScratchOptions())
    [line] = dropped_skills(scratch.deployment, "runner")
    assert line.startswith(
        f"runner: skill {NAME} is dropped, it cannot run on robot panda_mobile:\n  eef_"
    )
    options = ScratchOptions(options={"runner": {"skills": [NAME]}})
    scratch = make_scratch(SOURCE, tmp_path / "listed", options)
    done = fairlead("up", str(scratch.file), state=tmp_path / "state")
    assert done.returncode == 1
    assert f"ERROR skill {NAME} cannot run on robot panda_mobile:\n  eef_frame: " in done.stderr
    assert "starting" not in done.stdout
