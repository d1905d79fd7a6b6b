"""The option ``--require``, and at the end which peers were asked."""

from __future__ import annotations

from typing import Any

import pytest

from tests.peers import environment


def pytest_addoption(parser: pytest.Parser) -> None:
    peers = [variable.lower() for variable in environment.VARIABLES]
    parser.addoption(
        "--require", action="append", default=[], choices=["all", *peers],
        help="a peer without which its tests fail, where they were skipped",
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    wanted = config.getoption("--require", [])
    environment.required = {
        variable
        for variable in environment.VARIABLES
        if variable.lower() in wanted or "all" in wanted
    }


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    if config.getoption("--require", None) is None:
        return  # the peers' tests are not what was started
    terminalreporter.section("peers")
    for variable in environment.VARIABLES:
        for found in environment.releases(variable):
            terminalreporter.line(f"{variable}: asked: {found}", green=True)
        if not environment.named(variable):
            text = f"{variable}: NOT ASKED: {variable}={environment.VARIABLES[variable]} make peers"
            terminalreporter.line(text, red=True)
