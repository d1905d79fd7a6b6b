"""Skills that a robot which is about to start will not be able to see for."""

from __future__ import annotations

from collections.abc import Iterator

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import state_problems
from fairlead.skill.manifest import load_skill, skill_ids


def dropped_skills(deployment: Deployment, runner: str) -> Iterator[str]:
    """A line for each skill that a runner offers whose state vector nothing can fill.

    Raises:
        ConfigError: if the deployment asks by its name for such a skill, or one that does not load.
    """
    robot = load_robot(deployment.robot)
    listed = deployment.services[runner].options.get("skills")
    wanted = listed if isinstance(listed, list) else None
    for name in skill_ids() if wanted is None else wanted:
        try:
            skill = load_skill(name)
        except ConfigError:
            if wanted is not None:
                raise
            continue  # the runner leaves it out, and says what is wrong with the file
        problems = state_problems(skill.state_contract, robot)
        if not problems or (wanted is None and robot.id not in skill.embodiments):
            continue
        reasons = "".join(f"\n  {problem}" for problem in problems)
        if wanted is not None:
            raise ConfigError(f"skill {name} cannot run on robot {robot.id}:{reasons}")
        yield f"{runner}: skill {name} is dropped, it cannot run on robot {robot.id}:{reasons}"
