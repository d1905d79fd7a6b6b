"""Deployed and in plain robosuite, the same vectors do the same to the last bit."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from bench.equipment.rendering import CAN_RENDER
from fairlead.errors import ServiceError
from fairlead.operate.goal_run import GoalOptions
from fairlead.paths import deployment_path, rskill_dir
from fairlead_tools.parity import deployed_episode, plain_episodes
from fairlead_tools.parity.episode_trace import EpisodeTrace, compare
from fairlead_tools.supervisor.scratch import Scratch, ScratchOptions
from tests.cli.command import fairlead, fairlead_here

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]


def parity(folder: Path, *arguments: str) -> dict[str, Any]:
    done: subprocess.CompletedProcess[str] = fairlead(
        "parity", "--json", "--out", str(folder / "out"), *arguments, state=folder / "registry"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.thorough
def test_what_the_clone_does_deployed_it_does_in_one_process_and_its_vectors_in_plain_robosuite(
    tmp_path: Path,
) -> None:
    report = parity(tmp_path, "--skill", "bc-counter-to-cabinet", "--seed", "300")
    (episode,) = report["episodes"]
    assert (report["same"], episode["succeeded"], episode["seed"]) == (True, True, 300)
    rows = {row["quantity"]: row for row in episode["rows"]}
    assert list(rows) == ["packed", "qpos", "qvel"]
    policy = {row["quantity"]: row for row in report["policy"]}
    assert list(policy) == ["observations", "actions"]
    assert all(row["same"] for row in report["policy"])
    calls = policy["actions"]["deployed"]
    assert episode["held"] == 0 and episode["apart"] == 0.0
    assert episode["compared"] == episode["ticks"] == 8 * calls > 100
    # The reset's held tick is plain robosuite's zero vector, and compared, too.
    assert all(row["same"] and row["deployed"] == 1 + 8 * calls for row in rows.values())


LOOKS_BACK = """
import numpy as np

class Policy:
    @classmethod
    def from_options(cls, skill, options):
        return cls()

    def reset(self): ...

    def infer(self, observation):
        states = observation.states
        assert states.shape == (3, 30)
        rows = np.zeros((8, 12), np.float32)
        rows[:, :3] = 0.02 + (states[2, :3] - states[1, :3]) + (states[1, :3] - states[0, :3]) / 2
        return rows
"""


@pytest.mark.thorough
def test_the_earlier_states_of_a_deployed_policy_are_those_of_one_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    manifest = yaml.safe_load((rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml").read_text())
    manifest |= {"id": "looks-back", "policy": {"backend": "python"}}
    manifest["policy"]["options"] = {"file": "policy.py", "class": "Policy"}
    manifest["state_contract"]["deltas"] = [-3, -1, 0]
    (tmp_path / "looks-back").mkdir()
    (tmp_path / "looks-back" / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    (tmp_path / "looks-back" / "policy.py").write_text(LOOKS_BACK)
    report = parity(tmp_path, "--skill", "looks-back", "--ticks", "24", "--policy")
    actions = next(row for row in report["policy"] if row["quantity"] == "actions")
    assert report["same"] and actions["deployed"] == 3


def test_random_vectors_of_full_scale_do_in_plain_robosuite_what_the_hal_does_with_them(
    tmp_path: Path,
) -> None:
    report = parity(tmp_path, "--random", "1.0", "--episodes", "3", "--ticks", "40")
    assert report["same"], report
    assert report["policy"] == []
    assert [episode["seed"] for episode in report["episodes"]] == [0, 1, 2]
    assert [episode["compared"] for episode in report["episodes"]] == [40, 40, 40]
    assert not any(episode["held"] for episode in report["episodes"])


@pytest.mark.thorough
def test_a_hal_that_slows_joints_down_is_not_the_simulator_of_the_training(
    tmp_path: Path,
) -> None:
    plain = yaml.safe_load(deployment_path("panda_mobile_sim").read_text())
    plain["services"]["hal"]["options"]["joint_speed_guard"] = 1.5
    (tmp_path / "guarded.yaml").write_text(yaml.safe_dump(plain))
    words = ["--random", "1.0", "--ticks", "20", "--deployment", str(tmp_path / "guarded.yaml")]
    done = fairlead("parity", "--json", *words, state=tmp_path / "registry")
    assert done.returncode == 1
    rows = {row["quantity"]: row for row in json.loads(done.stdout)["episodes"][0]["rows"]}
    assert rows["packed"]["same"] and not rows["qpos"]["same"]


def test_the_plain_loop_knows_nothing_of_the_hal_but_the_scene() -> None:
    job: dict[str, Any] = {
        "env": "MobilePickPlace", "robot": "PandaOmron", "controller": None, "part_order": None,
        "imports": ["fairlead_hal_sim.task"], "env_options": {}, "control_hz": 20.0,
        "episodes": [{"seed": 0, "zeros": 1, "vectors": []}],
    }  # fmt: skip
    script = Path(plain_episodes.__file__).with_name("plain_robosuite.py")
    done = subprocess.run(
        [sys.executable, script], input=json.dumps(job), capture_output=True, text=True, check=True
    )
    imported = json.loads(done.stdout)["imported"]
    assert not [name for name in imported if name.startswith("fairlead.") and "hal" in name]
    services = [name for name in imported if name.startswith("fairlead_")]
    assert [name for name in services if ".task" not in name] == [
        "fairlead_hal_sim",
        "fairlead_hal_sim.graphics_choice",
        "fairlead_hal_sim.quiet_robosuite",
    ]


def test_rows_of_several_control_periods_are_refused_before_anything_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = yaml.safe_load((rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml").read_text())
    (tmp_path / "slow").mkdir()
    (tmp_path / "slow" / "rskill.yaml").write_text(
        yaml.safe_dump(manifest | {"id": "slow", "rate_hz": 10})
    )
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    out = tmp_path / "out"
    done = fairlead_here("parity", "--skill", "slow", "--out", str(out), state=tmp_path)
    said = "ERROR parity: skill slow: expected a row for each control period, got 10 rows/s\n"
    assert (done.returncode, done.stderr) == (1, said)
    assert not out.exists()


def test_hal_and_runner_are_traced_whatever_the_deployment_calls_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[ScratchOptions] = []

    def stop_here(source: Path, folder: Path, options: ScratchOptions) -> Scratch:
        asked.append(options)
        raise ServiceError("stop here")

    monkeypatch.setattr(deployed_episode, "make_scratch", stop_here)
    content = yaml.safe_load(deployment_path("panda_mobile_sim").read_text())
    services = content["services"]
    services["simulator"], services["brain"] = services.pop("hal"), services.pop("runner")
    (tmp_path / "renamed.yaml").write_text(yaml.safe_dump(content))
    wish = GoalOptions("oracle-counter-to-cabinet")
    with pytest.raises(ServiceError, match="stop here"):
        deployed_episode.deployed_episodes(
            tmp_path / "renamed.yaml", wish, [3], tmp_path / "state", lambda now: None
        )
    traced = {"simulator": {"trace": True, "cameras": []}, "brain": {"trace": True}}
    assert asked[0].options == traced


def trace(packed: bytes = b"\0\0\x80\x3f" * 12) -> EpisodeTrace:
    return EpisodeTrace(
        observations=[bytes(240)], actions=[bytes(384)], packed=[packed],
        qpos=[bytes(80)], qvel=[bytes(80)],
    )  # fmt: skip


LOOKS = """
import numpy as np

class Looks:
    @classmethod
    def from_options(cls, skill, options):
        return cls()

    def infer(self, observation):  # its answer depends on what it sees
        rows = np.zeros((16, 12), np.float32)
        rows[:, 9] = np.mean([image.mean() for image in observation.images.values()]) / 2550
        return rows

    def reset(self):
        pass
"""


@pytest.mark.thorough
@pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine")
def test_the_very_pictures_that_a_policy_gets_are_the_same_in_process_and_deployed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = yaml.safe_load(
        (rskill_dir("pi05-robocasa365-human300-nf4") / "rskill.yaml").read_text()
    )
    images = manifest["images"]
    images["observation/image"] |= {
        "transforms": [{"rotate_deg": 180}, {"resize_with_pad": [224, 128]}],
        "dtype": "float32_signed",
        "deltas": [-2, 0],
    }
    home = tmp_path / "skills" / "looks"
    home.mkdir(parents=True)
    options = {"file": "policy.py", "class": "Looks"}
    manifest |= {"id": "looks", "horizon": 16, "policy": {"backend": "python", "options": options}}
    (home / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    (home / "policy.py").write_text(LOOKS)
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    source = yaml.safe_load(deployment_path("panda_mobile_sim_cameras").read_text())
    cameras = {one["name"]: one for one in source["services"]["hal"]["options"]["cameras"]}
    cameras["robot0_eye_in_hand"]["jpeg_quality"] = 90
    file = tmp_path / "jpeg.yaml"
    file.write_text(yaml.safe_dump(source))
    report = parity(tmp_path, "--policy", "--skill", "looks", "--ticks", "48", "-d", str(file))
    assert report["lossy_cameras"] == ["robot0_eye_in_hand"]
    rows = {row["quantity"]: row for row in report["policy"]}
    assert report["same"] and report["episodes"] == []
    assert list(rows) == ["observations", "pictures", "actions"]
    assert all(row["same"] and row["deployed"] == row["local"] == 3 for row in rows.values())
    lines = (tmp_path / "out" / "state" / "runner" / "trace.jsonl").read_text().splitlines()
    seen = [json.loads(line)["pictures"] for line in lines]
    assert all(one.keys() == images.keys() for one in seen)
    assert len({one["observation/image"] for one in seen}) == 3, "it turned: it sees something else"


def test_the_first_picture_that_differs_is_named() -> None:
    one, other = trace(), trace()
    one.pictures = [b'{"a": "1", "b": "2"}']
    other.pictures = [b'{"a": "1", "b": "3"}']
    (row,) = compare(one, other, ("pictures",))
    assert row.difference == "record 0: picture b: deployed 2, beside it 3"


def test_a_flipped_sign_of_zero_is_a_difference() -> None:
    rows = {
        row.quantity: row for row in compare(trace(bytes(48)), trace(bytes(44) + b"\0\0\0\x80"))
    }
    assert not rows["packed"].same
    assert rows["packed"].difference == (
        "record 0: number 11: deployed np.float32(0.0), beside it np.float32(-0.0)"
    )
    assert rows["qpos"].same


def test_a_missing_record_is_a_difference() -> None:
    shorter = trace()
    shorter.qvel.clear()
    rows = {row.quantity: row for row in compare(trace(), shorter)}
    assert rows["qvel"].difference == "1 records deployed, 0 beside them"


def test_two_empty_traces_are_no_proof() -> None:
    assert not any(row.same for row in compare(EpisodeTrace(), EpisodeTrace()))
