"""Part commands become the simulator's vector: right place, right bits, or a refusal."""

from __future__ import annotations

import re

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_hal_sim.packing import ActionMap, ActionVector, pack
from fairlead_skill_runner.candidate import dispatch
from tests.packing.vectors import (
    ARM_SCALE,
    BASE_SCALE,
    ORDERS,
    action_map,
    base_velocity,
    delta,
    mode,
    opening,
)

ZEROS = np.zeros(12, dtype=np.float32)


@pytest.fixture(params=sorted(ORDERS))
def order(request: pytest.FixtureRequest) -> dict[str, tuple[int, int]]:
    return ORDERS[request.param]


@pytest.fixture
def slots(order: dict[str, tuple[int, int]]) -> ActionMap:
    return action_map(order)


def part(vector: ActionVector, order: dict[str, tuple[int, int]], name: str) -> list[float]:
    first, stop = order[name]
    return [float(value) for value in vector[first:stop]]


def test_every_part_lands_in_its_own_slot(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    vector = pack(
        {
            "arm": delta([0.05, -0.05, 0.025, 0.5, -0.5, 0.25]),
            "gripper": opening(0.0),
            "base": base_velocity(base_x=1.0, base_y=-0.5, base_yaw=0.75),
            "composite": mode(1.0),
        },
        slots,
        ZEROS,
    )
    assert vector.dtype == np.float32
    assert part(vector, order, "right") == [1.0, -1.0, 0.5, 1.0, -1.0, 0.5]
    assert part(vector, order, "right_gripper") == [1.0]
    assert part(vector, order, "base") == [1.0, -0.5, 0.5]
    assert part(vector, order, "torso") == [0.0]
    assert vector[-1] == 1.0


def test_si_values_give_back_the_policys_float32_bits(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    rng = np.random.default_rng(5)
    for _ in range(2000):
        raw = rng.uniform(-1, 1, 9).astype(np.float32) * np.float32(10.0 ** rng.integers(-6, 1))
        si = raw.astype(np.float64)
        base = dict(zip(("base_x", "base_y", "base_yaw"), si[6:] * BASE_SCALE, strict=True))
        vector = pack(
            {"arm": delta(si[:6] * ARM_SCALE), "base": base_velocity(**base)}, slots, ZEROS
        )
        first, stop = order["right"]
        assert vector[first:stop].tobytes() == raw[:6].tobytes()
        first, stop = order["base"]
        assert vector[first:stop].tobytes() == raw[6:].tobytes()


def test_open_and_close_give_back_their_exact_signs(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    for sign in (-1.0, 1.0):
        vector = pack({"gripper": opening(sign * -0.04 + 0.04)}, slots, ZEROS)
        assert part(vector, order, "right_gripper") == [sign]


def test_without_commands_parts_hold_by_their_laws(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    previous = np.full(12, 0.5, dtype=np.float32)
    previous[slice(*order["right_gripper"])] = 1.0
    vector = pack({}, slots, previous)
    assert part(vector, order, "right") == [0.0] * 6
    assert part(vector, order, "right_gripper") == [1.0]  # a grasp is kept
    assert part(vector, order, "base") == [0.0] * 3
    assert vector[-1] == -1.0


def test_torso_is_zero_and_never_remembered(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    previous = np.ones(12, dtype=np.float32)
    vector = pack({"arm": delta(np.full(6, 0.01))}, slots, previous)
    assert part(vector, order, "torso") == [0.0]


def test_yaw_alone_reaches_only_its_own_input(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    vector = pack({"base": base_velocity(base_yaw=0.75)}, slots, ZEROS)
    assert part(vector, order, "base") == [0.0, 0.0, 0.5]


def test_values_of_inactive_joints_are_ignored(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    values = np.full(11, 0.3)
    command = PartCommand(ControlMode.JOINT_VELOCITY, "", values, (1,))
    vector = pack({"base": command}, slots, ZEROS)
    assert part(vector, order, "base") == [0.0, np.float32(0.3), 0.0]


def test_each_call_gives_a_fresh_array(slots: ActionMap) -> None:
    previous = ZEROS.copy()
    first = pack({}, slots, previous)
    first[:] = 7.0
    assert not previous.any()
    assert pack({}, slots, previous)[0] == 0.0


REFUSALS = {
    "unknown part": (
        {"torso": opening(0.1)},
        "packing: expected a part of this robot, got 'torso' "
        "(valid: arm, gripper, base, composite)",
    ),
    "mode the part does not have": (
        {"arm": PartCommand(ControlMode.JOINT_POSITION, "", np.zeros(11), (3,))},
        "packing: part arm: expected a mode it supports, got joint_position "
        "(valid: cartesian_delta)",
    ),
    "mode without a controller input": (
        {"base": PartCommand(ControlMode.FOOT_PLACEMENT, "", np.zeros(3), ())},
        "packing: part base: expected a mode it supports, got foot_placement "
        "(valid: joint_velocity, body_twist)",
    ),
    "delta too narrow": (
        {"arm": delta(np.zeros(3))},
        "packing: part arm: expected 6 values for inputs [0, 6) of simulator part 'right', got 3",
    ),
    "wrong frame": (
        {"arm": PartCommand(ControlMode.CARTESIAN_DELTA, "odom", np.zeros(6), ())},
        "packing: part arm: expected frame 'base_link', got 'odom'",
    ),
    "no active joint": (
        {"base": PartCommand(ControlMode.JOINT_VELOCITY, "", np.zeros(11), ())},
        "packing: part base: expected at least one active joint, got none "
        "(valid: base_x, base_y, base_yaw)",
    ),
    "twist without a base that turns": (
        {"base": PartCommand(ControlMode.BODY_TWIST, "base_link", np.zeros(6), ())},
        "packing: part base: expected a base that can follow a body_twist, got none",
    ),
}


@pytest.mark.parametrize("case", sorted(REFUSALS))
def test_what_does_not_fit_is_refused_in_full_words(case: str, slots: ActionMap) -> None:
    commands, text = REFUSALS[case]
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
        pack(commands, slots, ZEROS)


def test_a_mode_wider_than_its_slot_is_refused_with_both_widths() -> None:
    slots = action_map({**ORDERS["stock"], "right": (0, 3)})
    text = "packing: part arm: expected 3 values for inputs [0, 3) of simulator part 'right', got 6"
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
        pack({"arm": delta(np.zeros(6))}, slots, ZEROS)


def test_a_zero_of_the_gripper_is_not_turned_into_a_negative_one(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    half_open = {"gripper": opening(0.04)}  # what +0.0 means
    (value,) = part(pack(half_open, slots, ZEROS), order, "right_gripper")
    assert value == 0.0 and not np.signbit(value)


def test_both_zeros_of_a_policy_come_back_through_the_grippers_offset(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    routes = resolve_routes(
        load_skill("oracle-counter-to-cabinet").action_contract, load_robot("panda_mobile")
    )
    actions = np.zeros((2, 12), dtype=np.float32)
    actions[1] = -0.0
    told = floats(dispatch(routes, actions, 12)[1].values)
    assert told[0] == 0.04 and abs(told[1] - 0.04) <= np.spacing(0.04)
    values = [
        part(pack({"gripper": opening(one)}, slots, ZEROS), order, "right_gripper") for one in told
    ]
    assert values == [[0.0], [0.0]]
    assert [bool(np.signbit(value[0])) for value in values] == [False, True]


def test_the_sign_of_a_zero_survives_where_there_is_no_offset(
    slots: ActionMap, order: dict[str, tuple[int, int]]
) -> None:
    told = {"arm": delta(np.array([-0.0, 0.0, -0.0, 0.0, -0.0, 0.0]))}
    values = part(pack(told, slots, ZEROS), order, "right")
    assert np.signbit(values).tolist() == [True, False] * 3
