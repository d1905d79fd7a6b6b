"""Unchanged servers of others, from checkouts that a person names, drive the shipped skills."""

from __future__ import annotations

import json
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.live_robot import wait_for
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.fitted_rows import fitted
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from fairlead_tools.supervisor.this_host import free_ports
from tests.peers.environment import checkouts, peer
from tests.peers.rows import HORIZON, SHARES, overshooting
from tests.peers.serve_openpi import FAILING
from tests.runner.asked_policies import PI05, failure, observation

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

FRAMES = [-6, -4, -2, 0]
ZMQ_SKILLS = [
    ("rldx1-ft-rc365-nf4", FRAMES, [0]),
    ("rldx-robocasa", FRAMES, [0]),
    ("gr00t-robocasa", [0], FRAMES),
]
"""With the frames that fit, and others that do not."""


@contextmanager
def serving(module: str, *arguments: str) -> Iterator[int]:
    """A server of the peers' environment on a port of ours, from when it can be reached."""
    port = free_ports(1)[0]
    command = [*peer(module), arguments[0], str(port), *arguments[1:]]

    def is_up() -> bool:
        assert server.poll() is None, "the server ended; above is what it said"
        with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
            return True
        return False

    with subprocess.Popen(command) as server:
        try:
            wait_for(is_up, f"{module} listens", 60.0)
            yield port
        finally:
            server.kill()


def made(skill: SkillManifest, kind: Any, address: str) -> Any:
    """The skill's policy with a server of ours."""
    return kind.from_options(skill, skill.policy.options | {"address": address})


def admitted_rows(skill: SkillManifest, rows: Any) -> Any:
    """What goes to the gate of a policy's rows."""
    routes = resolve_routes(skill.action_contract, load_robot("panda_mobile"))
    return fitted(routes, rows)


def test_openpi_s_server_drives_the_pi05_skill(capfd: pytest.CaptureFixture[str]) -> None:
    [checkout] = checkouts("OPENPI", "src/openpi/serving/websocket_policy_server.py")
    skill = load_skill(PI05)
    with serving("serve_openpi", str(checkout)) as port:
        policy = made(skill, OpenpiPolicy, f"ws://127.0.0.1:{port}")
        assert "tells of itself: reset_pose; asked with a probe " in capfd.readouterr().err
        policy.reset()
        rows = policy.infer(observation(skill))
        assert rows.tobytes() == overshooting().tobytes()
        assert np.abs(admitted_rows(skill, rows)[:, :10]).max() == 1.0
        text = failure(lambda: policy.infer(replace(observation(skill), prompt=FAILING)))
        assert text.endswith("failed: RuntimeError: out of memory, as told")
        said = capfd.readouterr().err
        assert "Traceback (most recent call last):" in said
        assert "websocket_policy_server.py" in said
        policy.reset()
        assert policy.infer(observation(skill)).tobytes() == overshooting().tobytes()
        policy._close()


def config_of(skill: SkillManifest, frames: list[int]) -> str:
    options: Any = skill.policy.options
    return json.dumps({
        "video": (frames, list(skill.images)),
        "state": ([0], list(options["state"])),
        "action": (list(range(HORIZON)), list(SHARES)),
        "language": ([0], [options["language_key"]]),
    })  # fmt: skip


def drive(checkout: Path, name: str, fitting: list[int], others: list[int]) -> None:
    skill = load_skill(name)
    with serving("serve_zmq", str(checkout), config_of(skill, fitting)) as port:
        policy = made(skill, RldxZmqPolicy, f"tcp://127.0.0.1:{port}")
        policy.reset()
        rows = policy.infer(observation(skill))
        assert rows.tobytes() == overshooting().tobytes()
        assert np.abs(admitted_rows(skill, rows)[:, :10]).max() == 1.0
        policy._link.close()
    with serving("serve_zmq", str(checkout), config_of(skill, others)) as port:
        address = f"tcp://127.0.0.1:{port}"
        text = failure(lambda: made(skill, RldxZmqPolicy, address))
        assert f"it wants frames at deltas {others}" in text


@pytest.mark.parametrize(("name", "fitting", "others"), ZMQ_SKILLS)
def test_gr00t_s_server_drives_the_skills(name: str, fitting: list[int], others: list[int]) -> None:
    for checkout in checkouts("GROOT", "gr00t/policy/server_client.py"):
        drive(checkout, name, fitting, others)


@pytest.mark.parametrize(("name", "fitting", "others"), ZMQ_SKILLS[:2])
def test_rldx_s_server_drives_its_skills(name: str, fitting: list[int], others: list[int]) -> None:
    for checkout in checkouts("RLDX", "rldx/policy/server_client.py"):
        drive(checkout, name, fitting, others)
