"""Another user who listens in the place of a service, and passes on what proves who dials it.

``python -m tests.access.relay PORT GATE NAME [ID]``: listens on a port, has a session of its own
dial the gate's port in that name, with the session id or any, and answers the gate's challenge with
what whoever dials it says to the same one. Prints ``listens``; then, if there was a proof to pass
on, ``passed on``, and ``link`` if that made one. Each line of its input is a key that is then
asked; it prints how many answered.
"""

from __future__ import annotations

import encodings.idna  # noqa: F401 - what is imported later another user may not read
import json
import os
import secrets
import socket
import struct
import sys
import threading

import zenoh

from fairlead.messages import Arm, StatusQuery, encode
from tests.access.intruder import NOBODY

WAIT_S = 20.0
ANSWER_S = 1.0
_ZID = 5
"""Where the id of whoever answers begins in his first batch; its length is in the byte before."""


def batch(stream: socket.socket) -> bytes:
    """The next one of Zenoh's, with its length in front."""
    head = _exactly(stream, 2)
    return head + _exactly(stream, struct.unpack("<H", head)[0])


def _exactly(stream: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count:
        more = stream.recv(count - len(found))
        if not more:
            raise EOFError
        found += more
    return found


def proof_place(opening: bytes, name: bytes) -> slice:
    """Where a batch has what proves a name, which stands before it; raises `ValueError`."""
    begin = opening.index(bytes([len(name)]) + name) + 1 + len(name)
    return slice(begin + 1, begin + 1 + opening[begin])


class Relay:
    """Between whoever dials its port, its own session, and the gate."""

    def __init__(self, port: int, gate: int, name: str) -> None:
        self._gate, self._name = gate, name.encode()
        self._dialled = socket.create_server(("127.0.0.1", port))
        self._own = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._own.getsockname()[1]}"

    def run(self) -> None:
        own, _ = self._own.accept()
        gate = socket.create_connection(("127.0.0.1", self._gate))
        gate.sendall(batch(own))
        challenge = batch(gate)
        proof = self._answer_to(challenge)
        print("passed on", flush=True)
        own.sendall(challenge)
        opening = bytearray(batch(own))
        opening[proof_place(bytes(opening), self._name)] = proof
        gate.sendall(opening)
        threading.Thread(target=_copy, args=(own, gate), daemon=True).start()
        _copy(gate, own)

    def _answer_to(self, challenge: bytes) -> bytes:
        end = _ZID + (challenge[_ZID - 1] >> 4) + 1
        mine = challenge[:_ZID] + secrets.token_bytes(end - _ZID - 1) + b"\x7f" + challenge[end:]
        while True:
            dialler, _ = self._dialled.accept()
            dialler.settimeout(WAIT_S)
            with dialler:
                try:
                    batch(dialler)
                    dialler.sendall(mine)
                    opening = batch(dialler)
                    return opening[proof_place(opening, self._name)]
                except (EOFError, OSError, ValueError):
                    continue


def _copy(source: socket.socket, sink: socket.socket) -> None:
    try:
        while chunk := source.recv(65536):
            sink.sendall(chunk)
    except OSError:
        return


def main(port: str, gate: str, name: str, *own_id: str) -> None:
    os.setgroups([])
    os.setresgid(NOBODY, NOBODY, NOBODY)
    os.setresuid(NOBODY, NOBODY, NOBODY)
    relay = Relay(int(port), int(gate), name)
    print("listens", flush=True)
    threading.Thread(target=relay.run, daemon=True).start()
    config = {
        "mode": "client",
        "connect": {"endpoints": [relay.endpoint], "timeout_ms": int(WAIT_S * 1000)},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": {
            "auth": {"usrpwd": {"user": name, "password": "0" * 64}},
            "unicast": {"open_timeout": int(WAIT_S * 1000)},
        },
        **({"id": own_id[0]} if own_id else {}),
    }
    try:
        session = zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError:
        os._exit(0)
    print("link", flush=True)
    for line in sys.stdin:
        key = line.strip()
        payload = encode(Arm(by="mallory") if key.endswith("arm") else StatusQuery())
        found = [reply.ok for reply in session.get(key, payload=payload, timeout=ANSWER_S)]
        print(sum(one is not None for one in found), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
