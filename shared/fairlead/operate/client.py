"""The same robot for programs that block: each method runs its namesake of `Robot` to the end."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar

from fairlead.deploy.deployment import Deployment
from fairlead.errors import FairleadError, NoAnswerError
from fairlead.keys import Keys
from fairlead.messages import (
    ArmReply,
    Done,
    GateStatus,
    GoalFeedback,
    HalStatus,
    JointState,
    ResetEpisodeReply,
    TransformBatch,
    Verdict,
)
from fairlead.operate.blocking import BlockingClaim, BlockingGoal, BlockingSubscription, LoopThread
from fairlead.operate.part_claim import PartClaim
from fairlead.operate.protective_stop import NO_REASON
from fairlead.operate.robot import STALL_TIMEOUT_S, Robot
from fairlead.operate.services import (
    ALIVE_TIMEOUT_S,
    GATE_FOLLOWS_TIMEOUT_S,
    RobotStatus,
)
from fairlead.operate.subscription import QUEUE, SILENCE_S, Heard, Subscription
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Bus
from fairlead.wire.topics import EVERY

SEEN_S = 1.0  # links are up, and tokens told, well within

T = TypeVar("T")


def alive_services(deployment: Deployment, settle_s: float = SEEN_S) -> frozenset[str]:
    """Services whose liveliness token is seen within ``settle_s``: a hint for people.

    Raises:
        TransportError: if the session cannot be opened.
    """
    with RobotClient(deployment) as client:
        with suppress(NoAnswerError):
            client.wait_alive(*deployment.services, timeout_s=settle_s)
        return client.alive


class RobotClient:
    """A running robot; its methods block, may be called from any thread, and raise as `Robot`'s.

    Args:
        deployment: whose services.
        bus: an open transport, which stays open; None opens (and `close` closes) a Zenoh session.
        by: the program that asks; services log it behind the person's name.

    Raises:
        TransportError: if the session cannot be opened.
    """

    def __init__(
        self, deployment: Deployment, bus: Bus | None = None, by: str = "fairlead"
    ) -> None:
        self._thread = LoopThread()
        self._do = self._thread.run
        try:
            self._robot = self._do(Robot.open(deployment, by, bus))
        except BaseException:
            self._thread.close()
            raise
        self._is_open = True

    def __enter__(self) -> RobotClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """As `Robot.close`."""
        if self._is_open:
            self._is_open = False
            try:
                self._do(self._robot.close())
            finally:
                self._thread.close()

    # --- who is there ---------------------------------------------------------------

    @property
    def by(self) -> str:
        """Person, host and program, as services log who asks."""
        return self._robot.by

    @property
    def deployment(self) -> Deployment:
        """Whose services these are."""
        return self._robot.deployment

    @property
    def keys(self) -> Keys:
        """Keys of this robot."""
        return self._robot.keys

    @property
    def bus(self) -> Bus:
        """The transport; its handlers run on threads of their own."""
        return self._robot.bus

    @property
    def gate(self) -> str:
        """Name of the gate."""
        return self._robot.gate

    @property
    def hal(self) -> str:
        """Name of the HAL."""
        return self._robot.hal

    @property
    def manifest(self) -> RobotManifest:
        """As `Robot.manifest`."""
        return self._robot.manifest

    @property
    def alive(self) -> frozenset[str]:
        """As `Robot.alive`."""
        return self._robot.alive

    def wait_alive(self, *services: str, timeout_s: float = ALIVE_TIMEOUT_S) -> None:
        """As `Robot.wait_alive`."""
        self._do(self._robot.wait_alive(*services, timeout_s=timeout_s))

    def wait_anyone(self, timeout_s: float = ALIVE_TIMEOUT_S) -> None:
        """As `Robot.wait_anyone`."""
        self._do(self._robot.wait_anyone(timeout_s))

    def status(self, timeout_s: float = ALIVE_TIMEOUT_S) -> RobotStatus:
        """As `Robot.status`."""
        return self._do(self._robot.status(timeout_s))

    # --- the gate and the HAL ---------------------------------------------------------

    def gate_status(self) -> GateStatus:
        """As `Robot.gate_status`."""
        return self._do(self._robot.gate_status())

    def hal_status(self) -> HalStatus:
        """As `Robot.hal_status`."""
        return self._do(self._robot.hal_status())

    def arm(self) -> ArmReply:
        """As `Robot.arm`."""
        return self._do(self._robot.arm())

    def disarm(self) -> Done:
        """As `Robot.disarm`."""
        return self._do(self._robot.disarm())

    def stop(self, reason: str = NO_REASON) -> int:
        """As `Robot.stop`."""
        return self._do(self._robot.stop(reason))

    def reset(self, stop_or_latch_id: int) -> Done:
        """As `Robot.reset`."""
        return self._do(self._robot.reset(stop_or_latch_id))

    def reset_episode(self, seed: int) -> ResetEpisodeReply:
        """As `Robot.reset_episode`."""
        return self._do(self._robot.reset_episode(seed))

    def following_gate(self) -> GateStatus | None:
        """As `Robot.following_gate`."""
        return self._do(self._robot.following_gate())

    def wait_gate_follows(self, timeout_s: float = GATE_FOLLOWS_TIMEOUT_S) -> GateStatus:
        """As `Robot.wait_gate_follows`."""
        return self._do(self._robot.wait_gate_follows(timeout_s))

    # --- goals and claims ---------------------------------------------------------------

    def run(
        self,
        skill: str,
        *,
        prompt: str = "",
        deadline_ticks: int = 0,
        stall_timeout_s: float = STALL_TIMEOUT_S,
        runner: str = "",
        hand_over_to: str = "",
    ) -> BlockingGoal:
        """As `Robot.run`."""
        starting = self._robot.run(
            skill,
            prompt=prompt,
            deadline_ticks=deadline_ticks,
            stall_timeout_s=stall_timeout_s,
            runner=runner,
            hand_over_to=hand_over_to,
        )
        return BlockingGoal(self._thread, self._do(starting))

    def load(self, skill: str, runner: str = "") -> Done:
        """As `Robot.load`."""
        return self._do(self._robot.load(skill, runner))

    def cancel(self, runner: str, goal_id: int) -> Done:
        """As `Robot.cancel`."""
        return self._do(self._robot.cancel(runner, goal_id))

    def goal_feedback(self, runner: str) -> GoalFeedback:
        """As `Robot.goal_feedback`."""
        return self._do(self._robot.goal_feedback(runner))

    def claim(self, parts: Sequence[str], *, source: str, task: str = "") -> BlockingClaim:
        """As `Robot.claim`, for a ``with`` block."""

        async def claim() -> PartClaim:
            return self._robot.claim(parts, source=source, task=task)

        return BlockingClaim(self._thread, self._do(claim()))

    # --- to look on ---------------------------------------------------------------------

    def joint_states(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> BlockingSubscription[JointState]:
        """As `Robot.joint_states`."""
        return self._subscribe(Robot.joint_states, queue=queue, timeout_s=timeout_s)

    def transforms(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> BlockingSubscription[TransformBatch]:
        """As `Robot.transforms`."""
        return self._subscribe(Robot.transforms, queue=queue, timeout_s=timeout_s)

    def verdicts(
        self, source: str = EVERY, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> BlockingSubscription[Verdict]:
        """As `Robot.verdicts`."""
        return self._subscribe(Robot.verdicts, source, queue=queue, timeout_s=timeout_s)

    def gate_statuses(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> BlockingSubscription[GateStatus]:
        """As `Robot.gate_statuses`."""
        return self._subscribe(Robot.gate_statuses, queue=queue, timeout_s=timeout_s)

    def topic(
        self, name: str, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> BlockingSubscription[Heard]:
        """As `Robot.topic`."""
        return self._subscribe(Robot.topic, name, queue=queue, timeout_s=timeout_s)

    def _subscribe(
        self, subscribe: Callable[..., Subscription[T]], *words: Any, **options: Any
    ) -> BlockingSubscription[T]:
        async def made() -> Subscription[T]:
            return subscribe(self._robot, *words, **options)

        return BlockingSubscription(self._thread, self._do(made()))


def load_meanwhile(client: RobotClient, skill: str, runner: str = "") -> None:
    """As `Robot.load`, without waiting for what comes of it: the skill's goal will say that."""

    def load() -> None:
        with suppress(FairleadError, asyncio.CancelledError):
            client.load(skill, runner)

    threading.Thread(target=load, name="load", daemon=True).start()
