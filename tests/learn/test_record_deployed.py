"""``fairlead dataset record --deployed``: what the gate released is beside what was said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from pyarrow import parquet

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ServiceError
from fairlead.paths import deployment_path, rskill_dir
from fairlead.skill.manifest import load_skill
from fairlead_tools.learn.dataset import Episode, episodes, read_header
from fairlead_tools.learn.record import record
from fairlead_tools.parity import deployed_episode
from fairlead_tools.parity.deployed_episode import by_tick
from tests.cli.command import fairlead_here

SKILL, EXPERT, TICKS = "leaps-once", "oracle-counter-to-cabinet", 16
SOURCE = "panda_mobile_sim"
POLICY = """
import numpy as np

from fairlead.policy import Done


class Policy:
    @classmethod
    def from_options(cls, skill, options):
        return cls()

    def reset(self):
        self.calls = 0

    def infer(self, observation):
        self.calls += 1
        if self.calls == 3:
            return Done("enough")
        rows = np.zeros((8, 12), np.float32)
        rows[:, 2] = 5.0 if self.calls == 2 else 0.1
        return rows
"""
"""Its second answer is far beyond the limits: the gate refuses it. The third ends the goal."""


def write_skill(folder: Path) -> None:
    """As the scripted expert, with the policy above."""
    manifest = yaml.safe_load((rskill_dir(EXPERT) / "rskill.yaml").read_text())
    own = {"file": "policy.py", "class": "Policy"}
    manifest |= {"id": SKILL, "policy": {"backend": "python", "options": own}}
    (folder / SKILL).mkdir(parents=True)
    (folder / SKILL / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    (folder / SKILL / "policy.py").write_text(POLICY)


def recorded(skill: str, folder: Path, source: str = SOURCE) -> Episode:
    out = folder / "data"
    words = ("dataset", "record", skill, "--seeds", "5", "--ticks", str(TICKS), "--deployed")
    done = fairlead_here(*words, "--out", str(out), "-d", source, state=folder / "registry")
    assert done.returncode == 0, done.stdout + done.stderr
    (episode,) = episodes(out)
    return episode


@pytest.mark.processes
@pytest.mark.simulator
@pytest.mark.timeout(300)
def test_a_refused_row_is_told_from_those_the_gate_released(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    write_skill(tmp_path / "skills")
    one = recorded(SKILL, tmp_path)
    leaps = one.rows[:, 2] == 5.0
    assert leaps.sum() == 1, "refused, it is asked anew in the next tick, and ends"
    np.testing.assert_array_equal(one.released, ~leaps)
    assert (one.acted[one.released, 2] == np.float32(0.1)).all()
    assert not one.acted[leaps, :6].any(), "it holds"
    (told,) = read_header(tmp_path / "data").episodes
    assert (told.ticks, told.released) == (len(leaps), len(leaps) - 1)
    shown = fairlead_here("dataset", "show", str(tmp_path / "data"), state=tmp_path)
    assert not told.succeeded, "that is the task's word, not the policy's"
    assert f"5 {told.ticks} {told.released} no" in " ".join(shown.stdout.split())
    target = tmp_path / "lerobot"
    done = fairlead_here(
        "export", "lerobot", str(tmp_path / "data"), str(target), "--failed", state=tmp_path
    )
    assert done.returncode == 0, done.stderr
    frames = parquet.read_table(target / "data/chunk-000/file-000.parquet").to_pydict()
    assert frames["released"] == one.released.tolist()


@pytest.mark.processes
@pytest.mark.simulator
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    ("name", "source"),
    [
        (EXPERT, SOURCE),
        pytest.param(
            "bc-reach-cube", "ur5e_robosuite_cameras",
            marks=pytest.mark.skipif(not CAN_RENDER, reason="no rendering library"),
        ),
    ],
)  # fmt: skip
def test_where_all_is_released_it_is_what_one_process_records_bit_for_bit(
    tmp_path: Path, name: str, source: str
) -> None:
    skill = load_skill(name)
    one = recorded(name, tmp_path, source)
    deployment = load_deployment(deployment_path(source))
    [local] = record(deployment, skill, [5], 0.0, TICKS, lambda seed, tick: None)
    assert one.released.all()
    for array in ("states", "rows", "acted"):
        assert getattr(one, array).tobytes() == getattr(local, array).tobytes(), array
    assert one.pictures.keys() == local.pictures.keys() == skill.images.keys()
    for eye, frames in local.pictures.items():
        np.testing.assert_array_equal(one.pictures[eye], frames)


def test_of_what_a_full_disk_left_out_of_a_trace_is_said_how_much_room_there_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = tmp_path / "trace.jsonl"
    trace.write_text('{"tick": 1}\n{"tick": 2, "qp')
    assert by_tick(trace) == {1: {"tick": 1}}
    monkeypatch.setattr(deployed_episode, "_WRITTEN_TIMEOUT_S", 0.0)
    said = f"{trace}: expected 2 policy calls, got 1 \\([0-9.]+ MB are free there\\)$"
    with pytest.raises(ServiceError, match=said):
        deployed_episode.written_calls(tmp_path, 2)


@pytest.mark.parametrize("option", [("--noise", "0.1"), ("--expert", EXPERT)])
def test_noise_and_experts_are_of_one_process(tmp_path: Path, option: tuple[str, str]) -> None:
    words = ("dataset", "record", EXPERT, "--seeds", "5", "--deployed", *option)
    done = fairlead_here(*words, "--out", str(tmp_path / "d"), state=tmp_path)
    assert done.returncode == 1
    assert done.stderr == (
        "ERROR dataset record: --deployed: expected no --noise and no --expert: they are of one "
        f"process, got {option[0]}\n"
    )
    assert not (tmp_path / "d").exists()
