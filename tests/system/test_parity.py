"""Deployed and in one process, the same episode is the same to the last bit."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from fairlead.parity.comparison import compare
from fairlead.parity.episode_trace import EpisodeTrace
from tests.cli.command import fairlead

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]


def test_deployed_numbers_equal_the_loop_of_env_step_bit_for_bit(tmp_path: Path) -> None:
    done: subprocess.CompletedProcess[str] = fairlead(
        "parity", "--seed", "3", "--json", "--out", str(tmp_path), state=tmp_path / "registry"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads(done.stdout)
    assert (report["same"], report["succeeded"], report["seed"]) == (True, True, 3)
    rows = {row["quantity"]: row for row in report["rows"]}
    assert list(rows) == ["observations", "actions", "packed", "qpos", "qvel"]
    assert all(row["same"] and row["deployed"] == row["local"] for row in rows.values())
    calls, steps = rows["actions"]["deployed"], rows["packed"]["deployed"]
    assert rows["observations"]["deployed"] == calls > 10
    assert rows["qpos"]["deployed"] == rows["qvel"]["deployed"] == steps > 100
    assert steps == 1 + 8 * calls  # one held tick of the reset, then eight rows a call


def trace(packed: bytes = b"\0\0\x80\x3f" * 12) -> EpisodeTrace:
    return EpisodeTrace(
        observations=[bytes(240)], actions=[bytes(384)], packed=[packed],
        qpos=[bytes(80)], qvel=[bytes(80)],
    )  # fmt: skip


def test_a_flipped_sign_of_zero_is_a_difference() -> None:
    rows = {
        row.quantity: row for row in compare(trace(bytes(48)), trace(bytes(44) + b"\0\0\0\x80"))
    }
    assert not rows["packed"].same
    assert rows["packed"].difference == (
        "record 0: number 11: deployed np.float32(0.0), in one process np.float32(-0.0)"
    )
    assert rows["qpos"].same


def test_a_missing_record_is_a_difference() -> None:
    shorter = trace()
    shorter.qvel.clear()
    rows = {row.quantity: row for row in compare(trace(), shorter)}
    assert rows["qvel"].difference == "1 records deployed, 0 in one process"


def test_two_empty_traces_are_no_proof() -> None:
    assert not any(row.same for row in compare(EpisodeTrace(), EpisodeTrace()))
