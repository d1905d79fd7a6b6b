"""The action vector: what the gate makes of the parts it gets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from bench.equipment.live_robot import LiveRobot
from fairlead.messages import ActionPart, GateState, Outcome, Verdict
from fairlead.modes import ControlMode
from tests.system.injector import SOURCE, Injector, part

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

BASE = (0, 1, 2)


@pytest.fixture
def injector(light_robot: LiveRobot) -> Iterator[Injector]:
    light_robot.ready_to_move()
    parts = ("arm", "base", "composite")
    with light_robot.client.claim(parts, source=SOURCE) as claim:
        injector = Injector(light_robot, claim.reply)
        yield injector
        injector.close()


def judged(injector: Injector, *parts: ActionPart) -> Verdict:
    return injector.send(injector.chunk(parts=parts, horizon=1))


def base_rows(value: float, joint: int = 0) -> np.ndarray:
    rows = np.zeros((1, 11))
    rows[0, joint] = value
    return rows


@pytest.mark.parametrize(("joint", "limit"), [(0, 1.0), (1, 1.0), (2, 1.5)])
@pytest.mark.parametrize(("share", "code"), [(1.0, 0), (-1.0, 0), (1.02, 20), (-1.02, 20)])
def test_action_39_each_base_joint_is_held_to_its_own_velocity_limit(
    injector: Injector, joint: int, limit: float, share: float, code: int
) -> None:
    """The gate passes 1.0 m/s of a base joint, refuses 1.02."""
    rows = base_rows(share * limit, joint)
    verdict = judged(injector, part("base", ControlMode.JOINT_VELOCITY, rows, *BASE))
    assert verdict.code == code, verdict


@pytest.mark.parametrize(("value", "code"), [(-1.0, 0), (1.0, 0), (1.01, 20), (np.nan, 8)])
def test_action_40_the_gate_checks_the_switch_as_it_checks_everything(
    injector: Injector, value: float, code: int
) -> None:
    """composite_mode outside [-1, 1] is refused; NaN stops."""
    verdict = judged(injector, part("composite", ControlMode.COMPOSITE_MODE, np.array([[value]])))
    assert verdict.code == code, verdict
    stopped = injector.gate().state in (GateState.STOPPED, GateState.LATCHED)
    assert stopped == (code == 8)


def test_action_41_three_numbers_for_the_base_alone_are_no_row(
    injector: Injector, light_robot: LiveRobot
) -> None:
    """A joint mode without padding is refused; nothing moves."""
    before = len(light_robot.motion.read())
    narrow = part("base", ControlMode.JOINT_VELOCITY, np.full((1, 3), 0.1), *BASE)
    verdict = judged(injector, narrow)
    assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, 7), verdict
    light_robot.client.disarm()
    light_robot.client.reset_episode(0)  # the world goes on
    after = light_robot.motion.read()[before:]
    assert after and not any(line.moves for line in after)


def test_action_42_a_number_beside_the_masked_joints_is_refused(injector: Injector) -> None:
    """A number outside the mask is refused."""
    rows = base_rows(0.1)
    rows[0, 5] = 0.1
    verdict = judged(injector, part("base", ControlMode.JOINT_VELOCITY, rows, *BASE))
    assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, 9), verdict
