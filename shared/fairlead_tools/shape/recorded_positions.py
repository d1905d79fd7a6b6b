"""Joint positions that a gate was given in one run, from its log (`run_log`)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fairlead.errors import ConfigError, MessageError, expected
from fairlead.messages import FloatArray, JointState, decode, floats
from fairlead.regular_file import regular
from fairlead.robot.manifest import RobotManifest

_FIRST_LINE = b"fairlead-decisions-2\n"
_FRAME_BYTES, _CRC_BYTES = 5, 4
_STEP, _JOINT_STATE = 3, 1  # type of a frame, kind of its event
_TIMES_BYTES = 20  # of a step: now, when its event was received, how long the step before took


def recorded_positions(robot: RobotManifest, log: Path) -> FloatArray:
    """Every joint state of a log, each tick once: ``[n, joints]``, measured joints in wire order.

    A log that ends within a frame, as that of a gate that was killed, counts up to there.

    Raises:
        ConfigError: no such file, no decision log, of another robot, or without joint states.
    """
    try:
        data = regular(log).read_bytes()
    except OSError as error:
        raise ConfigError(f"{log}: cannot be read: {error.strerror}") from None
    if not data.startswith(_FIRST_LINE):
        raise ConfigError(f"{log}: is no decision log of this version")
    states: dict[tuple[int, int], FloatArray] = {}
    for payload in _joint_states(data):
        try:
            state = decode(JointState, payload)
        except MessageError:
            continue  # the gate was given it all the same, and refused it
        states[state.session, state.tick] = floats(state.positions)
    if not states:
        raise ConfigError(f"{log}: holds no joint state")
    wanted, widths = len(robot.measured_joint_names), {len(one) for one in states.values()}
    if widths != {wanted}:
        raise ConfigError(expected(f"{log}", f"{wanted} joints of {robot.id}", str(sorted(widths))))
    return np.stack(list(states.values()))


def _joint_states(data: bytes) -> Iterator[bytes]:
    place, crc = len(_FIRST_LINE), zlib.crc32(_FIRST_LINE)
    while place + _FRAME_BYTES + _CRC_BYTES <= len(data):
        kind, size = data[place], int.from_bytes(data[place + 1 : place + 4], "little")
        end = place + _FRAME_BYTES + size
        crc = zlib.crc32(data[place:end], crc)
        if data[end : end + _CRC_BYTES] != crc.to_bytes(_CRC_BYTES, "little"):
            return
        body = data[place + _FRAME_BYTES : end]
        if kind == _STEP and body[_TIMES_BYTES] == _JOINT_STATE:
            after = _TIMES_BYTES + 2 + body[_TIMES_BYTES + 1]  # kind, size of source, source
            (length,) = struct.unpack_from("<I", body, after)
            yield body[after + 4 : after + 4 + length]
        place = end + _CRC_BYTES
