"""What ``--help`` promises (that each has an example is tested with the documents)."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from fairlead_tools.cli.app import app
from fairlead_tools.cli.options import EXIT_CODES

READING = ("ps", "logs", "status", "parity", "demo", "run", "skill ls", "skill show",
           "skill check", "robot show", "layout ls", "layout verify", "router")  # fmt: skip
ACTING = ("up", "down", "arm", "disarm", "stop", "reset", "robot compile")


def help_of(name: str) -> str:
    result = CliRunner().invoke(app, [*name.split(), "--help"], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    return " ".join(result.output.split())


@pytest.mark.parametrize("name", READING + ACTING)
def test_help_tells_the_exit_codes(name: str) -> None:
    assert EXIT_CODES in help_of(name)


@pytest.mark.parametrize("name", READING)
def test_commands_that_read_offer_json(name: str) -> None:
    assert "--json" in help_of(name)


def test_completion_can_be_shown_and_installed() -> None:
    assert {"--install-completion", "--show-completion"} <= set(help_of("").split())
    asked = {
        "_FAIRLEAD_COMPLETE": "complete_bash",
        "COMP_WORDS": "fairlead topic ",
        "COMP_CWORD": "2",
    }
    done = CliRunner().invoke(app, prog_name="fairlead", env=asked)
    assert done.output.split() == ["list", "echo", "hz"]
