"""Runs skills: a process, started by ``python -m fairlead_skill_runner``.

The names below are for fairlead's own tools. A goal is given through `fairlead.RobotClient`, and a
policy of one's own is a class in the skill's folder (docs/my-first-skill.md).
"""

from fairlead_skill_runner.action_rows import policy_rows
from fairlead_skill_runner.candidate import dispatch
from fairlead_skill_runner.fitted_rows import fitted
from fairlead_skill_runner.observation_buffer import ObservationBuffer
from fairlead_skill_runner.options import RunnerOptions
from fairlead_skill_runner.picture import as_declared, pixels_of
from fairlead_skill_runner.policies.backends import check_policy_options, policy_class
from fairlead_skill_runner.policies.onnx_files import action_names, state_names
from fairlead_skill_runner.policy_server import PolicyServer, served_policy
from fairlead_skill_runner.trace import TraceRecord, picture_hashes, read_trace

__all__ = [
    "ObservationBuffer",
    "PolicyServer",
    "RunnerOptions",
    "TraceRecord",
    "action_names",
    "as_declared",
    "check_policy_options",
    "dispatch",
    "fitted",
    "picture_hashes",
    "pixels_of",
    "policy_class",
    "policy_rows",
    "read_trace",
    "served_policy",
    "state_names",
]
