"""A service whose caller has closed the standard streams: nothing else gets their numbers."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.deploy.credentials import forget_secrets
from fairlead.paths import gate_binary, repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import fairlead_command, fairlead_environment

CLOSED = 'exec "$@" <&- >&- 2>&-'


def streams_of(pid: int) -> list[str]:
    return [str(Path(f"/proc/{pid}/fd/{number}").readlink()) for number in range(3)]


@pytest.mark.processes
def test_a_gate_without_streams_has_none(tmp_path: Path) -> None:
    file = repo_root() / "compose" / "panda_mobile_sim.yaml"
    scratch = make_scratch(file, tmp_path / "state", ScratchOptions())
    command = fairlead_command(
        "service", str(scratch.file), "safety", "--state-dir", str(tmp_path / "gate")
    )
    environment = fairlead_environment(tmp_path / "registry")
    with subprocess.Popen(["sh", "-c", CLOSED, "sh", *command], env=environment) as one:
        try:
            gate, files = Path(f"/proc/{one.pid}/exe"), Path(f"/proc/{one.pid}/fd")
            wait_for(lambda: gate.readlink() == gate_binary(), "no gate was started")
            wait_for(lambda: len([*files.iterdir()]) > 4, "it opened nothing")
            assert streams_of(one.pid) == ["/dev/null"] * 3
        finally:
            one.kill()
    forget_secrets(scratch.deployment.keys)
