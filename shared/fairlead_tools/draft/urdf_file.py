"""A person's URDF as XML, and its meshes as MuJoCo reads them."""

from __future__ import annotations

import re
import shutil
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Mapping
from html import unescape
from pathlib import Path
from xml.sax.saxutils import quoteattr

from fairlead.errors import ConfigError, expected
from fairlead.regular_file import regular
from fairlead.robot.gate_file import MOST
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
        root = ET.parse(regular(path)).getroot()  # noqa: S314 - the person's own file
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


MESHES = "meshes"
"""The copies' folder in a robot's."""
_PACKAGE = "package://"
_FILENAME = re.compile(r"""(\bfilename\s*=\s*)("[^"]*"|'[^']*')""")


def copied_urdf(path: Path, folder: Path, *, with_meshes: bool) -> str:
    """The URDF's text for a robot's folder.

    Args:
        with_meshes: whether geometry comes from it: then its meshes are copied to the folder.

    Raises:
        ConfigError: it cannot be read, or a mesh is missing.
    """
    root = read_urdf(path)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ConfigError(f"{WHO}: --urdf: {path}: not a text file in UTF-8") from None
    if not with_meshes:
        return text
    copies: dict[Path, str] = {}
    named: dict[str, str] = {}
    for mesh in root.findall("link/collision/geometry/mesh"):
        name = mesh.get("filename", "")
        found = _find(path, name).resolve()
        if found not in copies:  # another folder may have a mesh of the same name
            taken = f"{len(copies)}_" if found.name in copies.values() else ""
            copies[found] = f"{taken}{found.name}"
            (folder / MESHES).mkdir(exist_ok=True)
            shutil.copyfile(found, folder / MESHES / copies[found])
        named[name] = f"{MESHES}/{copies[found]}"
    return _FILENAME.sub(lambda found: _renamed(found, named), text)


def _renamed(attribute: re.Match[str], named: Mapping[str, str]) -> str:
    copy = named.get(unescape(attribute[2][1:-1]))
    return attribute[0] if copy is None else f"{attribute[1]}{quoteattr(copy)}"


def _find(urdf: Path, named: str) -> Path:
    """A mesh by its path beside the URDF, or in its package: a folder on the way up or beside it.

    Raises:
        ConfigError: there is none; the mesh of another package is never taken for it.
    """
    if not named.startswith(_PACKAGE):
        found = urdf.parent / named.removeprefix("file://")
        if found.is_file():
            return found
        raise ConfigError(f"{WHO}: --urdf: {urdf}: no mesh {named}; put it beside the file")
    package, _, inside = named.removeprefix(_PACKAGE).partition("/")
    for parent in urdf.resolve().parents:
        for folder in (parent / package, parent):
            if (folder / inside).is_file() and (folder != parent or _is_package(parent, package)):
                return folder / inside
    what = f"{inside} in a folder {package}, or one whose package.xml has that name"
    raise ConfigError(
        f"{WHO}: --urdf: {urdf}: no mesh {named}: looked for {what}, beside the file and in each "
        "folder above it; put the package there"
    )


def _is_package(folder: Path, name: str) -> bool:
    try:
        root = ET.parse(regular(folder / "package.xml")).getroot()  # noqa: S314 - the person's own
    except (OSError, ET.ParseError, LookupError, ValueError):
        return False
    return (root.findtext("name") or "").strip() == name
