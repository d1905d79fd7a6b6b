"""Which class stands behind the name of a policy backend, and what it says of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from pydantic import JsonValue

from fairlead.checked_model import Locate, MisfitError, nowhere
from fairlead.errors import ConfigError, expected
from fairlead.plugins import POLICIES, Plugin
from fairlead.policy import Policy, ServerAddress
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.deltas import NOW
from fairlead.skill.manifest import SkillManifest, find_backend, of_options
from fairlead_skill_runner.policies.probe import ask_once

PlannerMaker = Callable[[SkillManifest, Mapping[str, JsonValue], RobotManifest, str], Policy]
"""``for_robot`` of a `fairlead.policy.PolicyOfRobot`."""


def policy_class(plugin: Plugin) -> type[Policy]:
    """Import a policy's class.

    Raises:
        ConfigError: naming its package, if it cannot be imported or is no policy.
    """
    found = plugin.load()
    is_made = hasattr(found, "from_options") or hasattr(found, "for_robot")
    if not isinstance(found, type) or not is_made:
        raise plugin.refuse("a class with from_options (fairlead.policy.Policy)", found)
    return found


def make_policy(
    plugin: Plugin,
    skill: SkillManifest,
    options: Mapping[str, JsonValue],
    robot: Callable[[], RobotManifest],
    profile: str,
) -> Policy:
    """Load a policy.

    Args:
        robot: loads the robot, for a class that asks for it.

    Raises:
        ConfigError: for options that do not fit, a seam that the policy makes itself, and earlier
            states that it does not read.
        PolicyError: it answers a probe with no rows of the skill's.
    """
    found = policy_class(plugin)
    _check_states(found, skill, plugin.name, nowhere)
    for_robot: PlannerMaker | None = getattr(found, "for_robot", None)
    if for_robot is not None:
        policy = for_robot(skill, options, robot(), profile)
    else:
        policy = found.from_options(skill, options)
    lacks = [name for name in ("infer", "reset") if not hasattr(policy, name)]
    if lacks:
        got = f"{type(policy).__name__} without {' and '.join(lacks)}"
        raise plugin.refuse("an object with infer and reset", got)
    if skill.seam is not None and getattr(policy, "continues_rows", False):
        who, wanted = f"skill {skill.id}: seam", "none, for the policy continues the rows itself"
        raise ConfigError(expected(who, wanted, f"blend_ticks: {skill.seam.blend_ticks}"))
    if not plugin.ships and getattr(found, "probe", True):
        ask_once(plugin.who, policy, skill, "probe = False in its class")
    return policy


def check_policy_options(
    skill: SkillManifest, locate: Locate = nowhere, folder: Path | None = None
) -> None:
    """Let a skill's policy pass if its backend is known and its options fit.

    No policy is loaded, no server asked, no file of the skill run.

    Args:
        locate: says the line of a place in the skill's manifest.
        folder: the skill's; its files are compared with the options too.

    Raises:
        ConfigError: naming every option that does not fit, or the backends there are.
    """
    found = policy_class(find_backend(skill.policy, locate))
    _check_states(found, skill, skill.policy.backend, locate)
    try:
        getattr(found, "check_options", _unchecked)(skill, skill.policy.options)
        if folder is not None:
            getattr(found, "check_files", _unchecked)(skill, skill.policy.options, folder)
    except MisfitError as error:
        raise ConfigError(f"policy.options: {error.located(of_options(locate))}") from None
    except ConfigError as error:
        raise ConfigError(f"{of_options(locate)(())}policy.options: {error}") from None


def _check_states(found: type[Policy], skill: SkillManifest, backend: str, locate: Locate) -> None:
    if skill.state_contract.deltas != NOW and not getattr(found, "takes_states", False):
        line = locate(("state_contract", "deltas"))
        who = f"{line}skill {skill.id}: state_contract.deltas"
        wanted = f"[0] for the backend {backend}, which sees no earlier states"
        raise ConfigError(expected(who, wanted, list(skill.state_contract.deltas)))


def _unchecked(*_: object) -> None:
    """What a policy that checks nothing beforehand says of its options."""


def server_address(backend: str) -> ServerAddress | None:
    """How the address of a backend's server is written; None for one without a server.

    Raises:
        ConfigError: as `policy_class`.
    """
    found: ServerAddress | None = getattr(
        policy_class(POLICIES.find(backend)), "server_address", None
    )
    return found
