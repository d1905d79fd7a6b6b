"""Looking transforms up at a tick: what is found, and the full text of what is not."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.assembler.buffer_inputs import buffer_with, error_of


def pose(x: float = 0.0, yaw: float = 0.0) -> pin.SE3:
    return pin.SE3(pin.utils.rotate("z", yaw), np.array([x, 0.0, 0.0]))


def random_pose(rng: np.random.Generator) -> pin.SE3:
    quaternion = rng.normal(size=4)
    rotation = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).toRotationMatrix()
    return pin.SE3(rotation, rng.uniform(-2, 2, 3))


def test_lookup_goes_up_and_down_the_tree_through_a_common_ancestor() -> None:
    rng = np.random.default_rng(0)
    T_odom_base, T_base_hand, T_odom_object = (random_pose(rng) for _ in range(3))
    buffer = buffer_with()
    buffer.add("odom", "base", T_odom_base, 5, is_static=False)
    buffer.add("base", "hand", T_base_hand, 5, is_static=False)
    buffer.add("odom", "object", T_odom_object, 5, is_static=False)
    found, oldest = buffer.lookup("hand", "object", 5)
    wanted = (T_odom_base * T_base_hand).inverse() * T_odom_object
    assert np.allclose(found.homogeneous, wanted.homogeneous, atol=1e-12)
    assert oldest == 5


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), depth=st.integers(1, 6))
def test_lookup_both_ways_round_is_the_inverse(seed: int, depth: int) -> None:
    rng = np.random.default_rng(seed)
    buffer = buffer_with()
    for level in range(depth):
        buffer.add(f"a{level}", f"a{level + 1}", random_pose(rng), 1, is_static=False)
        buffer.add(
            f"b{level}" if level else "a0", f"b{level + 1}", random_pose(rng), 1, is_static=True
        )
    there, _ = buffer.lookup(f"a{depth}", f"b{depth}", 1)
    back, _ = buffer.lookup(f"b{depth}", f"a{depth}", 1)
    assert np.allclose((there * back).homogeneous, np.eye(4), atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), depth=st.integers(1, 6))
def test_a_view_finds_the_bits_that_lookups_of_their_own_find(seed: int, depth: int) -> None:
    rng = np.random.default_rng(seed)
    buffer = buffer_with(**{f"f{number}": 3 for number in range(0, depth, 2)})
    for number in range(depth):
        parent = f"f{rng.integers(number)}" if number else "root"
        tick = 9 if number % 2 else int(rng.integers(6, 10))
        buffer.add(parent, f"f{number}", random_pose(rng), tick, is_static=False)
    view = buffer.at(9)
    pairs = [(f"f{one}", f"f{other}") for one in range(depth) for other in range(depth)]
    for _ in range(2):
        for parent, child in rng.permutation(pairs).tolist():
            found, _ = buffer.lookup(parent, child, 9)
            assert view.pose(parent, child).homogeneous.tobytes() == found.homogeneous.tobytes()
    assert view.oldest_tick == min(buffer.lookup(one, other, 9)[1] for one, other in pairs)


def test_frame_in_itself_is_the_identity_even_if_nothing_is_known() -> None:
    found, oldest = buffer_with().lookup("base", "base", 3)
    assert np.array_equal(found.homogeneous, np.eye(4))
    assert oldest == 3


def test_static_transform_is_valid_at_every_tick_and_does_not_age() -> None:
    buffer = buffer_with()
    buffer.add("map", "odom", pose(1.0), 1, is_static=True)
    found, oldest = buffer.lookup("map", "odom", 10_000)
    assert found.translation[0] == 1.0
    assert oldest == 10_000


def test_newer_static_transform_replaces_the_older_one_in_any_order() -> None:
    buffer = buffer_with()
    buffer.add("map", "odom", pose(2.0), 5, is_static=True)
    buffer.add("map", "odom", pose(1.0), 3, is_static=True)
    assert buffer.lookup("map", "odom", 6)[0].translation[0] == 2.0


def test_missing_tick_between_its_neighbours_is_interpolated() -> None:
    buffer = buffer_with()
    buffer.add("odom", "base", pose(0.0, 0.0), 4, is_static=False)
    buffer.add("odom", "base", pose(1.0, 1.0), 6, is_static=False)
    found, oldest = buffer.lookup("odom", "base", 5)
    assert np.allclose(found.translation, [0.5, 0.0, 0.0])
    assert np.allclose(found.rotation, pin.utils.rotate("z", 0.5))
    assert oldest == 4


@settings(max_examples=50, deadline=None)
@given(
    start=st.floats(-3.0, 3.0),
    turn=st.floats(-3.0, 3.0),
    gap=st.integers(2, 10),
    data=st.data(),
)
def test_interpolation_turns_and_moves_in_proportion(
    start: float, turn: float, gap: int, data: st.DataObject
) -> None:
    at = data.draw(st.integers(1, gap - 1))
    buffer = buffer_with(base=gap)
    buffer.add("odom", "base", pose(start, start), 1, is_static=False)
    buffer.add("odom", "base", pose(start + turn, start + turn), 1 + gap, is_static=False)
    found, oldest = buffer.lookup("odom", "base", 1 + at)
    wanted = pose(start + turn * at / gap, start + turn * at / gap)
    assert np.allclose(found.homogeneous, wanted.homogeneous, atol=1e-9)
    assert oldest == 1


def test_gap_wider_than_the_neighbouring_ticks_is_not_interpolated() -> None:
    buffer = buffer_with()
    buffer.add("odom", "base", pose(), 3, is_static=False)
    buffer.add("odom", "base", pose(), 900, is_static=False)
    error = error_of(buffer, "odom", "base", 5)
    assert (error.kind, error.age_ticks) == ("stale_frame", 2)


def test_transform_of_the_tick_wins_over_interpolation_whatever_the_order_of_arrival() -> None:
    buffer = buffer_with()
    for tick, x in ((6, 6.0), (4, 4.0), (5, 50.0)):
        buffer.add("odom", "base", pose(x), tick, is_static=False)
    assert buffer.lookup("odom", "base", 5)[0].translation[0] == 50.0


def test_late_frame_names_frame_parent_and_age() -> None:
    buffer = buffer_with()
    buffer.add("odom", "base_link", pose(), 17, is_static=False)
    error = error_of(buffer, "odom", "base_link", 20)
    assert str(error) == (
        "transforms: odom -> base_link is stale at tick 20: the newest before it is 3 tick(s) "
        "old, allowed 0"
    )
    assert (error.kind, error.name, error.parent, error.age_ticks) == (
        "stale_frame", "base_link", "odom", 3,
    )  # fmt: skip


@pytest.mark.parametrize(("age", "found"), [(0, True), (9, True), (10, True), (11, False)])
def test_slow_frame_is_used_up_to_its_declared_age(age: int, found: bool) -> None:
    buffer = buffer_with(odom=10)
    buffer.add("map", "odom", pose(1.0), 5, is_static=False)
    if found:
        assert buffer.lookup("map", "odom", 5 + age)[1] == 5
    else:
        assert error_of(buffer, "map", "odom", 5 + age).age_ticks == age


def test_oldest_tick_is_that_of_the_slowest_frame_on_the_way() -> None:
    buffer = buffer_with(odom=10)
    buffer.add("map", "odom", pose(), 5, is_static=False)
    buffer.add("odom", "base", pose(), 9, is_static=False)
    view = buffer.at(9)
    view.pose("odom", "base")
    assert view.oldest_tick == 9
    view.pose("map", "base")
    assert view.oldest_tick == 5


def test_frame_that_is_only_known_later_says_from_when() -> None:
    buffer = buffer_with()
    buffer.add("odom", "object", pose(), 8, is_static=False)
    error = error_of(buffer, "odom", "object", 7)
    assert str(error) == ("transforms: odom -> object is known from tick 8 on, not at tick 7")
    assert (error.kind, error.name, error.parent) == ("missing_tick", "object", "odom")


def test_unknown_frame_is_named_with_the_known_ones() -> None:
    buffer = buffer_with()
    buffer.add("odom", "base", pose(), 1, is_static=False)
    error = error_of(buffer, "base", "goal", 1)
    assert str(error) == ("transforms: no frame 'goal' (looked up from 'base'); known: base, odom")
    assert (error.kind, error.name, error.parent, error.age_ticks) == (
        "missing_frame", "goal", "base", -1,
    )  # fmt: skip
    error = error_of(buffer, "goal", "base", 1)
    assert (error.name, error.parent) == ("goal", "base")


def test_lookup_in_an_empty_buffer_says_that_nothing_is_known() -> None:
    assert str(error_of(buffer_with(), "odom", "base", 1)) == (
        "transforms: no frame 'base' (looked up from 'odom'); known: none"
    )


def test_two_trees_are_named_by_their_roots() -> None:
    buffer = buffer_with()
    buffer.add("odom", "base", pose(), 1, is_static=False)
    buffer.add("camera", "tag", pose(), 1, is_static=False)
    error = error_of(buffer, "base", "tag", 1)
    assert str(error) == (
        "transforms: 'tag' is not connected to 'base': nothing says where its root 'camera' "
        "is in 'odom'"
    )
    assert (error.kind, error.name, error.parent) == ("missing_frame", "camera", "base")


def test_loop_is_shown_instead_of_followed() -> None:
    buffer = buffer_with()
    buffer.add("a", "b", pose(), 1, is_static=False)
    buffer.add("b", "c", pose(), 1, is_static=False)
    buffer.add("c", "a", pose(), 1, is_static=False)
    error = error_of(buffer, "odom", "c", 1)
    assert str(error) == "transforms: frame 'c' hangs in a loop: c -> b -> a -> c"
    assert (error.kind, error.name, error.parent) == ("loop", "c", "odom")


def test_history_is_bounded_and_keeps_the_newest() -> None:
    buffer = buffer_with()
    for tick in range(1, 500):
        buffer.add("odom", "base", pose(float(tick)), tick, is_static=False)
    assert buffer.lookup("odom", "base", 499)[0].translation[0] == 499.0
    assert buffer.lookup("odom", "base", 436)[0].translation[0] == 436.0
    assert error_of(buffer, "odom", "base", 435).kind == "missing_tick"
