"""A checkpoint's normaliser statistics: which action dimensions its training data moved.

Three files are read: LeRobot's ``stats.json`` (``action.{mean, std, min, max}``), openpi's
``norm_stats.json`` (``norm_stats.actions.{mean, std, q01, q99}``) and RLDX's
``statistics.json`` (``<embodiment>.action.<name>.{mean, std, min, max}``, names to be joined).
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from fairlead.errors import ConfigError, expected
from fairlead.regular_file import regular
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import SkillManifest

StatsForm = Literal["lerobot", "openpi", "rldx"]

CONSTANT_BELOW = 1e-6
"""A standard deviation or range this small is rounding, not motion (units of the data)."""

_SPANS = (("min", "max"), ("q01", "q99"))


@dataclass(frozen=True)
class DimensionStats:
    """One action dimension in the training data.

    evidence: the number that says whether it moved, for example ``std 0.21``.
    """

    constant: bool
    evidence: str


@dataclass(frozen=True)
class CheckpointStats:
    """The action statistics of one file, in the order of the action vector."""

    form: StatsForm
    actions: tuple[DimensionStats, ...]


def read_checkpoint_stats(
    path: Path, names: Sequence[str] = (), embodiment: str = ""
) -> CheckpointStats:
    """Read a statistics file of any of the three forms.

    Args:
        names: RLDX only, the order of its named outputs; empty: the file's order.
        embodiment: RLDX only, whose statistics; "" if the file has one.

    Raises:
        ConfigError: for a file that cannot be read, is of no known form, or has numbers
            missing or not finite.
    """
    try:
        document = json.loads(regular(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: not JSON: {error}") from None
    if not isinstance(document, dict):
        raise ConfigError(expected(str(path), "a map", type(document).__name__))
    if _is_map(document.get("norm_stats")):
        actions = document["norm_stats"].get("actions")
        return CheckpointStats("openpi", _dimensions(f"{path}: norm_stats.actions", actions))
    if _is_map(document.get("action")):
        return CheckpointStats("lerobot", _dimensions(f"{path}: action", document["action"]))
    return CheckpointStats("rldx", _joined(path, document, names, embodiment))


def _joined(
    path: Path, document: dict[str, Any], names: Sequence[str], embodiment: str
) -> tuple[DimensionStats, ...]:
    found = {
        key: block["action"]
        for key, block in document.items()
        if _is_map(block) and _is_map(block.get("action"))
    }
    if not found:
        raise ConfigError(
            f"{path}: no action statistics (valid: action, norm_stats.actions, "
            f"<embodiment>.action.<name>; the file has: {', '.join(document) or 'nothing'})"
        )
    chosen = embodiment or (next(iter(found)) if len(found) == 1 else "")
    if chosen not in found:
        got = repr(chosen) if chosen else "none named"
        raise ConfigError(expected(str(path), "one of its embodiments", got, found))
    blocks = found[chosen]
    order = names or tuple(blocks)
    absent = [name for name in order if name not in blocks]
    if absent:
        raise ConfigError(
            expected(f"{path}: {chosen}.action", f"outputs {', '.join(order)}",
                     f"no {', '.join(absent)}", blocks)
        )  # fmt: skip
    return tuple(
        one
        for name in order
        for one in _dimensions(f"{path}: {chosen}.action.{name}", blocks[name])
    )


def _dimensions(where: str, block: object) -> tuple[DimensionStats, ...]:
    if not isinstance(block, dict):
        raise ConfigError(expected(where, "a map of statistics", type(block).__name__))
    spans = [pair for pair in _SPANS if pair[0] in block and pair[1] in block]
    if "std" in block:
        deviations = _numbers(f"{where}.std", block["std"])
        return tuple(DimensionStats(std <= CONSTANT_BELOW, f"std {std:g}") for std in deviations)
    if not spans:
        raise ConfigError(expected(where, "std, min and max, or q01 and q99", ", ".join(block)))
    low_name, high_name = spans[0]
    lows = _numbers(f"{where}.{low_name}", block[low_name])
    highs = _numbers(f"{where}.{high_name}", block[high_name])
    if len(lows) != len(highs):
        raise ConfigError(expected(f"{where}.{high_name}", f"{len(lows)} numbers", len(highs)))
    return tuple(
        DimensionStats(high - low <= CONSTANT_BELOW, f"{low_name} {low:g}, {high_name} {high:g}")
        for low, high in zip(lows, highs, strict=True)
    )


def _numbers(where: str, value: object) -> list[float]:
    numbers = []
    for item in value if isinstance(value, list) else [value]:
        if isinstance(item, bool) or not isinstance(item, (int, float)) or not math.isfinite(item):
            raise ConfigError(expected(where, "finite numbers", repr(item)))
        numbers.append(float(item))
    return numbers


def _is_map(value: object) -> bool:
    return isinstance(value, dict)


def contract_findings(contract: ActionContract, actions: Sequence[DimensionStats]) -> list[str]:
    """Every dimension whose statistics contradict the contract, in order.

    Statistics may be wider than the contract where the surplus is constant padding.
    """
    surplus = [index for index in range(contract.dim, len(actions)) if not actions[index].constant]
    if len(actions) < contract.dim or surplus:
        return [f"action_contract: dim {contract.dim}, the statistics have {len(actions)}"]
    routed = {index: slot for slot in contract.routed for index in range(slot.first, slot.last + 1)}
    findings = []
    for index, stats in enumerate(actions[: contract.dim]):
        slot = routed.get(index)
        if slot is not None and stats.constant:
            findings.append(
                f"dimension {index}: constant in training ({stats.evidence}), but {slot.name} "
                "commands it"
            )
        elif slot is None and not stats.constant:
            findings.append(
                f"dimension {index}: active in training ({stats.evidence}), but discarded"
            )
    return findings


def named_outputs(skill: SkillManifest) -> tuple[str, ...]:
    """The names of a policy's outputs in order, where its options give them; else empty."""
    actions = skill.policy.options.get("actions")
    if not isinstance(actions, list):
        return ()
    return tuple(str(item["name"]) for item in actions if isinstance(item, dict) and "name" in item)
