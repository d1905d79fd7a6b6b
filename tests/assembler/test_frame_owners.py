"""Each frame has one publisher, one parent and one kind: anything else is a fault, no jump."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from fairlead.errors import LayoutError
from fairlead_state_assembler import TransformBuffer
from fairlead_state_assembler.branches import HISTORY_TICKS
from tests.assembler.buffer_inputs import SESSION, batch

OWNERS = {"odom": "hal", "base": "hal", "hand": "state_assembler"}


def buffer_of(**owners: str) -> TransformBuffer:
    buffer = TransformBuffer({}, OWNERS | owners, "hal")
    assert buffer.enter(SESSION, 1)
    return buffer


def fault(buffer: TransformBuffer, parent: str, child: str, tick: int) -> LayoutError:
    with pytest.raises(LayoutError) as error:
        buffer.lookup(parent, child, tick)
    assert error.value.kind == "contested_frame"
    assert error.value.is_certain
    return error.value


def test_frame_of_the_hal_that_another_sends_too_names_both_and_never_the_others_numbers() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(1, ("map", "odom", 0.0), is_static=True), "hal")
    buffer.add_batch(batch(3, ("odom", "base", 1.0)), "hal")
    buffer.add_batch(batch(3, ("map", "odom", 5.0)), "stray")
    assert str(fault(buffer, "map", "base", 3)) == (
        "transforms: frame 'odom' is contested: hal sends map -> odom (static), stray sends "
        "map -> odom (every tick); only hal may send it"
    )
    assert buffer.lookup("odom", "base", 3)[0].translation[0] == 1.0  # not on this way


def test_the_others_transform_is_no_answer_either_before_the_owner_has_sent_one() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(3, ("odom", "base", 1.0)), "hal")
    buffer.add_batch(batch(3, ("map", "odom", 5.0)), "stray")
    assert str(fault(buffer, "map", "base", 3)) == (
        "transforms: frame 'odom' is contested: hal is to send it, stray sends map -> odom "
        "(every tick); only hal may send it"
    )


def test_link_of_the_robot_that_another_sends_is_contested() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(3, ("hand", "tool", 0.0)), "tracker")
    buffer.add_batch(batch(3, ("map", "hand", 0.0)), "tracker")
    assert "only state_assembler may send it" in str(fault(buffer, "hand", "map", 3))


def test_frame_that_was_looked_up_before_another_sent_it_is_contested_too() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(3, ("map", "odom", 1.0)), "hal")
    assert buffer.lookup("map", "odom", 3)[0].translation[0] == 1.0
    buffer.add_batch(batch(3, ("map", "odom", 5.0)), "stray")
    fault(buffer, "map", "odom", 3)


def test_links_are_known_again_in_a_new_episode() -> None:
    buffer = buffer_of()
    for episode in (1, 5):
        buffer.enter(SESSION, episode)
        for tick in (episode, episode + 1):
            buffer.add_links("base", {"hand": 0}, [pin.SE3.Identity()], tick)
            assert buffer.lookup("base", "hand", tick)[1] == tick


def test_frame_of_nobody_belongs_to_whoever_sends_it_first() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(3, ("odom", "tag", 1.0)), "tracker")
    buffer.add_batch(batch(3, ("odom", "tag", 2.0)), "camera")
    assert str(fault(buffer, "odom", "tag", 3)).endswith(
        "tracker sends odom -> tag (every tick), camera sends odom -> tag (every tick); only one "
        "of them may send it"
    )


@pytest.mark.parametrize(
    ("second", "said"),
    [
        (batch(2, ("hand", "tag", 2.0)), "hal sends hand -> tag (every tick)"),
        (batch(2, ("odom", "tag", 2.0), is_static=True), "hal sends odom -> tag (static)"),
    ],
    ids=["parent", "static"],
)
def test_frame_whose_parent_or_kind_changes_is_contested_by_its_own_publisher(
    second: object, said: str
) -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(1, ("odom", "tag", 1.0)), "hal")
    buffer.add_batch(second, "hal")  # type: ignore[arg-type]
    assert str(fault(buffer, "odom", "tag", 2)).endswith(
        f"hal sends odom -> tag (every tick), {said}; a frame has one parent, and is static or not"
    )


def test_fault_ends_when_the_other_has_been_silent_for_as_long_as_transforms_are_kept() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(1, ("map", "odom", 0.0), is_static=True), "hal")
    buffer.add_batch(batch(9, ("map", "odom", 5.0), is_static=True), "stray")
    fault(buffer, "map", "odom", 9 + HISTORY_TICKS)
    assert buffer.lookup("map", "odom", 10 + HISTORY_TICKS)[0].translation[0] == 0.0


def test_new_episode_may_hang_a_frame_elsewhere() -> None:
    buffer = buffer_of()
    buffer.add_batch(batch(5, ("odom", "tag", 1.0)), "hal")
    buffer.add_batch(batch(8, ("hand", "tag", 2.0)), "hal")  # before the joints that say so
    buffer.enter(SESSION, 8)
    buffer.add_batch(batch(9, ("hand", "tag", 2.0)), "hal")
    assert buffer.lookup("hand", "tag", 9)[0].translation[0] == 2.0


def test_session_is_the_hals_and_a_localiser_of_an_older_one_is_not_followed() -> None:
    buffer = TransformBuffer({"odom": 5}, OWNERS | {"odom": "amcl"}, "hal")  # just restarted
    assert not buffer.add_batch(batch(900, ("map", "odom", 9.0), session=3), "amcl")
    assert buffer.add_batch(batch(4, ("odom", "base", 1.0)), "hal")
    assert not buffer.add_batch(batch(901, ("map", "odom", 9.0), session=3), "amcl")
    assert buffer.add_batch(batch(4, ("map", "odom", 2.0)), "amcl")
    assert buffer.lookup("map", "base", 4)[0].translation[0] == 3.0


def at(x_m: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array([x_m, 0.0, 0.0]))


def test_links_that_somebody_else_sends_stay_contested() -> None:
    """Also when the other is silent for longer than transforms are kept."""
    buffer = TransformBuffer()
    buffer.add("odom", "hand", at(1.0), 1, is_static=False)
    for tick in range(1, 2 * HISTORY_TICKS):
        buffer.add_links("base", {"hand": 0, "arm": 1}, [at(2.0), at(3.0)], tick)
        assert fault(buffer, "odom", "hand", tick).kind == "contested_frame"
        assert buffer.lookup("base", "arm", tick)[0].translation[0] == 3.0
