"""Files of others, changed at random: read as they are, or refused with the file's name.

Robots, skills, deployments, a gate's decision log, certificates. Whatever else a reader raises is
a fault of ours.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from fairlead.deploy.certificates import read_certificate
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import FairleadError
from fairlead.paths import deployment_path, repo_root, rskill_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import read_skill
from fairlead.yaml_file import load_yaml
from fairlead_tools.record.run_log import read_run

TRIES = {"robot.yaml": 150, "rskill.yaml": 500, "deployment.yaml": 500, "run.decisions": 200}
STRANGE = (
    "null", "[]", "{}", "-1", "1e999", ".nan", "!!python/object/apply:os.system [true]", "&a [*a]",
    "2026-11-27", "0x7fffffffffffffffffff", "'\\0'", "ä" * 300, "[" * 3000, "yes", "*nobody", "\t",
)  # fmt: skip
LOG = repo_root() / "services/safety/test/corpus/panda.decisions"

Reader = Callable[[Path], object]
READERS: dict[str, tuple[Path, Reader]] = {
    "robot.yaml": (repo_root() / "robots/panda/robot.yaml", lambda p: load_yaml(p, RobotManifest)),
    "rskill.yaml": (
        rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml",
        lambda path: read_skill(path.parent),
    ),
    "deployment.yaml": (deployment_path("panda_mobile_two_hosts"), load_deployment),
    "run.decisions": (LOG, read_run),
}


def changed(chance: random.Random, text: bytes) -> bytes:
    """A line or some bytes of it are others, twice, or gone."""
    if chance.random() < 0.6:
        lines = text.splitlines(keepends=True)
        at = chance.randrange(len(lines))
        line = lines[at]
        head = line.partition(b":")[0]
        lines[at] = chance.choice((
            b"", line * 2, b"  " + line, line.lstrip(), head + b": "
            + chance.choice(STRANGE).encode() + b"\n", line.upper(),
        ))  # fmt: skip
        return b"".join(lines)
    spoiled = bytearray(text)
    at = chance.randrange(len(spoiled))
    match chance.randrange(4):
        case 0:
            spoiled[at] ^= 1 << chance.randrange(8)
        case 1:
            del spoiled[at:]
        case 2:
            spoiled[at:at] = chance.randbytes(5)
        case _:
            del spoiled[at : at + chance.randrange(1, 60)]
    return bytes(spoiled)


@pytest.mark.parametrize("name", TRIES)
def test_it_is_read_or_refused_by_its_name(name: str, tmp_path: Path) -> None:
    source, read = READERS[name]
    text, chance = source.read_bytes(), random.Random(name)
    file = tmp_path / source.parent.name / name
    file.parent.mkdir()
    file.write_bytes(text)
    read(file)
    refused = 0
    for number in range(TRIES[name]):
        spoiled = changed(chance, text)
        file.write_bytes(spoiled)
        try:
            read(file)
        except FairleadError as error:
            refused += 1
            assert file.name in str(error) and "Traceback" not in str(error)
        except Exception as error:
            raise AssertionError(f"{name}, change {number}: {error!r}:\n{spoiled!r}") from error
    assert refused  # a log is read as far as its sums are right


NAMES = (
    " ", "../../etc/passwd", "a/b", "*", "**", "fl/*/x", "x" * 64, "\u202eresu", "a\nb",
    "a\x00b", "operator,CN=safety", "ä",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_certificate_of_any_name_is_read_or_refused(name: str, tmp_path: Path) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    now = datetime.now(UTC)
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
    made = (
        x509.CertificateBuilder().subject_name(subject).issuer_name(subject)
        .public_key(key.public_key()).serial_number(1).not_valid_before(now)
        .not_valid_after(now + timedelta(days=1)).sign(key, hashes.SHA256())
    )  # fmt: skip
    file = tmp_path / "one.crt"
    pem = made.public_bytes(serialization.Encoding.PEM)
    file.write_bytes(pem)
    assert read_certificate(file).name == name
    chance = random.Random(name)
    for _ in range(60):
        file.write_bytes(changed(chance, pem))
        try:
            read_certificate(file)
        except FairleadError as error:
            assert file.name in str(error)
