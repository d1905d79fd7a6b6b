"""Every HAL that ships, and the example of the document, keep the contract."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml

from bench.equipment.emulated_arm import emulated_arm
from fairlead.paths import deployment_path, repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.conformance.hal_check import HalCheck
from fairlead_tools.conformance.row import GROUPS
from fairlead_tools.supervisor.this_host import free_ports
from tests.conformance.running_hal import Wanted, check_all, rows_of
from tests.ros2.ros_process import FINGERS, JOINTS, RosProcess, panda_options
from tests.so101.arm import as_delivered

pytestmark = [pytest.mark.processes, pytest.mark.simulator]

AT_ONCE = 7
EXAMPLE = repo_root() / "docs" / "examples" / "minimal_hal.py"
PATIENT_S = 2.0
"""On a busy machine the robot on the other side may be late."""
TIMING = {"tick rate", "jitter"}
"""On a busy machine anybody's ticks may come late."""
MAY_FAIL = {"hal_sim": {"joint limits under cartesian rows arm cartesian_delta"}}
"""Without joint_speed_guard, by where the arm stands (tests/task/test_holding.py: it is faster)."""
NO_TOOL = {"command frame", "tool gain", "joint limits under cartesian rows"}
NO_BASE, NO_GRIPPER = {"base command frame"}, {"gripper way"}
GUARD = ("forged rows", "forged leases")
NOT_CHECKED: dict[str, set[str]] = {
    "minimal_hal": NO_TOOL | NO_BASE,
    "hal_kinematic": NO_TOOL | NO_BASE,
    "hal_mujoco": NO_TOOL | NO_BASE,
    "hal_mujoco_waiting": TIMING | (set(GROUPS) - set(GUARD)),
    "hal_ros2": NO_TOOL | NO_BASE,
    "hal_so101": NO_BASE | NO_GRIPPER,
    "hal_sim": {"turns"},  # the check does not drive a base that far
}
"""What its robot has not: of each HAL all that may be left out."""


def _shipped_options(deployment: str) -> dict[str, Any]:
    spec = yaml.safe_load(deployment_path(deployment).read_text(encoding="utf-8"))
    hal = spec["services"]["hal"]
    return {"run": hal["run"], "options": hal["options"]}


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, HalCheck]]:
    folder = tmp_path_factory.mktemp("shipped")
    with ExitStack() as ends:
        arm = ends.enter_context(emulated_arm(folder / "arm"))
        servos = {
            "port": str(arm.port),
            "calibration": str(as_delivered(folder)),
            "answer_timeout_s": 0.4,
        }
        wanted = {
            "hal_sim": Wanted("panda_mobile", _shipped_options("panda_mobile_sim_realtime")),
            "hal_ros2": Wanted("panda", {"run": "hal_ros2", "options": _ros(ends, folder)}),
            "hal_so101": Wanted("so101", {"run": "hal_so101", "options": servos}),
            "hal_mujoco": Wanted("panda", {"run": "hal_mujoco"}),
            "hal_mujoco_waiting": Wanted(
                "panda", {"run": "hal_mujoco"}, pacing="lockstep", only=GUARD
            ),
            "hal_kinematic": Wanted("panda", {"run": "hal_kinematic"}),
            "minimal_hal": Wanted("panda", {"command": ["python", str(EXAMPLE)]}),
        }
        for name, one in wanted.items():
            wanted[name] = replace(one, expected=partial(keeps_the_contract, name))
        yield check_all(folder, wanted, AT_ONCE)


def _ros(ends: ExitStack, folder: Path) -> dict[str, Any]:
    """A robot that speaks ROS 2 through a router, and the options that lead to it."""
    port = free_ports(1)[0]
    endpoint = f"tcp/127.0.0.1:{port}"
    router = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    ends.callback(router.close)
    told = {"joints": JOINTS | FINGERS, "positions": list(FINGERS), "port": port, "domain": 0}
    ends.callback(RosProcess(folder, "ros_robot", **told).end)
    return panda_options(endpoint) | {"stale_after_s": PATIENT_S}


def keeps_the_contract(name: str, found: HalCheck) -> bool:
    """Velocities that are asked too seldom say nothing of what the joint did in between."""
    failed = set(rows_of(found, "fail"))
    if "tick rate" in failed:
        failed = {one for one in failed if not one.startswith("SI velocities")}
    return failed <= TIMING | MAY_FAIL.get(name, set())


@pytest.mark.thorough
@pytest.mark.parametrize("name", NOT_CHECKED)
def test_a_hal_that_ships_keeps_the_contract(found: dict[str, HalCheck], name: str) -> None:
    failed = rows_of(found[name], "fail")
    assert keeps_the_contract(name, found[name]), failed


@pytest.mark.thorough
@pytest.mark.parametrize("name", NOT_CHECKED)
def test_nothing_is_left_out_but_what_its_robot_has_not(
    found: dict[str, HalCheck], name: str
) -> None:
    left = {row.check for row in found[name].rows if row.outcome == "not checked"}
    assert left == NOT_CHECKED[name], rows_of(found[name], "not checked")
