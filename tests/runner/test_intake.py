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

EYE = {"camera": "front", "width": 2, "height": 3, "rotation_deg": 0}


def seeing(**change: object) -> SkillManifest:
    data = SKILL.model_dump(mode="json") | {"images": {"eye": EYE | change}}
    return SkillManifest.model_validate(data)


def intake(skill: SkillManifest, *, exact: bool) -> ObservationBuffer:
    return ObservationBuffer(skill, "pick", {"front": 4}, exact=exact, has_task=False)


def frame(tick: int, value: int = 0) -> Image:
    pixels = np.full((3, 2, 3), value, dtype=np.uint8)
    pixels[0, 1] = 255  # top right
    return Image(
        session=SESSION, tick=tick, camera="front", width=2, height=3, encoding_name="rgb8",
        data=pixels.tobytes(),
    )  # fmt: skip


def test_lockstep_waits_for_the_frame_that_is_due_at_the_tick() -> None:
    box = intake(seeing(), exact=True)  # frames are due at ticks 1, 5, 9
    box.add_layout(layout(7))
    assert box.missing(7) == "image eye from camera front"
    box.add_image(frame(1))
    assert box.missing(7) == "image eye from camera front", "the frame of tick 5 is due"
    box.add_image(frame(5))
    assert box.missing(7) == ""
    assert box.gather().oldest_tick == 5


def test_realtime_takes_the_newest_frame_up_to_the_skills_age() -> None:
    box = intake(seeing(), exact=False)
    box.add_image(frame(5))
    box.add_layout(layout(15))
    assert box.missing(15) == ""
    assert box.gather().oldest_tick == 5
    box.add_layout(layout(16))
    assert box.missing(16) == "image eye from camera front"


def test_a_frame_of_an_earlier_episode_or_of_the_future_does_not_count() -> None:
    box = intake(seeing(), exact=False)
    box.add_image(frame(5))
    box.add_layout(msgspec.structs.replace(layout(8), episode_tick=6))
    assert box.missing(8) == "image eye from camera front"
    box.add_image(frame(9))
    assert box.missing(8) == "image eye from camera front"


def test_an_older_frame_that_comes_late_does_not_replace_a_newer_one() -> None:
    box = intake(seeing(), exact=False)
    box.add_image(frame(5, value=50))
    box.add_image(frame(4, value=40))
    box.add_layout(layout(6))
    assert box.gather().observation.images["eye"][2, 0, 0] == 50


@pytest.mark.parametrize(
    ("rotation", "shape", "where"),
    [
        (0, (3, 2, 3), (0, 1)),
        (90, (2, 3, 3), (1, 2)),  # clockwise: top right becomes bottom right
        (180, (3, 2, 3), (2, 0)),
        (270, (2, 3, 3), (0, 0)),
    ],
)
def test_pictures_are_turned_clockwise_as_declared(
    rotation: int, shape: tuple[int, ...], where: tuple[int, int]
) -> None:
    box = intake(seeing(rotation_deg=rotation), exact=False)
    box.add_image(frame(5))
    box.add_layout(layout(5))
    image = box.gather().observation.images["eye"]
    assert image.shape == shape
    assert [tuple(i) for i in np.argwhere(image[:, :, 0] == 255)] == [where]


def test_the_layouts_own_oldest_input_counts_too() -> None:
    box = intake(SKILL, exact=False)
    box.add_layout(layout(9, oldest=6))
    assert box.gather().oldest_tick == 6


def test_a_picture_of_another_size_or_encoding_is_a_policy_error() -> None:
    box = intake(seeing(width=4), exact=False)
    box.add_image(msgspec.structs.replace(frame(5), encoding_name="jpeg"))
    box.add_layout(layout(5))
    with pytest.raises(PolicyError) as caught:
        box.gather()
    assert str(caught.value) == "image eye: expected rgb8 of 4 x 3, got jpeg of 2 x 3"


def test_lockstep_waits_for_the_task_state_of_the_tick() -> None:
    box = ObservationBuffer(SKILL, "pick", {}, exact=True, has_task=True)
    box.add_layout(layout(5))
    box.add_task(task(4))
    assert box.missing(5) == "task state"
    box.add_task(task(5))
    assert box.missing(5) == ""
