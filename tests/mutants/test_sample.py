"""A fixed sample of mutants, every one of which a test must notice; make mutate hunts them all."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from bench.mutants.__main__ import key_of, reviewed
from bench.mutants.hunt import Fate, hunt
from bench.mutants.population import CORE, ROOT, TESTS, populate

SAFETY = ROOT / "services/safety"
BUILT = ROOT / "build/safety"
FILES = ("release/claim_table.cpp", "chunk/shape.cpp", "gate/limit_overrides.cpp")
EVERY = 8


def compile_and_link(texts: dict[str, str], folder: Path) -> Path:
    """The built tests, linked with mutated objects before the library that has the true ones."""
    compiler = [os.environ.get("CXX", "c++"), "-std=c++20", "-O1", "-w", "-fpermissive"]
    eigen = re.search(r"^EIGEN_INCLUDE:\w+=(.+)$", (BUILT / "CMakeCache.txt").read_text(), re.M)
    assert eigen
    folders = [SAFETY / name for name in ("include", "src", "test")]
    include = [f"-I{folder}" for folder in (*folders, eigen[1])]
    running = []
    for name in FILES:
        file = folder / Path(name).name
        file.write_text(texts[name])
        running.append(subprocess.Popen([*compiler, *include, "-c", file], cwd=folder))
    runtime = SAFETY / "test/mutants/mutant.cpp"
    running.append(subprocess.Popen([*compiler, *include, "-c", runtime], cwd=folder))
    assert [one.wait(timeout=120) for one in running] == [0] * len(running)
    objects = sorted((BUILT / f"CMakeFiles/{TESTS}.dir/test").rglob("*.o"))
    libraries = [BUILT / f"libfairlead_safety_{part}.a" for part in ("shell", "core")]
    mutated = sorted(folder.glob("*.o"))
    command = [*compiler, *objects, *mutated, *libraries, "-pthread", "-o", folder / TESTS]
    subprocess.run([str(word) for word in command], check=True, timeout=120)
    return folder / TESTS


@pytest.mark.soak
@pytest.mark.processes
def test_every_mutant_of_a_fixed_sample_is_noticed(tmp_path: Path) -> None:
    """Not in make test: each edit of these files draws another sample, whose survivors are new."""
    population = populate(FILES)
    known = [key for entries in reviewed().values() for key in entries]
    sample = {
        number: mutant.file
        for number, mutant in population.mutants.items()
        if number % EVERY == 0 and key_of(mutant) not in known
    }
    assert len(sample) > 20
    fates = hunt(compile_and_link(population.texts, tmp_path), sample, jobs=2)
    alive = [
        population.mutants[number]
        for number, fate in fates.items()
        if fate not in (Fate.KILLED, Fate.TIMED_OUT)
    ]
    assert alive == []


@pytest.mark.parametrize(
    "name", sorted(path.relative_to(CORE).as_posix() for path in CORE.rglob("*.cpp"))
)
def test_every_source_of_the_core_has_mutants_of_its_own(name: str) -> None:
    population = populate((name,))
    assert population.texts[name] != (CORE / name).read_text()
    assert {mutant.file for mutant in population.mutants.values()} == {name}
