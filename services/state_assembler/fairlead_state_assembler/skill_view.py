"""One wanted skill: what to assemble for it, and what it has been answered."""

from __future__ import annotations

from typing import NamedTuple

from fairlead.errors import FairleadError, LayoutError
from fairlead.messages import NO_HASH, LayoutFault, LayoutState, encode, pack_floats
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.registry import assemble_contract
from fairlead_state_assembler.transforms_at_tick import TransformsAtTick


class Moment(NamedTuple):
    """The tick layouts are assembled for."""

    session: int
    tick: int
    episode_tick: int
    joints: JointPositions


class SkillView:
    """Assembles one skill's layout and remembers the answer of the current tick.

    Attributes:
        answer: the encoded `LayoutState` of ``tick``, None while there is none. Faults
            are never remembered: an error is not an answer.
    """

    def __init__(self, skill: str) -> None:
        self.skill = skill
        self.answer: bytes | None = None
        self._manifest: SkillManifest | None = None
        self._hash = NO_HASH
        self._refusal: FairleadError | None = None
        try:
            self._manifest = load_skill(skill)
            self._hash = self._manifest.skill_hash  # once: it is as dear as all the rest of a tick
        except FairleadError as error:
            self._refusal = error

    @property
    def refusal(self) -> FairleadError | None:
        """Why the skill cannot be assembled for at all, None if it can."""
        return self._refusal

    def try_answer(self, moment: Moment, transforms: TransformsAtTick) -> LayoutError | None:
        """Assemble for ``moment``; on success `answer` is set, else the error is returned."""
        try:
            self.answer = encode(self._assemble(moment, transforms))
        except LayoutError as error:
            return error
        return None

    def _assemble(self, moment: Moment, transforms: TransformsAtTick) -> LayoutState:
        if self._manifest is None:
            raise LayoutError(str(self._refusal), kind="unknown_skill", name=self.skill)
        contract = self._manifest.state_contract
        values = assemble_contract(contract, moment.joints, transforms)
        return LayoutState(
            session=moment.session,
            tick=moment.tick,
            episode_tick=moment.episode_tick,
            oldest_tick=transforms.oldest_tick,
            skill=self.skill,
            skill_hash=self._hash,
            layout=contract.layout_name,
            values=pack_floats(values),
            fault=None,
        )

    def fault_message(self, moment: Moment, error: LayoutError) -> bytes:
        """The encoded `LayoutState` that says why there is no vector."""
        manifest = self._manifest
        fault = LayoutFault(
            kind=error.kind,
            name=error.name,
            parent=error.parent,
            age_ticks=error.age_ticks,
            text=str(error),
        )
        return encode(
            LayoutState(
                session=moment.session,
                tick=moment.tick,
                episode_tick=moment.episode_tick,
                oldest_tick=moment.tick,
                skill=self.skill,
                skill_hash=self._hash,
                layout=manifest.state_contract.layout_name if manifest else "",
                values=None,
                fault=fault,
            )
        )
