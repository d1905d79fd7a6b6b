"""The ``options`` of a skill whose policy is a Python class in the skill's own folder.

Nothing here runs that file: it is executed only in the policy's own process.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected

BACKEND = "python"
METHODS = ("from_options", "infer", "reset")


class PythonPolicyOptions(BaseModel):
    """Which class, and what it is handed.

    Attributes:
        file: in the skill's folder.
        class_name: ``class``: its name there.
        options: handed to the class.
        probe: whether it is asked once as it is loaded, so that rows of another shape are known
            before there is a claim; false for a policy whose ``infer`` does more than answer.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: str = Field(pattern=r"^[^/\\]+\.py$")
    class_name: str = Field(alias="class", pattern=r"^[A-Za-z_]\w*$")
    options: dict[str, JsonValue] = Field(default_factory=dict)
    probe: bool = True

    def path(self, folder: Path) -> Path:
        """The file in a skill's folder.

        Raises:
            ConfigError: it is not there, or a link leads out of the folder.
        """
        path = folder / self.file
        if not path.is_file() or path.resolve().parent != folder.resolve():
            raise ConfigError(f"python policy: no file {self.file} in {folder}")
        return path


def python_policy_options(options: Mapping[str, JsonValue]) -> PythonPolicyOptions:
    """Check a manifest's ``policy.options``.

    Raises:
        ConfigError: naming every field that does not fit.
    """
    return checked_model("python policy: options", PythonPolicyOptions, options)


def check_python_policy(folder: Path, options: Mapping[str, JsonValue]) -> None:
    """Read, without running it, whether the file has the class, and that its methods.

    Raises:
        ConfigError: naming what is missing.
    """
    wanted = python_policy_options(options)
    path = wanted.path(folder)
    try:
        tree = ast.parse(path.read_bytes(), filename=str(path))
    except (SyntaxError, ValueError) as error:
        raise ConfigError(f"python policy: {path}: {error}") from None
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    found = classes.get(wanted.class_name)
    if found is None:
        who, what = f"python policy: {path}", f"a class {wanted.class_name}"
        raise ConfigError(expected(who, what, "none", classes or ["no class at all"]))
    has = {node.name for node in found.body if isinstance(node, ast.FunctionDef)}
    missing = [name for name in METHODS if name not in has]
    if missing and not found.bases:  # a base class may bring them
        raise ConfigError(
            f"python policy: {path}: class {wanted.class_name} lacks {', '.join(missing)}"
        )
