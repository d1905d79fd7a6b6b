"""A person's URDF as XML."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

from fairlead.errors import ConfigError, expected
from fairlead.robot.gate_capacity import MOST
from fairlead_tools.draft.source_model import WHO

_MOST_MOVING = MOST["joints"] + MOST["passive_joints"]
_RUN_XACRO = "xacro is not a URDF yet: run xacro first"


def read_urdf(path: Path) -> ET.Element:
    """The URDF's ``<robot>``.

    Raises:
        ConfigError: there is no such file, or it is no URDF, or one that is still xacro; its links
            and joints have no names of their own, are a ring, or more than a gate has room for.
    """
    who = f"{WHO}: --urdf: {path}"
    try:
        root = ET.parse(path).getroot()  # noqa: S314 - the person's own file
    except OSError as error:
        raise ConfigError(f"{who}: cannot be read: {error.strerror}") from None
    except (ET.ParseError, LookupError, ValueError) as error:
        hint = f"; {_RUN_XACRO}" if ".xacro" in path.suffixes else ""
        raise ConfigError(f"{who}: cannot be read as XML: {error}{hint}") from None
    if root.tag != "robot":
        hint = ": give it as --mjcf" if root.tag == "mujoco" else ""
        raise ConfigError(expected(who, "<robot>", f"<{root.tag}>{hint}"))
    for one in root.iter():
        space, _, tag = one.tag.rpartition("}")
        words = [word for word in one.attrib.values() if "${" in word or "$(" in word]
        if space.endswith("xacro") or words:  # of its namespace's several addresses
            got = words[0] if words else f"<xacro:{tag}>"
            raise ConfigError(expected(who, "no xacro", f"{got}; {_RUN_XACRO}"))
    _check_tree(who, root)
    return root


def _check_tree(who: str, root: ET.Element) -> None:
    names = {
        kind: [one.get("name", "") for one in root.findall(kind)] for kind in ("link", "joint")
    }
    for kind, given in names.items():
        for name, times in Counter(given).items():
            if not name:
                raise ConfigError(expected(who, f"a name for each {kind}", "none"))
            if times > 1:
                raise ConfigError(f"{who}: {kind} {name!r} is declared {times} times")
    if names["link"] and set(names["link"]) <= {one.get("link") for one in root.iter("child")}:
        raise ConfigError(expected(who, "one link that hangs on no joint", "none: they are a ring"))
    moving = sum(one.get("type") != "fixed" and one.find("mimic") is None
                 for one in root.findall("joint"))  # fmt: skip
    if moving > _MOST_MOVING:
        raise ConfigError(expected(who, f"at most {_MOST_MOVING} joints that move", moving))
