"""Runs skills: a process, started by ``python -m fairlead_skill_runner``.

Nothing in here is for others to import; a goal is given through `fairlead.RobotClient`,
and a policy of one's own is a class in the skill's folder (docs/my-first-skill.md).
"""

__all__: list[str] = []
