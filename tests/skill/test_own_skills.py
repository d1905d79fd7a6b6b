"""``skill new`` and ``skill install``: a skeleton that fits, and refusals that write nothing."""

from __future__ import annotations

import re
import runpy
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pytest_asyncio
import yaml

from fairlead.errors import ConfigError, PolicyError
from fairlead.paths import rskill_dir
from fairlead.plugins import POLICIES
from fairlead.policy import Actions, Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import find_skill, load_skill, read_skill, skill_ids
from fairlead.skill.python_policy import check_python_policy
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_tools.skills.install import install_skill
from fairlead_tools.skills.skeleton import ARM_MODES, skill_skeleton
from tests.cli.command import fairlead_here as fairlead

OPTIONS = {"file": "policy.py", "class": "Policy"}


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's skills: an empty place of this test's own."""
    folder = tmp_path / "data" / "rskills"
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(folder))
    return folder


def written(folder: Path, robot: str = "panda_mobile", mode: str = "") -> Path:
    """A skeleton in ``folder``, as `skill new` writes it."""
    folder.mkdir(parents=True)
    for file, text in skill_skeleton(folder.name, load_robot(robot), mode).items():
        (folder / file).write_text(text, encoding="utf-8")
    return folder


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize("mode", ["", *ARM_MODES])
@pytest.mark.parametrize("robot", ["panda_mobile", "panda"])
def test_a_new_skill_is_admitted_on_its_robot(robot: str, mode: str, tmp_path: Path) -> None:
    loaded = load_robot(robot)
    if mode and mode not in loaded.part("arm").modes:
        with pytest.raises(ConfigError, match=f"expected an arm that takes {mode}, got"):
            skill_skeleton("mine", loaded, mode)
        return
    skill = read_skill(written(tmp_path / "mine", robot, mode))
    assert admission_problems(skill, loaded) == []
    (slot,) = skill.action_contract.slots
    assert slot.control_mode in ([mode] if mode else ARM_MODES)


def test_a_new_skill_sees_an_arm_of_any_number_of_joints() -> None:
    panda = load_robot("panda")
    arm = panda.part("arm")
    short = arm.model_copy(update={"joints": arm.joints[:5]})
    robot = panda.model_copy(update={"parts": (short,), "passive_joints": (), "home": None})
    state = yaml.safe_load(skill_skeleton("mine", robot)["rskill.yaml"])["state_contract"]
    assert state == {
        "dim": 6,
        "joints": [
            {"names": list(arm.joints[:5]), "quantity": "position", "unit": "rad"},
            {"names": ["panda_gripper"], "quantity": "position", "unit": "m"},
        ],
    }


def test_a_new_skills_wave_can_be_seen(tmp_path: Path) -> None:
    folder, robot = written(tmp_path / "mine"), load_robot("panda_mobile")
    manifest = yaml.safe_load((folder / "rskill.yaml").read_text(encoding="utf-8"))
    (slot,) = manifest["action_contract"]["slots"]
    options = manifest["policy"]["options"]["options"]
    policy = runpy.run_path(str(folder / "policy.py"))["Policy"].from_options(None, options)
    seen = Observation(1, np.zeros(0), "")
    up_m = np.concatenate([policy.infer(seen)[:, 2] for _ in range(5)]) * slot["scale"][2]
    limits = robot.profile("sim").parts["arm"].cartesian_delta
    assert limits is not None
    assert np.ptp(np.cumsum(up_m)) * np.mean(limits.gain) > 0.01  # what the robot makes of it


def test_a_robot_without_an_arm_is_refused_with_what_its_parts_take() -> None:
    panda = load_robot("panda")
    with pytest.raises(ConfigError) as caught:
        skill_skeleton("mine", panda.model_copy(update={"parts": (panda.part("gripper"),)}))
    assert str(caught.value) == (
        "skill new: robot panda: expected an arm that takes cartesian_delta or joint_velocity or "
        "joint_position, got gripper takes gripper_position"
    )


def test_a_name_that_cannot_be_a_key_is_refused() -> None:
    with pytest.raises(ConfigError, match="skill id: expected"):
        skill_skeleton("My Skill", load_robot("panda_mobile"))


def test_an_installed_skill_is_listed_and_found(installed: Path, tmp_path: Path) -> None:
    assert "mine" not in skill_ids()
    assert install_skill(written(tmp_path / "mine")) == installed / "mine"
    assert "mine" in skill_ids() and rskill_dir("mine") == installed / "mine"
    assert load_skill("mine").version == "0.1.0"
    assert sorted(p.name for p in installed.parent.iterdir()) == ["rskills"]


def test_the_same_version_is_replaced_and_another_only_with_force(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    install_skill(folder)
    edit(folder / "policy.py", "waves the arm", "waves gently")
    install_skill(folder)
    assert "waves gently" in (installed / "mine" / "policy.py").read_text(encoding="utf-8")
    edit(folder / "rskill.yaml", "version: 0.1.0", "version: 0.2.0")
    with pytest.raises(ConfigError, match=r"version 0\.1\.0 is installed .*--force"):
        install_skill(folder)
    assert load_skill("mine").version == "0.1.0"
    install_skill(folder, force=True)
    assert load_skill("mine").version == "0.2.0"


def test_every_missing_binding_is_named_and_nothing_is_written(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    manifest = folder / "rskill.yaml"
    text = manifest.read_text(encoding="utf-8")
    text = re.sub(r"  joints:\n(    - .*\n)+", "", text)
    text = text.replace("dim: 9", "dim: 16\n  layout: human300_16d")
    manifest.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        install_skill(folder)
    assert "eef_frame, base_frame, gripper_qpos_joints" in str(caught.value)
    assert not installed.exists()


def test_what_the_robot_and_the_policy_lack_is_listed_together(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    edit(folder / "rskill.yaml", "[panda_mobile]", "[panda_mobile, nobody]")
    edit(folder / "rskill.yaml", "rate_hz: 20", "rate_hz: 15")
    edit(folder / "policy.py", "class Policy", "class Wave")
    with pytest.raises(ConfigError) as caught:
        install_skill(folder)
    lines = str(caught.value).splitlines()
    assert lines[0] == "skill mine is not installed:"
    assert any("on panda_mobile: rate_hz" in line for line in lines)
    assert any("on nobody: robot 'nobody'" in line for line in lines)
    assert any("a class Policy, got none (valid: Wave)" in line for line in lines)
    assert not installed.exists()


def test_a_place_that_cannot_be_written_is_named_with_the_way_to_another(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    installed.parent.write_text("a file in the way", encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        install_skill(folder)
    assert f"skill mine: cannot write {installed / 'mine'}: " in str(caught.value)
    assert str(caught.value).endswith("another folder: set FAIRLEAD_SKILLS")


def test_a_name_that_ships_is_refused(installed: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="one of this name ships with fairlead"):
        install_skill(written(tmp_path / "oracle-counter-to-cabinet"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("class Policy:\n  def infer(self): ...\n", "lacks from_options, reset"),
        ("def f(:\n", "invalid syntax"),
        ("x = 1\n", "expected a class Policy"),
    ],
)
def test_a_policy_file_is_read_without_being_run(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "policy.py").write_text(f"{text}raise SystemExit(3)\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=said):
        check_python_policy(tmp_path, OPTIONS)


@pytest.mark.parametrize("file", ["../policy.py", "/tmp/policy.py", "sub/policy.py", "policy.txt"])  # noqa: S108
def test_a_policy_file_outside_the_skill_is_refused(file: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="python policy: options: 1 problem.s.:\n  file"):
        check_python_policy(tmp_path, {"file": file, "class": "Policy"})


def test_a_link_out_of_the_skill_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.py").write_text("class Policy: ...\n", encoding="utf-8")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "policy.py").symlink_to(tmp_path / "other.py")
    with pytest.raises(ConfigError, match=r"no file policy\.py in"):
        check_python_policy(tmp_path / "mine", OPTIONS)


@pytest_asyncio.fixture
async def workers() -> AsyncIterator[list[PolicyWorker]]:
    started: list[PolicyWorker] = []
    yield started
    for worker in started:
        await worker.close()


def worker_of(skill: str, workers: list[PolicyWorker]) -> PolicyWorker:
    manifest = load_skill(skill)
    policy = manifest.policy
    workers.append(PolicyWorker(POLICIES.find(policy.backend), manifest, policy.options))
    return workers[-1]


@pytest.mark.processes
@pytest.mark.asyncio
async def test_the_new_policy_waves_40_rows_then_holds_and_begins_again(
    installed: Path, tmp_path: Path, workers: list[PolicyWorker]
) -> None:
    folder, first = written(tmp_path / "mine"), "import numpy as np\n"
    edit(folder / "policy.py", first, f"from __future__ import annotations\n{first}")
    own = "from dataclasses import dataclass\n@dataclass\nclass Sent:\n    rows: int\n"
    edit(folder / "policy.py", "ROWS = 8", f"{own}ROWS = Sent(8).rows")  # as files may have
    install_skill(folder)
    worker = worker_of("mine", workers)
    await worker.load()

    async def asked(tick: int) -> Actions:
        answer = await worker.infer(Observation(tick=tick, state=np.zeros(9), prompt="wave"))
        assert isinstance(answer, np.ndarray)
        return answer

    rows = np.concatenate([await asked(1 + 8 * number) for number in range(6)])
    assert rows.shape == (48, 6) and 0.2 < np.abs(rows).max() <= 0.9 + 1e-6
    assert np.abs(rows[:40, 2]).max() > 0.1
    assert not rows[:, [0, 1, 3, 4, 5]].any() and not rows[40:].any()
    await worker.reset()
    np.testing.assert_array_equal(await asked(11), rows[:8])
    # Asked early, as in realtime, it says the same of a tick as before.
    np.testing.assert_array_equal((await asked(16))[:3], rows[5:8])


@pytest.mark.processes
@pytest.mark.asyncio
async def test_a_policy_file_that_raises_says_so_from_its_own_process(
    installed: Path, tmp_path: Path, workers: list[PolicyWorker], capfd: Any
) -> None:
    folder = written(tmp_path / "mine")
    edit(folder / "policy.py", "ROWS = 8", "ROWS = 1 // 0")
    install_skill(folder)
    with pytest.raises(PolicyError, match=r"policy\.py: ZeroDivisionError"):
        await worker_of("mine", workers).load()
    assert 'policy.py", line' in capfd.readouterr().err, "which is the runner's log"


def test_the_commands_refuse_an_existing_folder_and_a_folder_without_a_skill(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROOT", str(Path(__file__).parents[2]))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    refused = fairlead("skill", "new", "mine", state=tmp_path)
    assert refused.returncode == 1 and "mine exists already" in refused.stderr
    empty = fairlead("skill", "install", "mine", state=tmp_path)
    assert empty.returncode == 1 and "rskill.yaml" in empty.stderr
    assert "Traceback" not in empty.stderr


def test_a_skill_being_written_is_checked_and_shown_by_its_path(tmp_path: Path) -> None:
    folder = written(tmp_path / "mine")
    for command in ("check", "show"):
        done = fairlead("skill", command, str(folder), state=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "mine" in done.stdout
    edit(folder / "rskill.yaml", "rate_hz: 20", "rate_hz: 15")
    refused = fairlead("skill", "check", str(folder), state=tmp_path)
    assert refused.returncode == 1
    assert f"fix {folder / 'rskill.yaml'}" in refused.stdout


def test_a_skill_that_is_nowhere_is_answered_with_those_that_ship_and_those_installed(
    installed: Path, tmp_path: Path
) -> None:
    install_skill(written(tmp_path / "mine"))
    with pytest.raises(ConfigError, match=r"valid: .*mine, .*oracle-.*or a folder"):
        find_skill("./nowhere")
    assert find_skill("mine") == installed / "mine"
