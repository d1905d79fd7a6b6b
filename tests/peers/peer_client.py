"""Run in the peers' environment: openpi's own client asks a server once and prints what it got."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np


def main() -> None:
    """``python -m tests.peers.peer_client ADDRESS KEY [DIM [PICTURE]]``.

    DIM: numbers of 0.5 as the state. PICTURE: its name; its bytes, float32 ``[3, 64, 64]``, come
    on standard input.
    """
    policy = importlib.import_module("openpi_client.websocket_client_policy")
    client = policy.WebsocketClientPolicy(host=sys.argv[1], api_key=sys.argv[2])
    request: dict[str, Any] = {"prompt": "go"}
    if sys.argv[3:]:
        request["observation/state"] = np.full(int(sys.argv[3]), 0.5, np.float32)
    if sys.argv[4:]:
        pixels = np.frombuffer(sys.stdin.buffer.read(), np.float32)
        request[sys.argv[4]] = pixels.reshape(3, 64, 64)
    answer = client.infer(request)
    sys.stdout.write(f"{client.get_server_metadata()} {answer['actions'].tobytes().hex()}\n")


if __name__ == "__main__":
    main()
