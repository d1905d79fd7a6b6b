"""Run in the peers' environment: GR00T's or RLDX's own server, from a checkout.

``python -m tests.peers.serve_zmq CHECKOUT PORT CONFIG``. Its own simulation wrapper checks every
observation and answer; only what the model computes is a stand-in's. CONFIG: JSON, by modality its
deltas and keys.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

from tests.peers import import_stubs
from tests.peers.rows import SHARES, overshooting


def main() -> None:
    """Serve until killed."""
    checkout, port, told = sys.argv[1], int(sys.argv[2]), json.loads(sys.argv[3])
    sys.path.insert(0, checkout)
    import_stubs.install()
    package = "gr00t" if (Path(checkout) / "gr00t").is_dir() else "rldx"
    policy = importlib.import_module(f"{package}.policy.policy")
    wrapping = importlib.import_module(f"{package}.policy.{package}_policy")
    types = importlib.import_module(f"{package}.data.types")
    served = importlib.import_module(f"{package}.policy.server_client")
    configs = {
        name: types.ModalityConfig(delta_indices=deltas, modality_keys=keys)
        for name, (deltas, keys) in told.items()
    }

    class Model(policy.BasePolicy):  # type: ignore[misc, name-defined]
        modality_configs = configs

        def get_modality_config(self) -> Any:
            return configs

        def check_observation(self, observation: Any) -> None: ...

        def check_action(self, action: Any) -> None: ...

        def _get_action(self, observation: Any, options: Any = None) -> Any:
            rows = overshooting()[None]
            return {name: rows[:, :, first:last] for name, (first, last) in SHARES.items()}, {}

        def reset(self, options: Any = None) -> Any:
            sys.stdout.write(f"reset {options}\n")
            return {}

    wrapper = {"gr00t": "Gr00tSimPolicyWrapper", "rldx": "RLDXSimPolicyWrapper"}[package]
    wrapped = getattr(wrapping, wrapper)(Model(strict=False), strict=True)
    served.PolicyServer(policy=wrapped, host="127.0.0.1", port=port).run()


if __name__ == "__main__":
    main()
