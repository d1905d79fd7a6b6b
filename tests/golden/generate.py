"""Write the golden files that the Python and the C++ codec are tested against.

    tests/golden/<name>.bin   the exact bytes of one message
    tests/golden/index.json   per file: type, type id, version, size, sha256, hex, fields
    tests/golden/refused.json frames that every codec must refuse, per type
    tests/golden/keys.json    key expressions for every method of `fairlead.keys.Keys`

Example:
    scripts/make-golden           write them
    scripts/make-golden --check   exit 1 and name the files that are not what they should be
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import sys
from pathlib import Path

import msgspec

from fairlead.keys import Keys
from fairlead.messages import Message, encode, floats
from tests.golden.frames import bad_frames
from tests.golden.instances import MESSAGES

FOLDER = Path(__file__).resolve().parent

FLOAT_BLOCKS = {
    "positions",
    "velocities",
    "efforts",
    "translation",
    "rotation_xyzw",
    "lower",
    "upper",
    "values",
}
KEY_ROBOTS = (("panda_mobile", "fl"), ("left.arm-2", "lab_7"))
KEY_ARGUMENTS = {
    "tf": ("hal", "state_assembler"),
    "camera": ("front",),
    "layout": ("oracle-counter-to-cabinet",),
    "candidate": ("runner", "teleop"),
    "safe": ("runner",),
    "verdict": ("runner",),
    "claim": ("runner",),
    "gate_command": ("arm", "disarm", "reset"),
    "release": ("runner",),
    "hal_command": ("reset_episode",),
    "hal_session": (0x5EED,),
    "goal": ("runner",),
    "cancel": ("runner",),
    "load": ("runner",),
    "feedback": ("runner",),
    "heartbeat": ("runner",),
    "alive": ("safety", "hal"),
    "want_layout": ("oracle-counter-to-cabinet",),
}


def readable(value: object, name: str = "") -> object:
    """A message as JSON: float blocks as numbers, other bytes as hex, records as objects."""
    if isinstance(value, msgspec.Struct):
        return {field: readable(getattr(value, field), field) for field in value.__struct_fields__}
    if isinstance(value, bytes):
        return (
            [readable(x) for x in floats(value).tolist()] if name in FLOAT_BLOCKS else value.hex()
        )
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, tuple):
        return [readable(item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return int(value)
    return value


def entry(name: str, message: Message) -> dict[str, object]:
    """One row of index.json."""
    data = encode(message)
    return {
        "file": f"{name}.bin",
        "type": type(message).__name__,
        "type_id": message.__struct_config__.tag,
        "version": 1,
        "size": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "hex": data.hex(),
        "fields": readable(message),
    }


def golden_keys() -> list[dict[str, object]]:
    """Every key of every robot in `KEY_ROBOTS`: ``method``, ``argument`` ("" if none), ``key``."""
    rows: list[dict[str, object]] = []
    for robot, namespace in KEY_ROBOTS:
        keys = Keys(robot, namespace)
        for method in sorted(name for name in vars(Keys) if not name.startswith("_")):
            if method in ("robot", "namespace"):
                continue
            attribute = getattr(keys, method)
            arguments = KEY_ARGUMENTS[method] if callable(attribute) else ("",)
            for argument in arguments:
                rows.append(
                    {
                        "namespace": namespace,
                        "robot": robot,
                        "method": method,
                        "argument": argument,
                        "key": attribute(argument) if argument else attribute,
                    }
                )
    return rows


def golden_files() -> dict[str, bytes]:
    """Every golden file and the bytes it must have."""
    files = {f"{name}.bin": encode(message) for name, message in MESSAGES.items()}
    refused: list[dict[str, object]] = [
        {"type": bad.kind, "defect": bad.defect, "hex": bad.data.hex()}
        for bad in bad_frames(MESSAGES)
    ]
    files["index.json"] = _json([entry(name, message) for name, message in MESSAGES.items()])
    files["refused.json"] = _json(refused)
    files["keys.json"] = _json(golden_keys())
    return files


def differences(folder: Path) -> list[str]:
    """Names of the golden files in ``folder`` that are missing, wrong or not known."""
    wanted = golden_files()
    present = {path.name for path in folder.iterdir() if path.suffix in (".bin", ".json")}
    wrong = {
        name
        for name, data in wanted.items()
        if name not in present or (folder / name).read_bytes() != data
    }
    return sorted(wrong | (present - set(wanted)))


def _json(rows: list[dict[str, object]]) -> bytes:
    """One row a line: small diffs, and every JSON reader takes it."""
    lines = ",\n".join(json.dumps(row, ensure_ascii=True, allow_nan=False) for row in rows)
    return f"[\n{lines}\n]\n".encode()


def main() -> int:
    """Write the files, or with ``--check`` only compare them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if stale")
    if parser.parse_args().check:
        stale = differences(FOLDER)
        if stale:
            print(f"golden files are not current: {', '.join(stale)}\n  try: scripts/make-golden")
        return 1 if stale else 0
    wanted = golden_files()
    for path in FOLDER.iterdir():
        if path.suffix in (".bin", ".json") and path.name not in wanted:
            path.unlink()
    for name, data in wanted.items():
        (FOLDER / name).write_bytes(data)
    print(f"wrote {len(wanted)} golden files to {FOLDER}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
