"""Run in the peers' environment: openpi's own server, from a checkout, around a stand-in model.

``python -m tests.peers.serve_openpi CHECKOUT PORT``. The stand-in wants what RoboCasa's
configuration wants, and answers with rows that overshoot.
"""

from __future__ import annotations

import importlib
import logging
import sys
from typing import Any

from tests.peers import import_stubs
from tests.peers.rows import overshooting

FAILING, DIM = "fail", 12


class Model:
    """Its transforms ask for these names, as those of RoboCasa's configuration do."""

    def infer(self, obs: dict[str, Any]) -> dict[str, Any]:
        """Rows, or a failure where the prompt asks for one."""
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
        return {"actions": overshooting().astype("float64"), "state": obs["observation/state"]}


def main() -> None:
    """Serve until killed."""
    checkout, port = sys.argv[1], int(sys.argv[2])
    sys.path[:0] = [f"{checkout}/packages/openpi-client/src", f"{checkout}/src"]
    import_stubs.install()
    logging.basicConfig(level=logging.INFO)
    server = importlib.import_module("openpi.serving.websocket_policy_server")
    server.WebsocketPolicyServer(
        Model(), host="127.0.0.1", port=port, metadata={"reset_pose": [0.0]}
    ).serve_forever()


if __name__ == "__main__":
    main()
