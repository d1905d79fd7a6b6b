"""A SafeChunk is checked against the robot's shape before a row of it can run."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from fairlead.errors import MessageError
from fairlead.hal.claims import decode_released
from fairlead.messages import ActionPart, SafeChunk, pack_floats
from fairlead.modes import ControlMode
from tests.hal.gate_messages import N_DOF, PARTS, chunk


def with_part(mode: int, width: int, rows: int = 2, active: tuple[int, ...] = ()) -> SafeChunk:
    values = np.arange(float(rows * width)).reshape(rows, width)
    part = ActionPart(
        part=1, mode=mode, frame_id="base_link", values=pack_floats(values), active=active
    )
    return msgspec.structs.replace(chunk(10, 1, horizon=2), parts=(part,))


def test_rows_keep_their_width_and_their_active_joints() -> None:
    message = with_part(ControlMode.JOINT_VELOCITY, N_DOF, active=(1, 3))
    released = decode_released(message, PARTS, N_DOF)
    command = released.commands(1)[1]
    assert command.mode is ControlMode.JOINT_VELOCITY
    assert command.values.tolist() == [4.0, 5.0, 6.0, 7.0]
    assert command.active == (1, 3)


def test_a_six_wide_twist_is_read_six_wide_whatever_the_robot_has_joints() -> None:
    released = decode_released(with_part(ControlMode.BODY_TWIST, 6), PARTS, N_DOF)
    assert released.commands(1)[1].values.tolist() == [6.0, 7.0, 8.0, 9.0, 10.0, 11.0]


@pytest.mark.parametrize(
    ("message", "complaint"),
    [
        (with_part(ControlMode.BODY_TWIST, N_DOF), "expected 2 rows of body_twist, got 64 bytes"),
        (with_part(ControlMode.JOINT_VELOCITY, 6), "expected 2 rows of joint_velocity"),
        (with_part(ControlMode.COMPOSITE_MODE, 1, rows=3), "expected 2 rows of composite_mode"),
        (with_part(77, 1), "expected a known mode, got 77"),
        (with_part(ControlMode.FOOT_PLACEMENT, 1), "expected a mode the gate checks, got foot_pl"),
        (with_part(ControlMode.JOINT_VELOCITY, N_DOF, active=(4,)), r"expected joints < 4"),
        (chunk(10, 1, parts=(0, 0)), r"each part once, got horizon 4, parts \[0, 0\]"),
        (chunk(10, 1, parts=()), r"rows for at least one part"),
        (chunk(10, 1, horizon=0), r"got horizon 0"),
    ],
)
def test_a_chunk_that_does_not_fit_is_refused_by_name(message: SafeChunk, complaint: str) -> None:
    with pytest.raises(MessageError, match=complaint):
        decode_released(message, PARTS, N_DOF)
