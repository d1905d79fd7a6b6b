"""Two chunks that the gate must refuse, sent on purpose: too fast, and from the past."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from fairlead.errors import ChunkRefusedError, NoAnswerError, ServiceError
from fairlead.messages import ActionChunk, Outcome, Verdict
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Qos
from fairlead.wire.verdict_text import describe

SOURCE = "demo"
VERDICT_TIMEOUT_S = 3.0
RESEND_S = 0.1
OVER_LIMIT_M = 5.0  # in one control period


@dataclass(frozen=True)
class Challenge:
    """What was sent and what the gate said of it."""

    sent: str
    verdict: Verdict

    @property
    def reason(self) -> str:
        """The verdict in words."""
        return describe(self.verdict)


def over_limit(client: RobotClient, robot: RobotManifest, skill: SkillManifest) -> Challenge:
    """Claim the arm of an armed robot and ask for a step far beyond its limit."""
    rows = np.zeros((skill.horizon, 6))
    rows[:, 0] = OVER_LIMIT_M
    sent = f"a chunk that moves the arm {OVER_LIMIT_M:g} m in every control period"
    with client.claim(["arm"], source=SOURCE, task=skill.id) as claim:
        arm = claim.rows("arm", ControlMode.CARTESIAN_DELTA, rows, frame=robot.base_frame)
        try:
            verdict = claim.send(claim.next_tick().number, arm)
        except ChunkRefusedError as refused:
            verdict = refused.verdict
    return _refused(sent, verdict)


def replay(client: RobotClient, recorded: bytes) -> Challenge:
    """Send a chunk of a finished goal again, exactly as it was recorded.

    On a key of its own: nobody but the runner gets anything through on the runner's.
    """
    verdicts = client.verdicts(SOURCE)
    publisher = client.bus.publisher(client.keys.candidate(SOURCE), ActionChunk, Qos.HOT)
    deadline_s = time.monotonic() + VERDICT_TIMEOUT_S
    while time.monotonic() < deadline_s:
        publisher.put_bytes(recorded)  # hot keys may lose a message, copies are answered alike
        verdict = verdicts.next(RESEND_S)
        if verdict is not None:
            return _refused("a recorded chunk of the finished goal, unchanged", verdict)
    raise NoAnswerError(f"no verdict for {SOURCE} within {VERDICT_TIMEOUT_S:g} s")


def _refused(sent: str, verdict: Verdict) -> Challenge:
    if verdict.outcome != Outcome.REFUSED:
        raise ServiceError(f"the gate did not refuse {sent}: {describe(verdict)}")
    return Challenge(sent, verdict)
