"""A run as the log of a real gate tells it."""

from __future__ import annotations

import zlib
from pathlib import Path

import pytest

from bench.equipment.gate_scene import Scene
from fairlead.errors import ConfigError, NoAnswerError
from fairlead.messages import GateState, Outcome
from fairlead_tools.record.run_log import newest_log, read_run
from tests.gate.decision_logs import drive, logs, wait_until_recorded

pytestmark = pytest.mark.processes


def test_a_run_has_what_was_measured_asked_decided_and_stopped(scene: Scene) -> None:
    scene.ready_to_move()
    drive(scene, (0.01, 0.09))
    wait_until_recorded(logs(scene)[-1], released=1, refused=1)
    scene.raise_stop(77)
    cause = scene.wait_state(GateState.STOPPED).cause
    scene.silence()
    assert scene.gate.stop() == 0
    run = read_run(newest_log(scene.state_dir))
    assert (run.header.robot, run.header.profile, run.damage) == ("panda_mobile", "sim", "")
    assert [Outcome(one.outcome) for _, one in run.verdicts] == [Outcome.RELEASED, Outcome.REFUSED]
    released, refused = run.chunks
    assert {tick for tick, _ in run.verdicts} <= {state.tick for state in run.joints}
    assert run.claims[released.claim_id].source == released.source
    assert run.newest_claim is not None and run.newest_claim[1] == released.start_tick
    assert [why for _, why, _ in run.stops] == [cause]
    assert len(run.between(refused.start_tick, 10**6, refused.session).verdicts) == 1


def test_a_log_that_is_cut_or_changed_is_read_up_to_there(scene: Scene, tmp_path: Path) -> None:
    scene.ready_to_move()
    drive(scene, (0.01,))
    wait_until_recorded(logs(scene)[-1], released=1, refused=0)
    scene.gate.kill()
    whole = logs(scene)[-1].read_bytes()
    cut, changed = tmp_path / "cut", tmp_path / "changed"
    cut.write_bytes(whole[:-3])
    changed.write_bytes(whole[:-60] + bytes([whole[-60] ^ 1]) + whole[-59:])
    assert read_run(cut).damage.startswith("cut off in a record at byte ")
    assert read_run(changed).damage.startswith("damaged in the record at byte ")


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_text("id: x\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="line to be fairlead-decisions-2, got 'id: x'$"):
        read_run(other)
    with pytest.raises(NoAnswerError, match="no decision log in "):
        newest_log(tmp_path)


def forged(*records: tuple[int, bytes]) -> bytes:
    """A log whose checksums are right."""
    text = b"fairlead-decisions-2\n"
    crc = zlib.crc32(text)
    for kind, body in records:
        head = bytes([kind]) + len(body).to_bytes(3, "little")
        head += bytes([head[0] ^ head[1] ^ head[2] ^ head[3] ^ 0xA5])
        crc = zlib.crc32(head + body, crc)
        text += head + body + crc.to_bytes(4, "little")
    return text


HEADER = b'{"robot": "panda", "profile": "sim", "started": "2026-11-28"}'


@pytest.mark.parametrize(
    "records", [[(1, b"no JSON")], [(1, b'{"robot": 3}')], [(1, HEADER), (3, b"short")]]
)
def test_a_log_that_no_gate_writes_is_refused(
    records: list[tuple[int, bytes]], tmp_path: Path
) -> None:
    log = tmp_path / "forged.decisions"
    log.write_bytes(forged(*records))
    with pytest.raises(ConfigError, match=r"forged\.decisions: not as a gate writes it: "):
        read_run(log)
