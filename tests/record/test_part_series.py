"""Recordings become curves: what was proposed, released and measured, tick by tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from fairlead.keys import Keys
from fairlead.messages import (
    NO_HASH,
    NO_TRACE,
    Acted,
    ActionChunk,
    ActionPart,
    Hold,
    Image,
    JointState,
    Outcome,
    SafeChunk,
    Transform,
    TransformBatch,
    Verdict,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.record.film import pixels, write_film
from fairlead.record.part_series import Panel, held_ticks, panels
from fairlead.record.recorder import Recorder, Recording, first_outcomes
from fairlead.record.timeline import draw_timeline, hold_names, verdict_counts
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Qos
from fairlead.wire.memory_bus import MemoryBus

ROBOT = load_robot("panda_mobile")
ROW = Acted(hold=Hold.NONE, verdict_id=9, row=0)
NO_ROW = Acted(hold=Hold.NO_ROW, verdict_id=0, row=0)
ARM, GRIPPER, BASE = (ROBOT.part_names.index(name) for name in ("arm", "gripper", "base"))


def part(index: int, mode: ControlMode, rows: npt.ArrayLike, active: tuple[int, ...]) -> ActionPart:
    return ActionPart(part=index, mode=mode, frame_id="", values=pack_floats(rows), active=active)


def some_parts() -> tuple[ActionPart, ...]:
    arm = [[0.03, 0.04, 0.0, 0.0, 0.0, 0.1], [0.0] * 6]
    base = np.zeros((2, ROBOT.n_dof))
    base[:, 0] = [0.5, 0.25]
    return (
        part(ARM, ControlMode.CARTESIAN_DELTA, arm, ()),
        part(GRIPPER, ControlMode.GRIPPER_POSITION, [[0.08], [0.0]], ()),
        part(BASE, ControlMode.JOINT_VELOCITY, base, (0,)),
    )


def candidate(source: str = "runner", start_tick: int = 10) -> ActionChunk:
    return ActionChunk(
        robot_hash=NO_HASH, session=1, epoch=1, claim_id=1, source=source, seq=1, goal_id=1,
        obs_tick=start_tick, oldest_tick=start_tick, start_tick=start_tick, horizon=2,
        parts=some_parts(), trace=NO_TRACE,
    )  # fmt: skip


def safe(first_tick: int = 11) -> SafeChunk:
    first = tuple(
        part(p.part, ControlMode(p.mode), np.frombuffer(p.values)[len(p.values) // 16 :], p.active)
        for p in some_parts()
    )
    return SafeChunk(
        session=1, epoch=1, claim_id=1, source="runner", verdict_id=9, judged_tick=10,
        first_tick=first_tick, horizon=1, after=NO_ROW, parts=first,
    )  # fmt: skip


def joints(tick: int, acted: tuple[Acted, ...]) -> JointState:
    n = len(ROBOT.measured_joint_names)
    positions, velocities = np.zeros(n), np.zeros(n)
    positions[ROBOT.joint_names.index("panda_gripper")] = 0.001 * tick
    velocities[0] = 0.01 * tick
    return JointState(
        session=1, tick=tick, episode_tick=1, stamp_ns=0, positions=pack_floats(positions),
        velocities=pack_floats(velocities), efforts=pack_floats(np.zeros(n)), acted=acted,
        robot_hash=NO_HASH,
    )  # fmt: skip


def hand_at(tick: int, x: float) -> TransformBatch:
    tool = ROBOT.end_effector("gripper").tool_frame
    pose = Transform(
        parent=ROBOT.base_frame, child=tool, translation=pack_floats([x, 0.0, 0.0]),
        rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
    )  # fmt: skip
    return TransformBatch(session=1, tick=tick, is_static=False, transforms=(pose,))


def verdict(seq: int, outcome: Outcome, code: int = 0, source: str = "runner") -> Verdict:
    return Verdict(
        verdict_id=seq, session=1, epoch=1, claim_id=1, source=source, seq=seq, outcome=outcome,
        code=code, row=-1, part="", axis="", value=0.0, limit=0.0, margin=0.0, limit_source="",
        released_first=0, released_last=0, config_hash=NO_HASH, latency_ns=0,
    )  # fmt: skip


@pytest.fixture
def recording() -> Recording:
    return Recording(
        joints=[joints(10, (NO_ROW,) * 4), joints(11, (NO_ROW,) * 4), joints(12, (ROW,) * 4)],
        candidates=[candidate(), candidate(source="other", start_tick=50)],
        safes=[safe()],
        verdicts=[verdict(1, Outcome.RELEASED), verdict(2, Outcome.REFUSED, 20)],
        verdict_ticks=[10, 12],
        transforms=[hand_at(10, 0.0), hand_at(11, 0.004)],
    )


def by_name(recording: Recording) -> dict[tuple[str, str], Panel]:
    return {(p.part, p.quantity): p for p in panels(recording, ROBOT, "runner")}


def test_each_quantity_has_its_curves_in_readable_units(recording: Recording) -> None:
    found = by_name(recording)
    assert list(found) == [
        ("arm", "step"), ("arm", "turn"), ("gripper", "opening"), ("base", "base_x"),
    ]  # fmt: skip
    assert found["arm", "step"].proposed == pytest.approx({10: 50.0, 11: 0.0})
    assert found["arm", "turn"].proposed == pytest.approx({10: 100.0, 11: 0.0})
    assert found["gripper", "opening"].proposed == {10: 80.0, 11: 0.0}
    assert found["base", "base_x"].proposed == {10: 0.5, 11: 0.25}
    assert found["base", "base_x"].released == {11: 0.25}


def test_measured_velocity_of_a_tick_is_that_of_the_state_after_it(recording: Recording) -> None:
    assert by_name(recording)["base", "base_x"].measured == pytest.approx(
        {9: 0.10, 10: 0.11, 11: 0.12}
    )


def test_measured_opening_and_hand_motion_come_from_states_and_transforms(
    recording: Recording,
) -> None:
    found = by_name(recording)
    assert found["gripper", "opening"].measured == pytest.approx({9: 10.0, 10: 11.0, 11: 12.0})
    assert found["arm", "step"].measured == pytest.approx({10: 4.0})


def test_another_source_is_left_out(recording: Recording) -> None:
    assert all(50 not in panel.proposed for panel in by_name(recording).values())


def test_a_tick_in_which_every_part_held_is_marked_with_its_reason(recording: Recording) -> None:
    assert held_ticks(recording) == {9: Hold.NO_ROW, 10: Hold.NO_ROW}
    assert hold_names(recording) == {"no_row": 2}


def test_only_the_first_verdict_of_a_chunk_counts(recording: Recording) -> None:
    recording.verdicts += [verdict(1, Outcome.REFUSED, 4), verdict(1, Outcome.REFUSED, 20, "demo")]
    recording.verdict_ticks += [10, 10]
    assert first_outcomes(recording, "runner") == {(1, 1): "released", (1, 2): "refused"}


def test_the_timeline_counts_a_chunk_once_however_often_it_was_answered(
    recording: Recording,
) -> None:
    once = verdict_counts(recording)
    recording.verdicts += [verdict(1, Outcome.RELEASED), verdict(1, Outcome.REFUSED, 20, "demo")]
    recording.verdict_ticks += [10, 10]
    assert verdict_counts(recording) == {**once, "refused": once["refused"] + 1}


def test_the_recorder_keeps_what_it_hears_and_drops_repeats_of_a_tick() -> None:
    bus, keys = MemoryBus(), Keys("r")
    recorder = Recorder(bus, keys, ["front"])
    image = Image(
        session=1, tick=1, camera="front", width=1, height=1, encoding_name="rgb8", data=b"abc"
    )
    for tick in (1, 1, 2):
        bus.publisher(keys.joints, JointState, Qos.HOT).put(joints(tick, ()))
    bus.publisher(keys.candidate("runner"), ActionChunk, Qos.HOT).put(candidate())
    bus.publisher(keys.safe("runner"), SafeChunk, Qos.HOT).put(safe())
    bus.publisher(keys.verdict("runner"), Verdict, Qos.HOT).put(verdict(1, Outcome.RELEASED))
    bus.publisher(keys.camera("front"), Image, Qos.CAMERA).put(image)
    heard = recorder.close()
    bus.publisher(keys.joints, JointState, Qos.HOT).put(joints(3, ()))
    assert [state.tick for state in heard.joints] == [1, 2]
    assert heard.candidates == [candidate()] and heard.safes == [safe()]
    assert (heard.verdict_ticks, heard.images) == ([2], [image])


def test_the_timeline_is_a_picture(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "timeline.png"
    draw_timeline(recording, ROBOT, "runner", "a title", path)
    assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000


@pytest.mark.processes
def test_a_film_has_one_frame_for_each_tick(tmp_path: Path) -> None:
    import imageio_ffmpeg

    frames = [
        Image(
            session=1, tick=tick, camera="front", width=32, height=16, encoding_name="rgb8",
            data=bytes([8 * tick]) * (32 * 16 * 3),
        )
        for tick in (3, 1, 2, 2)
    ]  # fmt: skip
    path = tmp_path / "film.mp4"
    write_film(frames, 10.0, path)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert (count, seconds) == (3, pytest.approx(0.3, abs=0.01))
    assert pixels(frames[0]).shape == (16, 32, 3)
