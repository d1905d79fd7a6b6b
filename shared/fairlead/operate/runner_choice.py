"""Which of a deployment's runners a goal is for."""

from __future__ import annotations

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, expected


def choose_runner(deployment: Deployment, skill: str, named: str = "") -> str:
    """The runner ``named``, else the only one for ``skill``.

    A runner whose ``skills`` name the skill goes before one that offers whatever is made for
    the robot.

    Raises:
        ConfigError: there is no such runner, or not exactly one for the skill.
    """
    runners = deployment.runners
    if not runners:
        raise ConfigError(
            f"deployment {deployment.id}: has no skill_runner, so it runs no skills; a program of "
            "your own can claim parts: docs/navigation.md"
        )
    if named:
        if named not in runners:
            who = f"deployment {deployment.id}"
            raise ConfigError(expected(who, "a runner", repr(named), runners))
        return named
    if len(runners) == 1:
        return runners[0]  # which says itself what it offers
    listed = {name: deployment.services[name].options.get("skills") for name in runners}
    able = [name for name, skills in listed.items() if skills is not None and skill in skills]
    able = able or [name for name, skills in listed.items() if skills is None]
    if len(able) == 1:
        return able[0]
    if able:
        raise ConfigError(
            f"skill {skill}: {' and '.join(able)} can run it; choose one: --runner {able[0]}"
        )
    offers = "; ".join(f"{name}: {', '.join(skills or ())}" for name, skills in listed.items())
    raise ConfigError(f"skill {skill}: no runner of {deployment.id} offers it ({offers})")
