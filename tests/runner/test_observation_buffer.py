"""Gathering an observation: which frames count, how old the oldest input is."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from fairlead.errors import PolicyError
from fairlead.messages import Image
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.observation_buffer import ObservationBuffer
from tests.runner.scripted_robot import SESSION, SKILL, layout, task

EYE = {"camera": "front", "width": 2, "height": 3}


def seeing(**change: object) -> SkillManifest:
    data = SKILL.model_dump(mode="json") | {"images": {"eye": EYE | change}}
    return SkillManifest.model_validate(data)


def gathering(skill: SkillManifest, *, exact: bool) -> ObservationBuffer:
    return ObservationBuffer(skill, "pick", {"front": 4}, exact=exact, has_task=False)


def frame(tick: int, value: int = 0) -> Image:
    pixels = np.full((3, 2, 3), value, dtype=np.uint8)
    pixels[0, 1] = 255  # top right
    return Image(
        session=SESSION, tick=tick, camera="front", width=2, height=3, encoding_name="rgb8",
        data=pixels.tobytes(),
    )  # fmt: skip


def test_lockstep_waits_for_the_frame_that_is_due_at_the_tick() -> None:
    box = gathering(seeing(), exact=True)  # frames are due at ticks 1, 5, 9
    box.add_layout(layout(7))
    assert box.missing(7) == "image eye from camera front"
    box.add_image(frame(1))
    assert box.missing(7) == "image eye from camera front", "the frame of tick 5 is due"
    box.add_image(frame(5))
    assert box.missing(7) == ""
    assert box.gather().oldest_tick == 5


def test_realtime_takes_the_newest_frame_up_to_the_skills_age() -> None:
    box = gathering(seeing(), exact=False)
    box.add_image(frame(5))
    box.add_layout(layout(15))
    assert box.missing(15) == ""
    assert box.gather().oldest_tick == 5
    box.add_layout(layout(16))
    assert box.missing(16) == "image eye from camera front"


def test_a_frame_of_an_earlier_episode_or_of_the_future_does_not_count() -> None:
    box = gathering(seeing(), exact=False)
    box.add_image(frame(5))
    box.add_layout(msgspec.structs.replace(layout(8), episode_tick=6))
    assert box.missing(8) == "image eye from camera front"
    box.add_image(frame(9))
    assert box.missing(8) == "image eye from camera front"


def test_an_older_frame_that_comes_late_does_not_replace_a_newer_one() -> None:
    box = gathering(seeing(), exact=False)
    box.add_image(frame(5, value=50))
    box.add_image(frame(4, value=40))
    box.add_layout(layout(6))
    assert box.gather().observation.images["eye"][2, 0, 0] == 50


def test_the_layouts_own_oldest_input_counts_too() -> None:
    box = gathering(SKILL, exact=False)
    box.add_layout(layout(9, oldest=6))
    assert box.gather().oldest_tick == 6


def test_a_picture_of_another_size_or_encoding_is_a_policy_error() -> None:
    box = gathering(seeing(width=4), exact=False)
    box.add_image(msgspec.structs.replace(frame(5), encoding_name="depth32f"))
    box.add_layout(layout(5))
    with pytest.raises(PolicyError) as caught:
        box.gather()
    assert str(caught.value) == "image eye: expected rgb8 of 4 x 3, got depth32f of 2 x 3"


def test_lockstep_waits_for_the_task_state_of_the_tick() -> None:
    box = ObservationBuffer(SKILL, "pick", {}, exact=True, has_task=True)
    box.add_layout(layout(5))
    box.add_task(task(4))
    assert box.missing(5) == "task state"
    box.add_task(task(5))
    assert box.missing(5) == ""


def test_a_picture_with_deltas_comes_with_frames_at_those_before_the_newest() -> None:
    box = gathering(seeing(deltas=[-2, -1, 0]), exact=False)
    for tick in (5, 6, 7, 8):
        box.add_image(frame(tick, value=tick))
    box.add_layout(layout(9))
    observation = box.gather().observation
    frames = observation.frames_of("eye")
    assert frames.shape == (3, 3, 2, 3)
    assert frames[:, 2, 0, 0].tolist() == [6, 7, 8]
    np.testing.assert_array_equal(frames[-1], observation.images["eye"])
    assert box.gather().oldest_tick == 8, "earlier frames are as old as they are meant to be"


def test_a_picture_without_deltas_has_one_frame() -> None:
    box = gathering(seeing(), exact=False)
    box.add_image(frame(5))
    box.add_layout(layout(5))
    observation = box.gather().observation
    assert observation.frames == {}
    assert observation.frames_of("eye").shape == (1, 3, 2, 3)


def test_before_the_first_frame_of_a_goal_or_an_episode_there_is_that_one_again() -> None:
    box = gathering(seeing(deltas=[-4, -2, 0]), exact=False)
    for tick in (5, 6, 7):
        box.add_image(frame(tick, value=tick))
    box.add_layout(layout(7))
    assert box.missing(7) == ""
    assert box.gather().observation.frames["eye"][:, 2, 0, 0].tolist() == [5, 5, 7]
    box.add_layout(msgspec.structs.replace(layout(8), episode_tick=7))
    assert box.gather().observation.frames["eye"][:, 2, 0, 0].tolist() == [7, 7, 7]


def test_a_frame_that_was_lost_is_waited_for_and_said_and_never_made_up() -> None:
    box = gathering(seeing(deltas=[-2, 0]), exact=False)
    for tick in (5, 6, 8):
        box.add_image(frame(tick, value=tick))
    box.add_layout(layout(8))
    assert box.missing(8) == ""
    box.add_image(frame(9))
    box.add_layout(layout(9))
    assert box.missing(9) == (
        "image eye of tick 7 from camera front (its deltas want one every 2 ticks, the last came "
        "1 to 2 ticks apart)"
    )
    box.add_image(frame(7, value=7))
    assert box.missing(9) == "", "it came late"


def test_deltas_of_a_slower_policy_are_its_rows_and_no_control_periods() -> None:
    skill = seeing(deltas=[-1, 0])
    box = ObservationBuffer(skill, "pick", {"front": 1}, exact=False, has_task=False, periods=3)
    for tick in range(5, 10):
        box.add_image(frame(tick, value=tick))
    box.add_layout(layout(9))
    assert box.gather().observation.frames["eye"][:, 2, 0, 0].tolist() == [6, 9]


@pytest.mark.parametrize("deltas", [[], [0, 0], [-1], [-1, -2, 0], [1, 0], [-65, 0]])
def test_deltas_ascend_and_end_now(deltas: list[int]) -> None:
    with pytest.raises(ValueError, match="expected ascending whole numbers from -64 that end"):
        seeing(deltas=deltas)


def test_a_camera_that_stalls_repeats_or_goes_black_is_told_by_its_newest_new_exposure() -> None:
    box = gathering(seeing(), exact=False)
    assert box.blind(90) == "", "it has not seen anything yet: the goal waits"
    box.add_image(frame(5))
    box.add_image(frame(9))  # a still scene: the same pixels, another exposure
    assert box.blind(19) == ""
    late = "camera front: newest picture of tick 9, 11 ticks ago (age_max_ticks 10); "
    assert box.blind(20) == late + "nothing has come since"
    box.add_image(frame(9))
    box.add_image(frame(9, value=7))
    assert box.blind(20) == late + "its last exposure came 2 times more"
    for tick in (13, 17):
        box.add_image(black(tick))
    assert box.blind(20) == late + "2 pictures of one colour came since (contrast_min)"
    box.add_layout(layout(20))
    assert box.missing(20) == (
        "image eye from camera front: 2 pictures of one colour came since (contrast_min)"
    )
    box.add_image(frame(17))
    assert box.blind(20) == box.missing(20) == ""


def test_a_skill_may_declare_that_a_dark_picture_is_one() -> None:
    box = gathering(seeing(contrast_min=0), exact=False)
    box.add_image(black(5))
    box.add_layout(layout(5))
    assert box.missing(5) == ""


def black(tick: int) -> Image:
    return msgspec.structs.replace(frame(tick), data=bytes(18))
