"""The command line's help and the documents agree with the commands that exist."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator

import pytest
import typer.main
from typer.core import TyperCommand, TyperGroup

from fairlead_tools.cli.app import app
from tests.repo.tree import ROOT, python_files, text_of

WANTED = {
    *(
        "up",
        "down",
        "ps",
        "logs",
        "run",
        "arm",
        "disarm",
        "stop",
        "reset",
        "status",
        "why",
    ),
    *("teleop", "jog", "home"),
    *("cancel", "episode", "eval", "judge", "plot"),
    *(
        "skill ls",
        "skill show",
        "skill check",
        "skill new",
        "skill install",
        "robot ls",
        "robot show",
        "robot bounds",
        "robot compile",
        "robot capsules",
        "robot distances",
    ),
    *("layout ls", "layout verify", "parity", "demo"),
    *("topic list", "topic echo", "topic hz", "bridge ros2"),
}


def leaves(command: object, path: str = "") -> Iterator[tuple[str, TyperCommand]]:
    """Every command that does something, with the words that call it."""
    if isinstance(command, TyperGroup):
        for name, sub in command.commands.items():
            yield from leaves(sub, f"{path} {name}".strip())
    else:
        assert isinstance(command, TyperCommand)
        yield path, command


COMMANDS = dict(leaves(typer.main.get_command(app)))


def options_of(command: TyperCommand) -> set[str]:
    """Every spelling of every option."""
    return {name for parameter in command.params for name in parameter.opts} | {"--help"}


def test_the_command_line_has_every_command() -> None:
    assert set(COMMANDS) >= WANTED


@pytest.mark.parametrize("path", COMMANDS)
def test_help_says_what_the_command_does_with_an_example_that_parses(path: str) -> None:
    command = COMMANDS[path]
    assert command.help
    example = re.search(r"Example: (.*?)(?:  --  |$)", command.epilog or "", re.M)
    assert example, f"fairlead {path} --help has no example"
    words = shlex.split(example.group(1))
    assert words[: 1 + len(path.split())] == ["fairlead", *path.split()]
    unknown = {w.split("=")[0] for w in words if w.startswith("--")} - options_of(command)
    assert unknown == set()


@pytest.mark.parametrize("path", COMMANDS)
def test_every_option_is_explained(path: str) -> None:
    silent = [p.name for p in COMMANDS[path].params if not getattr(p, "help", None)]
    assert silent == []


def test_a_deployment_is_explained_in_the_same_words_everywhere() -> None:
    asked = [(path, one) for path, command in COMMANDS.items() for one in command.params]
    texts = {str(getattr(one, "help", "")) for _, one in asked if one.metavar == "NAME_OR_FILE"}
    named = [text for text in texts if "compose/" in text or "`fairlead ps`" in text]
    ways = {re.sub("^.*: (?=as in)|; without it: .*", "", text) for text in named}
    assert ways == {
        "as in `fairlead ps`, a name in compose/, or a file",
        "as in `fairlead ps`, or its file",
        "a name in compose/, or a file",
        "names in compose/, or files",
    }


def test_the_documents_name_only_commands_that_exist() -> None:
    groups = {path.split()[0] for path in COMMANDS if " " in path}
    wrong = set()
    for document in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]:
        for first, second in re.findall(
            r"(?:`|\.venv/bin/)fairlead ([a-z][a-z-]*)(?:\s+([a-z][a-z0-9]*))?",
            document.read_text(),
        ):
            path = f"{first} {second}" if first in groups else first
            if path not in COMMANDS:
                wrong.add(f"{document.name}: fairlead {path}")
    assert wrong == set()


def test_a_command_prints_through_the_console_which_escapes_control_characters() -> None:
    speaks = re.compile(r"\btyper\.(echo|secho)\(|(?<![\w.])print\(")
    commands = python_files("shared/fairlead_tools/cli/")
    bare = {path.name for path in commands if speaks.search(text_of(path))}
    assert bare == {"console.py", "main.py"}
