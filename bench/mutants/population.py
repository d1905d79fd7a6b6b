"""All mutants of the core: written into one set of sources, built into one program."""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from bench.mutants.mutations import Mutant, Mutations, checked_functions, storage_sizes

ROOT = Path(__file__).resolve().parents[2]
TESTS = "fairlead-safety-tests"
CORE = ROOT / "services/safety/src/core"
HEADERS = ROOT / "services/safety/include/fairlead_safety"
MACROS = ROOT / "services/safety/test/mutants/mutant.hpp"
BLOCK = 400  # numbers for each file: those of one stay as they are when another changes
INDEXED = ("fixed.hpp", "messages.hpp")


@dataclass(frozen=True)
class Population:
    """The mutants by id (from 1), and each file's text with them in it."""

    mutants: dict[int, Mutant]
    texts: dict[str, str]


def populate(files: tuple[str, ...] = ()) -> Population:
    """Mutate the core, or only some files of it by name."""
    paths = sorted(CORE.rglob("*.?pp"))
    sources = {path.relative_to(CORE).as_posix(): path.read_text() for path in paths}
    checked = checked_functions(list(sources.values()))
    sizes = storage_sizes(list(sources.values()))
    mutants: dict[int, Mutant] = {}
    texts = dict(sources)
    for index, (name, source) in enumerate(sources.items()):
        if files and name not in files:
            continue
        first = 1 + index * BLOCK
        found = Mutations(name, source, checked, sizes, first)
        assert len(found.mutants) <= BLOCK, name
        mutants.update(enumerate(found.mutants, start=first))
        texts[name] = found.text()
    room = re.search(r"unsigned most = ([\d']+);", MACROS.read_text())
    most = int(room[1].replace("'", "")) if room else 0
    assert max(mutants, default=0) < most, f"{MACROS} has room for {most} only"
    return Population(mutants, texts)


def bounded(header: str) -> str:
    """A container that ends the process when it is read beyond its end."""
    pattern = r"operator\[\]\(std::size_t i\)(?: const)? \{"
    text, count = re.subn(pattern, r"\g<0> if (i >= size()) __builtin_trap();", header)
    assert count > 0
    return text


def write(population: Population, folder: Path) -> None:
    """The sources into a folder; files that are as they were keep their time."""
    bounds = {
        f"../include/fairlead_safety/{name}": bounded((HEADERS / name).read_text())
        for name in INDEXED
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (population.texts | bounds).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def build(population: Population, build_dir: Path) -> Path:
    """The test program with every mutant in it."""
    core = build_dir / "mutated/core"
    write(population, core)
    jobs = {"FAIRLEAD_BUILD_JOBS": os.environ.get("FAIRLEAD_BUILD_JOBS", "2")}
    subprocess.run(
        [
            *(ROOT / "scripts/build-gate", "--tests", "--target", TESTS),
            *("--build-dir", build_dir, "--", "-DFAIRLEAD_SAFETY_MUTANTS=ON"),
            f"-DFAIRLEAD_CORE_DIR={core}",
        ],
        env=os.environ | jobs,
        check=True,
    )
    return build_dir / TESTS
