"""Which class stands behind the name of a policy backend in a manifest."""

from __future__ import annotations

import importlib

from fairlead.errors import ConfigError
from fairlead_skill_runner.policies.protocol import Policy

POLICIES = {
    "oracle": "fairlead_skill_runner.policies.oracle.policy:OraclePolicy",
    "joint_reach": "fairlead_skill_runner.policies.joint_reach:JointReachPolicy",
    "go_to": "fairlead_skill_runner.policies.go_to:GoToPolicy",
    "replay": "fairlead_skill_runner.policies.replay:ReplayPolicy",
    "python": "fairlead_skill_runner.policies.python_file:PythonFilePolicy",
    "constant": "fairlead_skill_runner.policies.constant:ConstantPolicy",
    "openpi": "fairlead_skill_runner.policies.remote.openpi:OpenpiPolicy",
    "rldx_zmq": "fairlead_skill_runner.policies.remote.rldx_zmq:RldxZmqPolicy",
}
"""Backend name in a manifest -> ``module:Class``, so that only the worker imports it."""


def policy_class(path: str) -> type[Policy]:
    """Import the class at ``module:Class``.

    Raises:
        ConfigError: if there is no such module or class.
    """
    module, _, name = path.partition(":")
    try:
        found: type[Policy] = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ConfigError(f"policy {path}: cannot be imported: {error}") from None
    return found
