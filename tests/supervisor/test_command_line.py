"""With what command and environment a service is started."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, gate_config, repo_root
from fairlead_tools.supervisor.command_line import (
    new_state_command,
    service_command,
    service_environment,
)

FILE = repo_root() / "compose" / "panda_mobile_sim.yaml"


def test_the_gate_gets_its_compiled_file_and_connects_to_the_services_above_it() -> None:
    deployment = load_deployment(FILE)
    command = service_command(FILE, deployment, "safety", Path("/state/safety"))
    *command, option, access = command
    assert (option, json.loads(Path(access).read_text())) == (
        "--access",
        deployment.endpoints("safety").part,
    )
    assert Path(access).stat().st_mode & 0o777 == 0o600
    assert command == [
        str(gate_binary()),
        "--robot", "panda_mobile",
        "--namespace", "fl",
        "--service", "safety",
        "--config", str(gate_config("panda_mobile", "sim")),
        "--state-dir", "/state/safety",
        "--listen", deployment.listen("safety"),
        "--connect", deployment.listen("hal"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("service", "module"),
    [
        ("hal", "fairlead.hal.serve"),
        ("state_assembler", "fairlead_state_assembler"),
        ("runner", "fairlead_skill_runner"),
    ],
)
def test_python_services_run_as_modules_of_this_interpreter(service: str, module: str) -> None:
    command = service_command(FILE, load_deployment(FILE), service, Path("/state") / service)
    assert command == [
        sys.executable, "-m", module,
        "--deployment", str(FILE),
        "--service", service,
        "--state-dir", f"/state/{service}",
    ]  # fmt: skip


def test_a_new_state_folder_is_told_to_the_gate_once_and_to_nobody_else() -> None:
    build, deployment = new_state_command(), load_deployment(FILE)
    plain = service_command(FILE, deployment, "safety", Path("/state/safety"))
    assert build(FILE, deployment, "safety", Path("/state/safety")) == [*plain, "--new-state"]
    assert build(FILE, deployment, "safety", Path("/state/safety")) == plain, "started again"
    assert "--new-state" not in build(FILE, deployment, "hal", Path("/state/hal"))


@pytest.mark.parametrize(
    ("variable", "usual"),
    [("OMP_NUM_THREADS", "1"), ("OPENBLAS_NUM_THREADS", "1"), ("MALLOC_ARENA_MAX", "2")],
)
def test_libraries_get_few_threads_and_heaps_unless_the_caller_says_otherwise(
    variable: str, usual: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(variable, raising=False)
    assert service_environment()[variable] == usual
    monkeypatch.setenv(variable, "3")
    assert service_environment()[variable] == "3"


def test_a_program_that_is_not_there_is_said_before_the_start() -> None:
    deployment = load_deployment(FILE)
    hal = deployment.services["hal"].model_copy(
        update={"command": ("no-such-hal", "--fast"), "run": "", "options": {}}
    )
    other = deployment.model_copy(update={"services": {**deployment.services, "hal": hal}})
    with pytest.raises(ConfigError, match="service hal: command: expected a program that this us"):
        service_command(FILE, other, "hal", Path("/state/hal"))
    found = hal.model_copy(update={"command": ("sh", "-c")})
    other = deployment.model_copy(update={"services": {**deployment.services, "hal": found}})
    assert service_command(FILE, other, "hal", Path("/state/hal"))[:2] == ["sh", "-c"]
