"""A decision log judged again: identical bit for bit, or what other limits would have said."""

from __future__ import annotations

import json
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from fairlead.messages import GateState
from fairlead.paths import decisions_binary, gate_config
from tests.cli.command import fairlead
from tests.gate.decision_logs import (
    drive,
    judge,
    judged_text,
    logs,
    moves,
    tightened,
)

pytestmark = pytest.mark.processes


@pytest.fixture
def a_run(scene: Scene) -> Path:
    """The log of a run with good chunks, bad ones, a stop and a reset; the gate has ended."""
    scene.ready_to_move()
    assert drive(scene, (0.01, 0.05, 0.09, 0.02, 0.04)) == [0, 0, 2, 0, 0]
    scene.send_bytes(b"\xc1")
    scene.send(moves(scene, float("nan")))
    stopped = scene.wait_state(GateState.STOPPED)
    scene.reset(stopped.stop_ids[0])
    scene.silence()
    assert scene.gate.stop() == 0
    return logs(scene)[-1]


def test_a_run_judged_again_is_identical_bit_for_bit(a_run: Path) -> None:
    status, found = judge(a_run)
    assert (status, found["identical"], found["same_program"]) == (0, True, True), found
    assert found["read"] == "complete: the gate ended on request"
    assert (found["released"], found["refused"], found["lost"]) == (4, 3, 0)


def test_a_tighter_limit_names_exactly_the_chunks_it_would_have_refused(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    status, found = judge(a_run, "--config", tightened(config, tmp_path, 0.03))
    changes = [
        (c["recorded"]["seq"], c["recorded"]["outcome"], c["instead"]["outcome"])
        for c in found["changed"]
    ]
    assert (status, changes) == (1, [(2, "released", "refused"), (5, "released", "refused")])
    instead = found["changed"][0]["instead"]
    assert (instead["code"], instead["part"], instead["axis"]) == (20, "arm", "linear")
    assert (instead["value"], instead["limit"]) == (pytest.approx(0.05), 0.03)
    assert (found["unjudged"], found["notes"]) == (0, [])


def test_the_same_limits_under_another_name_change_nothing(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    status, found = judge(a_run, "--config", tightened(config, tmp_path, 0.0867))
    assert (status, found["changed"], found["unjudged"]) == (0, [], 0)


def test_chunks_of_a_claim_that_would_have_been_refused_are_counted_not_judged(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    file = json.loads(config.read_text())
    file["protocol"]["chunk_rate_max_hz"] = 10.0
    (tmp_path / "slower.json").write_text(json.dumps(file))
    status, found = judge(a_run, "--config", tmp_path / "slower.json")
    assert (status, found["changed"], found["unjudged"]) == (1, [], 6), found
    assert found["notes"][0].startswith("tick 1: refused a query: "), found["notes"]
    assert found["open_loop"].startswith("open loop: states are as recorded")


def test_a_log_is_not_judged_under_the_limits_of_another_robot(a_run: Path) -> None:
    other = gate_config("panda", "sim")
    assert judged_text(a_run, "--config", other) == (
        2,
        "ERROR fairlead-decisions: judge: the log is of the robot panda_mobile, "
        f"{other} of panda\n",
    )


def test_judge_says_in_words_what_changes(a_run: Path, config: Path, tmp_path: Path) -> None:
    status, text = judged_text(a_run, "--config", tightened(config, tmp_path, 0.03))
    source = json.loads(config.read_text())["parts"][0]["modes"]["cartesian_delta"]["source"]
    assert status == 1
    assert [line for line in text.splitlines() if line.startswith("  tick")] == [
        "  tick 5: chunk 2 of runner was released; instead: chunk 2 of runner refused: G020 arm "
        f"linear, row 0: 0.05 m, limit 0.03 m ({source})",
        "  tick 14: chunk 5 of runner was released; instead: chunk 5 of runner refused: G020 arm "
        "linear, row 0: 0.04 m, limit 0.03 m",  # where that comes from has been said
    ]
    assert "2 of 7 verdicts change\n" in text


def forged(log: Path, config: str) -> bytes:
    """The log with another configuration in its header, and every CRC made right again."""
    data = log.read_bytes()
    start = data.index(b"\n") + 1
    crc = zlib.crc32(data[:start])
    made = data[:start]
    while start < len(data):
        length = int.from_bytes(data[start + 1 : start + 4], "little")
        kind, body = data[start], data[start + 5 : start + 5 + length]
        start += 9 + length
        if kind == 1:
            body = json.dumps(json.loads(body) | {"config": config}).encode()
        head = bytes([kind]) + len(body).to_bytes(3, "little")
        head += bytes([head[0] ^ head[1] ^ head[2] ^ head[3] ^ 0xA5])
        crc = zlib.crc32(head + body, crc)
        made += head + body + crc.to_bytes(4, "little")
    return made


def test_decisions_that_do_not_follow_from_the_recorded_limits_are_different(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "forged.decisions"
    copy.write_bytes(forged(a_run, config.read_text()))
    assert judge(copy)[0] == 0
    copy.write_bytes(forged(a_run, tightened(config, tmp_path, 0.03).read_text()))
    status, found = judge(copy)
    assert (status, found["identical"], found["first_difference"]["step"]) == (1, False, 1)


def test_a_changed_byte_is_found_wherever_it_is(a_run: Path, tmp_path: Path) -> None:
    original = a_run.read_bytes()
    for place in np.linspace(0, len(original) - 1, 40).astype(int):
        damaged = bytearray(original)
        damaged[place] ^= 0x10
        copy = tmp_path / "damaged.decisions"
        copy.write_bytes(damaged)
        status, found = judge(copy)
        assert status == 2, (place, found)


def test_a_log_cut_off_anywhere_is_judged_up_to_there(a_run: Path, tmp_path: Path) -> None:
    original = a_run.read_bytes()
    header = original.index(b"\x02", original.rindex(b'"started"'))
    for place in np.linspace(header + 200, len(original) - 1, 20).astype(int):
        copy = tmp_path / "cut.decisions"
        copy.write_bytes(original[:place])
        status, found = judge(copy)
        assert (status, found["identical"]) == (0, True), (place, found)
        assert not found["read"].startswith("complete")


def test_what_is_no_log_is_refused_by_name(tmp_path: Path) -> None:
    status, text = judged_text(tmp_path)
    assert (status, text) == (
        2,
        f"ERROR fairlead-decisions: decision log: no *.decisions in the folder {tmp_path}\n",
    )
    (tmp_path / "other").write_text("what the robot did\n")
    status, text = judged_text(tmp_path / "other")
    assert (status, text) == (
        2,
        f"ERROR fairlead-decisions: decision log {tmp_path}/other: expected its first line to be "
        "fairlead-decisions-2\n",
    )


def test_a_refusal_is_json_where_json_is_asked_for(tmp_path: Path) -> None:
    status, text = judged_text(tmp_path, "--json")
    message = f"decision log: no *.decisions in the folder {tmp_path}"
    error = {"kind": "ConfigError", "message": message, "fix": ""}
    assert (status, json.loads(text)) == (2, {"error": error})


def test_a_log_of_an_older_gate_is_refused_by_its_layout(tmp_path: Path) -> None:
    (tmp_path / "old").write_text("fairlead-decisions-1\n")
    status, text = judged_text(tmp_path / "old")
    assert (status, text) == (
        2,
        f"ERROR fairlead-decisions: decision log {tmp_path}/old: it has layout 1, this gate reads "
        "layout 2 only: judge it with the gate that wrote it\n",
    )


@pytest.mark.parametrize("value", [[], [""]])
def test_an_option_without_a_value_is_not_an_option_that_was_not_given(
    a_run: Path, value: list[str]
) -> None:
    done = subprocess.run(
        [decisions_binary(), "judge", a_run, "--config", *value],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (
        2,
        "ERROR fairlead-decisions: judge: --config: expected a value after it; see: "
        "fairlead-decisions judge --help\n",
    )


@pytest.mark.parametrize("words", [[], ["check", "LOG"]])
def test_the_reader_of_logs_knows_two_commands_and_no_gate(words: list[str]) -> None:
    told = [str(decisions_binary()), *words]
    done = subprocess.run(told, capture_output=True, text=True, check=False)
    got = words[0] if words else ""
    assert (done.returncode, done.stderr) == (
        2,
        f"ERROR fairlead-decisions: expected judge or explain, got '{got}'; see: "
        "fairlead-decisions --help\n",
    )
    helped = subprocess.run([told[0], "--help"], capture_output=True, text=True, check=False)
    assert helped.returncode == 0 and "example: fairlead-decisions judge" in helped.stdout


def test_the_command_line_judges_by_the_gates_own_program(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    for words in ((), ("--config", tightened(config, tmp_path, 0.03)), ("--json",)):
        told = [a_run, *words]
        done = fairlead("judge", *map(str, told), state=tmp_path / "registry")
        assert (done.returncode, done.stdout) == judged_text(*told)
    missing = fairlead("judge", str(tmp_path / "none"), state=tmp_path / "registry")
    assert (missing.returncode, "does not exist" in missing.stderr) == (2, True)


def test_a_folder_is_no_configuration(a_run: Path, tmp_path: Path) -> None:
    assert judged_text(a_run, "--config", tmp_path) == (
        2,
        f"ERROR fairlead-decisions: configuration {tmp_path}: cannot be read; make it with: "
        "fairlead robot compile\n",
    )
