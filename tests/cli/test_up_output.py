"""A terminal that takes nothing keeps `up` from nothing, and a restart needs no router's answer."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from fairlead.deploy.registry import Running
from fairlead.errors import ConfigError, TransportError
from fairlead.operate.asker import OPERATOR_VARIABLE
from fairlead.paths import repo_root
from fairlead_tools.cli import service
from fairlead_tools.cli.up_output import UpOutput

FILE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"


STUCK = """
import sys
from pathlib import Path
from fairlead_tools.cli.up_output import MOST_LINES, UpOutput
say = UpOutput(Path(sys.argv[1]))
for number in range(2 * MOST_LINES):
    say("hal", f"{number} {'x' * 1000}")
say("up", "hal died")
say.close()
"""


@pytest.mark.processes
def test_a_terminal_that_takes_no_lines_holds_nobody_up(tmp_path: Path) -> None:
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONUNBUFFERED"}
    reader, writer = os.pipe()  # which nobody reads
    with subprocess.Popen(
        [sys.executable, "-c", STUCK, str(tmp_path)], stdout=writer, env=environment
    ) as process:
        os.close(writer)
        assert process.wait(60.0) == 0
    os.close(reader)
    assert "hal died" in (tmp_path / "logs" / "up.log").read_text()


def test_all_lines_are_shown_before_it_ends(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    say = UpOutput(tmp_path)
    for number in range(100):
        say("hal", str(number))
    say.close()
    assert capfd.readouterr().out.splitlines() == [f"[hal] {number}" for number in range(100)]


@pytest.mark.parametrize("error", [TransportError("no link"), ConfigError("no certificate")])
def test_a_router_that_lets_nobody_in_is_started_anew(
    error: Exception, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuses(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(service, "RobotClient", refuses)
    entry = Running("cell", str(FILE), "/state", None)
    service._refuse_while_claimed(entry, "router")
    assert "WARNING nobody could be asked whether a goal runs: no " in capsys.readouterr().err
    with pytest.raises(type(error)):
        service._refuse_while_claimed(entry, "runner")
    monkeypatch.setenv(OPERATOR_VARIABLE, "Ada Lovelace")  # which is nobody's name
    with pytest.raises(ConfigError, match=OPERATOR_VARIABLE):
        service._refuse_while_claimed(entry, "router")
