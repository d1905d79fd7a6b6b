"""Run in the peers' environment: the bytes of a published package, and what it makes of ours.

``python -m tests.peers.peer_bytes WIRE`` reads one line of hex a document from stdin, and says for
each ``ok`` or what differs, a blank, and its own bytes as hex.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

from tests.peers.documents import SEEDS, document, same


def codec(wire: str) -> tuple[Any, Any]:
    """The peer's own way to pack and to unpack."""
    if wire == "openpi":
        peer = importlib.import_module("openpi_client.msgpack_numpy")
        return peer.packb, peer.unpackb
    peer, msgpack = importlib.import_module("msgpack_numpy"), importlib.import_module("msgpack")
    return (
        lambda made: msgpack.packb(made, default=peer.encode),
        lambda data: msgpack.unpackb(data, object_hook=peer.decode),
    )


def main() -> None:
    """One line for each document."""
    pack, unpack = codec(sys.argv[1])
    for seed, line in zip(SEEDS, sys.stdin, strict=True):
        made = document(seed)
        found = "ok" if same(unpack(bytes.fromhex(line.strip())), made) else "differs"
        sys.stdout.write(f"{found} {pack(made).hex()}\n")


if __name__ == "__main__":
    main()
