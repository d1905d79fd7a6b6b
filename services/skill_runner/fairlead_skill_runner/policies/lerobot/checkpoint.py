"""A checkpoint's folder, and whether what it says of itself is what the skill has."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.lerobot.other_python import WHO
from fairlead_skill_runner.policies.onnx_files import action_names, state_names

STATE, _ACTION = "observation.state", "action"
_PROCESSORS = ("policy_preprocessor.json", "policy_postprocessor.json")
_FILES = ("config.json", "model.safetensors", *_PROCESSORS)
_OURS = "lerobot."
_POSITION = ".pos"  # behind the names of its robots' motors
_WHERE = {STATE: "state_contract.joints", _ACTION: "slots"}

Stamp = tuple[tuple[int, int], ...]


def stamp_of(folder: Path) -> Stamp:
    """Changes when a file of the checkpoint does.

    Raises:
        ConfigError: a file is missing, or a processor has steps of anybody's code.
    """
    missing = [name for name in _FILES if not (folder / name).is_file()]
    if missing:
        hint = "" if set(missing) - set(_PROCESSORS) else (
            "; one older than lerobot 0.4 gets them by "
            "python -m lerobot.processor.migrate_policy_normalization"
        )  # fmt: skip
        raise ConfigError(
            expected(f"{WHO}: checkpoint {folder}", ", ".join(_FILES), f"no {', '.join(missing)}")
            + hint
        )
    for name in _PROCESSORS:
        _check_steps(folder / name)
    told = (path.stat() for path in sorted(folder.iterdir()))
    return tuple((one.st_mtime_ns, one.st_size) for one in told)


def _check_steps(path: Path) -> None:
    """Lerobot makes an object of any class that a file names, with any arguments."""
    try:
        steps = json.loads(path.read_text(encoding="utf-8"))["steps"]
        classes = [step["class"] for step in steps if "registry_name" not in step]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{WHO}: {path}: no processor of lerobot's: {error!r}") from None
    for name in classes:
        if not str(name).startswith(_OURS):
            raise ConfigError(expected(f"{WHO}: {path}", "steps of lerobot's own", repr(name)))


def feature_names(skill: SkillManifest, inputs: Mapping[str, Any]) -> dict[str, str]:
    """What the checkpoint calls each of the skill's pictures."""
    return {
        name: next(
            (known for known in (f"observation.{name}", name) if known in inputs),
            f"observation.images.{name}",
        )
        for name in skill.images
    }


def check_told(skill: SkillManifest, checkpoint: Path, told: Mapping[str, Any]) -> None:
    """Hold what a checkpoint says of itself against the skill.

    Raises:
        ConfigError: with all that does not fit.
    """
    _require_none(f"{checkpoint} ({told['type']})", skill, _problems(skill, told))


def check_dataset(skill: SkillManifest, folder: Path) -> None:
    """Hold names, order and rate of a LeRobotDataset against the skill.

    Raises:
        ConfigError: with all that does not fit; it is none.
    """
    path = folder / "meta" / "info.json"
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        rate_hz = float(info["fps"])
        named = {key: _listed(info["features"][key]["names"]) for key in (STATE, _ACTION)}
    except OSError as error:
        raise ConfigError(f"{WHO}: dataset: {path}: cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{WHO}: dataset: {path}: no LeRobotDataset: {error!r}") from None
    problems = [
        expected(f"the names of {key}", " or ".join(map(", ".join, ours)), ", ".join(joints))
        for key, ours in _our_names(skill).items()
        if (joints := _joints(named[key])) not in ours
    ]
    problems += [one for key in named for one in _unit_problems(skill, key, named[key])]
    if rate_hz != skill.rate_hz:
        problems.append(expected("rate_hz", f"{rate_hz:g}, its fps", f"{skill.rate_hz:g}"))
    _require_none(str(folder), skill, problems)


def _listed(names: Any) -> list[str]:
    flat = next(iter(names.values())) if isinstance(names, dict) else names
    return [str(name) for name in flat]


def _joints(names: Iterable[str]) -> list[str]:
    """Of the skill's own words for them; lerobot's robots add .pos to a joint's name."""
    return [name.removesuffix(_POSITION) for name in names]


def _unit_problems(skill: SkillManifest, key: str, names: Iterable[str]) -> Iterator[str]:
    """Lerobot's robots have units and zeros of their own, which no dataset tells."""
    plain = {
        STATE: [field.names for field in skill.state_contract.joints if field.in_units],
        _ACTION: [
            slot.joint_names or ()
            for slot in skill.action_contract.routed
            if slot.scale is None and slot.offset is None
        ],
    }[key]
    as_lerobot = {f"{name}{_POSITION}" for joints in plain for name in joints}
    found = [name for name in names if name in as_lerobot]
    if found:
        yield expected(
            f"{key}: {', '.join(found)}",
            f"their scale or offset in the skill's {_WHERE[key]}: numbers of LeRobot's robots are "
            "-100 to 100 or degrees, a gripper's 0 to 100, from the zeros of its own calibration",
            "neither",
        )


def _our_names(skill: SkillManifest) -> dict[str, list[list[str]]]:
    """As `export lerobot` writes them, or joints."""
    joints = [name for field in skill.state_contract.joints for name in field.names]
    slots = sorted(skill.action_contract.routed, key=lambda slot: slot.first)
    moved = [name for slot in slots for name in slot.joint_names or ()]
    ours = {STATE: [list(state_names(skill)), joints], _ACTION: [list(action_names(skill)), moved]}
    dims = {STATE: skill.state_contract.dim, _ACTION: skill.action_contract.dim}
    return {key: [one for one in ours[key] if len(one) == dims[key]] for key in ours}


def _require_none(what: str, skill: SkillManifest, problems: Iterable[str]) -> None:
    listed = "".join(f"\n  {one}" for one in problems)
    if listed:
        raise ConfigError(f"{WHO}: {what} does not fit skill {skill.id}:{listed}")


def _problems(skill: SkillManifest, told: Mapping[str, Any]) -> Iterator[str]:
    names = feature_names(skill, told["inputs"])
    wanted = {STATE: [skill.state_contract.dim]} | {
        names[name]: [3, *spec.shape[:2]] for name, spec in skill.images.items() if spec.is_plain
    }
    for name, spec in skill.images.items():
        if not spec.is_plain:
            got = f"{spec.dtype}, {spec.axes}"
            yield expected(f"images.{name}", "dtype uint8, axes hwc: LeRobot turns them", got)
    yield from _shape_problems(told["inputs"], wanted)
    yield from _shape_problems(told["outputs"], {_ACTION: [skill.action_contract.dim]})
    deltas = told["deltas"] or [0]
    given = {"state_contract": skill.state_contract.deltas}
    given |= {f"images.{name}": spec.deltas for name, spec in skill.images.items()}
    for what, ours in given.items():
        if list(ours) != deltas:
            yield expected(f"{what}.deltas", f"{deltas}, the checkpoint's", list(ours))
    said = _listed(told["action_names"])
    yield from _unit_problems(skill, _ACTION, said)
    named = _joints(said)
    for own in _our_names(skill)[_ACTION]:
        if sorted(own) == sorted(named) and own != named:
            yield expected("the order of action", ", ".join(own), ", ".join(named))
    for name in told["without_statistics"]:
        yield f"{name}: was normalised in training, but the processors have no statistics of it"


def _shape_problems(
    found: Mapping[str, list[int]], wanted: Mapping[str, list[int]]
) -> Iterator[str]:
    for name in [*wanted, *(name for name in found if name not in wanted)]:
        if found.get(name) != wanted.get(name):
            ours = f"{wanted[name]} of the skill" if name in wanted else "none in the skill"
            theirs = found.get(name, "none")
            yield f"{name}: the checkpoint has {theirs}, expected {ours}"
