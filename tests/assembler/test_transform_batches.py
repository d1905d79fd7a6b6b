"""What a message of transforms may do to the buffer: episodes, sessions, refused numbers."""

from __future__ import annotations

import pytest

from fairlead.errors import MessageError
from fairlead.messages import Transform, pack_floats
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
