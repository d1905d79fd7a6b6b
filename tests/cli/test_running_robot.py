"""``up`` and everything a person does with a robot that runs, as real processes."""

from __future__ import annotations

import getpass
import json
import os
import signal
import socket
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from fairlead.deploy.process_table import command_of
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.background_up import SOURCE, Up, end, started_in
from tests.cli.command import (
    fairlead,
    fairlead_command,
    fairlead_environment,
)
from tests.cli.process_list import all_pids, pids_that_mention

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SKILL = "oracle-counter-to-cabinet"
MOVED_RAD = 0.01


@pytest.fixture
def start_up(tmp_path: Path) -> Iterator[Callable[[str], Up]]:
    started: list[Up] = []

    def start(name: str) -> Up:
        started.append(started_in(tmp_path, name))
        return started[-1]

    yield start
    for up in started:
        end(up)


@pytest.fixture(scope="module")
def shared_up(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Up]:
    """One robot for all that leave it running."""
    up = started_in(tmp_path_factory.mktemp("shared"), "shared")
    up.wait_line("is up")
    yield up
    end(up)


@pytest.fixture
def up(shared_up: Up) -> Up:
    """The robot that is shared, disarmed."""
    assert shared_up.do("disarm").returncode == 0
    return shared_up


def test_a_robot_is_started_watched_run_and_stopped(start_up: Callable[[str], Up]) -> None:
    up = start_up("robot")
    up.wait_line(f"[up] {up.name} is up")
    assert up.wait_line("[hal] ").endswith("lockstep, hal_kinematic")
    (entry,) = up.read("ps")
    assert entry["name"] == up.name and entry["supervised"]
    assert {s["state"] for s in entry["services"].values()} == {"ready"}

    status = up.read("status")
    assert status["gate"]["state"] == "disarmed"
    assert status["alive"] == ["hal", "runner", "safety", "state_assembler"]
    assert (status["hal"]["pacing"], status["hal"]["period_ms"]) == ("lockstep", 50.0)
    assert_topics_can_be_looked_at(up)

    assert_what_cannot_run_is_refused(up)

    before = arm_joints(up)
    done = fairlead("run", SKILL, "--deadline-ticks", "40", state=up.state)  # grasps nothing
    assert done.returncode == 1, done.stdout + done.stderr
    assert f"{SKILL} deadline after 4" in done.stdout and "not done after 40 ticks" in done.stdout
    after = up.read("status")["gate"]
    assert after["state"] == "disarmed"
    judged = after["counters"]
    assert (judged["released"], judged["truncated"], judged["refused"]) == (5, 0, 0), judged
    moved = {name: abs(now - before[name]) for name, now in arm_joints(up).items()}
    assert max(moved.values()) > MOVED_RAD, moved

    assert_its_run_can_be_drawn(up)
    logs = up.read("logs", "safety", "--lines", "50")
    who = f"by {getpass.getuser()}@{socket.gethostname()} (fairlead run)"
    assert any(line.endswith(f"armed {who}") for line in logs["safety"])
    assert any(line.endswith(f"of runner for {SKILL}, {who}") for line in logs["safety"])
    logs = up.read("logs", "runner", "--lines", "50")
    assert any(line.endswith(f"accepted: {SKILL}, {who}") for line in logs["runner"])
    assert up.do("logs", "gate").returncode == 1

    stopped = fairlead("down", state=up.state)
    assert (stopped.returncode, stopped.stdout) == (0, f"stopped {up.name}\n")
    assert up.process.wait(timeout=10.0) == 0
    assert up.processes() == []
    assert up.read("ps") == []


def assert_its_run_can_be_drawn(up: Up) -> None:
    picture = up.state / "run.png"
    for words in ((), ("-d", up.name)):
        drawn = up.do("plot", *words, "--out", str(picture))
        assert drawn.stdout.startswith(f"{picture}: ticks "), drawn.stderr
        assert picture.read_bytes().startswith(b"\x89PNG")
        picture.unlink()


def arm_joints(up: Up) -> dict[str, float]:
    """Positions by name [rad]."""
    joints = up.read("topic", "echo", "state/joints", "--count", "1")["positions"]
    return {name: at for name, at in joints.items() if name.startswith("panda_joint")}


def assert_what_cannot_run_is_refused(up: Up) -> None:
    """Before anything is armed, with the reason and the next command."""
    before = up.read("status")["gate"]
    blind = up.do("run", "rldx-robocasa")
    assert blind.returncode == 1 and "needs camera 'robot0_agentview_left'" in blind.stderr
    assert "try: fairlead down, then fairlead up panda_mobile_sim_cameras" in blind.stderr
    dropped = up.do("run", "panda-joint-reach")
    assert dropped.returncode == 1
    assert "embodiments: made for panda, not panda_mobile" in dropped.stderr
    assert dropped.stderr.endswith("try: fairlead skill ls --robot panda_mobile\n")
    after = up.read("status")["gate"]
    assert (after["state"], after["epoch"]) == ("disarmed", before["epoch"]), "nothing was armed"


def assert_topics_can_be_looked_at(up: Up) -> None:
    listed = {row["key"]: row for row in up.read("topic", "list", "--seconds", "1.5")}
    assert listed["tf/hal"]["type"] == "TransformBatch"
    assert listed["state/joints"]["messages"] and listed["safety/lease"]["messages"]
    joints = up.read("topic", "echo", "state/joints", "--count", "1")
    assert (joints["type"], len(joints["positions"])) == ("JointState", 14)
    assert isinstance(joints["positions"]["panda_joint1"], float), "by name"
    assert list(joints["velocities"]) == list(joints["positions"])
    idle = up.do("topic", "hz", "state/joints", "--count", "5")
    assert "state/joints: 4 messages repeat a tick: a lockstep world that waits" in idle.stdout
    (rates,) = up.read("topic", "hz", "safety/lease", "--count", "20")
    assert rates["messages"] == 20 and rates["rate_hz"] > 5


def test_arm_stop_reset_disarm_each_name_the_next_command(up: Up) -> None:
    assert up.do("arm").stdout.startswith(f"armed {up.name}: epoch ")
    stopped = up.do("stop", "--reason", "test")
    assert stopped.returncode == 0, stopped.stderr
    stop_id = stopped.stdout.split()[-1]
    assert stopped.stdout == f"stopped {up.name}; when it is safe: fairlead reset {stop_id}\n"

    gate = up.read("status")["gate"]
    assert (gate["state"], gate["stop_ids"]) == ("stopped", [stop_id])
    refused = up.do("arm")
    assert refused.returncode == 1 and f"fairlead reset {stop_id}" in refused.stderr
    wrong = up.do("reset", f"{int(stop_id, 16) ^ 1:x}")
    assert wrong.returncode == 1 and "refused" in wrong.stderr

    assert "next: fairlead arm" in up.do("reset", stop_id).stdout
    assert up.do("arm").returncode == 0
    assert up.do("disarm").returncode == 0
    assert up.read("status")["gate"]["state"] == "disarmed"


def test_run_leaves_a_robot_armed_that_it_did_not_arm(up: Up) -> None:
    up.do("arm")
    report = json.loads(up.do("run", SKILL, "--deadline-ticks", "16", "--json").stdout)
    assert report["result"]["outcome"] == "deadline"
    assert up.read("status")["gate"]["state"] == "armed"


@pytest.mark.parametrize("errors", ["terminal", "the same pipe"])
def test_up_whose_reader_goes_away_says_so_and_ends_and_leaves_no_process(
    tmp_path: Path, errors: str
) -> None:
    options = ScratchOptions(f"piped{os.getpid()}", hal=LIGHT_HAL)
    scratch = make_scratch(SOURCE, tmp_path / "piped", options)
    with subprocess.Popen(
        fairlead_command("up", str(scratch.file), "--state-dir", str(scratch.state_dir)),
        env=fairlead_environment(tmp_path / "registry"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE if errors == "terminal" else subprocess.STDOUT,
        text=True,
    ) as up:
        assert up.stdout is not None
        up.stdout.readline()
        up.stdout.close()
        said = up.stderr.read() if up.stderr is not None else ""
        assert up.wait(timeout=60.0) == 0
    if errors == "terminal":
        assert said.splitlines()[-1] == f"[up] stopped {options.id}; no process is left"
        assert "[up] what read these lines has gone, so it ends; " in said
    log = (scratch.state_dir / "logs" / "up.log").read_text(encoding="utf-8")
    assert "INFO up: what read these lines has gone, so it ends; " in log
    assert pids_that_mention(scratch.state_dir) == []


def test_a_killed_up_leaves_no_process_and_is_started_again_until_ctrl_c_ends_it(
    start_up: Callable[[str], Up],
) -> None:
    up = start_up("robot")
    up.wait_line("is up")
    up.do("run", SKILL, "--deadline-ticks", "8")  # so that the policy's own process exists
    workers = [pid for pid in all_pids() if _is_worker_of(up, pid)]
    assert workers
    up.end(signal.SIGKILL)
    wait_for(lambda: not up.processes(), "no service is left")
    wait_for(lambda: not any(command_of(pid) for pid in workers), "no policy process is left")
    again = Up(up.scratch, up.state)
    again.wait_line("is up")
    assert again.end(signal.SIGINT) == 0
    assert again.output[-1] == f"[up] stopped {again.name}; no process is left"
    assert again.processes() == []


def _is_worker_of(up: Up, pid: int) -> bool:
    if "fairlead_skill_runner.policy_process" not in command_of(pid):
        return False
    stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    parent = int(stat.rpartition(")")[2].split()[1])
    return str(up.scratch.state_dir) in command_of(parent)


def test_a_second_up_of_the_same_robot_is_refused_and_disturbs_nothing(up: Up) -> None:
    second = up.do("up", str(up.scratch.file))
    assert second.returncode == 1
    assert second.stderr == (
        f"ERROR deployment {up.name} is already running (pid {up.process.pid}); "
        f"stop it first: fairlead down {up.name}\n"
    )
    assert up.read("status")["gate"]["state"] == "disarmed"


def test_status_of_a_robot_whose_hal_is_gone_still_shows_the_gate(
    start_up: Callable[[str], Up],
) -> None:
    up = start_up("robot")
    up.wait_line("is up")
    (entry,) = up.read("ps")
    os.kill(entry["services"]["hal"]["process"]["pid"], signal.SIGSTOP)
    os.kill(entry["supervisor"]["pid"], signal.SIGSTOP)  # or it would be brought back
    os.kill(entry["services"]["hal"]["process"]["pid"], signal.SIGKILL)
    shown = up.do("status")
    os.kill(entry["supervisor"]["pid"], signal.SIGCONT)
    assert shown.returncode == 1, shown.stderr
    lines = shown.stdout.splitlines()
    assert lines[0].startswith("gate   ")
    assert "robot  the HAL does not answer" in lines
    assert lines[-1] == "missing hal; see: fairlead ps, fairlead logs hal"


def test_two_robots_run_side_by_side_and_must_then_be_named(up: Up) -> None:
    one, other = up, started_in(up.state.parent, "other")
    other.wait_line("is up")
    vague = one.do("status")
    assert vague.returncode == 1 and f"--deployment {other.scratch.file}" in vague.stderr
    one.do("arm", "--deployment", str(one.scratch.file))
    states = [
        up.read("status", "--deployment", str(up.scratch.file))["gate"]["state"]
        for up in (one, other)
    ]
    assert states == ["armed", "disarmed"]
    contrary = one.do("down", one.name, "-d", other.name)
    assert (contrary.returncode, "expected one deployment" in contrary.stderr) == (1, True)
    assert one.do("down", "-d", other.name).returncode == 0
    end(other)
    assert [entry["name"] for entry in one.read("ps")] == [one.name]


def test_a_gate_that_dies_is_restarted_and_up_says_how_to_reset_it(up: Up) -> None:
    up.do("arm")
    (entry,) = up.read("ps")
    os.kill(entry["services"]["safety"]["process"]["pid"], signal.SIGKILL)
    up.wait_line("[up] safety was killed by signal 9; starting it again in 0.5 s")
    up.wait_line("[up] the gate is latched")
    fix = up.wait_line("fairlead reset ")
    wait_for(lambda: up.do("reset", fix.split()[-1]).returncode == 0, "the latch is reset")
    assert up.do("run", SKILL, "--deadline-ticks", "8").stdout.startswith(f"{SKILL} deadline")
    (entry,) = up.read("ps")
    assert entry["services"]["safety"]["restarts"] == 1
