"""Ctrl-C: what runs is ended in order, one line says so, and the exit code is 130."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import IO

import pytest

from bench.equipment.live_robot import wait_for
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.process_list import pids_that_mention

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]


def read_until(stream: IO[str], text: str) -> None:
    said = []
    for line in stream:
        said.append(line)
        if text in line:
            return
    raise AssertionError(f"the stream ended without {text!r}: {''.join(said)}")


@pytest.mark.parametrize(
    ("moment", "done_after", "ending"),
    [
        ("starting hal", "ready after", signal.SIGTERM),
        # Not at a line about its progress: in lockstep a quick machine may have none before the
        # goal is done, and in realtime a slow one may end it with a stop.
        pytest.param(
            "armed; goal: ", "now two chunks that must not pass", signal.SIGINT,
            marks=pytest.mark.thorough,
        ),
    ],
)  # fmt: skip
def test_ctrl_c_or_sigterm_ends_the_demo_at_once_and_leaves_no_process(
    moment: str, done_after: str, ending: signal.Signals, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with subprocess.Popen(
        fairlead_command("demo", "--no-video", "--out", str(out)),
        env=fairlead_environment(tmp_path / "registry"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # a terminal sends Ctrl-C to the whole group
    ) as demo:
        assert demo.stderr is not None and demo.stdout is not None
        read_until(demo.stderr, moment)
        os.killpg(demo.pid, ending)
        rest, printed = demo.stderr.read(), demo.stdout.read()
        assert demo.wait(timeout=60.0) == 130
    assert rest.endswith("interrupted\n") and done_after not in rest
    assert "Traceback" not in rest and printed == ""
    assert sorted(path.name for path in out.iterdir()) == ["state"], "nothing was drawn"
    left = [path.name for path in (tmp_path / "registry").glob("running/*")]
    assert [name for name in left if not name.endswith(".lock")] == [], "it is not listed"
    wait_for(lambda: not pids_that_mention(out), "no process is left")
