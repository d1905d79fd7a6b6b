"""HAL, assembler and gate in one test-side session, speaking messages to a real runner."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, TypeVar

import yaml

from fairlead.errors import RefusedError
from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    Cancel,
    Claim,
    ClaimInfo,
    ClaimReply,
    Done,
    GateState,
    GateStatus,
    Goal,
    GoalAccepted,
    GoalFeedback,
    HalPart,
    HalStatus,
    Heartbeat,
    JointState,
    LayoutState,
    Lease,
    Message,
    ModeRange,
    TaskState,
    Verdict,
    decode,
    pack_floats,
)
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports
from tests.runner.scripted_robot import (
    CLAIM,
    EPOCH,
    ROBOT,
    ROUTES,
    SESSION,
    SKILL,
    joints,
    layout,
    lease,
    task,
    verdict,
)

DEADLINE_S = 20.0
T = TypeVar("T")


class ScriptedWorld:
    """Counts ticks when told, judges every chunk as told, remembers what the runner said."""

    def __init__(self, folder: Path, *, pacing: Literal["realtime", "lockstep"]) -> None:
        self.keys = Keys("test_robot")
        self.pacing: Literal["realtime", "lockstep"] = pacing
        self.judge: Callable[[ActionChunk, int], Verdict | None] = verdict
        self.claim_refusals: list[RefusedError] = []
        self.claims: list[Claim] = []
        self.released: list[int] = []
        self.chunks: list[bytes] = []
        self.heartbeats: list[float] = []
        self.feedback: list[GoalFeedback] = []
        self.wanted = False
        self.gate, self.epoch = GateState.LATCHED, EPOCH
        self._verdicts = 0
        self._leases = 0
        self._changed = threading.Condition()
        port, runner_port = free_ports(2)
        self.bus = ZenohBus(Endpoints(listen=[f"tcp/127.0.0.1:{port}"]))
        self._deployment = self._write(folder, port, runner_port)
        self._folder = folder
        self.runner: subprocess.Popen[str] | None = None
        self._publishers = {
            kind: self.bus.publisher(key, kind, Qos.HOT)
            for key, kind in (
                (self.keys.joints, JointState),
                (self.keys.task, TaskState),
                (self.keys.layout(SKILL.id), LayoutState),
                (self.keys.lease, Lease),
                (self.keys.verdict("runner"), Verdict),
                (self.keys.hal_status, HalStatus),
            )
        }
        self._listen()

    def _write(self, folder: Path, port: int, runner_port: int) -> Path:
        path = folder / "deployment.yaml"
        options = {"skills": [SKILL.id], "trace": True, "policies": {}}
        self.options: dict[str, Any] = options
        self.document: dict[str, Any] = {
            "robot": "panda_mobile",
            "id": "test_robot",
            "pacing": self.pacing,
            "access": "open",  # one session is everybody but the runner
            "services": {
                "hal": {"run": "hal_sim", "listen": f"tcp/127.0.0.1:{port}"},
                "runner": {
                    "run": "skill_runner",
                    "listen": f"tcp/127.0.0.1:{runner_port}",
                    "options": options,
                },
            },
        }
        return path

    def _listen(self) -> None:
        keys = self.keys
        self.bus.subscribe(keys.candidate("runner"), lambda s: self._on_chunk(s.payload))
        self.bus.subscribe(
            keys.heartbeat("runner"),
            lambda s: self._note(self.heartbeats, decode(Heartbeat, s.payload)),
        )
        self.bus.subscribe(
            keys.feedback("runner"),
            lambda s: self._note(self.feedback, decode(GoalFeedback, s.payload)),
        )
        self.bus.watch_tokens(keys.every_want_layout, self._on_want)
        self.bus.serve(keys.hal_status, "hal", lambda _: self.hal_status())
        self.bus.serve(keys.gate_status, "safety", lambda _: self.gate_status())
        self.bus.serve(keys.claim("runner"), "safety", self._on_claim)
        self.bus.serve(keys.release("runner"), "safety", self._on_release)

    # --- the runner's process ---------------------------------------------------------

    def start_runner(self, policy: dict[str, Any]) -> None:
        self.options["policies"] = {SKILL.id: policy}
        self._deployment.write_text(yaml.safe_dump(self.document))
        command = [sys.executable, "-X", "faulthandler", "-m", "fairlead_skill_runner"]
        command += ["--deployment", str(self._deployment), "--service", "runner"]
        with (self._folder / "runner.log").open("w") as log:
            self.runner = subprocess.Popen(
                [*command, "--state-dir", str(self._folder / "state")],
                stdout=log,
                stderr=subprocess.STDOUT,
                text=True,
            )
        alive = threading.Event()
        self.bus.watch_tokens(self.keys.alive("runner"), lambda _, up: alive.set() if up else None)
        assert alive.wait(DEADLINE_S), (self._folder / "runner.log").read_text()

    def close(self) -> None:
        try:
            if self.runner is not None:
                self._end(self.runner)
        finally:
            self.bus.close()

    def _end(self, runner: subprocess.Popen[str]) -> None:
        runner.terminate()
        try:
            runner.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            runner.send_signal(signal.SIGABRT)  # says where every thread stands
            runner.wait()
            log = (self._folder / "runner.log").read_text()
            raise AssertionError(f"the runner did not end; it said:\n{log}") from None

    # --- what the test says -----------------------------------------------------------

    def tick(self, number: int, *, success: bool = False) -> None:
        self.publish(task(number, success))
        self.publish(joints(number))
        self.publish(layout(number))
        self.publish_lease()

    def gate_turns(self, state: GateState, epoch: int = EPOCH) -> None:
        self.gate, self.epoch = state, epoch

    def publish_lease(self, state: GateState = GateState.ARMED) -> None:
        self._leases += 1
        held = (CLAIM,) if self.claims and state == GateState.ARMED else ()
        self.publish(lease(self._leases, epoch=self.epoch, state=state, claims=held))

    def publish(self, message: Message) -> None:
        self._publishers[type(message)].put(message)  # type: ignore[index]

    def start_goal(self, stall_timeout_s: float = 5.0, deadline_ticks: int = 0) -> int:
        goal = Goal(
            skill=SKILL.id, skill_hash=SKILL.skill_hash, prompt="", deadline_ticks=deadline_ticks,
            stall_timeout_s=stall_timeout_s,
        )  # fmt: skip
        reply = self.bus.query(self.keys.goal("runner"), goal, DEADLINE_S)
        return decode(GoalAccepted, reply).goal_id

    def cancel(self, goal_id: int) -> None:
        cancel = Cancel(goal_id=goal_id, by="test")
        decode(Done, self.bus.query(self.keys.cancel("runner"), cancel, DEADLINE_S))

    def wait_for(self, found: Callable[[], T | None], every: Callable[[], None] | None = None) -> T:
        """Wait until ``found`` gives something; ``every`` is done ten times a second."""
        until_s = time.monotonic() + DEADLINE_S
        while (value := found()) is None:
            if time.monotonic() > until_s:
                log = (self._folder / "runner.log").read_text()
                raise AssertionError(f"not within {DEADLINE_S} s; the runner said:\n{log}")
            if every is not None:
                every()
            with self._changed:
                self._changed.wait(0.1)
        return value

    def result(self, goal_id: int, every: Callable[[], None] | None = None) -> GoalFeedback:
        return self.wait_for(
            lambda: next(
                (f for f in self.feedback if f.goal_id == goal_id and f.result is not None), None
            ),
            every,
        )

    # --- what the runner says ---------------------------------------------------------

    def _note(self, notes: list[Any], what: object) -> None:
        with self._changed:
            notes.append(what)
            self._changed.notify_all()

    def _on_chunk(self, payload: bytes) -> None:
        self._note(self.chunks, payload)
        self._verdicts += 1
        judged = self.judge(decode(ActionChunk, payload), self._verdicts)
        if judged is not None:
            self.publish(judged)

    def _on_want(self, key: str, alive: bool) -> None:
        self.wanted = alive

    def _on_claim(self, payload: bytes) -> ClaimReply:
        if self.claim_refusals:
            raise self.claim_refusals.pop(0)
        self._note(self.claims, decode(Claim, payload))
        return ClaimReply(claim_id=CLAIM, epoch=self.epoch, session=SESSION)

    def _on_release(self, payload: bytes) -> Done:
        self._note(self.released, CLAIM)
        return Done(text="released")

    def hal_status(self) -> HalStatus:
        ranges = {0: [0.05] * 3 + [0.5] * 3, 1: [0.08], 2: [1.0, 1.0, 1.5], 3: [1.0]}
        return HalStatus(
            session=SESSION, robot="test_robot", robot_hash=ROBOT.robot_hash, pacing=self.pacing,
            period_ns=ROBOT.tick_period_ns, tick=1, episode_tick=1, state="ready", detail="",
            joints=ROBOT.joint_names, passive_joints=ROBOT.passive_joint_names,
            parts=tuple(
                HalPart(
                    name=part.name, simulator_part="", joints=part.joints,
                    ranges=(ModeRange(
                        mode=int(ROUTES[index].mode),
                        lower=pack_floats([0.0 if index == 1 else -v for v in ranges[index]]),
                        upper=pack_floats(ranges[index]),
                    ),),
                )
                for index, part in enumerate(ROBOT.parts)
            ),
            simulator_order=(), cameras=(), has_task=True, overruns=0,
        )  # fmt: skip

    def gate_status(self) -> GateStatus:
        former = ClaimInfo(source="runner", skill=SKILL.id, claim_id=1, parts=("arm",))
        return GateStatus(
            robot="test_robot", profile="sim", session=SESSION, epoch=self.epoch,
            state=self.gate, cause="three stops within 60 s", fix="fairlead reset 7",
            latch_id=7, stop_ids=(), claims=(former,), counters=(), state_tick=1,
            lockstep_allowed=True,
            config_hash=bytes(32), robot_hash=ROBOT.robot_hash,
        )  # fmt: skip
