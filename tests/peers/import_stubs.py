"""Stand-ins for heavy libraries that a server imports and that do nothing where no weights are.

Only libraries of this list, and only where they are not installed; and a server's own model. A
stand-in can be subclassed, called, subscripted, used in an annotation and as a decorator.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import sys
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

HEAVY = {
    "accelerate", "albumentations", "av", "beartype", "cv2", "datasets", "decord", "diffusers",
    "einops", "flash_attn", "flax", "huggingface_hub", "jax", "jaxtyping", "matplotlib",
    "omegaconf", "packaging", "pandas", "peft", "pydantic", "requests", "safetensors", "scipy",
    "torch", "torchcodec", "torchvision", "tqdm", "transformers", "tree", "tyro", "wandb", "yaml",
}  # fmt: skip


class _Stub(type):
    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return stub(name)

    def __getitem__(cls, item: object) -> Any:
        return cls


def _decorated(self: object, function: Any = None, *rest: object, **named: object) -> Any:
    return function if callable(function) else self


def stub(name: str) -> _Stub:
    """A class that stands for anything."""
    return _Stub(name, (), {"__call__": _decorated, "__getattr__": lambda self, other: stub(other),
                            "__init__": lambda self, *a, **k: None})  # fmt: skip


class _StubModule(ModuleType):
    __path__: list[str] = []  # noqa: RUF012 - a package's, so that it may have submodules

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return stub(name)


class StubFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Stands in for packages and all that is below them.

    At the end of ``sys.meta_path`` what is installed comes first; at the beginning it does.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._names = frozenset(names)

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """A stand-in for a module of the list."""
        if not any(name == one or name.startswith(f"{one}.") for one in self._names):
            return None
        return importlib.machinery.ModuleSpec(name, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """The stand-in."""
        return _StubModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Nothing to do."""


def install(*own: str) -> None:
    """From now on missing libraries of the list are stand-ins, and ``own`` packages too."""
    sys.meta_path.insert(0, StubFinder(own))
    sys.meta_path.append(StubFinder(HEAVY))
