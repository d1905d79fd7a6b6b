"""A policy of one's own is asked once as it is loaded: what it answers wrongly comes out then."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from pathlib import Path

import numpy as np
import pytest
import pytest_asyncio

from fairlead.errors import PolicyError
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_tools.skills.skeleton import skill_skeleton

pytestmark = [pytest.mark.processes, pytest.mark.asyncio]

Loaded = Callable[[dict[str, str]], PolicyWorker]


@pytest_asyncio.fixture
async def worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Loaded]:
    """Makes the worker of a new skill, some of whose text is replaced."""
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    (tmp_path / "mine").mkdir()
    made: list[PolicyWorker] = []

    def make(changes: dict[str, str]) -> PolicyWorker:
        for name, text in skill_skeleton("mine", load_robot("panda_mobile")).items():
            for old, new in changes.items():
                text = text.replace(old, new)
            (tmp_path / "mine" / name).write_text(text, encoding="utf-8")
        skill = load_skill("mine")
        plugin = POLICIES.find(skill.policy.backend)
        made.append(PolicyWorker(plugin, skill, skill.policy.options))
        return made[-1]

    yield make
    for one in made:
        await one.close()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("return actions", "return actions[:, 1:]",
         r"expected actions as floats \[1 to 8, 6\], got float32 \[8, 5\]"),
        ("actions = np", "actions = nb", "NameError: name 'nb' is not defined"),
        ("return actions", "raise SystemExit", "SystemExit"),
        ("row = obs", "observation.state[0] = 0; row = obs", "destination is read-only"),
    ],
)  # fmt: skip
async def test_a_policy_that_answers_a_probe_wrongly_is_not_loaded_but_where_it_wants_none(
    worker: Loaded, old: str, new: str, said: str
) -> None:
    wanted = rf"policy\.py: asked with a probe observation: .*{said}.*\n  .*probe: false"
    with pytest.raises(PolicyError, match=wanted):
        await worker({old: new}).load()
    await worker({old: new, "class: Policy": "class: Policy\n    probe: false"}).load()


async def test_an_episode_sees_nothing_of_the_probe_which_is_an_episode_too(
    worker: Loaded,
) -> None:
    asked = worker(
        {
            "        self.reset()\n": "",  # what it remembers is made by reset alone
            "self.begun = None": "self.begun, self.calls = None, 0",
            "        row = obs": "        self.calls += 1\n        row = obs",
            "return actions": "return actions * 0 + self.calls",
        }
    )
    await asked.load()
    first = await asked.infer(Observation(tick=1, state=np.zeros(9), prompt="wave"))
    assert isinstance(first, np.ndarray) and first[0, 0] == 1.0
