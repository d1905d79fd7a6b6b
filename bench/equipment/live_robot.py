"""A running robot as the system tests drive it: goals, faults, and the way back to a goal."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
import time
from collections.abc import Callable, Collection
from concurrent.futures import Future
from contextlib import suppress

from bench.equipment.motion_log import MotionLine, MotionLog
from fairlead.deploy.hosts import ROUTER
from fairlead.errors import FairleadError, RefusedError
from fairlead.messages import GateState, GoalResult, ResetEpisodeReply, SafeChunk, decode
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor import ServiceEvent, Supervisor
from fairlead_tools.supervisor.scratch import ScratchRobot

SKILL = "oracle-counter-to-cabinet"
WAIT_S = 60.0
ARM_S = 10.0
HOLD_TIMEOUT_S = 15.0  # far beyond any promise
POLL_S = 0.02
DEADLINE_TICKS = 800
MOVING_TICKS = 10  # rows in a row before a fault is injected


def wait_for(condition: Callable[[], bool], what: str, timeout_s: float = WAIT_S) -> None:
    """Poll until a condition of another process holds."""
    pause, deadline = threading.Event(), time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"not within {timeout_s:g} s: {what}"
        pause.wait(POLL_S)


def recover(client: RobotClient) -> None:
    """The operator's way from stopped or latched to disarmed; an armed gate stays so."""
    client.wait_gate_follows(WAIT_S)

    def acknowledged() -> bool:
        gate = client.gate_status()
        if gate.state in (GateState.DISARMED, GateState.ARMED):
            return True
        for one in filter(None, (gate.latch_id, *gate.stop_ids)):
            with suppress(FairleadError):  # not still yet, or the cause is not gone: asked again
                client.reset(one)
        return False

    wait_for(acknowledged, "the gate is disarmed")


class LiveRobot:
    """Services that run, a client, the HAL's motion log, and what the gate released.

    first_ticks: first tick of each released chunk, by verdict.
    """

    def __init__(self, robot: ScratchRobot, skill: str = SKILL) -> None:
        self.robot = robot
        self._skill = skill
        self.client = robot.client
        self.supervisor = robot.supervisor
        self.motion = MotionLog(robot.scratch.state_dir / "hal")
        self.first_ticks: dict[int, int] = {}
        self.client.bus.subscribe(self.client.keys.every_safe, self._on_safe)

    def _on_safe(self, sample: Sample) -> None:
        chunk = decode(SafeChunk, sample.payload)
        self.first_ticks[chunk.verdict_id] = chunk.first_tick

    # --- goals -----------------------------------------------------------------------

    def ready_to_move(self, seed: int = 0) -> ResetEpisodeReply:
        """Acknowledge whatever holds the gate, start an episode, arm; how the reset went."""
        self.recover()
        if self.client.gate_status().state == GateState.ARMED:
            self.client.disarm()
        reset = self.client.reset_episode(seed)
        wait_for(self._is_armed, "a machine that is not too late to arm", ARM_S)
        return reset

    def _is_armed(self) -> bool:
        try:
            self.client.arm()
        except RefusedError as error:
            if "ms old, at most" not in str(error):  # the newest state, on a busy machine
                raise
            return False
        return True

    def make_ready(self, seed: int) -> None:
        """What a goal needs before it can begin to move."""
        self.ready_to_move(seed)

    def start_goal(self, stall_timeout_s: float = 3.0) -> Future[Progress]:
        """Run a goal of the skill in the background."""
        wish = GoalOptions(
            self._skill, deadline_ticks=DEADLINE_TICKS, stall_timeout_s=stall_timeout_s
        )
        progress: Future[Progress] = Future()

        def run() -> None:
            try:
                progress.set_result(run_goal(self.client, wish))
            except BaseException as error:  # noqa: BLE001 - handed to whoever asks for the result
                progress.set_exception(error)

        # A daemon: a goal that nobody ends, after a test failed, must not keep the tests alive.
        threading.Thread(target=run, daemon=True).start()
        return progress

    def run_goal(self, seed: int) -> GoalResult:
        """One whole goal in a new episode; leaves the robot disarmed."""
        self.ready_to_move(seed)
        result = self.start_goal().result(timeout=240.0).result
        self.client.disarm()
        assert result is not None
        return result

    def start_moving(self, seed: int = 0) -> Future[Progress]:
        """A goal whose rows are being executed now."""
        self.make_ready(seed)
        began_ns = time.monotonic_ns()
        goal = self.start_goal()
        wait_for(lambda: goal.done() or self._moves_since(began_ns), "the robot moves")
        assert not goal.done(), goal.result()
        return goal

    def _moves_since(self, stamp_ns: int) -> bool:
        newest = self.motion.since(stamp_ns)[-MOVING_TICKS:]
        return len(newest) == MOVING_TICKS and all(line.moves for line in newest)

    # --- faults ----------------------------------------------------------------------

    def signal(self, service: str, number: signal.Signals) -> int:
        """Send a signal to a service.

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        pid, now_ns = self.supervisor.pid(service), time.monotonic_ns()
        os.kill(pid, number)
        return now_ns

    def motion_ended(self, injected_ns: int, settle_ticks: int = 4) -> list[MotionLine]:
        """Every tick decided after an injection, once some held ticks have followed."""

        def held() -> bool:
            newest = self.motion.since(injected_ns)[-settle_ticks:]
            return len(newest) == settle_ticks and not any(line.moves for line in newest)

        wait_for(held, "the robot holds", HOLD_TIMEOUT_S)
        return self.motion.since(injected_ns)

    def restarted(self, *services: str) -> None:
        """Let the supervisor bring dead services back, and wait until they are ready."""
        self.robot.loop.run(_bring_back(self.supervisor, services))
        if ROUTER not in services:
            self.client.wait_alive(*services, timeout_s=WAIT_S)

    def recover(self) -> None:
        """The operator's way from stopped or latched to disarmed."""
        recover(self.client)


async def _bring_back(supervisor: Supervisor, services: Collection[str]) -> None:
    """Start again what is dead until each of these services has said that it is ready again."""
    missing, back = set(services), asyncio.Event()

    def on_event(event: ServiceEvent) -> None:
        if event.kind == "ready":
            missing.discard(event.service)
            if not missing:
                back.set()

    async with asyncio.timeout(120.0), asyncio.TaskGroup() as tasks:
        keeping = tasks.create_task(supervisor.keep(on_event))
        await back.wait()
        keeping.cancel()
