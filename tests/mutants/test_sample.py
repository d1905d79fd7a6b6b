"""A fixed sample of mutants, every one of which a test must notice; make mutate hunts them all."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from bench.mutants.__main__ import key_of, reviewed
from bench.mutants.hunt import Fate, hunt
from bench.mutants.population import CORE, ROOT, TESTS, populate, write

SAFETY = ROOT / "services/safety"
BUILT = ROOT / "build/safety"
FILES = ("release/claim_table.cpp", "chunk/shape.cpp", "gate/limit_overrides.cpp")
EVERY = 8


def compiler_of(folders: tuple[Path, ...]) -> list[str]:
    """The compiler as for the gate, with these folders and Eigen to include from."""
    eigen = re.search(r"^EIGEN_INCLUDE:\w+=(.+)$", (BUILT / "CMakeCache.txt").read_text(), re.M)
    assert eigen
    include = [f"-I{folder}" for folder in (*folders, eigen[1])]
    return [os.environ.get("CXX", "c++"), "-std=c++20", "-O1", "-w", "-fpermissive", *include]


def compile_and_link(texts: dict[str, str], folder: Path) -> Path:
    """The built tests, linked with mutated objects before the library that has the true ones."""
    compiler = compiler_of((SAFETY / "include", SAFETY / "src", SAFETY / "test"))
    running = []
    for name in FILES:
        file = folder / Path(name).name
        file.write_text(texts[name])
        running.append(subprocess.Popen([*compiler, "-c", file], cwd=folder))
    runtime = SAFETY / "test/mutants/mutant.cpp"
    running.append(subprocess.Popen([*compiler, "-c", runtime], cwd=folder))
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


@pytest.mark.thorough
@pytest.mark.processes
@pytest.mark.timeout(900)
def test_the_core_with_all_mutants_compiles(tmp_path: Path) -> None:
    write(populate(), tmp_path / "src/core")
    folders = (tmp_path / "src", tmp_path / "src/include", SAFETY / "include", SAFETY / "test")
    # Behind all else that runs: other tests have robots that want to be in time.
    command = ["nice", "-n", "19", *compiler_of(folders), "-fsyntax-only"]
    files = sorted((tmp_path / "src/core").rglob("*.cpp"))
    assert len(files) > 40
    for file in files:
        done = subprocess.run([*command, file], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
