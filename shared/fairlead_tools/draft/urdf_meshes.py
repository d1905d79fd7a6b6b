"""A copy of a person's URDF, with the meshes that its links collide with where nothing else is."""

from __future__ import annotations

import shutil
from pathlib import Path

from fairlead.errors import ConfigError
from fairlead_tools.draft.joints import read_urdf
from fairlead_tools.draft.source_model import WHO

_FOLDER = "meshes"
_PACKAGE = "package://"


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
    for mesh in root.findall("link/collision/geometry/mesh"):
        named = mesh.get("filename", "")
        found = _find(path, named).resolve()
        if found not in copies:  # another folder may have a mesh of the same name
            taken = f"{len(copies)}_" if found.name in copies.values() else ""
            copies[found] = f"{taken}{found.name}"
            (folder / _FOLDER).mkdir(exist_ok=True)
            shutil.copyfile(found, folder / _FOLDER / copies[found])
        text = text.replace(f'"{named}"', f'"{_FOLDER}/{copies[found]}"')
    return text


def _find(urdf: Path, named: str) -> Path:
    """A mesh by its path beside the URDF, or in a package that the URDF lies in."""
    if not named.startswith(_PACKAGE):
        found = urdf.parent / named.removeprefix("file://")
        if found.is_file():
            return found
    inside = Path(named.removeprefix(_PACKAGE))
    for parent in urdf.resolve().parents:
        for found in (parent / inside, parent / Path(*inside.parts[1:])):
            if found.is_file():
                return found
    raise ConfigError(f"{WHO}: --urdf: {urdf}: no mesh {named}; put it beside the file")
