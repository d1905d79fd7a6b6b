"""A person's URDF as XML."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from fairlead.errors import ConfigError, expected
from fairlead_tools.draft.source_model import WHO

_RUN_XACRO = "xacro is not a URDF yet: run xacro first"


def read_urdf(path: Path) -> ET.Element:
    """The URDF's ``<robot>``.

    Raises:
        ConfigError: there is no such file, or it is no URDF, or one that is still xacro.
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
    return root
