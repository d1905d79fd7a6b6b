"""Many cases of one robot: where the two judges differ, and what the cases reached."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from bench.equipment.case import Case
from bench.equipment.core_gate import CaseRefusedError
from fairlead.messages import Outcome
from tests.differential.chunks import CaseMaker
from tests.differential.comparison import differences, readable, rulings, smallest
from tests.differential.gates import Pair

REPORTED = 3


@dataclass
class Campaign:
    """disagreements: as text, the first few. codes, outcomes: of the judged chunks."""

    disagreements: list[str] = field(default_factory=list)
    codes: Counter[int] = field(default_factory=Counter)
    outcomes: Counter[Outcome] = field(default_factory=Counter)


def run_campaign(pair: Pair, seed: int, count: int) -> Campaign:
    """Draw ``count`` cases; stops at the third disagreement."""
    maker = CaseMaker(pair.robot, pair.file, seed)
    campaign = Campaign()
    for number in range(count):
        case = maker.draw()
        expected = rulings(pair.file, case)
        fault = expected[-1].fault
        campaign.codes[fault.code if fault else 0] += 1
        campaign.outcomes[expected[-1].outcome] += 1
        try:
            found = differences(pair.file, case, expected, pair.answers(case))
        except CaseRefusedError as refusal:
            text = f"refused before any chunk: {refusal}"
            campaign.disagreements.append(f"seed {seed}, case {number}: {text}")
            continue
        if found:
            text = _least(pair, case)
            campaign.disagreements.append(f"seed {seed}, case {number}: {text}")
        if len(campaign.disagreements) == REPORTED:
            break
    return campaign


def _least(pair: Pair, case: Case) -> str:
    """The smallest case that still shows the same kind of disagreement."""
    kind = pair.signature(case)
    least = smallest(case, lambda other: pair.signature(other) == kind)
    return readable(least, pair.differences(least))
