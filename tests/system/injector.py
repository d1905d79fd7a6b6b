"""Chunks of one's own, sent beside a whole running robot, and what the gate says of them."""

from __future__ import annotations

import threading
import time

import msgspec
import numpy as np

from bench.equipment.live_robot import LiveRobot, wait_for
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    ClaimReply,
    FloatArray,
    GateStatus,
    JointState,
    Message,
    Verdict,
    decode,
    encode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Qos, Sample

ROBOT = load_robot("panda_mobile")
SOURCE = "injector"
ROWS = 8
GENTLE_M = 0.01  # a step that would be released
WATCHED_TICKS = 5


def part(name: str, mode: ControlMode, rows: FloatArray, *active: int) -> ActionPart:
    """Rows ``[H, width]`` of one part, SI; cartesian ones along the base's axes."""
    frame = ROBOT.base_frame if mode is ControlMode.CARTESIAN_DELTA else ""
    return ActionPart(
        part=ROBOT.part_names.index(name),
        mode=mode,
        frame_id=frame,
        values=pack_floats(rows),
        active=active,
    )


class Injector:
    """An armed robot, a claim of its own on the arm, and the gate's answers."""

    def __init__(self, robot: LiveRobot, claim: ClaimReply) -> None:
        self.robot, self.claim = robot, claim
        self.verdicts: list[Verdict] = []
        self._newest: JointState | None = None
        self._arrived = threading.Condition()
        bus, keys = robot.client.bus, robot.client.keys
        self._publisher = bus.publisher(keys.candidate(SOURCE), ActionChunk, Qos.HOT)
        self._heard = [
            bus.subscribe(keys.verdict(SOURCE), self._on_verdict),
            bus.subscribe(keys.joints, self._on_joints),
        ]

    def close(self) -> None:
        for subscription in self._heard:
            subscription.undeclare()

    def chunk(self, value: float = GENTLE_M, **changes: object) -> ActionChunk:
        """A chunk for the newest tick that moves the arm, with some fields changed."""
        with self._arrived:
            assert self._arrived.wait_for(lambda: self._newest is not None, 10.0)
            assert self._newest is not None
            tick = self._newest.tick
        rows = np.zeros((ROWS, 6))
        rows[:, 0] = value
        chunk = ActionChunk(
            robot_hash=ROBOT.robot_hash,
            session=self.claim.session,
            epoch=self.claim.epoch,
            claim_id=self.claim.claim_id,
            source=SOURCE,
            seq=1,
            goal_id=0,
            obs_tick=tick,
            oldest_tick=tick,
            start_tick=tick,
            horizon=ROWS,
            parts=(part("arm", ControlMode.CARTESIAN_DELTA, rows),),
            trace=NO_TRACE,
        )
        return msgspec.structs.replace(chunk, **changes)

    def send(self, message: Message) -> Verdict:
        """The gate's verdict; copies repair a lost message."""
        payload, count = encode(message), len(self.verdicts)

        def answered() -> bool:
            self._publisher.put_bytes(payload)
            with self._arrived:
                return self._arrived.wait_for(lambda: len(self.verdicts) > count, 0.1)

        wait_for(answered, "a verdict", timeout_s=5.0)
        return self.verdicts[count]

    def send_bytes(self, payload: bytes) -> None:
        self._publisher.put_bytes(payload)

    def nothing_moves(self) -> None:
        """The HAL's log: no row acts in the ticks after now."""
        now_ns = time.monotonic_ns()
        motion = self.robot.motion
        wait_for(lambda: len(motion.since(now_ns)) >= WATCHED_TICKS, "some ticks pass")
        assert not any(line.moves for line in motion.since(now_ns - 10**9))

    def gate(self) -> GateStatus:
        return self.robot.client.gate_status()

    def _on_verdict(self, sample: Sample) -> None:
        with self._arrived:
            self.verdicts.append(decode(Verdict, sample.payload))
            self._arrived.notify_all()

    def _on_joints(self, sample: Sample) -> None:
        with self._arrived:
            self._newest = decode(JointState, sample.payload)
            self._arrived.notify_all()
