"""A gripper loses what it held: gate, HAL core and physics, tick by tick in lockstep."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from bench.equipment.core_gate import SESSION, SOURCE, CoreGate
from fairlead.hal.core import HalCore, TickPlan
from fairlead.messages import (
    Acted,
    GateState,
    JointState,
    Lease,
    SafeChunk,
    decode,
    encode,
    pack_floats,
)
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.hal_mujoco.dual_panda import DualPanda

pytestmark = pytest.mark.processes

GRIPPER, OPENING_MODE = "left_gripper", 10
OBJECT_M = 0.03
SLIP_M = 0.005


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """dual_panda's gate file, in which losing an object is a stop."""
    data = json.loads(gate_config("dual_panda", "sim").read_text())
    for part in data["parts"]:
        if part["name"] == GRIPPER:
            part["modes"]["gripper_position"]["slip_limit"] = SLIP_M
    path = tmp_path_factory.mktemp("gate") / "gate.slip.json"
    path.write_text(json.dumps(data))
    return path


class Bench:
    """The three, and an object between the fingers: they end where it begins."""

    def __init__(self, config: Path) -> None:
        self.robot = load_robot("dual_panda")
        self.world = DualPanda(self.robot)
        self.gate = CoreGate(config)
        self.core = HalCore(
            SESSION, "lockstep", len(self.robot.parts), self.robot.n_dof, self.robot.tick_period_ns
        )
        self.part = self.robot.part_names.index(GRIPPER)
        self.joint = self.robot.joint_names.index(GRIPPER)
        self.tick = 1

    def hold_object(self, width_m: float) -> None:
        """The fingers meet it; 0: it is gone."""
        model = self.world.backend._model
        model.joint("left_finger_joint1").range[0] = width_m / 2
        model.joint("left_finger_joint2").range[1] = -width_m / 2

    def close_gripper(self) -> None:
        """Arm, claim, and 64 rows that close it."""
        positions = self.world.backend.read().positions
        self.gate.start("lockstep", still(self.tick, positions))
        empty = Chunk(self.tick, 1, ())
        self.gate.claim(Case("dual_panda", "lockstep", still(self.tick, positions), empty))
        rows = PartRows(self.part, OPENING_MODE, np.zeros((64, 1)))
        self.gate._seq = 1
        self._send("candidate", encode(self.gate.message(Chunk(self.tick, 64, (rows,)), self.tick)))

    @property
    def opening(self) -> float:
        return float(self.world.backend.read().positions[self.joint])

    def acted(self) -> Acted:
        return self.core.acted[self.part]

    def step(self) -> None:
        """The HAL does what it decides for this tick, and measures the next one."""
        plan = self.core.decide(self.tick, 0, is_still=False)
        assert isinstance(plan, TickPlan), plan
        names = self.robot.part_names
        self.world.backend.apply({names[part]: row for part, row in plan.commands.items()})
        self.tick += 1
        measured = self.world.backend.read()
        state = JointState(
            session=SESSION,
            tick=self.tick,
            episode_tick=1,
            stamp_ns=0,
            positions=pack_floats(measured.positions),
            velocities=pack_floats(measured.velocities),
            efforts=pack_floats(measured.efforts),
            acted=self.core.acted,
            robot_hash=self.robot.robot_hash,
        )
        self._send("joint_state", encode(state))

    def _send(self, kind: str, payload: bytes) -> None:
        source = SOURCE if kind == "candidate" else ""
        for out in self.gate._step(kind, source, payload):  # type: ignore[arg-type]
            if out.kind == "safe_chunk":
                self.core.on_safe_chunk(decode(SafeChunk, out.payload))
            elif out.kind == "lease":
                self.core.on_lease(decode(Lease, out.payload), 0)


@pytest.fixture
def bench(config: Path) -> Iterator[Bench]:
    bench = Bench(config)
    yield bench
    bench.gate.close()


def test_a_lost_object_stops_and_the_gripper_keeps_its_command(bench: Bench) -> None:
    bench.hold_object(OBJECT_M)
    bench.close_gripper()
    for _ in range(40):
        bench.step()
        assert not bench.acted().hold
    assert bench.gate.status().state == GateState.ARMED
    assert bench.opening > OBJECT_M - 0.01, "the object is between the fingers"
    held_at = bench.opening
    bench.hold_object(0.0)
    ticks = 0
    while bench.gate.status().state == GateState.ARMED:
        bench.step()
        ticks += 1
        assert ticks <= 4
    assert bench.gate.status().cause.startswith("stopped: G042 left_gripper left_gripper: ")
    assert "lost what it held" in bench.gate.status().cause
    assert held_at - bench.opening > SLIP_M
    for _ in range(20):
        bench.step()
        assert bench.acted().hold
    assert bench.opening < 0.002, "stopped, it still closes: a grasp would be kept"


def test_an_object_that_stays_is_no_stop(bench: Bench) -> None:
    bench.hold_object(OBJECT_M)
    bench.close_gripper()
    for _ in range(60):
        bench.step()
    assert bench.gate.status().state == GateState.ARMED
