"""A terminal that takes nothing keeps `up` from nothing, and a restart needs no router's answer."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from fairlead.deploy.registry import Running
from fairlead.errors import ConfigError, TransportError
from fairlead.paths import repo_root
from fairlead_tools.cli import service, up_output
from fairlead_tools.cli.up_output import MOST_LINES, UpOutput

FILE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"


def test_a_terminal_that_takes_no_lines_holds_nobody_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    takes, shown, forgotten = threading.Event(), list[str](), list[bool]()

    def stuck(line: str) -> None:
        takes.wait()
        shown.append(line)

    monkeypatch.setattr(up_output, "echo", stuck)
    monkeypatch.setattr(up_output, "LAST_WORDS_S", 0.05)
    monkeypatch.setattr(up_output, "forget_output", lambda: forgotten.append(True))
    say = UpOutput(tmp_path)
    for number in range(2 * MOST_LINES):
        say("hal", str(number))
    say("up", "hal died")
    say.close()
    assert forgotten == [True]
    assert "hal died" in (tmp_path / "logs" / "up.log").read_text()
    takes.set()


def test_all_lines_are_shown_before_it_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    say = UpOutput(tmp_path)
    for number in range(100):
        say("hal", str(number))
    say.close()
    assert capsys.readouterr().out.splitlines() == [f"[hal] {number}" for number in range(100)]


@pytest.mark.parametrize("error", [TransportError("no link"), ConfigError("no certificate")])
def test_a_router_that_lets_nobody_in_is_started_anew(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(service, "RobotClient", refuses)
    entry = Running("cell", str(FILE), "/state", None)
    service._refuse_while_claimed(entry, "router")
    with pytest.raises(type(error)):
        service._refuse_while_claimed(entry, "runner")
