"""Run in the peers' environment: openpi's own server, from a checkout, around a stand-in model.

``python -m tests.peers.serve_openpi CHECKOUT PORT ROWS FIRST_S``. The stand-in wants what
RoboCasa's configuration wants, and answers with rows that overshoot: ROWS of them, the first time
after FIRST_S, as one that compiles.
"""

from __future__ import annotations

import importlib
import logging
import sys
import threading
from typing import Any

import numpy as np

from tests.peers import import_stubs
from tests.peers.rows import overshooting

FAILING, HANGING = "fail", "hang"
"""Prompts for which it does."""


class Model:
    """Its transforms ask for these names, as those of RoboCasa's configuration do."""

    def __init__(self, rows: int, first_s: float) -> None:
        self._rows, self._first_s = rows, first_s

    def infer(self, obs: dict[str, Any]) -> dict[str, Any]:
        """Rows, or what the prompt asks for instead."""
        threading.Event().wait(self._first_s)
        self._first_s = 0.0
        pictures = [obs["observation/image"], obs["observation/wrist_image"]]
        pictures.append(obs["observation/right_image"])
        if {(p.shape, str(p.dtype)) for p in pictures} != {((256, 256, 3), "uint8")}:
            raise ValueError([p.shape for p in pictures])
        if (obs["observation/state"].shape, str(obs["observation/state"].dtype)) != (
            (16,),
            "float32",
        ):
            raise ValueError(obs["observation/state"].shape)
        if obs["prompt"] == FAILING:
            raise RuntimeError("out of memory, as told")
        if obs["prompt"] == HANGING:
            sys.stderr.write(f"{HANGING} as told\n")
            threading.Event().wait()
        rows = np.resize(overshooting(), (self._rows, 12)).astype("float64")
        return {"actions": rows, "state": obs["observation/state"]}


def main() -> None:
    """Serve until killed."""
    checkout, port, rows, first_s = sys.argv[1:]
    sys.path[:0] = [f"{checkout}/packages/openpi-client/src", f"{checkout}/src"]
    import_stubs.install()
    logging.basicConfig(level=logging.INFO)
    server = importlib.import_module("openpi.serving.websocket_policy_server")
    server.WebsocketPolicyServer(
        Model(int(rows), float(first_s)),
        host="127.0.0.1",
        port=int(port),
        metadata={"reset_pose": [0.0]},
    ).serve_forever()


if __name__ == "__main__":
    main()
