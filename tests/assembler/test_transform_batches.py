"""What a message of transforms may do to the buffer: episodes, sessions, refused numbers."""

from __future__ import annotations

import pytest

from fairlead.errors import MessageError
from fairlead.messages import Transform, pack_floats
from fairlead_state_assembler import TransformBuffer
from tests.assembler.buffer_inputs import SESSION, batch, buffer_with, error_of


def test_new_episode_discards_what_was_measured_before_it() -> None:
    buffer = buffer_with()
    buffer.add_batch(batch(5, ("odom", "base", 5.0)))
    buffer.add_batch(batch(9, ("odom", "base", 9.0)))
    buffer.add_batch(batch(3, ("map", "odom", 3.0), is_static=True))
    assert buffer.enter(SESSION, 8)
    assert error_of(buffer, "odom", "base", 5).kind == "missing_tick"
    assert error_of(buffer, "map", "base", 9).kind == "missing_frame"
    assert buffer.lookup("odom", "base", 9)[0].translation[0] == 9.0
    assert not buffer.add_batch(batch(7, ("odom", "base", 7.0)))
    assert error_of(buffer, "odom", "base", 7).kind == "missing_tick"


def test_new_session_starts_empty_and_a_left_session_is_ignored() -> None:
    buffer = buffer_with()
    buffer.add_batch(batch(500, ("odom", "base", 1.0)))
    assert buffer.add_batch(batch(1, ("odom", "base", 2.0), session=8))
    assert buffer.lookup("odom", "base", 1)[0].translation[0] == 2.0
    assert not buffer.add_batch(batch(501, ("odom", "base", 3.0)))
    assert not buffer.enter(SESSION, 1)
    assert error_of(buffer, "odom", "base", 501).kind == "stale_frame"


def test_static_frames_sent_before_the_gate_follows_their_session_are_known_once_it_does() -> None:
    buffer = TransformBuffer(owners={"base": "hal", "odom": "localiser"}, hal="hal")
    buffer.follow(SESSION)
    buffer.add_batch(batch(9, ("odom", "base", 9.0)), "hal")
    for session, x in ((8, 1.0), (8, 2.0), (SESSION, 3.0)):
        static = batch(1, ("map", "odom", x), session=session, is_static=True)
        buffer.add_batch(static, "localiser")
    assert not buffer.add_batch(batch(1, ("base", "cup", 5.0), session=8, is_static=True), "hal")
    assert error_of(buffer, "base", "cup", 9).kind == "missing_frame"
    assert buffer.lookup("map", "odom", 9)[0].translation[0] == 3.0
    buffer.follow(8)
    buffer.add_batch(batch(2, ("odom", "base", 4.0), session=8), "hal")
    assert buffer.lookup("map", "cup", 2)[0].translation[0] == 11.0


def test_static_frames_of_a_hal_that_the_gate_never_follows_are_never_known() -> None:
    buffer = TransformBuffer(owners={"base": "hal"}, hal="hal")
    buffer.follow(SESSION)
    for publisher in ("hal", "somebody"):
        static = batch(1, ("map", "odom", 1.0), session=8, is_static=True)
        assert not buffer.add_batch(static, publisher)
    buffer.follow(9)
    assert buffer.add_batch(batch(2, ("odom", "base", 1.0), session=9), "hal")
    assert error_of(buffer, "map", "odom", 2).kind == "missing_frame"


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_transform_that_is_not_finite_is_refused_with_its_batch(value: float) -> None:
    buffer = buffer_with()
    with pytest.raises(MessageError) as error:
        buffer.add_batch(batch(1, ("odom", "base", 1.0), ("odom", "object", value)))
    assert str(error.value) == (
        "transform of 'object': expected finite numbers and a unit quaternion, got "
        f"[{value}, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]"
    )
    assert buffer.frames == frozenset()


@pytest.mark.parametrize(
    ("translation", "rotation", "got"),
    [([0.0, 0.0], [0.0, 0.0, 0.0, 1.0], "2 + 4"), ([0.0] * 3, [0.0, 0.0, 1.0], "3 + 3")],
)
def test_transform_of_the_wrong_size_is_refused(
    translation: list[float], rotation: list[float], got: str
) -> None:
    item = Transform(
        parent="odom",
        child="base",
        translation=pack_floats(translation),
        rotation_xyzw=pack_floats(rotation),
    )
    with pytest.raises(MessageError) as error:
        buffer_with().add_batch(batch(1, transforms=(item,)))
    assert str(error.value) == f"transform of 'base': expected 3 + 4 numbers, got {got}"


def test_quaternion_that_is_no_rotation_is_refused() -> None:
    item = Transform(
        parent="odom",
        child="base",
        translation=pack_floats([0.0] * 3),
        rotation_xyzw=pack_floats([0.0] * 4),
    )
    with pytest.raises(MessageError, match="expected finite numbers and a unit quaternion"):
        buffer_with().add_batch(batch(1, transforms=(item,)))
