"""What installed packages add to fairlead: entry points, found without importing anything.

A package registers a HAL, a policy or a layout under a name in its ``pyproject.toml``, and a
folder of robots, skills and deployment files; what ships with fairlead is registered the same
way. Looking a name up reads the installed packages' metadata only. The object behind it is
imported when it is used, so a package that is broken is in nobody's way until then.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint, distributions
from importlib.util import find_spec
from pathlib import Path

from fairlead.errors import ConfigError, expected

_MARK = "[fairlead."
_LOG = logging.getLogger("fairlead.plugins")


@dataclass(frozen=True)
class Plugin:
    """One registered name.

    Attributes:
        what: what it names, for errors: ``layout``.
        value: ``module:object`` as the package wrote it.
        package: name and version of the distribution.
    """

    what: str
    name: str
    value: str
    package: str

    @property
    def who(self) -> str:
        """How errors call it."""
        return f"{self.what} {self.name!r} of {self.package}"

    @property
    def ships(self) -> bool:
        """Whether it is fairlead's own."""
        return self.package.partition(" ")[0] == "fairlead"

    def folder(self) -> Path | None:
        """The package or folder in a package that `value` names; None if there is none.

        Nothing is imported.
        """
        top, *below = self.value.split(".")
        try:
            found = find_spec(top)
        except (ImportError, ValueError):
            return None
        places = found.submodule_search_locations if found is not None else None
        folders = (Path(place, *below) for place in places or ())
        return next((folder for folder in folders if folder.is_dir()), None)

    def load(self) -> object:
        """Import the object.

        Raises:
            ConfigError: naming the package, if anything at all goes wrong.
        """
        try:
            return EntryPoint(self.name, self.value, "fairlead").load()
        except (Exception, SystemExit) as error:
            raise ConfigError(
                f"{self.who}: {self.value} cannot be imported: {type(error).__name__}: {error}; "
                "mend or uninstall that package"
            ) from error

    def refuse(self, wanted: str, got: object) -> ConfigError:
        """The error for an object that is not what its group is for."""
        return ConfigError(expected(f"{self.who}: {self.value}", wanted, _brief(got)))


@dataclass(frozen=True)
class PluginGroup:
    """One kind of plug-in.

    Attributes:
        group: of its entry points.
        what: what one is called.
    """

    group: str
    what: str

    def every(self) -> tuple[Plugin, ...]:
        """Every registered plug-in, by package and name."""
        return tuple(sorted(self._plugins(), key=lambda one: (one.package, one.name)))

    def names(self) -> tuple[str, ...]:
        """Every registered name, sorted."""
        return tuple(sorted({one.name for one in self._plugins()}))

    def find(self, name: str, who: str = "") -> Plugin:
        """The plug-in of a name; nothing is imported.

        Args:
            who: who asks for it, as the error begins.

        Raises:
            ConfigError: nobody registers it, with every name and where it comes from; or two
                packages do.
        """
        found = [one for one in self._plugins() if one.name == name]
        if not found:
            unknown = f"expected a {self.what}, got {name!r} ({self.choices()})"
            raise ConfigError(f"{who}: {unknown}" if who else unknown)
        if len(found) > 1:
            owners = " and ".join(one.package for one in found)
            raise ConfigError(f"{self.what} {name!r}: {owners} register it; uninstall one of them")
        return found[0]

    def choices(self) -> str:
        """What is valid, and where each comes from: ``valid: a, b from p 1.0; c from q 2.0``."""
        by_package: dict[str, list[str]] = {}
        for one in self._plugins():
            by_package.setdefault(one.package, []).append(one.name)
        listed = [f"{', '.join(sorted(n))} from {p}" for p, n in sorted(by_package.items())]
        text = "valid: " + "; ".join(listed)
        if not listed:
            text = "none is registered: install fairlead again, in a checkout with scripts/setup"
        return text

    def _plugins(self) -> Iterator[Plugin]:
        for package, entry in _registered():
            if entry.group == self.group:
                yield Plugin(self.what, entry.name, entry.value, package)


HALS = PluginGroup("fairlead.hals", "HAL")
LAYOUTS = PluginGroup("fairlead.layouts", "layout")
POLICIES = PluginGroup("fairlead.policies", "policy backend")
DATA = PluginGroup("fairlead.data", "folder of data")


@functools.cache
def _registered() -> tuple[tuple[str, EntryPoint], ...]:
    """Every entry point of ours with its package; read once a process."""
    found: dict[str, list[tuple[str, EntryPoint]]] = {}
    for distribution in distributions():
        try:
            if _MARK in (distribution.read_text("entry_points.txt") or ""):
                name = distribution.metadata["Name"]
                package = f"{name} {distribution.version}"
                # The first on the path is the one that is imported; others are older copies.
                entries = [(package, entry) for entry in distribution.entry_points]
                found.setdefault(name.lower().replace("_", "-"), entries)
        except Exception as error:  # noqa: BLE001 - half removed, say; of whatever kind
            where = getattr(distribution, "_path", distribution.locate_file(""))
            _LOG.warning("%s: not read, install or remove that package anew: %r", where, error)
    return tuple(one for entries in found.values() for one in entries)


@functools.cache
def data_folders() -> tuple[Path, ...]:
    """Where installed packages have ``robots/``, ``rskills/`` and ``compose/``, in fixed order."""
    folders = (one.folder() for one in DATA.every())
    return tuple(folder for folder in folders if folder is not None)


def _brief(got: object) -> str:
    text = repr(got)
    return text if len(text) <= 80 else f"{text[:77]}..."
