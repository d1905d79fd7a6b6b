"""Recordings become curves: what was proposed, released and measured, tick by tick."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    ActionPart,
    Hold,
    Image,
    JointState,
    Outcome,
    encode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.wire.bus import Qos
from fairlead.wire.memory_bus import MemoryBus
from fairlead_tools.record.caption import HEIGHT_PX, captions, refusal
from fairlead_tools.record.part_series import Panel, held_ticks, panels
from fairlead_tools.record.recorder import Recorder
from fairlead_tools.record.run_log import Header, Run
from fairlead_tools.record.timeline import draw_timeline, hold_names, verdict_counts
from fairlead_tools.record.video import STILL_S, captioned, write_video
from tests.record.runs import (
    ARM,
    BASE,
    NO_ROW,
    ROBOT,
    ROW,
    candidate,
    joints,
    replace_parts,
    verdict,
)


@pytest.fixture
def run() -> Run:
    return Run(
        Header("panda_mobile", "sim", ""),
        joints=[joints(10, (NO_ROW,) * 4), joints(11, (NO_ROW,) * 4), joints(12, (ROW,) * 4)],
        chunks=[candidate()],
        verdicts=[(10, verdict(1, Outcome.RELEASED, released=11)),
                  (12, verdict(2, Outcome.REFUSED, 20))],
    )  # fmt: skip


def by_name(run: Run) -> dict[str, Panel]:
    return {panel.name: panel for panel in panels(run, ROBOT)}


def test_each_quantity_has_its_curves_in_readable_units_and_one_frame(run: Run) -> None:
    found = by_name(run)
    assert [(p.name, p.unit, p.frame) for p in found.values()] == [
        ("arm x", "mm per tick", "base_link"),
        ("arm y", "mm per tick", "base_link"),
        ("arm turn z", "mrad per tick", "base_link"),
        ("gripper opening", "mm", ""),
        ("base base_x", "m/s", "odom"),
    ]
    assert found["arm x"].asked == pytest.approx({10: 30.0, 11: 0.0})
    assert found["arm y"].asked == pytest.approx({10: 40.0, 11: 0.0})
    assert found["arm turn z"].asked == pytest.approx({10: 100.0, 11: 0.0})
    assert found["gripper opening"].asked == {10: 80.0, 11: 0.0}
    assert found["base base_x"].asked == {10: 0.5, 11: 0.25}


def test_released_is_what_the_chunks_first_verdict_names(run: Run) -> None:
    run.verdicts.append((12, verdict(1, Outcome.REFUSED, 4)))  # a copy, answered again
    assert by_name(run)["base base_x"].released == {11: 0.25}


def test_what_takes_the_number_of_a_released_chunk_was_not_released(run: Run) -> None:
    forged = [
        msgspec.structs.replace(part, values=pack_floats([7.0] * (len(part.values) // 8)))
        for part in candidate().parts
    ]
    run.chunks.append(candidate())  # a copy, sent again
    run.chunks.append(replace_parts(forged))
    assert by_name(run)["base base_x"].released == {11: 0.25}


def test_a_chunk_that_is_made_for_another_robot_has_no_curves(run: Run) -> None:
    wrong = [
        ActionPart(part=9, mode=1, frame_id="", values=b"12345678", active=()),
        ActionPart(part=ARM, mode=77, frame_id="", values=b"", active=()),
        ActionPart(
            part=ARM, mode=ControlMode.CARTESIAN_DELTA, frame_id="moon", active=(),
            values=pack_floats([0.1] * 6),
        ),
        ActionPart(part=BASE, mode=ControlMode.JOINT_VELOCITY, frame_id="", values=b"1", active=()),
    ]  # fmt: skip
    assert panels(replace(run, chunks=[replace_parts(wrong)]), ROBOT) == []


def test_what_was_asked_of_nothing_that_moves_has_no_panel(run: Run) -> None:
    assert not {"arm z", "arm turn x", "composite composite_mode"} & set(by_name(run))


def test_the_gain_is_the_declared_one_and_the_share_the_measured_one(run: Run) -> None:
    base = by_name(run)["base base_x"]
    assert base.gain == (0.0, 1.0)
    assert base.share == pytest.approx(0.12 / 0.25)
    assert by_name(run)["gripper opening"].gain is None


def test_what_a_tool_makes_of_a_motion_is_told_of_ticks_in_which_its_base_stands(run: Run) -> None:
    def arm(speed: float) -> Panel:
        states = [joints(tick, (ROW,) * 4, base_x=speed) for tick in (10, 11, 12)]
        states = [
            msgspec.structs.replace(state, positions=one.positions)
            for state, one in zip(states, _turning(), strict=True)
        ]
        released = [(10, verdict(1, Outcome.RELEASED, released=10))]
        return by_name(replace(run, joints=states, verdicts=released))["arm turn z"]

    assert arm(0.0).share == pytest.approx(1.0)
    assert arm(0.0).carried == frozenset()
    assert arm(0.1).share is None
    assert arm(0.1).carried == {9, 10, 11, 12}


def _turning() -> list[JointState]:
    return [joints(tick, (ROW,) * 4, first_joint=0.1 * tick) for tick in (10, 11, 12)]


def test_measured_velocity_of_a_tick_is_that_of_the_state_after_it(run: Run) -> None:
    assert by_name(run)["base base_x"].measured == pytest.approx({9: 0.10, 10: 0.11, 11: 0.12})


def test_a_slide_that_is_told_against_the_yaw_is_drawn_along_its_own_axis(run: Run) -> None:
    turned = [joints(tick, (ROW,) * 4, yaw=math.pi / 2) for tick in (10, 11, 12)]
    found = by_name(replace(run, joints=turned))
    assert found["base base_y"].asked == pytest.approx({10: -0.5, 11: -0.25})


def test_measured_opening_and_tool_motion_come_from_the_joints(run: Run) -> None:
    found = by_name(run)
    assert found["gripper opening"].measured == pytest.approx({9: 10.0, 10: 11.0, 11: 12.0})
    turn = by_name(replace(run, joints=_turning()))["arm turn z"]
    assert turn.measured == pytest.approx({10: 100.0, 11: 100.0})


def test_a_tick_in_which_every_part_held_is_marked_with_its_reason(run: Run) -> None:
    assert held_ticks(run) == {9: Hold.NO_ROW, 10: Hold.NO_ROW}
    assert hold_names(run) == {"no_row": 2}
    run.joints.append(joints(13, (NO_ROW, ROW, ROW, ROW)))
    assert 12 in held_ticks(run, ARM) and 12 not in held_ticks(run, BASE)


def test_a_cut_keeps_the_verdicts_of_the_chunks_that_reach_into_it(run: Run) -> None:
    cut = run.between(11, 12, session=1)
    assert [state.tick for state in cut.joints] == [11, 12]
    assert by_name(cut)["base base_x"].released == {11: 0.25}
    assert run.between(12, 20, session=1).chunks == run.between(1, 20, session=2).chunks == []


def test_only_the_first_verdict_of_a_chunk_counts(run: Run) -> None:
    run.verdicts.append((10, verdict(1, Outcome.REFUSED, 4)))
    run.verdicts.append((10, verdict(1, Outcome.REFUSED, 20, "demo")))
    assert run.outcomes("runner") == {(1, 1): "released", (1, 2): "refused"}
    assert verdict_counts(run) == {"released": 1, "refused": 2}


def test_the_recorder_keeps_chunks_as_sent_and_pictures() -> None:
    bus, keys = MemoryBus(), Keys("r")
    recorder = Recorder(bus, keys, ["front"])
    image = Image(
        session=1, tick=1, camera="front", width=1, height=1, encoding_name="rgb8", data=b"abc"
    )
    bus.publisher(keys.candidate("runner"), ActionChunk, Qos.HOT).put(candidate())
    bus.publisher(keys.camera("front"), Image, Qos.CAMERA).put(image)
    heard = recorder.close()
    bus.publisher(keys.camera("front"), Image, Qos.CAMERA).put(image)
    assert (heard.candidate_bytes, heard.images) == ([encode(candidate())], [image])


def test_the_timeline_is_a_picture(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "timeline.png"
    draw_timeline(run, ROBOT, "a title", path)
    assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000


def test_a_picture_of_another_format_is_refused_before_it_is_drawn(
    run: Run, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=r"a file of a picture, got '.*\.foo' \(valid: \.png"):
        draw_timeline(run, ROBOT, "a title", tmp_path / "timeline.foo")


def test_the_caption_of_a_tick_is_the_newest_verdict_then_or_that_the_robot_holds(
    run: Run,
) -> None:
    def shown(tick: int) -> tuple[str, str, str]:
        caption = captions(run, "wave")(tick)
        return caption.word, caption.said, caption.counts

    assert shown(9) == (
        "HOLDS", "no chunk yet: every part of the robot holds",
        "tick 9   chunks: 0 released, 0 truncated, 0 refused",
    )  # fmt: skip
    assert shown(10)[:2] == ("HOLDS", "no released row for this tick")
    assert shown(11) == (
        "RELEASED", "chunk 1: rows for ticks 11 to 11",
        "tick 11   chunks: 1 released, 0 truncated, 0 refused",
    )  # fmt: skip
    assert shown(12) == (
        "REFUSED", "G020 limit: chunk 2 refused",
        "tick 12   chunks: 1 released, 0 truncated, 1 refused",
    )  # fmt: skip


def test_the_caption_of_a_refusal_says_without_its_limits_source_whether_the_robot_holds(
    run: Run,
) -> None:
    beyond = msgspec.structs.replace(
        verdict(2, Outcome.REFUSED, 20),
        value=5.0,
        limit=0.1,
        margin=-4.9,
        limit_source="a data sheet",
    )
    moving = refusal(run, "5 m", beyond)
    assert moving.said == "G020 limit: chunk 2 refused: 5, limit 0.1"
    assert moving.counts == "tick 12"
    run.joints.append(joints(13, (NO_ROW,) * 4))
    assert refusal(run, "5 m", beyond).counts == "tick 13   every part holds"


@pytest.mark.processes
@pytest.mark.parametrize("name", ["video.mp4", "video.gif"])
def test_a_video_has_a_frame_for_each_tick_and_a_still_for_each_end(
    run: Run, tmp_path: Path, name: str
) -> None:
    import imageio_ffmpeg

    images = [
        Image(
            session=1, tick=tick, camera="front", width=320, height=16, encoding_name="rgb8",
            data=bytes([8 * tick]) * (320 * 16 * 3),
        )
        for tick in (13, 11, 12, 12)
    ]  # fmt: skip
    ends = [refusal(run, "sent: too much", verdict(2, Outcome.REFUSED, 20))]
    frames = list(captioned(images, captions(run, "wave"), ends, 10.0))
    assert {frame.shape for frame in frames} == {(16 + HEIGHT_PX, 320, 3)}
    assert (frames[0][:16] == 8 * 11).all() and (frames[-1][:16] == 8 * 13).all()
    bars = [frame[16:].tobytes() for frame in frames]
    assert len(bars) == 3 + 10 * STILL_S and len(set(bars)) == 4
    write_video(frames, 10.0, tmp_path / name)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / name))
    assert (count, seconds) == (len(frames), pytest.approx(len(frames) / 10, abs=0.01))
