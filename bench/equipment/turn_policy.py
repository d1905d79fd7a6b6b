"""A skill's own policy, which asks before each answer whether it may give it."""

from __future__ import annotations

from collections.abc import Mapping
from multiprocessing.connection import Client
from typing import Any, Self

from fairlead.plugins import POLICIES
from fairlead.policy import Actions, Done, Failed, Observation, Policy
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner import policy_class


class TurnPolicy:
    """options: the ``policy`` behind it, as in rskill.yaml; ``address`` of `turns.Turns`."""

    def __init__(self, policy: Policy, address: str) -> None:
        self._policy, self._turns = policy, Client(address, "AF_UNIX")

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        """Build the policy behind it and connect."""
        policy = options["policy"]
        kind = policy_class(POLICIES.find(policy["backend"]))
        return cls(kind.from_options(skill, policy.get("options", {})), options["address"])

    def reset(self) -> None:
        """Of the policy."""
        self._policy.reset()

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        """The policy's answer, once it is our turn."""
        self._turns.send_bytes(b"")
        self._turns.recv_bytes()
        return self._policy.infer(observation)
