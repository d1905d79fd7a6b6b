"""Skill manifests (``rskills/<id>/rskill.yaml``): what a policy needs and what it emits."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, JsonValue, field_validator, model_validator

from fairlead.checked_model import Locate, Place
from fairlead.errors import ConfigError
from fairlead.keys import check_name
from fairlead.modes import ControlMode
from fairlead.paths import rskill_dir, skill_folders, user_skills_dir
from fairlead.plugins import POLICIES, Plugin
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.image_spec import ImageSpec
from fairlead.skill.slots import MODE_NAMES
from fairlead.skill.state_contract import StateContract
from fairlead.yaml_file import load_yaml, locator

Between = Literal["hold", "linear"]
"""What the rows between two of a slower policy's are."""


class PolicySpec(BaseModel):
    """Which policy runs.

    backend: a name that an installed package registers in ``fairlead.policies``; only where the
        policy runs has that package to be installed.
    options: checked by that policy.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    backend: str = Field(min_length=1)
    options: dict[str, JsonValue] = Field(default_factory=dict)


class SeamSpec(BaseModel):
    """How an answer goes over to the next while rows act (realtime).

    blend_ticks: control periods that are between both, linearly; grippers, hands and switches
        change at once. Of an answer that has only targets, and finds its joints holding, all rows
        come later: it begins with the one nearest to where they are, and its last ones fall out.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    blend_ticks: int = Field(ge=1)


class SkillLimit(BaseModel):
    """A limit tighter than the robot's; ``name`` as in the compiled gate file's mode block."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    part: str
    control_mode: str
    name: str
    value: float = Field(allow_inf_nan=False)

    @field_validator("control_mode")
    @classmethod
    def _known_mode(cls, value: str) -> str:
        if value not in MODE_NAMES:
            raise ValueError(f"expected a mode, got {value!r} (valid: {', '.join(MODE_NAMES)})")
        return value

    @property
    def mode(self) -> ControlMode:
        """The mode whose limit is tightened."""
        return ControlMode[self.control_mode.upper()]


class SkillManifest(BaseModel):
    """One skill.

    Attributes:
        embodiments: ids of the robots it was made for.
        prompt: the instruction given to the policy unless the goal brings its own.
        images: picture name in the policy's observation -> camera.
        rate_hz: rows per second; the robot's control rate, or a whole fraction of it.
        between: of a slower policy: positions and poses are held, or go evenly to the next row.
        horizon: most rows one policy call returns.
        execute_steps: most rows used before the next call.
        seam: how an answer goes over to the next; None: at once, as the policy says.
        age_max_ticks: oldest observation (control periods) the gate may accept.
        inference_timeout_s: a policy call that takes longer has failed.
        decided_by: whose word is success: of the simulator's task, where there is one, or of the
            policy alone (`fairlead.policy.Done`).
        limits: tighter than the robot's; the gate refuses looser ones.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str
    version: str = Field(pattern=r"^\d+\.\d+\.\d+$")
    licence: str = Field(min_length=1)
    model_family: str = Field(min_length=1)
    policy: PolicySpec
    embodiments: tuple[str, ...] = Field(min_length=1)
    prompt: str
    images: dict[str, ImageSpec] = Field(default_factory=dict)
    state_contract: StateContract
    action_contract: ActionContract
    rate_hz: float = Field(gt=0, allow_inf_nan=False)
    between: Between = "hold"
    horizon: int = Field(ge=1)
    execute_steps: int = Field(ge=1)
    seam: SeamSpec | None = None
    age_max_ticks: int = Field(ge=1)
    inference_timeout_s: float = Field(gt=0, allow_inf_nan=False)
    decided_by: Literal["task", "policy"] = "task"
    limits: tuple[SkillLimit, ...] = ()

    @field_validator("id")
    @classmethod
    def _key_chunk(cls, value: str) -> str:
        try:
            return check_name("skill id", value)
        except ConfigError as error:
            raise ValueError(str(error)) from None

    @model_validator(mode="after")
    def _check_steps(self) -> Self:
        if self.execute_steps > self.horizon:
            raise ValueError(
                f"execute_steps: expected at most the horizon, {self.horizon}, "
                f"got {self.execute_steps}"
            )
        if self.seam is not None and self.seam.blend_ticks > self.execute_steps:
            raise ValueError(
                f"seam.blend_ticks: expected at most execute_steps, {self.execute_steps}, for the "
                f"next answer may come then; got {self.seam.blend_ticks}"
            )
        return self

    def control_periods(self, period_ns: int) -> int | None:
        """Control periods for one row of the policy; None where that is no whole number."""
        row_ns = 1e9 / self.rate_hz
        if math.isinf(row_ns):
            return None
        periods = max(1, round(row_ns / period_ns))
        return periods if round(row_ns / periods) == period_ns else None

    @property
    def skill_hash(self) -> bytes:
        """SHA-256 of the manifest's canonical JSON: defaults filled in, keys sorted."""
        canonical = json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).digest()


def load_skill(skill_id: str) -> SkillManifest:
    """Read and check a skill that ships or was installed.

    Raises:
        ConfigError: naming the file and every field that does not fit.
    """
    return read_skill(rskill_dir(skill_id))


def find_skill(wanted: str) -> Path:
    """The folder of the skill a person means: a path, or the name of a known one.

    Raises:
        ConfigError: there is neither, naming the skills there are.
    """
    if wanted in skill_ids():
        return rskill_dir(wanted)
    if (Path(wanted) / "rskill.yaml").is_file():
        return Path(wanted)
    link = user_skills_dir() / wanted
    if "/" not in wanted and link.is_symlink():
        what = f"a folder with rskill.yaml behind {link}, got {link.readlink()}"
        raise ConfigError(
            f"skill {wanted!r}: expected {what}; try: fairlead skill install FOLDER/{wanted} --link"
        )
    raise ConfigError(
        f"skill {wanted!r}: no {Path(wanted) / 'rskill.yaml'}, and none of that name ships or is "
        f"installed (valid: {', '.join(skill_ids()) or 'none'}, or a folder)"
    )


def read_skill(folder: Path) -> SkillManifest:
    """Read and check ``folder/rskill.yaml``; its id must be the folder's name.

    Raises:
        ConfigError: naming the file and every field that does not fit.
    """
    path = folder / "rskill.yaml"
    manifest = load_yaml(path, SkillManifest)
    name = folder.resolve().name
    if manifest.id != name:
        where = locator(path)(("id",))
        raise ConfigError(f"{where}id: expected {name!r}, the folder's name, got {manifest.id!r}")
    return manifest


def locate_in_skill(skill_id: str) -> Locate:
    """Says ``file:line:column: `` of a place in a known skill's manifest, "" for another skill."""

    def locate(place: Place) -> str:
        try:
            return locator(rskill_dir(skill_id) / "rskill.yaml")(place)
        except ConfigError:
            return ""

    return locate


def of_options(locate: Locate) -> Locate:
    """The same for places in the block of the policy's options."""
    return lambda place: locate(("policy", "options", *place))


def find_backend(policy: PolicySpec, locate: Locate) -> Plugin:
    """What a policy's backend names.

    Args:
        locate: says the line of a place in the skill's manifest.

    Raises:
        ConfigError: no installed package has it, with the names there are.
    """
    try:
        return POLICIES.find(policy.backend, "policy.backend")
    except ConfigError as error:
        raise ConfigError(f"{locate(('policy', 'backend'))}{error}") from None


def skill_ids() -> tuple[str, ...]:
    """Ids of every skill that ships and of every one the user installed, sorted."""
    found = {path.parent.name for one in skill_folders() for path in one.glob("*/rskill.yaml")}
    return tuple(sorted(found))
