"""Runs skills: a process, started by ``python -m fairlead_skill_runner``.

The names below are for fairlead's own tools. A goal is given through `fairlead.RobotClient`, and a
policy of one's own is a class in the skill's folder (docs/my-first-skill.md).
"""

from fairlead_skill_runner.candidate import dispatch
from fairlead_skill_runner.policies.backends import check_policy_options, policy_class
from fairlead_skill_runner.trace import TraceRecord, read_trace

__all__ = ["TraceRecord", "check_policy_options", "dispatch", "policy_class", "read_trace"]
