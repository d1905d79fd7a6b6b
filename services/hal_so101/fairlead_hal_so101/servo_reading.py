"""What a servo's registers say, in SI units."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntFlag

FIRST, LENGTH = 40, 31
"""Registers 40 to 70: torque, goal, and everything that is measured."""
_LAYOUT = struct.Struct("<BBHHHH5xBHHHBBxBB2xH")
_CURRENT_UNIT_A = 0.0065
_STALL_NM_PER_A = 2.94 / 2.7
"""12 V variant stalled: 30 kg cm at 2.7 A. An estimate: friction is not in it."""


class ServoFault(IntFlag):
    """Bits of the error byte in every answer."""

    VOLTAGE = 1
    SENSOR = 2
    OVERHEAT = 4
    OVERCURRENT = 8
    OVERLOAD = 32


@dataclass(frozen=True)
class ServoReading:
    """One servo at one moment.

    position_steps, speed_steps_s: as the servo counts. load: share of its full duty cycle, with
    sign. effort_nm: estimated from the current.
    """

    has_torque: bool
    position_steps: int
    speed_steps_s: int
    load: float
    voltage_v: float
    temperature_c: int
    current_a: float
    effort_nm: float
    faults: ServoFault


def servo_reading(data: bytes, error: int) -> ServoReading:
    """Decode registers 40 to 70 and the error byte."""
    torque, _, _, _, _, _, _, position, speed, load, volts, celsius, _, _, amperes = _LAYOUT.unpack(
        data
    )
    current_a = abs(_signed(amperes, 15)) * _CURRENT_UNIT_A
    signed_load = _signed(load, 10) / 1000
    effort = current_a * _STALL_NM_PER_A * (-1 if signed_load < 0 else 1)
    return ServoReading(
        has_torque=torque == 1,
        position_steps=_signed(position, 15),
        speed_steps_s=_signed(speed, 15),
        load=signed_load,
        voltage_v=volts / 10,
        temperature_c=celsius,
        current_a=current_a,
        effort_nm=effort,
        faults=ServoFault(error & sum(ServoFault)),
    )


def _signed(value: int, sign_bit: int) -> int:
    size = value & ((1 << sign_bit) - 1)
    return -size if value >> sign_bit & 1 else size
