"""Run in the peers' environment: openpi's own client asks a server once and prints what it got."""

from __future__ import annotations

import importlib
import sys


def main() -> None:
    """``python -m tests.peers.peer_client ADDRESS KEY``."""
    policy = importlib.import_module("openpi_client.websocket_client_policy")
    client = policy.WebsocketClientPolicy(host=sys.argv[1], api_key=sys.argv[2])
    answer = client.infer({"prompt": "go"})
    sys.stdout.write(f"{client.get_server_metadata()} {answer['actions'].tobytes().hex()}\n")


if __name__ == "__main__":
    main()
