"""``eval``, ``episode`` and ``status --watch`` on a simulated robot that runs."""

from __future__ import annotations

import json
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer

from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, RefusedError
from fairlead.messages import GateState, ResetEpisodeReply, StopLevel
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions
from fairlead.paths import repo_root
from fairlead.wire.bus import Qos
from fairlead_tools.cli import episodes
from fairlead_tools.cli.console import ProgressLine
from fairlead_tools.cli.episodes import Episode, EpisodeRun, new_episode
from fairlead_tools.cli.evaluate import _print, parse_seeds, wilson
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here

SKILL = "panda-joint-reach"


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScratchRobot]:
    folder = tmp_path_factory.mktemp("evaluate")
    scratch = make_scratch(repo_root() / "compose" / "panda_mujoco.yaml", folder, ScratchOptions())
    with scratch_robot(scratch, Registry(folder / "registry")) as made:
        yield made


@pytest.mark.processes
@pytest.mark.simulator
def test_the_folder_of_a_run_that_goes_on_is_left_alone(robot: ScratchRobot) -> None:
    """Two of ``eval --pacing`` at once, say, or two demos."""
    scratch = robot.scratch
    with pytest.raises(ConfigError, match="another run uses it; choose another --out"):
        make_scratch(scratch.file, scratch.state_dir, ScratchOptions())
    assert scratch.file.is_file()


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("0:3", [0, 1, 2]), ("7", [7]), ("3,5,8", [3, 5, 8]), ("0:2,9", [0, 1, 9])],
)
def test_seeds_are_a_range_without_its_end_or_single_ones(text: str, seeds: list[int]) -> None:
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize(
    "text", ["", "a", "3:", ":3", "3:3", "4:2", "-1:2", "0:1000000", "1.5", "1,1", "0:3,2"]
)
def test_other_seeds_are_refused(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="expected "):
        parse_seeds(text)


@pytest.mark.parametrize(
    ("successes", "trials", "interval"),
    [
        (0, 0, (0.0, 1.0)),
        (10, 10, (0.7225, 1.0)),
        (0, 10, (0.0, 0.2775)),
        (17, 20, (0.6396, 0.9476)),  # as published tables have them
        (50, 100, (0.4038, 0.5962)),
    ],
)
def test_the_interval_is_wilsons(
    successes: int, trials: int, interval: tuple[float, float]
) -> None:
    assert wilson(successes, trials) == pytest.approx(interval, abs=1e-4)


@pytest.mark.processes
def test_an_episode_starts_without_a_goal_and_is_confirmed(
    robot: ScratchRobot, tmp_path: Path
) -> None:
    robot.client.arm()
    done = fairlead_here("episode", "--seed", "7", "-d", str(robot.scratch.file), state=tmp_path)
    assert done.returncode == 0, done.stderr
    told = re.match(r"\S+ is in a new episode, seed 7, from tick (\d+) on\n", done.stdout)
    assert told is not None, done.stdout
    assert robot.client.hal_status().episode_tick == int(told[1])
    assert robot.client.gate_status().state == GateState.DISARMED


def ended(seed: int, outcome: str, why: str, by: str = "runner", first_tick: int = 1) -> Episode:
    return Episode(seed, outcome, by, why, 9, {}, 0, 0, first_tick, 9, 1)


def test_what_ended_by_an_error_is_no_trial_and_is_said(
    capsys: pytest.CaptureFixture[str],
) -> None:
    done = [
        ended(0, "succeeded", "", "task"),
        ended(1, "succeeded", "", "policy"),
        ended(2, "deadline", "deadline: not done after 9 ticks"),
        ended(3, "failed", "policy_error: no policy server at ws://gpu", "policy", first_tick=0),
        ended(4, "cancelled", "cancelled: cancelled by ada", "operator"),
        ended(5, "failed", "stalled: no rows released for 30.0 s"),
        ended(6, "failed", "claim_lost: no claim was taken: the gate stopped", first_tick=0),
    ]
    assert [one.is_trial for one in done] == [True, True, True, False, False, True, False]
    _print(SKILL, range(7), done, None, None, False)
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith(
        f"{SKILL}: 2 of 4 succeeded (1 by the policy's own word), 3 not counted: ended by an error "
        "or a cancel; 95 % interval 15 to 85 %"
    )


def test_a_policy_that_breaks_once_it_was_asked_has_failed_its_trial(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Left out, a policy that says NaN in each episode that it loses would never lose one."""
    why = "policy_error: policy worker: actions: expected finite numbers, got nan at [0, 3]"
    done = [ended(0, "succeeded", "", "task"), ended(1, "failed", why, "policy")]
    assert [one.is_trial for one in done] == [True, True]
    _print(SKILL, range(2), done, None, None, False)
    assert capsys.readouterr().out.splitlines()[-1].startswith(f"{SKILL}: 1 of 2 succeeded; 95 % ")


@pytest.mark.processes
def test_each_seed_has_its_row_and_all_together_their_share(
    robot: ScratchRobot, tmp_path: Path
) -> None:
    words = ("eval", SKILL, "-d", str(robot.scratch.file), "--seeds")
    done = fairlead_here(*words, "0:2", state=tmp_path)
    assert done.returncode == 0, done.stderr
    header, *rows, total = done.stdout.splitlines()
    assert header.split() == [
        "SEED", "OUTCOME", "TICKS", "REFUSED", "STARVED", "STALLS", "SEAM", "STOPS", "WHY",
    ]  # fmt: skip
    assert [row.split()[:2] for row in rows] == [["0", "succeeded"], ["1", "succeeded"]]
    assert total.startswith(f"{SKILL}: 2 of 2 succeeded; 95 % interval 34 to 100 %; median ")
    assert "seed 0, 1 of 2, 0 succeeded | " in done.stderr

    out = tmp_path / "out"
    rest = ("5", "--deadline-ticks", "3", "--json", "--out", str(out))
    short = fairlead_here(*words, *rest, state=tmp_path)
    assert short.returncode == 0, short.stderr
    document = json.loads(short.stdout)
    (episode,) = document["episodes"]
    assert (episode["seed"], episode["outcome"], document["succeeded"]) == (5, "deadline", 0)
    assert (document["seeds"], document["error"]) == (1, None)
    # The robot is none of those that are known to run here: its gate's log is not looked for.
    assert (episode["stalls"], episode["picture"]) == (None, "")


@pytest.mark.processes
def test_a_goal_in_an_episode_of_another_is_none_of_the_seed_s(
    robot: ScratchRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    def begun_twice(client: RobotClient, seed: int) -> ResetEpisodeReply:
        mine = new_episode(client, seed)
        client.reset_episode(seed + 1)
        return mine

    monkeypatch.setattr(episodes, "new_episode", begun_twice)
    run = EpisodeRun(robot.client, GoalOptions(SKILL, runner="runner"), ProgressLine(), False, True)
    with pytest.raises(RefusedError, match="another began a new episode: the goal was none of "):
        run.episode(3, [], 1)


@pytest.mark.processes
@pytest.mark.thorough
def test_a_slow_policy_is_tried_on_a_copy_of_the_robot_and_what_failed_is_drawn(
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    words = [
        "eval", SKILL, "-d", "panda_mujoco", "--pacing", "realtime", "--seeds", "0", "--json",
        "--out", str(out), "--latency-ms",
    ]  # fmt: skip
    done = fairlead_here(*words, "200", state=tmp_path)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    (episode,) = document["episodes"]
    assert episode["outcome"] == "succeeded", episode
    assert (document["pacing"], document["latency_ms"]) == ("realtime", 200.0)
    # Its observations may be 0.5 s old.
    late = fairlead_here(*words, "700", "--deadline-ticks", "40", state=tmp_path)
    (episode,) = json.loads(late.stdout)["episodes"]
    assert (episode["outcome"], list(episode["refusals"])) == ("deadline", ["G006"]), episode
    picture = out / f"{SKILL}-seed-0.png"
    assert episode["picture"] == str(picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.processes
def test_nothing_is_run_while_the_gate_is_stopped(robot: ScratchRobot, tmp_path: Path) -> None:
    stop_id = robot.client.stop("test")
    words = ("eval", SKILL, "-d", str(robot.scratch.file), "--seeds", "0:2", "--json")
    done = fairlead_here(*words, state=tmp_path)
    robot.client.reset(stop_id)
    assert done.returncode == 1
    document = json.loads(done.stdout)
    assert document["episodes"] == []
    assert "fairlead eval refused: the gate is stopped" in document["error"]


class Eval:
    """A thousand episodes in the background."""

    def __init__(self, robot: ScratchRobot, folder: Path, *options: str) -> None:
        self.errors = folder / "errors"
        words = ("eval", SKILL, "-d", str(robot.scratch.file), "--seeds", "0:1000", *options)
        with self.errors.open("w", encoding="utf-8") as said:
            self.process = subprocess.Popen(
                fairlead_command(*words), env=fairlead_environment(folder),
                stdout=subprocess.PIPE, stderr=said, text=True,
            )  # fmt: skip

    def wait_seed(self, after: int) -> int:
        """The first seed above ``after`` that it says it runs."""

        def newest() -> int:
            said = re.findall(r"seed (\d+), .* \| tick", self.errors.read_text(encoding="utf-8"))
            return max(map(int, said), default=0)

        wait_for(lambda: newest() > after, f"a seed after {after}", 60.0)
        return newest()

    def end(self) -> tuple[int, str, list[list[str]]]:
        """Exit status, all it printed, and the cells of its rows."""
        printed, _ = self.process.communicate(timeout=60.0)
        rows = [line.split() for line in printed.splitlines() if re.match(r"\d", line)]
        return self.process.returncode, printed, rows


@pytest.mark.processes
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_one_cancels_the_goal_and_prints_what_it_has(
    robot: ScratchRobot, tmp_path: Path, number: signal.Signals
) -> None:
    run = Eval(robot, tmp_path)
    run.wait_seed(after=0)
    run.process.send_signal(number)
    status, printed, rows = run.end()
    assert status == 130, printed
    assert {row[1] for row in rows} == {"succeeded"}
    assert f"{SKILL}: {len(rows)} of {len(rows)} succeeded, {1000 - len(rows)} not run; " in printed
    assert robot.client.gate_status().state == GateState.DISARMED


@pytest.mark.processes
def test_a_stop_of_the_robots_own_is_reset_where_asked_for_and_a_persons_ends_it(
    robot: ScratchRobot, tmp_path: Path
) -> None:
    run = Eval(robot, tmp_path, "--reset-stops")
    seed = run.wait_seed(after=0)
    own = StopLevel(stop_id=77, by=robot.client.hal, reason="test")
    # Within an episode: one before its goal costs no row, the episode begins again.
    wait_for(lambda: bool(robot.client.gate_status().claims), "a goal runs", 60.0)
    robot.client.bus.publisher(robot.client.keys.stop, StopLevel, Qos.HOT).put(own)
    run.wait_seed(after=seed + 1)
    stop_id = robot.client.stop("test")
    status, printed, rows = run.end()
    robot.client.reset(stop_id)
    assert status == 1, printed
    assert stop_id in {int(found, 16) for found in re.findall(r"fairlead reset (\w+)",
                       run.errors.read_text(encoding="utf-8"))}  # fmt: skip
    stopped = [row for row in rows if row[1] == "failed"]
    assert len(stopped) <= 2, printed  # fewer if a goal had just reached its end
    assert "1" in {row[7] for row in rows}, printed


@pytest.mark.processes
def test_status_can_be_watched_block_after_block_until_interrupted(
    robot: ScratchRobot, tmp_path: Path
) -> None:
    watching = subprocess.Popen(
        fairlead_command("status", "--watch", "-d", str(robot.scratch.file)),
        env=fairlead_environment(tmp_path),
        stdout=subprocess.PIPE,
        text=True,
    )
    assert watching.stdout is not None
    everybody = f"alive  {', '.join(sorted(robot.scratch.deployment.services))}\n"
    for _ in range(2):
        block = list(iter(watching.stdout.readline, everybody))
        assert re.fullmatch(r"\d{4}-\S+Z\n", block[0])
        assert block[1].startswith("gate   disarmed"), block
    watching.send_signal(signal.SIGINT)
    watching.communicate(timeout=20.0)
    assert watching.returncode == 130
