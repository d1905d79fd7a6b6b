"""The gate's core against a second mind: thousands of chunks, verdict and evidence compared.

A failure prints the smallest case that shows it, and the seed and number that draw it again.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fairlead.messages import Outcome
from tests.differential.campaign import Campaign, run_campaign
from tests.differential.gates import Pair, pair_of

SEED = 20261121
COUNT = 800
LONG_COUNT = 40_000
# Without G022: the steps of panda_mobile admit a full reversal, only a claim's own do not.
ROW_CODES = (0, 6, 7, 8, 9, 11, 12, 20, 21)


@pytest.fixture(scope="session")
def campaign(pair: Pair) -> Campaign:
    """The same cases in every run."""
    print(f"seed {SEED}")
    return run_campaign(pair, SEED, COUNT)


@pytest.mark.processes
def test_gate_and_reference_agree_on_every_verdict_and_its_evidence(campaign: Campaign) -> None:
    assert not campaign.disagreements, "\n".join(campaign.disagreements)


@pytest.mark.processes
def test_the_cases_reach_every_outcome_and_every_check_of_rows(campaign: Campaign) -> None:
    assert min(campaign.codes[code] for code in ROW_CODES) >= 2, campaign.codes
    assert min(campaign.outcomes[outcome] for outcome in Outcome) >= 50, campaign.outcomes


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", [1, 2])
def test_gate_and_reference_agree_on_very_many_chunks(pair: Pair, seed: int) -> None:
    found = run_campaign(pair, seed, LONG_COUNT).disagreements
    assert not found, "\n".join(found)


@pytest.mark.processes
def test_a_gate_with_one_other_limit_is_found_out(panda: Pair, tmp_path: Path) -> None:
    data = json.loads(panda.config.read_text())
    data["joints"][3]["velocity_limit"] *= 1.001
    other = tmp_path / "gate.json"
    other.write_text(json.dumps(data))
    with pair_of("panda", other) as changed:
        mixed = replace(panda, core=changed.core)
        assert run_campaign(mixed, SEED, COUNT).disagreements
