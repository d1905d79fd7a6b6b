"""Which Zenoh library the gate is built on: what is asked for is taken, or it is said why not."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.repo.tree import ROOT

pytestmark = pytest.mark.processes

SOURCE = ROOT / "services" / "safety"
INSTALLED = """\
add_library(zenohc::lib INTERFACE IMPORTED)
"""


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A prefix with a CMake package zenohc that says it is there: a stand-in, with no library."""
    package = tmp_path / "prefix" / "lib" / "cmake" / "zenohc"
    package.mkdir(parents=True)
    (package / "zenohcConfig.cmake").write_text(INSTALLED, encoding="utf-8")
    return tmp_path / "prefix"


def configure(folder: Path, *definitions: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["cmake", "-S", SOURCE, "-B", folder, *(f"-D{one}" for one in definitions)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def said(done: subprocess.CompletedProcess[str]) -> str:
    """What CMake said, in one line: it wraps."""
    return " ".join((done.stdout + done.stderr).split())


def test_the_official_library_asked_for_and_absent_is_an_error_with_the_ways_out(
    tmp_path: Path,
) -> None:
    done = configure(tmp_path / "build", "FAIRLEAD_ZENOHC=official", "CMAKE_PREFIX_PATH=/nowhere")
    assert done.returncode != 0
    assert (
        "fairlead-safety: FAIRLEAD_ZENOHC=official, and there is no CMake package zenohc. "
        "looked for: zenohcConfig.cmake, in CMAKE_PREFIX_PATH ('/nowhere') and the system's "
        "folders fix: install libzenohc and libzenohc-dev 1.10.2 (or a release archive of "
        "zenoh-c, and name its folder: -DCMAKE_PREFIX_PATH=DIR) or do without: "
        "scripts/build-gate --shim builds the same calls from Rust"
    ) in said(done)


@pytest.mark.parametrize("choice", ["official", "auto"])
def test_an_installed_official_library_is_taken(
    choice: str, installed: Path, tmp_path: Path
) -> None:
    done = configure(
        tmp_path / "build", f"FAIRLEAD_ZENOHC={choice}", f"CMAKE_PREFIX_PATH={installed}"
    )
    assert done.returncode == 0, said(done)
    assert f"Zenoh from the zenohc package in {installed}/lib/cmake/zenohc" in said(done)


def test_the_shim_asked_for_is_taken_whatever_is_installed(installed: Path, tmp_path: Path) -> None:
    shim = tmp_path / "libfairlead_zenoh_shim.so"
    shim.touch()
    done = configure(
        tmp_path / "build",
        "FAIRLEAD_ZENOHC=shim",
        f"FAIRLEAD_SHIM_LIBRARY={shim}",
        f"CMAKE_PREFIX_PATH={installed}",
    )
    assert done.returncode == 0, said(done)
    assert "Zenoh from the Rust shim" in said(done)


def test_an_unknown_library_is_refused_with_those_there_are(tmp_path: Path) -> None:
    done = configure(tmp_path / "build", "FAIRLEAD_ZENOHC=zenoh-pico")
    assert done.returncode != 0
    assert "FAIRLEAD_ZENOHC=zenoh-pico (valid: auto, official, shim)" in said(done)
