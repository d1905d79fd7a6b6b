"""Run in the peers' environment: RLDX-1's own code reads a prefix; numpy stands for torch there."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.peers.rows import SHARES, overshooting

TAG, WIDTH, HALF = "general_embodiment", 64, 0.5
DELAY, EXECUTED = 4, 8
"""Rows of the server's own last answer that it goes on from where it is told nothing: 8 to 11."""


class Tensor(np.ndarray[Any, Any]):
    """As much of torch's as a prefix meets."""

    def unsqueeze(self, axis: int) -> Any:
        return np.expand_dims(self, axis)

    def expand(self, *sizes: int) -> Any:
        wanted = [old if new == -1 else new for old, new in zip(self.shape, sizes, strict=True)]
        return np.broadcast_to(self, wanted, subok=True)

    def dim(self) -> int:
        return self.ndim

    def numpy(self) -> Any:
        return self.view(np.ndarray)

    def to(self, *device: Any, dtype: Any = None) -> Any:
        return self

    contiguous = cpu = float = detach = to
    clone = np.ndarray.copy
    device = "cpu"


def _as_tensor(data: Any, dtype: Any = None, device: Any = None) -> Tensor:
    return np.asarray(data, dtype).view(Tensor)


def _stand_for_torch() -> None:
    torch: Any = importlib.import_module("torch")
    functional: Any = importlib.import_module("torch.nn.functional")
    torch.Tensor, torch.float32, torch.as_tensor = Tensor, np.float32, _as_tensor
    torch.stack = lambda parts, dim: np.stack(parts, dim).view(Tensor)
    functional.pad = lambda rows, beside: np.pad(rows, [(0, 0), (0, 0), beside]).view(Tensor)


def rows_with_prefix(configs: Any, is_on: bool) -> Callable[[Any, Any], Any]:
    """What a model of mode ``trained`` answers: first the prefix that the server's code gives it.

    That is in the model's numbers, which are `HALF` of those on the wire.
    """
    _stand_for_torch()
    processing = importlib.import_module("rldx.data.state_action.state_action_processor")
    numbers = {"min": -1.0 / HALF, "max": 1.0 / HALF, "mean": 0.0, "std": 1.0}
    statistics = {
        name: {kind: [number] * (last - first) for kind, number in numbers.items()}
        for name, (first, last) in SHARES.items()
    }
    processor = processing.StateActionProcessor(
        {TAG: {"action": configs["action"]}}, {TAG: {"action": statistics}}
    )
    steps = importlib.import_module("rldx.policy.step_request")
    runtime = importlib.import_module("rldx.policy.policy_runtime").PolicyRuntime(
        model=SimpleNamespace(device="cpu", action_model=SimpleNamespace(action_dim=WIDTH)),
        processor=SimpleNamespace(state_action_processor=processor),
        modality_configs=configs, embodiment_tag=TAG, collate_fn=None, language_key="",
        registry=importlib.import_module("rldx.policy.session_registry").SessionRegistry(),
        infer_lock=threading.Lock(), use_memory=False, rtc_inference_mode="trained",
        rtc_inference_delay=DELAY, rtc_exec_horizon=EXECUTED, rtc_enabled=is_on,
    )  # fmt: skip

    def answer(observation: Any, options: Any) -> Any:
        rows, collated = overshooting(), dict[str, Any]()
        request = steps.decode_options_to_step_request(observation, options)
        sessions = runtime._inject_rtc_prefix(request, collated, 1, None)
        length = collated.get("rtc_prefix_len", 0)
        if length:
            rows[:length] = collated["action_prefix"][0, :length, : rows.shape[1]] / HALF
        runtime.registry.save_rtc_batch(sessions, _as_tensor(rows[None] * HALF))
        return rows

    return answer
