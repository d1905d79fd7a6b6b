"""Chunks and requests that are not what they should be."""

from __future__ import annotations

import msgspec
import numpy as np

from bench.equipment.gate_scene import Scene
from bench.faults.gate_stage import (
    JUDGED,
    GateStage,
    Stopwatch,
    counted,
    refused,
    refused_at_once,
    stopped,
)  # fmt: skip
from bench.faults.row import Row, Shot
from fairlead.messages import (
    ActionChunk,
    GateState,
    HalStatus,
    Message,
    Outcome,
    encode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.wire.bus import Qos

T_MS = 50.0
JUMP_RAD = 0.5
SLOW_RAD_S = 0.1


def rows(value: float, at: int = 0, count: int = 8) -> bytes:
    """Rows of the arm that are 0 but for one number."""
    values = np.zeros((count, 6))
    values[at, 0] = value
    return pack_floats(values)


def replay(stage: GateStage) -> Shot:
    with stage.ready() as scene:
        watch = Stopwatch()
        recorded = scene.chunk()
        refused_at_once(scene, watch, scene.chunk(session=scene.hal.session ^ 1), 2)
        refused_at_once(scene, watch, scene.chunk(claim_id=scene.claim_id ^ 1), 4)
        scene.release()
        scene.take_claim()
        scene.seq = recorded.seq
        refused_at_once(scene, watch, recorded, 4)
        scene.disarm()
        scene.arm()
        scene.take_claim()
        refused_at_once(scene, watch, recorded, 3)
        return watch.shot("G002, G004, G004, G003")


def wild_numbers(stage: GateStage) -> Shot:
    with stage.ready() as scene:
        watch = Stopwatch()
        scene.send(scene.chunk())
        before = counted(scene, "G005")
        for seq in (10**9, 2**64 - 1, 0):
            refused_at_once(scene, watch, scene.chunk(seq=seq), 5)
        assert counted(scene, "G005") == before + 3
        scene.seq = 1
        for _ in range(5):
            refused_at_once(scene, watch, scene.chunk(obs_tick=scene.hal.tick + 10**6), 6)
        stopped(scene)
        return watch.shot("seq: 3 refused and counted; the fifth obs_tick stopped")


def no_numbers(stage: GateStage) -> Shot:
    watch = Stopwatch()
    watch.longest_ms = 0.0
    for value in (np.nan, np.inf, -np.inf, 1e308):
        with stage.ready() as scene:
            verdict = scene.send(scene.chunk(parts=(scene.arm_part(values=rows(value, at=7)),)))
            assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, 8), verdict
            watch.note_ms(verdict.latency_ns / 1e6)
            stopped(scene)
    with stage.ready() as scene:
        verdict = scene.send(scene.chunk(parts=(scene.arm_part(values=rows(5e-324)),)))
        assert verdict.outcome == Outcome.RELEASED, verdict
        watch.note_ms(verdict.latency_ns / 1e6)
    return watch.shot("denormal 5e-324 judged and released")


def wrong_robot(stage: GateStage) -> Shot:
    with stage.scene() as scene:
        scene.meet_hal()
        scene.arm()
        watch = Stopwatch()
        watch.timed(lambda: refused(lambda: scene.claim(robot_hash=bytes(32)), "robot_hash"))
        scene.take_claim()
        refused_at_once(scene, watch, scene.chunk(robot_hash=bytes(32)), 2)
        return watch.shot("claim refused, chunk G002")


def two_runners(stage: GateStage) -> Shot:
    with stage.ready() as scene:
        watch = Stopwatch()
        watch.timed(
            lambda: refused(lambda: scene.claim("arm", "gripper", source="second"), "runner", "arm")
        )
        assert [claim.source for claim in scene.status().claims] == ["runner"]
        return watch.shot("told that runner holds the arm")


def forged_reset(stage: GateStage) -> Shot:
    with stage.ready() as scene:
        watch = Stopwatch()
        scene.raise_stop(77)
        scene.wait_state(GateState.STOPPED)
        watch.timed(lambda: refused(lambda: scene.reset(76)))  # forged
        watch.timed(lambda: refused(lambda: scene.reset(0)))
        scene.reset(77)
        scene.wait_state(GateState.DISARMED)
        scene.raise_stop(78)
        scene.wait_state(GateState.STOPPED)
        watch.timed(lambda: refused(lambda: scene.reset(77)))  # replayed
        assert scene.status().stop_ids == (78,)
        scene.gate.wait_line("refused a query")
        return watch.shot("forged, zero and replayed refused, each in the gate's log")


def jump_between_chunks(stage: GateStage) -> Shot:
    """The arm of the robot that takes joint targets: 0.5 rad away from where it stands."""
    with stage.ready("panda") as scene:
        watch = Stopwatch()
        refused_at_once(scene, watch, targets(scene, JUMP_RAD), 21)
        good = scene.send(targets(scene, 0.0))
        assert good.outcome == Outcome.RELEASED, good
        scene.acted_on(good, 0)
        refused_at_once(scene, watch, targets(scene, JUMP_RAD), 21)
        return watch.shot("before the first row and after it")


def switch_in_motion(stage: GateStage) -> Shot:
    """Joint targets act; velocities for the same arm do not follow before it stands still."""
    with stage.ready("panda") as scene:
        watch = Stopwatch()
        good = scene.send(targets(scene, 0.0))
        assert good.outcome == Outcome.RELEASED, good
        scene.hal.velocities[0] = SLOW_RAD_S
        scene.acted_on(good, 0)
        joints = tuple(scene.hal.joints.index(name) for name in scene.hal.parts["arm"])
        values = pack_floats(np.zeros((4, len(scene.hal.joints))))
        part = scene.arm_part(
            mode=ControlMode.JOINT_VELOCITY, frame_id="", values=values, active=joints
        )
        refused_at_once(scene, watch, scene.chunk(rows=4, parts=(part,)), 25)
        return watch.shot("joint_position to joint_velocity")


def targets(scene: Scene, shift_rad: float) -> ActionChunk:
    """Joint targets at the measured position, the first joint shifted."""
    joints = tuple(scene.hal.joints.index(name) for name in scene.hal.parts["arm"])
    values = np.zeros((4, len(scene.hal.joints)))
    values[:, joints] = scene.hal.positions[list(joints)]
    values[:, joints[0]] += shift_rad
    part = scene.arm_part(
        mode=ControlMode.JOINT_POSITION, frame_id="", values=pack_floats(values), active=joints
    )
    return scene.chunk(rows=4, parts=(part,))


def of_version_two(message: Message) -> bytes:
    """A frame that differs from today's in its version alone."""
    fields = msgspec.msgpack.decode(encode(message))
    fields[1] = 2
    return msgspec.msgpack.encode(fields)


def other_versions(stage: GateStage) -> Shot:
    with stage.scene() as scene:
        watch = Stopwatch()
        status = scene.bus.publisher(scene.keys.hal_status, HalStatus, Qos.STATUS)
        status.put_bytes(of_version_two(scene.hal.status()))
        scene.gate.wait_line("the newest hal/status is unreadable: another version")
        refused(scene.arm, "hal/status is unreadable: another version")
        scene.meet_hal()
        scene.arm()
        scene.take_claim()
        scene.send_bytes(of_version_two(scene.chunk()))
        verdict = scene.verdicts.wait_for()
        assert verdict.code == 1, verdict
        assert verdict.limit_source.startswith("a chunk, got another version, at byte "), verdict
        return watch.shot("status: named, arming refused; chunk: G001 names it", timed=False)


ANSWER = "answer"
ROWS = (
    Row(
        16, "chunks of an earlier session, claim, epoch", "G002, G004, G003", T_MS, "gate", replay,
        JUDGED,
    ),
    Row(
        17, "seq jumps by 1e9, wraps; obs_tick far in the future",
        "refused and counted; repeated: stop", T_MS, "gate", wild_numbers, JUDGED,
    ),
    Row(
        19, "NaN, inf, 1e308 in a late row; denormals", "refused and stopped; denormals judged",
        1, "gate", no_numbers, JUDGED, 5,
    ),
    Row(21, "wrong robot hash", "claim refused; chunk G002", T_MS, "gate", wrong_robot, ANSWER),
    Row(
        22, "two runners, one claim", "the second is refused, with the holder's name",
        T_MS, "gate", two_runners, ANSWER,
    ),
    Row(
        27, "forged and replayed reset", "refused, in the log; the stop stays",
        T_MS, "gate", forged_reset, ANSWER, 5,
    ),
    Row(
        34, "jump of 0.5 rad between chunks", "G021", T_MS, "gate", jump_between_chunks, JUDGED, 5,
    ),
    Row(
        34, "mode switch in motion", "G025", T_MS, "gate", switch_in_motion, JUDGED, 5,
    ),
    Row(
        38, "messages of another version", "refused by name, at start", None, "gate",
        other_versions,
    ),
)  # fmt: skip
