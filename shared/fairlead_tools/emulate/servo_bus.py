"""Servos on a half-duplex serial bus, as a pseudo-terminal that answers at the bus's byte rate."""

from __future__ import annotations

import fcntl
import os
import pty
import random
import select
import struct
import time
import tty
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fairlead_tools.emulate.sts3215 import (
    BAUD_RATE,
    BAUD_RATES,
    ID,
    RESPONSE_LEVEL,
    RETURN_DELAY,
    Sts3215,
)
from fairlead_tools.emulate.sts_packets import (
    BROADCAST_ID,
    Instruction,
    Request,
    status_packet,
    take_request,
)

_BITS_PER_BYTE = 10
_TCGETS2 = 0x802C542A
"""Linux: read a terminal's settings, its speeds as numbers, last of them the output's."""
_TERMIOS2 = struct.Struct("4I20B2I")
_RETURN_DELAY_UNIT_S = 2e-6
_SHORTEST_DELAY_S = 20e-6
"""What a servo needs before it answers, at least; own choice."""


@dataclass
class BusFaults:
    """What goes wrong on the way.

    deaf: chance of each servo not to hear a packet. noise, lost, late: chance of each answer to
    come with a wrong byte, never, or late by ``late_s``. wrong: answers that have had a wrong byte.
    """

    deaf: float = 0.0
    noise: float = 0.0
    lost: float = 0.0
    late: float = 0.0
    late_s: float = 0.0
    wrong: int = 0


class ServoBus:
    """A chain of servos behind one port.

    Args:
        servos: in the order of the cable.
        advance: brings the servos' measurements up to a time [s].
        seed: of what `faults` leaves to chance.

    Attributes:
        port: the terminal's name.
        reached: so many servos have power and signal, counted along the cable.
        collisions: packets lost because the host talked into an answer.
    """

    def __init__(
        self, servos: Sequence[Sts3215], advance: Callable[[float], None], seed: int
    ) -> None:
        self._servos, self._advance = tuple(servos), advance
        self._chance = random.Random(seed)  # noqa: S311 - for variety
        self._received = bytearray()
        self._master, self._slave = pty.openpty()
        tty.setraw(self._master)
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self.faults = BusFaults()
        self.reached = len(self._servos)
        self.collisions = 0

    def close(self) -> None:
        """Unplug the adapter: who has the port open gets an error."""
        os.close(self._slave)
        os.close(self._master)

    def fileno(self) -> int:
        """Readable when the host has sent something."""
        return self._master

    def serve(self) -> None:
        """Answer what the host has sent."""
        came_s = time.monotonic()
        self._received += os.read(self._master, 4096)
        while (request := take_request(self._received)) is not None:
            self._advance(came_s)
            rate = _host_rate(self._master)
            heard = [
                one
                for one in self._servos[: self.reached]
                if _rate(one) == rate and self._chance.random() >= self.faults.deaf
            ]
            if heard:
                self._answer(request, heard, came_s, _BITS_PER_BYTE / rate)

    def _answer(
        self, request: Request, heard: Sequence[Sts3215], came_s: float, byte_s: float
    ) -> None:
        """One packet's answers, each when its last byte would have gone over the bus."""
        free_s = came_s + request.size * byte_s
        for answer in _answers(request, heard):
            if answer is None:  # its turn goes by in silence
                free_s += _SHORTEST_DELAY_S
                continue
            servo, packet = answer
            delay_s = servo.get(RETURN_DELAY) * _RETURN_DELAY_UNIT_S
            free_s += max(_SHORTEST_DELAY_S, delay_s) + len(packet) * byte_s
            self._send(packet, free_s)

    def _send(self, packet: bytes, due_s: float) -> None:
        faults = self.faults
        if self._chance.random() < faults.lost:
            return
        if self._chance.random() < faults.late:
            due_s += faults.late_s
        if self._chance.random() < faults.noise:
            place = self._chance.randrange(2, len(packet))
            wrong = packet[place] ^ self._chance.randrange(1, 256)
            packet = packet[:place] + bytes([wrong]) + packet[place + 1 :]
            faults.wrong += 1
        time.sleep(max(0.0, due_s - time.monotonic()))
        if select.select([self._master], [], [], 0)[0]:  # two talk at once: neither is understood
            os.read(self._master, 4096)
            self._received.clear()
            self.collisions += 1
            return
        os.write(self._master, packet)


def _rate(servo: Sts3215) -> int | None:
    value = servo.get(BAUD_RATE)
    return BAUD_RATES[value] if value < len(BAUD_RATES) else None


def _host_rate(terminal: int) -> int:
    """What the host has set [bit/s]: also one that has no name in termios."""
    found = fcntl.ioctl(terminal, _TCGETS2, bytes(_TERMIOS2.size))
    return int(_TERMIOS2.unpack(found)[-1])


Answer = tuple[Sts3215, bytes]


def _answers(request: Request, heard: Sequence[Sts3215]) -> list[Answer | None]:
    """What the servos do and say; None in place of one that a sync read asked and nobody is."""
    by_id = {servo.get(ID): servo for servo in heard}
    parameters = request.parameters
    if request.instruction == Instruction.SYNC_READ and len(parameters) >= 2:
        address, count = parameters[:2]
        found = [by_id.get(servo_id) for servo_id in parameters[2:]]
        return [None if one is None else _said(one, one.read(address, count)) for one in found]
    if request.instruction == Instruction.SYNC_WRITE and len(parameters) >= 2:
        _sync_write(parameters, by_id)
        return []
    if request.servo_id == BROADCAST_ID:
        for servo in heard:
            _carry_out(request, servo)
        ping = request.instruction == Instruction.PING
        return [_said(servo) for servo in heard] if ping else []
    one = by_id.get(request.servo_id)
    if one is None:
        return []
    silent = not one.get(RESPONSE_LEVEL)
    data = _carry_out(request, one)
    if silent and request.instruction not in (Instruction.PING, Instruction.READ):
        return []
    return [_said(one, data)]


def _sync_write(parameters: bytes, by_id: Mapping[int, Sts3215]) -> None:
    address, count = parameters[:2]
    for start in range(2, len(parameters) - count, count + 1):
        servo = by_id.get(parameters[start])
        if servo is not None:
            servo.write(address, parameters[start + 1 : start + 1 + count])


def _carry_out(request: Request, servo: Sts3215) -> bytes:
    """What one servo does; the data of its answer."""
    parameters = request.parameters
    match request.instruction:
        case Instruction.READ if len(parameters) == 2:
            return servo.read(*parameters)
        case Instruction.WRITE if len(parameters) >= 2:
            servo.write(parameters[0], parameters[1:])
        case Instruction.REG_WRITE if len(parameters) >= 2:
            servo.register_write(parameters[0], parameters[1:])
        case Instruction.ACTION:
            servo.act()
    return b""


def _said(servo: Sts3215, data: bytes = b"") -> Answer:
    return servo, status_packet(servo.get(ID), int(servo.faults), data)
