"""Zenoh's own router with the configuration that fairlead writes, between two hosts."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.system.two_hosts import SKILL, two_hosts
from tests.system.two_networks import two_networks

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]


def test_a_goal_runs_across_two_hosts_through_zenohd(tmp_path: Path) -> None:
    named = os.environ.get("ZENOHD", "")
    if not named:
        pytest.skip("ZENOHD names no router of Zenoh: make zenohd")
    with (
        two_networks() as network,
        two_hosts(network, tmp_path / "hosts", "lockstep", Path(named)) as hosts,
    ):
        result = hosts.ask("gpu", "run", SKILL, "--seed", "3")["result"]
        assert result["outcome"] == "succeeded"
        for host in ("gpu", "robot"):
            status = hosts.ask(host, "status")
            assert (status["access"], status["warnings"]) == ("closed", [])
            assert status["alive"] == ["hal", "runner", "safety", "state_assembler"]
