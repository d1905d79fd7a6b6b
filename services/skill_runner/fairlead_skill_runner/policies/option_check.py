"""Whether a manifest's ``policy.options`` fit its policy; no server is asked, no file is run."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pydantic import JsonValue

from fairlead.skill.manifest import SkillManifest
from fairlead.skill.python_policy import python_policy_options
from fairlead_skill_runner.policies.constant import ConstantPolicy
from fairlead_skill_runner.policies.go_to import check_go_to
from fairlead_skill_runner.policies.joint_reach import JointReachPolicy
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy
from fairlead_skill_runner.policies.remote.openpi import check_openpi_options
from fairlead_skill_runner.policies.remote.rldx_zmq import check_rldx_options
from fairlead_skill_runner.policies.replay import ReplayPolicy

CHECKS: Mapping[str, Callable[[SkillManifest, Mapping[str, JsonValue]], object]] = {
    "oracle": OraclePolicy.from_options,
    "joint_reach": JointReachPolicy.from_options,
    "go_to": check_go_to,
    "replay": ReplayPolicy.from_options,
    "constant": ConstantPolicy.from_options,
    "openpi": check_openpi_options,
    "rldx_zmq": check_rldx_options,
    "python": lambda skill, options: python_policy_options(options),
}
"""Policy backend -> what raises `ConfigError` for options that do not fit."""


def check_policy_options(skill: SkillManifest) -> None:
    """Let the options of a skill's policy pass if they fit.

    Raises:
        ConfigError: naming every option that does not.
    """
    CHECKS[skill.policy.backend](skill, skill.policy.options)
