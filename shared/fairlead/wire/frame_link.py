"""What both ends of shared frames agree on: the socket's name and its packets."""

from __future__ import annotations

import os
import socket
import struct

from fairlead.wire.socket_peer import peer_of

FRAME = struct.Struct("=IQ")
"""Sender to reader: slot, bytes. The first packet about a slot brings the descriptor of its memory,
and the numbers of all slots there are then, 4 bytes each."""
BACK = "I"
"""Reader to sender, in an array: the slots that it looks at no more."""
PACKET_MAX = 4096


def address(name: str) -> str:
    """Of a sender's socket: abstract, so it has no file."""
    return f"\0fairlead-frames-{name}"


def is_own(link: socket.socket) -> bool:
    """Whether the other end is this user's; asks the kernel."""
    return peer_of(link).user == os.getuid()
