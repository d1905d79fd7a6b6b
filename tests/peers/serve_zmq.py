"""Run in the peers' environment: GR00T's or RLDX's own server, from a checkout.

``python -m tests.peers.serve_zmq CHECKOUT PORT CONFIG FRAMES [rtc]``. Its own simulation wrapper
checks every observation and answer, and for RLDX its own runtime reads the prefix; only what the
model computes is a stand-in's.

CONFIG: for RLDX its module with the names, such as robocasa365_config; for GR00T, whose names are
in the checkpoint, nothing but a word. FRAMES: of a picture; one that is not 1 is every second of
the policy's rows, as RLDX's loader has it.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from tests.peers import import_stubs
from tests.peers.gr00t_config import ROBOCASA_PANDA_OMRON
from tests.peers.rows import SHARES, overshooting

STRIDE = 2


def rldx_configs(name: str, frames: int) -> Any:
    """The checkout's own, with the frames that its loader makes of a checkpoint's configuration."""
    importlib.import_module(f"rldx.configs.data.{name}")
    known = importlib.import_module("rldx.configs.data.embodiment_configs").MODALITY_CONFIGS
    configs = known["general_embodiment"]
    config = SimpleNamespace(
        use_memory=True, use_video=frames > 1, video_length=frames, video_stride=STRIDE
    )
    loader = importlib.import_module("rldx.policy.policy_loader")
    loader._apply_memory_config(SimpleNamespace(config=config), configs)
    return configs


def gr00t_configs(name: str, frames: int) -> Any:
    """The published checkpoint's."""
    make = importlib.import_module("gr00t.data.types").ModalityConfig
    configs = {
        kind: make(delta_indices=deltas, modality_keys=names)
        for kind, (deltas, names) in ROBOCASA_PANDA_OMRON.items()
    }
    configs["video"].delta_indices = [STRIDE * frame for frame in range(1 - frames, 1)]
    return configs


def main() -> None:
    """Serve until killed."""
    checkout, port, name, frames, *rtc = sys.argv[1:]
    sys.path.insert(0, checkout)
    package = "gr00t" if (Path(checkout) / "gr00t").is_dir() else "rldx"
    import_stubs.install(f"{package}.model")
    policy = importlib.import_module(f"{package}.policy.policy")
    wrapping = importlib.import_module(f"{package}.policy.{package}_policy")
    served = importlib.import_module(f"{package}.policy.server_client")
    configs = {"gr00t": gr00t_configs, "rldx": rldx_configs}[package](name, int(frames))
    rows_of: Callable[..., Any] = lambda observation, options: overshooting()  # noqa: E731
    if package == "rldx":
        from tests.peers.rldx_rtc import rows_with_prefix

        rows_of = rows_with_prefix(configs, bool(rtc))

    class Model(policy.BasePolicy):  # type: ignore[misc, name-defined]
        modality_configs = configs

        def get_modality_config(self) -> Any:
            return configs

        def check_observation(self, observation: Any) -> None: ...

        def check_action(self, action: Any) -> None: ...

        def _get_action(self, observation: Any, options: Any = None) -> Any:
            rows = rows_of(observation, options)[None]
            return {name: rows[:, :, first:last] for name, (first, last) in SHARES.items()}, {}

        def reset(self, options: Any = None) -> Any:
            sys.stdout.write(f"reset {options}\n")
            return {}

    wrapper = {"gr00t": "Gr00tSimPolicyWrapper", "rldx": "RLDXSimPolicyWrapper"}[package]
    wrapped = getattr(wrapping, wrapper)(Model(strict=False), strict=True)
    served.PolicyServer(policy=wrapped, host="127.0.0.1", port=int(port)).run()


if __name__ == "__main__":
    main()
