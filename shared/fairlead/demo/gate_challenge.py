"""Two chunks that the gate must refuse, sent on purpose: too fast, and from the past."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from fairlead.errors import NoAnswerError, ServiceError
from fairlead.keys import last_chunk
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    JointState,
    Outcome,
    Verdict,
    decode,
    encode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.operate.own_claim import own_claim
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.verdict_text import describe

SOURCE = "demo"
VERDICT_TIMEOUT_S = 3.0
RESEND_S = 0.1
OVER_LIMIT_M = 5.0  # in one control period


@dataclass(frozen=True)
class Challenge:
    """What was sent and what the gate said. ``code``: ``G020`` and the like."""

    sent: str
    code: str
    reason: str


class GateChallenge:
    """Sends chunks to an armed gate and waits for its verdicts."""

    def __init__(self, client: RobotClient, robot: RobotManifest, skill: SkillManifest) -> None:
        self._client, self._robot, self._skill = client, robot, skill
        self._arrived = threading.Condition()
        self._verdicts: list[tuple[str, Verdict]] = []
        self._newest: JointState | None = None
        client.bus.subscribe(client.keys.every_verdict, self._on_verdict)
        client.bus.subscribe(client.keys.joints, self._on_joints)

    def over_limit(self) -> Challenge:
        """Claim the arm and ask for a step far beyond its limit."""
        part = self._robot.part_names.index("arm")
        rows = [[OVER_LIMIT_M, 0.0, 0.0, 0.0, 0.0, 0.0]] * self._skill.horizon
        with own_claim(self._client, SOURCE, self._robot, self._skill, ("arm",)) as claim:
            tick = self._wait_state().tick
            chunk = ActionChunk(
                robot_hash=self._robot.robot_hash,
                session=claim.session,
                epoch=claim.epoch,
                claim_id=claim.claim_id,
                source=SOURCE,
                seq=1,
                goal_id=0,
                obs_tick=tick,
                oldest_tick=tick,
                start_tick=tick,
                horizon=len(rows),
                parts=(
                    ActionPart(
                        part=part,
                        mode=ControlMode.CARTESIAN_DELTA,
                        frame_id=self._robot.base_frame,
                        values=pack_floats(rows),
                        active=(),
                    ),
                ),
                trace=NO_TRACE,
            )
            text = f"a chunk that moves the arm {OVER_LIMIT_M:g} m in every control period"
            return self._send(SOURCE, encode(chunk), text)

    def replay(self, recorded: bytes) -> Challenge:
        """Send a chunk of the finished goal again, exactly as it was recorded."""
        source = decode(ActionChunk, recorded).source
        return self._send(source, recorded, "a recorded chunk of the finished goal, unchanged")

    def _send(self, source: str, payload: bytes, sent: str) -> Challenge:
        key = self._client.keys.candidate(source)
        with self._arrived:
            self._verdicts.clear()
        publisher = self._client.bus.publisher(key, ActionChunk, Qos.HOT)
        verdict = self._ask_verdict(source, lambda: publisher.put_bytes(payload))
        if verdict.outcome != Outcome.REFUSED:
            raise ServiceError(f"the gate did not refuse {sent}: {describe(verdict)}")
        return Challenge(sent, f"G{verdict.code:03d}", describe(verdict))

    def _ask_verdict(self, source: str, send: Callable[[], None]) -> Verdict:
        """Send until a verdict comes: hot keys may lose a message, copies are answered alike."""
        deadline = time.monotonic() + VERDICT_TIMEOUT_S
        while time.monotonic() < deadline:
            send()
            with self._arrived:
                self._arrived.wait_for(lambda: self._verdict_for(source) is not None, RESEND_S)
                verdict = self._verdict_for(source)
            if verdict is not None:
                return verdict
        raise NoAnswerError(f"no verdict for {source} within {VERDICT_TIMEOUT_S:g} s")

    def _verdict_for(self, source: str) -> Verdict | None:
        return next((verdict for who, verdict in self._verdicts if who == source), None)

    def _wait_state(self) -> JointState:
        with self._arrived:
            self._arrived.wait_for(lambda: self._newest is not None, VERDICT_TIMEOUT_S)
            if self._newest is None:
                raise NoAnswerError(f"no joint state within {VERDICT_TIMEOUT_S:g} s")
            return self._newest

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        with self._arrived:
            self._verdicts.append((last_chunk(sample.key), verdict))
            self._arrived.notify_all()

    def _on_joints(self, sample: Sample) -> None:
        with self._arrived:
            self._newest = decode(JointState, sample.payload)
            self._arrived.notify_all()
