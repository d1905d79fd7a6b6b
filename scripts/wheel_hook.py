"""What hatchling runs for the wheel: builds the gate, packs it with all that fairlead reads.

The wheel gets the tree of fairlead.paths in ``fairlead/data``: robots, skills, deployment files,
the lock file, and the gate, stripped, with the reader of its logs and the Zenoh library beside it.
The licences of what is compiled into these come with them.

FAIRLEAD_GATE_DIR names a folder where the gate lies built: it is packed as it is then.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

TREE = "fairlead/data"
READ_AS_THEY_ARE = ("robots", "rskills", "compose", "requirements-run.lock")
GATE = "fairlead-safety"
READER = "fairlead-decisions"
SHIM = "libfairlead_zenoh_shim.so"
LICENCES = "third-party-licences.txt"
# Every distribution has these; what versions of them a glibc comes with, PEP 600 settles: a glibc
# 2.35 with the C++ library's symbols up to 3.4.30, and so on (as auditwheel's policies say).
EVERYWHERE = re.compile(r"(lib(c|m|gcc_s|stdc\+\+|pthread|dl|rt)\.so\.\d|ld-linux[-\w]*\.so\.\d)")
GLIBC_OF_CXX = ((28, 31), (29, 34), (30, 35), (33, 39))


class GateWheelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the gate and the data to a wheel; an editable install has both in its checkout."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Hatchling's first call: say what goes into the wheel, and for which machines it is."""
        if version == "editable":
            return
        root = Path(self.root)
        self._stage = Path(tempfile.mkdtemp(prefix="fairlead-wheel-"))
        packed = {root / name: f"{TREE}/{name}" for name in READ_AS_THEY_ARE}
        gate_files = stripped(gate_dir(root), self._stage)
        packed |= {file: f"{TREE}/build/safety/{file.name}" for file in gate_files}
        licences = self._stage / LICENCES
        licences.write_text(output(root / "scripts" / "third-party-licences"), encoding="utf-8")
        packed[licences] = f"{TREE}/{LICENCES}"
        build_data["force_include"] |= {str(file): place for file, place in packed.items()}
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_of(gate_files)}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Hatchling's last call."""
        if version != "editable":
            shutil.rmtree(self._stage)


def gate_dir(root: Path) -> Path:
    """The folder of a built gate; builds it first unless told that there is one."""
    ready = os.environ.get("FAIRLEAD_GATE_DIR")
    if not ready:
        run(root / "scripts" / "check-machine", FAIRLEAD_PYTHON=sys.executable)
        run(root / "scripts" / "build-gate")
    folder = Path(ready) if ready else root / "build" / "safety"
    for name in (GATE, READER):
        if not (folder / name).is_file():
            raise SystemExit(f"wheel: no {name} in {folder}; build it with: scripts/build-gate")
    return folder


def stripped(folder: Path, stage: Path) -> list[Path]:
    """Copies without debugging symbols of the gate, its logs' reader and what the gate loads."""
    copies = []
    for name in (GATE, READER, SHIM):
        if (folder / name).is_file():  # a gate on the official zenoh-c has no shim
            copies.append(Path(shutil.copy2(folder / name, stage)))
            run("strip", str(copies[-1]))
    return copies


def platform_of(binaries: list[Path]) -> str:
    """The platform tag that is true: the newest symbols asked for decide.

    What is not in the wheel and not in every distribution makes it a wheel for this machine only.
    """
    shown = [output("readelf", "--wide", "--dynamic", "--version-info", str(b)) for b in binaries]
    machine, text = platform.machine(), "\n".join(shown)
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", text)) - {binary.name for binary in binaries}
    others = sorted(name for name in needed if not EVERYWHERE.fullmatch(name))
    newest = max(map(int, re.findall(r"\bGLIBC_2\.(\d+)", text)), default=0)
    newest_cxx = max(map(int, re.findall(r"\bGLIBCXX_3\.4\.(\d+)", text)), default=0)
    with_cxx = [glibc for cxx, glibc in GLIBC_OF_CXX if cxx >= newest_cxx]
    if others or not with_cxx:
        why = ", ".join(others) or f"GLIBCXX_3.4.{newest_cxx}"
        print(f"wheel: for machines like this one only: it needs {why}", file=sys.stderr)
        return f"linux_{machine}"
    return f"manylinux_2_{max(newest, with_cxx[0])}_{machine}"


def run(*command: str | Path, **environment: str) -> None:
    """Run a command with its output in sight, or end the build."""
    if subprocess.run(command, env=os.environ | environment, stdout=sys.stderr).returncode:
        raise SystemExit(f"wheel: {command[0]} failed; what it said stands above")


def output(*command: str | Path) -> str:
    """What a command prints; ends the build if it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"wheel: {command[0]} failed; what it said stands above")
    return done.stdout
