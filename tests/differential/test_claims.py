"""A claim's own limits: tighter ones are taken, looser ones are not, to the last bit."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, still
from bench.equipment.core_gate import CaseRefusedError
from fairlead.messages import LimitOverride
from fairlead.skill.limit_overrides import override_problems
from fairlead.skill.manifest import SkillLimit
from tests.differential.claims import is_tighter, tightenable
from tests.differential.gate_file import MODES
from tests.differential.gates import Pair

pytestmark = pytest.mark.processes


def is_taken(pair: Pair, *overrides: LimitOverride) -> bool:
    state = still(100, np.zeros(len(pair.file.joints) + len(pair.file.passive)))
    case = Case(pair.robot, "lockstep", state, Chunk(100, 1, ()), overrides=overrides)
    pair.core.start("lockstep", state)
    try:
        pair.core.claim(case)
    except CaseRefusedError:
        return False
    return True


def test_a_claim_is_taken_exactly_where_its_limit_is_no_looser(pair: Pair) -> None:
    for index, part in enumerate(pair.file.parts):
        for mode in part.modes:
            for name, room in tightenable(pair.file, index, mode).items():
                ends = (room.lowest, room.highest)
                near = [math.nextafter(end, to) for end in ends for to in (-math.inf, math.inf)]
                for value in (*ends, *near, 0.0, -1.0, 1e9, math.nan, math.inf):
                    override = LimitOverride(part=part.name, mode=mode, name=name, value=value)
                    expected = is_tighter(room, value)
                    assert is_taken(pair, override) == expected, f"{override}, room {room}"


def is_foretold(pair: Pair, *overrides: LimitOverride) -> bool:
    """Whether a skill with these limits is admitted before it claims anything."""
    limits = [
        SkillLimit(
            part=override.part,
            control_mode=MODES[override.mode],
            name=override.name,
            value=override.value,
        )
        for override in overrides
    ]
    return not override_problems(limits, json.loads(pair.config.read_text()))


def test_a_skill_is_told_beforehand_exactly_what_the_gate_will_say(pair: Pair) -> None:
    for index, part in enumerate(pair.file.parts):
        for mode in part.modes:
            for name, room in tightenable(pair.file, index, mode).items():
                middle = LimitOverride(
                    part=part.name, mode=mode, name=name, value=(room.lowest + room.highest) / 2
                )
                ends = (room.lowest, middle.value, room.highest)
                near = [math.nextafter(end, to) for end in ends for to in (-math.inf, math.inf)]
                for value in (*ends, *near, 0.0):
                    for other in {name, _opposite(name)}:
                        asked = LimitOverride(part=part.name, mode=mode, name=other, value=value)
                        for overrides in ((asked,), (middle, asked)):
                            taken = is_taken(pair, *overrides)
                            assert is_foretold(pair, *overrides) == taken, overrides


def _opposite(name: str) -> str:
    """The other end of a range; what is no end has none."""
    if name.startswith("lower"):
        return name.replace("lower", "upper")
    return name.replace("upper", "lower")


@pytest.mark.parametrize("name", ["source", "frames", "", "speed"])
def test_a_claim_that_names_what_is_no_limit_is_refused(pair: Pair, name: str) -> None:
    for part in pair.file.parts:
        for mode in part.modes:
            override = LimitOverride(part=part.name, mode=mode, name=name, value=1e-3)
            assert not is_taken(pair, override)
