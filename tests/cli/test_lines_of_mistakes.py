"""Whatever is wrong in a real deployment, robot or skill file is said with its line and column."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError
from fairlead.paths import repo_root
from fairlead.robot.manifest import RobotManifest
from fairlead.yaml_file import load_yaml
from fairlead_hal_sim import HalSimOptions
from fairlead_tools.supervisor.command_line import service_command
from tests.cli.command import fairlead_here

DEPLOYMENT = repo_root() / "compose" / "panda_mobile_sim.yaml"


def edited(source: Path, folder: Path, old: str, new: str) -> Path:
    """A copy with one passage replaced."""
    text = source.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{old!r} is there {text.count(old)} times"
    copy = folder / source.name
    copy.write_text(text.replace(old, new), encoding="utf-8")
    return copy


def position(file: Path, passage: str) -> str:
    """``file:line:column: `` of where a passage begins."""
    before = file.read_text(encoding="utf-8").partition(passage)[0]
    return f"{file}:{before.count(chr(10)) + 1}:{len(before.rpartition(chr(10))[2]) + 1}: "


def refusal(file: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load_deployment(file)
    return [line.strip() for line in str(caught.value).splitlines()[1:]]


@pytest.mark.parametrize(
    ("old", "new", "at", "said"),
    [
        ("{run: safety}", "{run: safety, listen: tcp/127.0.0.1:7502}", "listen:",
         "services.safety.listen: leave it out: on one host services listen where this user alone"),
        ("namespace: fl ", "localiser: hal ", "localiser", "localiser: 'hal' is a service of"),
        ("  runner:\n", "  operator:\n", "operator:", "services.operator: tools have this name"),
        ("{run: safety}", "{host: ''}", "safety: {host",
         "services.safety: expected run or command, got neither"),
    ],
)  # fmt: skip
def test_what_does_not_fit_together_in_a_deployment(
    tmp_path: Path, old: str, new: str, at: str, said: str
) -> None:
    file = edited(DEPLOYMENT, tmp_path, old, new)
    [line] = refusal(file)
    assert line.startswith(position(file, at) + said), line


def test_what_is_missing_at_the_top_has_the_files_name_alone(tmp_path: Path) -> None:
    file = edited(DEPLOYMENT, tmp_path, "robot: panda_mobile ", "")
    assert refusal(file) == [f"{file}: robot: is missing"]


def test_options_of_a_service_and_a_hal_that_nobody_knows(tmp_path: Path) -> None:
    file = edited(DEPLOYMENT, tmp_path, "      seed: 0\n", "      sed: 0\n")
    with pytest.raises(ConfigError) as caught:
        check_options(load_deployment(file), "hal", HalSimOptions)
    told = f"service hal: options: 1 problem(s):\n  {position(file, 'sed: 0')}sed: unknown key, did"
    assert str(caught.value).startswith(told)
    file = edited(DEPLOYMENT, tmp_path, "run: hal_sim", "run: hal_smi")
    with pytest.raises(ConfigError) as caught:
        service_command(file, load_deployment(file), "hal", tmp_path)
    told = f"{position(file, 'run: hal_smi')}service hal: run: expected a HAL, got 'hal_smi'"
    assert str(caught.value).startswith(told)


@pytest.mark.parametrize(
    ("old", "new", "at", "said"),
    [
        ("    joints: [panda_gripper]\n", "    joints: [panda_griper]\n", "panda_griper",
         "part 'gripper': joint 'panda_griper' is not a commanded joint"),
        ("base_joints: [base_x, base_y, base_yaw]", "base_joints: [base_y, base_x, base_yaw]",
         "base_joints:", "base_joints: expected the joints of role base in order"),
    ],
)  # fmt: skip
def test_what_does_not_fit_together_in_a_robot(
    tmp_path: Path, old: str, new: str, at: str, said: str
) -> None:
    file = edited(repo_root() / "robots" / "panda_mobile" / "robot.yaml", tmp_path, old, new)
    with pytest.raises(ConfigError) as caught:
        load_yaml(file, RobotManifest)
    assert f"\n  {position(file, at)}{said}" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "at", "said"),
    [
        ("    opening_m: 0.02\n", "    opening: 0.02\n", "opening: 0.02", "opening: unknown key"),
        ("  backend: joint_reach\n", "  backend: joint_rich\n", "backend: joint_rich",
         "policy.backend: expected a policy backend, got 'joint_rich'"),
        ("id: panda-joint-reach\n", "id: other\n", "id: other",
         "id: expected 'panda-joint-reach', the folder's name, got 'other'"),
        ("execute_steps: 8\n", "execute_steps: 17\n", "execute_steps: 17",
         "execute_steps: expected at most the horizon, 16, got 17"),
        ("  dim: 9\n", "  dim: 8\n", "dim: 8", "state_contract: dim: expected 9"),
    ],
)  # fmt: skip
def test_what_does_not_fit_in_a_skill(
    tmp_path: Path, old: str, new: str, at: str, said: str
) -> None:
    source = repo_root() / "rskills" / "panda-joint-reach"
    folder = Path(shutil.copytree(source, tmp_path / "panda-joint-reach"))
    file = edited(source / "rskill.yaml", folder, old, new)
    done = fairlead_here("skill", "check", str(folder), state=tmp_path)
    assert done.returncode == 1
    assert f"{position(file, at)}{said}" in done.stdout + done.stderr


@pytest.mark.parametrize("command", ["check", "install"])
def test_what_is_wrong_with_a_policys_options_is_said_once(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    made = fairlead_here("skill", "new", "my-wave", "--robot", "panda", state=tmp_path)
    assert made.returncode == 0, made.stderr
    file = tmp_path / "my-wave" / "rskill.yaml"
    file.write_text(file.read_text().replace("file: policy.py", "file: ../policy.py"))
    done = fairlead_here("skill", command, "./my-wave", state=tmp_path)
    assert (done.returncode, (done.stdout + done.stderr).count("file: String should")) == (1, 1)
