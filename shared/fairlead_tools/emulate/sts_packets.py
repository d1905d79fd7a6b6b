"""The bytes of Feetech's SMS/STS protocol, as a servo reads and writes them.

A packet is ``FF FF id length code parameters checksum``: length counts what follows it, code is an
instruction, or in a status packet the servo's error bits, checksum is the inverted sum of all
after ``FF FF``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

HEADER = b"\xff\xff"
BROADCAST_ID = 0xFE
_AROUND = 4  # header, id and length; the length counts the rest
_LEAST = 2  # code and checksum


class Instruction(IntEnum):
    """What a host may ask for."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83


@dataclass(frozen=True)
class Request:
    """One instruction packet. size: its bytes on the bus."""

    servo_id: int
    instruction: int
    parameters: bytes
    size: int


def checksum(body: bytes) -> int:
    """Of all bytes between header and checksum."""
    return ~sum(body) & 0xFF


def status_packet(servo_id: int, error: int, data: bytes = b"") -> bytes:
    """A servo's answer."""
    body = bytes([servo_id, len(data) + _LEAST, error]) + data
    return HEADER + body + bytes([checksum(body)])


def take_request(received: bytearray) -> Request | None:
    """Take the first whole packet with a right checksum off what was received.

    What is no packet, and a packet with a wrong checksum, is dropped without a word: so do the
    servos. None: no packet is whole yet.
    """
    while (start := received.find(HEADER)) >= 0:
        del received[:start]
        while received[2:3] == b"\xff":  # more than two: the last two begin the packet
            del received[:1]
        if len(received) < _AROUND or len(received) < _AROUND + received[3]:
            return None
        size = _AROUND + received[3]
        packet = bytes(received[:size])
        if received[3] >= _LEAST and packet[-1] == checksum(packet[2:-1]):
            del received[:size]
            return Request(packet[2], packet[4], packet[5:-1], size)
        del received[:2]
    del received[: max(0, len(received) - 1)]  # its last byte may begin a header
    return None
