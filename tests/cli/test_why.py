"""``fairlead why``: each kind of decision in the words a person reads, from a real gate's log."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import SOURCE, Scene
from bench.equipment.running_gate import ROBOT, RunningGate
from fairlead.messages import ActionChunk, GateState, Outcome, pack_floats
from fairlead.paths import gate_config
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

DECLARED = "robots/panda_mobile/robot.yaml: safety.sim.parts.arm.cartesian_delta"
ARM = json.loads(gate_config("panda_mobile", "sim").read_text(encoding="utf-8"))["parts"][0]
FROM = f"          {ARM['modes']['cartesian_delta']['source']}"
ASK_FOR_LESS = (
    "  do      ask for less; a limit that is wrong for the robot is changed where it is declared"
)


def rows_backwards(scene: Scene, *steps_m: float) -> ActionChunk:
    values = np.zeros((len(steps_m), 6))
    # Away from where the outstretched arm is singular; a NaN stays as it is.
    values[:, 0] = [step if np.isnan(step) else -step for step in steps_m]
    part = scene.arm_part(len(steps_m), values=pack_floats(values))
    return scene.chunk(len(steps_m), parts=(part,))


def hold_until(scene: Scene, tick: int) -> None:
    while scene.hal.tick < tick:
        scene.next_tick()


class Session:
    """A gate's session, one chunk at tens of ticks, and what ``why`` says about it afterwards."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scene = scene = Scene(gate_config(ROBOT, "sim"), folder / "robot" / "safety")
        scene.ready_to_move()
        self.chunk_at(10, (0.05,) * 4, Outcome.RELEASED)
        self.chunk_at(20, (0.09,) * 4, Outcome.REFUSED)
        self.chunk_at(30, (0.09, 0.01), Outcome.REFUSED)
        self.chunk_at(40, (0.01, 0.01, 0.09, 0.01), Outcome.TRUNCATED)
        hold_until(scene, 50)
        scene.send(scene.chunk(oldest_tick=30))
        self.chunk_at(60, (float("nan"),), Outcome.REFUSED)
        stop = scene.wait_state(GateState.STOPPED).stop_ids[0]
        self.stop_id = f"{stop:016x}"

    def chunk_at(self, tick: int, steps_m: tuple[float, ...], outcome: Outcome) -> None:
        hold_until(self.scene, tick)
        verdict = self.scene.send(rows_backwards(self.scene, *steps_m))
        assert verdict.outcome == outcome
        if outcome != Outcome.REFUSED:
            for row in range(verdict.released_last - verdict.released_first + 1):
                self.scene.acted_on(verdict, row)

        self._said: dict[tuple[str, ...], list[str]] = {}

    def why(self, *words: str) -> list[str]:
        """What is printed after the line that names the log; the log does not change any more."""
        if words not in self._said:
            self._said[words] = self._ask(*words)
        return self._said[words]

    def _ask(self, *words: str) -> list[str]:
        state = self.folder / "registry"
        done = fairlead("why", *words, "--state-dir", str(self.folder / "robot"), state=state)
        assert done.returncode == 0, done.stderr
        first, *lines = done.stdout.splitlines()
        assert re.fullmatch(
            rf"panda_mobile, gate started [\d-]+T[\d:.]+Z, log {self.folder}.*/000001\.decisions",
            first,
        )
        return lines


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    session = Session(tmp_path_factory.mktemp("session"))
    yield session
    session.scene.close()


@pytest.fixture(scope="module")
def ended_session(session: Session) -> Session:
    session.scene.silence()
    assert session.scene.gate.stop() == 0
    return session


def asked(rows: str, first: int, last: int) -> str:
    return (
        f"  asked   {rows} of arm cartesian_delta in base_link for ticks {first} to {last}, "
        f"from the state of tick {first}"
    )


def test_a_released_chunk_says_how_near_a_limit_it_came(ended_session: Session) -> None:
    assert ended_session.why("10") == [
        "tick 10: chunk 1 of runner (skill test) released, 4 rows for ticks 10 to 13",
        asked("4 rows", 10, 13),
        "  margin  arm: up to 1.734 times its numbers, asked of this gate; then G020 linear in "
        "row 0, limit 0.0867 m",
    ]


def test_a_refused_chunk_says_value_limit_its_source_and_what_would_have_passed(
    ended_session: Session,
) -> None:
    assert ended_session.why("20") == [
        "tick 20: chunk 2 of runner (skill test) refused, nothing of it moves",
        asked("4 rows", 20, 23),
        "  why     G020 limit: row 0, arm linear is 0.09 m, limit 0.0867 m, 0.0033 m beyond it",
        f"  limit   {DECLARED}.linear_limit_m",
        FROM,
        "  passes  the whole chunk, asked of this gate with every number of arm times 0.9633",
        ASK_FOR_LESS,
    ]


def test_one_row_at_fault_is_told_with_the_number_that_passes(ended_session: Session) -> None:
    assert (
        "  passes  the whole chunk, asked of this gate with arm linear in row 0 at 0.0867 m "
        "instead of 0.09 m" in ended_session.why("30")
    )


def test_a_truncated_chunk_says_what_was_released_and_which_row_was_not(
    ended_session: Session,
) -> None:
    assert ended_session.why("40") == [
        "tick 40: chunk 4 of runner (skill test) truncated, 2 rows released for ticks 40 to 41",
        asked("4 rows", 40, 43),
        "  why     G020 limit: row 2, arm linear is 0.09 m, limit 0.0867 m, 0.0033 m beyond it",
        f"  limit   {DECLARED}.linear_limit_m",
        FROM,
        "  passes  the whole chunk, asked of this gate with the change of arm linear in row 2 from "
        "the row before times 0.9587",
        ASK_FOR_LESS,
    ]


def test_a_tick_finds_the_chunk_that_has_a_row_for_it(ended_session: Session) -> None:
    assert ended_session.why("23") == ended_session.why("20")


def test_an_old_observation_is_told_without_a_row(ended_session: Session) -> None:
    assert ended_session.why("50") == [
        "tick 50: chunk 5 of runner (skill test) refused, nothing of it moves",
        asked("8 rows", 50, 57),
        "  why     G006 observation too new or too old: age is 20 ticks, limit 10 ticks, "
        "10 ticks beyond it",
        "  limit   the claim's age_max_ticks",
        "  do      answer from newer states; `age_max_ticks` of the skill says how old they may be",
    ]


def test_the_last_refusal_comes_with_the_stop_it_caused(ended_session: Session) -> None:
    assert ended_session.why("last") == [
        "tick 60: chunk 6 of runner (skill test) refused, nothing of it moves",
        asked("1 row", 60, 60),
        "  why     G008 number not finite or too large: row 0, arm cartesian_delta is nan, "
        "limit 1e+06",
        "  limit   every value is finite and at most 1e6",
        "  do      find the NaN, infinity or huge number of the policy, then reset the stop",
        "tick 60: the gate stopped",
        "  why     G008 arm cartesian_delta, row 0: nan, limit 1e+06",
        f"  do      when the cause has gone: fairlead reset {ended_session.stop_id}",
    ]


def test_only_chunks_of_the_source_that_is_asked_for(ended_session: Session) -> None:
    assert ended_session.why("last", "--source", SOURCE)[0].startswith("tick 60: chunk 6")
    assert ended_session.why("last", "--source", "somebody") == [
        "nothing of somebody was refused or cut: 6 verdicts in this log, newest state tick 60"
    ]


def test_a_tick_without_a_decision_says_so(ended_session: Session) -> None:
    assert ended_session.why("15") == [
        "no decision at tick 15 or about a row for it; the log's newest state is tick 60"
    ]


def test_json_has_the_numbers_and_the_words(ended_session: Session) -> None:
    state = ended_session.folder / "registry"
    folder = str(ended_session.folder / "robot" / "safety" / "decisions")
    done = fairlead("why", "20", "--log", folder, "--json", state=state)
    (decision,) = json.loads(done.stdout)["decisions"]
    assert decision["words"] == ended_session.why("20")
    assert (decision["kind"], decision["code"], decision["unit"]) == ("verdict", 20, "m")
    assert decision["would_pass"]["scale"] == pytest.approx(0.9633)


def test_a_stop_by_what_was_measured_says_what_to_look_at(tmp_path: Path) -> None:
    scene = Scene(gate_config(ROBOT, "sim"), tmp_path / "robot" / "safety")
    try:
        scene.ready_to_move()
        scene.hal.efforts[scene.hal.joints.index("panda_joint3")] = -12345.0
        scene.hal.publish_state()
        stop = scene.wait_state(GateState.STOPPED).stop_ids[0]
        scene.silence()
        assert scene.gate.stop() == 0
    finally:
        scene.close()
    words = ("why", "last", "--state-dir", str(tmp_path / "robot"))
    _, *lines = fairlead(*words, state=tmp_path / "registry").stdout.splitlines()
    assert lines[0].endswith(": the gate stopped")
    assert lines[1].startswith("  why     G042 arm panda_joint3: 12345 N m, limit ")
    assert lines[2:] == [
        "  limit   fairlead robot show panda_mobile --profile sim --sources",
        "  first   look what the robot touches or has lost, then reset the stop",
        f"  do      when the cause has gone: fairlead reset {stop:016x}",
    ]


def test_a_latched_gate_is_told_with_the_reset(tmp_path: Path) -> None:
    state_dir = tmp_path / "registry" / "robot" / "safety"
    killed = RunningGate(gate_config(ROBOT, "sim"), state_dir)
    killed.wait_line("ready")
    killed.kill()
    (state_dir / "clean_mark").unlink(missing_ok=True)
    gate = RunningGate(gate_config(ROBOT, "sim"), state_dir)
    gate.wait_line("ready")
    assert gate.stop() == 0
    lines = fairlead("why", state=tmp_path / "registry").stdout.splitlines()
    assert lines[1:3] == [
        "tick 0: the gate latched",
        "  why     the last exit was not clean: armed, stopped or latched",
    ]
    assert re.fullmatch(r"  do      when the cause has gone: fairlead reset [0-9a-f]{16}", lines[3])
    assert len(lines) == 4


def test_without_a_log_it_says_where_it_looked(tmp_path: Path) -> None:
    done = fairlead("why", state=tmp_path)
    assert (done.returncode, done.stderr) == (
        1,
        f"ERROR no decision log in {tmp_path}/*/*/decisions/*.decisions; a running gate "
        "writes one; name another place: --state-dir DIR or --log FILE\n",
    )


def test_a_file_that_is_no_log_is_named(tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("tick 12\n")
    done = fairlead("why", "--log", str(tmp_path / "notes"), state=tmp_path)
    assert (done.returncode, done.stderr) == (
        1,
        f"ERROR decision log {tmp_path}/notes: expected its first line to be "
        "fairlead-decisions-2\n",
    )


def test_a_check_is_told_as_the_table_of_the_documents_has_it(tmp_path: Path) -> None:
    done = fairlead("why", "G024", state=tmp_path)
    assert done.stdout.splitlines() == [
        "G024 cannot brake before a limit",
        "  hazard  no braking before the end stop",
        "  passes  lower <= q + v wait + v|v| / 2a <= upper after each row",
        "  unit    rad, m",
        "  else    truncate",
        "  example arm panda_joint4: -3.1 rad, limit -3.0718 rad",
        "  do      slow down before the limit: braking would end beyond it",
        "  more    docs/safety-checks.md, Prediction",
        "  tests   build/safety/fairlead-safety-tests --test-case='*G024*'",
    ]
    in_json = fairlead("why", "G024", "--json", state=tmp_path)
    assert json.loads(in_json.stdout)["words"] == done.stdout.splitlines()


def test_a_check_that_is_none_is_refused_with_those_there_are(tmp_path: Path) -> None:
    done = fairlead("why", "G099", state=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "expected the code of a check, got 'G099' (valid: G001, G002" in done.stderr


def test_what_is_no_tick_is_a_wrong_command_line(tmp_path: Path) -> None:
    done = fairlead("why", "yesterday", state=tmp_path)
    assert done.returncode == 2
    assert (
        "expected `last`, a tick such as 120 or a check such as G020, got 'yesterday'"
        in done.stderr
    )
