"""How many files and lines of the gate decide what is released.

    python -m bench.gate_size          the numbers
    python -m bench.gate_size --list   each file

Counted are the files of the core that docs/reading-the-gate.md names, all that these include, and
the sources of all headers among them; without configuration checks, claim admission and monitors.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SAFETY = ROOT / "services/safety"
PAGE = ROOT / "docs/reading-the-gate.md"
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
LEFT_OUT = ("core/limits/validat", "core/gate/admission", "core/gate/limit_overrides")
MONITORS = "core/monitor/"


def place_of(name: str) -> Path:
    """The file that an include names."""
    return SAFETY / ("include" if name.startswith("fairlead_safety/") else "src") / name


def name_of(path: Path) -> str:
    """How a file is, or would be, included."""
    root = "include" if path.is_relative_to(SAFETY / "include") else "src"
    return path.relative_to(SAFETY / root).as_posix()


def decides(name: str) -> bool:
    """Whether a file is of the core and counts."""
    of_core = name.startswith(("core/", "fairlead_safety/"))
    return of_core and not name.startswith((*LEFT_OUT, MONITORS))


def includes(name: str) -> list[str]:
    """What a file includes of the gate."""
    return INCLUDE.findall(place_of(name).read_text())


def sources() -> dict[str, list[str]]:
    """By header, its sources: of its name, or without a header of their own name."""
    found: dict[str, list[str]] = {}
    for path in sorted((SAFETY / "src/core").rglob("*.cpp")):
        name = name_of(path)
        own = [h for h in includes(name) if Path(h).stem == path.stem]
        for header in own or includes(name):
            found.setdefault(header, []).append(name)
    return found


def closure(starts: Iterator[str] | list[str]) -> set[str]:
    """All files that decide, from some on."""
    by_header = sources()
    found: set[str] = set()
    left = [name for name in starts if decides(name)]
    while left:
        name = left.pop()
        if name in found:
            continue
        found.add(name)
        needed = includes(name) + by_header.get(name, [])
        left += [one for one in needed if decides(one)]
    return found


def lines(names: set[str]) -> int:
    """Lines of all of them."""
    return sum(place_of(name).read_text().count("\n") for name in names)


def named_on_the_page() -> list[str]:
    """Files that docs/reading-the-gate.md names."""
    return re.findall(r"^ *([\w/]+\.cpp) ", PAGE.read_text(), re.M)


def summary(names: set[str]) -> str:
    """Both numbers, as the page has them."""
    return f"{len(names)} files, {lines(names)} lines"


def main() -> None:
    """Print what was counted."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.gate_size",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--list", action="store_true", help="each file with its lines")
    found = closure(named_on_the_page())
    if parser.parse_args().list:
        for name in sorted(found):
            print(f"{lines({name}):5} {name}")
    print(summary(found))


if __name__ == "__main__":
    main()
