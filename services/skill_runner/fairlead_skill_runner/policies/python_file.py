"""A policy of the user's own: a class in a Python file of the skill's folder."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

from pydantic import JsonValue

from fairlead.errors import ConfigError, expected
from fairlead.paths import rskill_dir
from fairlead.policy import Policy
from fairlead.reason_text import words_of
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.python_policy import python_policy_options
from fairlead_skill_runner.policies.probe import ask_once


class PythonFilePolicy:
    """Finds the user's class; what it builds is the policy itself, without a wrapper."""

    takes_states = True

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit; the file is not looked at."""
        python_policy_options(options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Policy:
        """Run the file (in the policy's own process), build its class and ask it once.

        Raises:
            ConfigError: for options that do not fit, and a file that cannot be run.
            PolicyError: it raises, or answers with no rows of the skill's.
        """
        wanted = python_policy_options(options)
        path = wanted.path(rskill_dir(skill.id))
        found = getattr(_run_file(path), wanted.class_name, None)
        if not isinstance(found, type):
            who, what = f"python policy: {path}", f"a class {wanted.class_name}"
            raise ConfigError(expected(who, what, repr(found)))
        build: type[Policy] = found
        policy = build.from_options(skill, wanted.options)
        if wanted.probe:
            ask_once(f"python policy: {path}", policy, skill, "policy.options: probe: false")
        return policy


def _run_file(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"fairlead_user_policy_{path.stem}", path)
    assert spec is not None and spec.loader is not None  # a .py file always has a loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ConfigError(f"python policy: {path}: {words_of(error)}") from error
    return module
