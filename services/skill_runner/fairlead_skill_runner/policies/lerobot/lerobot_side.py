"""LeRobot's side of the backend ``lerobot``: run as a file, by the interpreter that has lerobot.

It imports nothing of fairlead's, and until it is told to load only the standard library, so that
an interpreter without lerobot can say so. ``lerobot_side.py FD PARENT``: answers on the socket FD,
and ends with its parent.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import io
import json
import os
import signal
import socket
import struct
import sys
import traceback
from typing import Any

OLDEST = (0, 6)
"""The oldest release of lerobot that was tried."""

_SIZE = struct.Struct("!I")
_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG


def send(pipe: io.BufferedRWPair, document: dict[str, Any], *buffers: bytes) -> None:
    """One message: JSON after its length, then the buffers whose lengths it has."""
    text = json.dumps(document | {"buffers": [len(one) for one in buffers]}).encode()
    pipe.write(b"".join((_SIZE.pack(len(text)), text, *buffers)))
    pipe.flush()


def receive(pipe: io.BufferedRWPair) -> tuple[dict[str, Any], list[bytes]] | None:
    """One message; None when the other side is gone.

    Raises:
        ValueError, KeyError, TypeError: for bytes that are no message.
    """
    header = pipe.read(_SIZE.size)
    if len(header) < _SIZE.size:
        return None
    document = json.loads(pipe.read(*_SIZE.unpack(header)))
    return document, [pipe.read(size) for size in document["buffers"]]


def main() -> None:
    """Answer until the other side is gone."""
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != int(sys.argv[2]):  # it ended before the kernel knew
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    sys.path.pop(0)  # this file's folder
    pipe = socket.socket(fileno=int(sys.argv[1])).makefile("rwb")
    loaded: Loaded | None = None
    while (message := receive(pipe)) is not None:
        asked, buffers = message
        try:
            if "load" in asked:
                _require_lerobot()
                loaded = Loaded(asked["load"], asked["device"], asked["threads"], asked["rtc"])
                send(pipe, loaded.told())
            elif "seed" in asked:
                assert loaded is not None
                loaded.reset(asked["seed"])
                send(pipe, {})
            else:
                assert loaded is not None
                shape, data = loaded.infer(asked, buffers)
                send(pipe, {"shape": shape}, data)
        except Exception as error:  # noqa: BLE001 - whatever is raised over there is the answer
            traceback.print_exc()
            send(pipe, {"raised": f"{type(error).__name__}: {error}"})


def _require_lerobot() -> None:
    wanted = ".".join(map(str, OLDEST))
    try:
        found = importlib.metadata.version("lerobot")
        fits = tuple(int(part) for part in found.split(".")[:2]) >= OLDEST
    except importlib.metadata.PackageNotFoundError:
        found, fits = "none", False
    if not fits:
        raise RuntimeError(
            f"expected lerobot {wanted} or newer in {sys.executable}, got {found}: "
            f"{sys.executable} -m pip install 'lerobot>={wanted}'"
        )


class Loaded:
    """A checkpoint's policy between its own processors."""

    def __init__(self, checkpoint: str, device: str | None, threads: int, rtc: bool) -> None:
        import torch
        from lerobot.configs.policies import PreTrainedConfig
        from lerobot.policies.factory import get_policy_class, make_pre_post_processors

        torch.set_num_threads(threads)
        config = PreTrainedConfig.from_pretrained(checkpoint)
        config.device = device or config.device
        if hasattr(config, "pretrained_backbone_weights"):
            config.pretrained_backbone_weights = None  # the checkpoint has them: no download
        self._torch, self._config, self._rtc = torch, config, rtc
        self._policy = get_policy_class(config.type).from_pretrained(
            checkpoint, config=config, strict=True
        )
        # lerobot 0.6.0 does not say whether a policy continues rows
        self._continues = getattr(self._policy, "supports_rtc", bool)()
        if rtc and self._continues:
            self._switch_on_rtc()
        self._before, self._after = make_pre_post_processors(
            config,
            pretrained_path=checkpoint,
            preprocessor_overrides={
                "device_processor": {"device": config.device},
                "rename_observations_processor": {"rename_map": {}},  # they come as it knows them
            },
        )

    def told(self) -> dict[str, Any]:
        """What the checkpoint wants and gives."""
        config = self._config
        return {
            "lerobot": importlib.metadata.version("lerobot"),
            "type": config.type,
            "device": str(config.device),
            "inputs": _shapes(config.input_features),
            "outputs": _shapes(config.output_features),
            "deltas": config.observation_delta_indices,
            "action_names": getattr(config, "action_feature_names", None) or [],  # pi0 and its kin
            "without_statistics": self._without_statistics(),
            "rtc": self._continues,
        }

    def _without_statistics(self) -> list[str]:
        """Features that lerobot would leave as they are, though training normalised them."""
        features = {**self._config.input_features, **self._config.output_features}
        return [
            name
            for step in (*self._before.steps, *self._after.steps)
            if hasattr(step, "norm_map")
            for name in step.features
            if name in features
            and name not in (step.stats or {})
            and step.norm_map.get(features[name].type, "IDENTITY") != "IDENTITY"
        ]

    def reset(self, seed: int) -> None:
        """An episode begins."""
        self._policy.reset()
        self._before.reset()
        self._after.reset()
        self._torch.manual_seed(seed)

    def infer(self, asked: dict[str, Any], buffers: list[bytes]) -> tuple[list[int], bytes]:
        """A chunk of rows, float32, from arrays as they are described in ``asked``.

        ``action`` is rows that act meanwhile, as they were answered: the processors bring them
        into the policy's own numbers, as those of a dataset.
        """
        import numpy as np

        torch = self._torch
        batch: dict[str, Any] = {"task": [asked["prompt"]]}
        for (name, kind, shape), data in zip(asked["arrays"], buffers, strict=True):
            tensor = torch.from_numpy(np.frombuffer(data, kind).reshape(shape).copy())
            if kind == "uint8":
                tensor = tensor.movedim(-1, -3).to(torch.float32) / 255
            batch[name] = tensor[None]
        seen = self._before(batch)
        more = self._meanwhile(seen.pop("action", None)) if self._rtc else {}
        chunk = self._after(self._policy.predict_action_chunk(seen, **more))
        rows = chunk[0].to("cpu", torch.float32).contiguous().numpy()
        return list(rows.shape), rows.tobytes()

    def _switch_on_rtc(self) -> None:
        from lerobot.policies.rtc.configuration_rtc import RTCConfig

        config = self._config
        if getattr(config, "rtc_config", None) is None:
            # a horizon of all rows: those that are given count in full
            rows = getattr(config, "chunk_size", RTCConfig.execution_horizon)
            config.rtc_config = RTCConfig(execution_horizon=rows)
        config.rtc_config.enabled = True
        if hasattr(self._policy, "init_rtc_processor"):
            self._policy.init_rtc_processor()

    def _meanwhile(self, prefix: Any) -> dict[str, Any]:
        if prefix is None:
            return {"inference_delay": 0, "prev_chunk_left_over": None}
        count = prefix.shape[1]
        if getattr(self._config.rtc_config, "mode", "guided") == "trained":
            count = min(count, self._config.rtc_training_max_delay)
        return {"inference_delay": count, "prev_chunk_left_over": prefix[0, :count]}


def _shapes(features: dict[str, Any]) -> dict[str, list[int]]:
    return {name: list(feature.shape) for name, feature in features.items()}


if __name__ == "__main__":
    main()
