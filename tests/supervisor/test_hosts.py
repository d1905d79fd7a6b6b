"""Deployment files with several hosts: what fits, what does not, and which host this is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, ServiceError
from fairlead.paths import gate_binary
from fairlead_tools.supervisor.command_line import service_command
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from fairlead_tools.supervisor.this_host import choose_host
from tests.supervisor.two_hosts_file import COMPOSE, ELSEWHERE, FILES, HERE, content


def problem(tmp_path: Path, changed: dict[str, Any]) -> str:
    """What `load_deployment` says about a file, behind the file's name."""
    file = tmp_path / "hosts.yaml"
    file.write_text(yaml.safe_dump(changed, sort_keys=False), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_deployment(file)
    return str(caught.value).removeprefix(f"{file}: ")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_shipped_files_place_the_policy_on_the_gpu_host(file: Path) -> None:
    deployment = load_deployment(file)
    assert deployment.processes("robot") == ["router", "hal", "safety", "state_assembler"]
    assert deployment.processes("gpu") == ["runner"]
    assert deployment.with_host("runner") == "runner (host gpu)"
    assert deployment.pacing == ("realtime" if "realtime" in file.stem else "lockstep")


def test_services_and_tools_are_clients_of_the_router_alone() -> None:
    deployment = Deployment.model_validate(content(access="open"))
    for endpoints in (deployment.endpoints("runner"), deployment.tool_endpoints()):
        assert (endpoints.mode, endpoints.listen) == ("client", ())
        assert list(endpoints.connect) == ["tcp/127.0.0.1:7500"]
    command = service_command(FILES[0], deployment, "safety", Path("/state/safety"))
    assert command[0] == str(gate_binary())
    assert command[-2:] == ["--router", "tcp/127.0.0.1:7500"]
    assert not {"--listen", "--connect"} & set(command)


def test_an_ipv6_address_gets_its_brackets() -> None:
    hosts = {"robot": "fd00::1", "gpu": ELSEWHERE}
    deployment = Deployment.model_validate(content(hosts=hosts, access="open"))
    assert deployment.router_endpoint == "tcp/[fd00::1]:7500"


def test_a_copy_for_tests_runs_on_one_host_without_a_router(tmp_path: Path) -> None:
    copy = make_scratch(FILES[0], tmp_path / "state", ScratchOptions()).deployment
    assert copy.router is None and copy.hosts == {}
    assert copy.processes(None) == ["hal", "safety", "state_assembler", "runner"]


def services(**changes: dict[str, Any]) -> dict[str, Any]:
    return content()["services"] | changes  # type: ignore[no-any-return]


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "no router": (content(router=None), "router: missing; hosts and router go together"),
    "no hosts": (content(hosts={}), "hosts: missing; hosts and router go together"),
    "a host nobody has": (
        content(services=services(runner={"run": "skill_runner", "host": "gpo"})),
        "services.runner.host: expected a host, got 'gpo' (valid: robot, gpu)",
    ),
    "a service without a host": (
        content(services=services(runner={"run": "skill_runner"})),
        "services.runner.host: expected a host, got none (valid: robot, gpu)",
    ),
    "a client that listens": (
        content(
            services=services(
                runner={"run": "skill_runner", "host": "gpu", "listen": "tcp/127.0.0.1:7504"}
            )
        ),
        "services.runner.listen: clients of a router listen nowhere; leave it out",
    ),
    "a router on no host": (
        content(router={"host": "pi", "port": 7500}),
        "router.host: expected a host, got 'pi' (valid: robot, gpu)",
    ),
    "a router that no certificate fits": (
        content(hosts={"robot": "fd00::1", "gpu": ELSEWHERE}),
        "hosts.robot: expected a name or an IPv4 address, got fd00::1: Zenoh cannot hold a",
    ),
    "an address that is everybody's": (
        content(hosts={"robot": "0.0.0.0", "gpu": ELSEWHERE}),  # noqa: S104 - that is the point
        "hosts.robot: expected the one address or name by which the other hosts reach it",
    ),
    "an address with a port": (
        content(hosts={"robot": "tcp/10.0.0.1:7500", "gpu": ELSEWHERE}),
        "hosts.robot: expected the one address or name",
    ),
    **{
        f"the address {one[:20]}": (
            content(hosts={"robot": HERE, "gpu": one}),
            "hosts.gpu: expected the one address or name",
        )
        for one in (
            "192.168.1.20:22",
            "192.168.1.300",
            "192.168.001.010",
            "224.0.0.1",
            "gpu..lab",
            "gpu-.lab",
            "x" * 64,
            "x." * 127 + "x",
            "fe80::1%eth0",
        )
    },
    "the same address twice": (
        content(hosts={"robot": HERE, "gpu": HERE}),
        "hosts: robot and gpu have the same address 127.0.0.1",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_file_is_refused_with(mistake: str, tmp_path: Path) -> None:
    changed, text = MISTAKES[mistake]
    assert text in problem(tmp_path, changed)


def test_peers_have_no_host_and_no_port_while_access_is_closed(tmp_path: Path) -> None:
    read = yaml.safe_load((COMPOSE / "panda_mobile_sim.yaml").read_text(encoding="utf-8"))
    read["services"]["hal"] |= {"host": "robot", "listen": "tcp/127.0.0.1:7501"}
    said = problem(tmp_path, read)
    assert "services.hal.listen: leave it out: on one host services listen where this user" in said
    assert "services.hal.host: 'robot', but there are no hosts" in said


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("a/b", "service: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit"),
        ("../x", "got '../x'"),
        ("*", "got '*'"),
        ("x" * 65, "got 'xxx"),
        ("up", "up: the supervisor's log has this name; give it another one"),
    ],
)
def test_a_service_has_a_name_that_fits_a_key_and_a_log(
    name: str, said: str, tmp_path: Path
) -> None:
    read = yaml.safe_load((COMPOSE / "panda_mobile_sim.yaml").read_text(encoding="utf-8"))
    read["services"][name] = read["services"].pop("runner")
    assert said in problem(tmp_path, read)


def test_several_hosts_need_one_named_and_the_error_lists_them() -> None:
    with pytest.raises(ConfigError) as caught:
        choose_host(Deployment.model_validate(content()), None)
    assert str(caught.value) == (
        "deployment panda_mobile has 2 hosts; start each on its own machine, with --host "
        "(valid: robot at 127.0.0.1, gpu at 192.0.2.1); this machine has the address of robot"
    )


def test_a_host_that_is_not_in_the_file_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"got 'robto' \(valid: robot, gpu\)"):
        choose_host(Deployment.model_validate(content()), "robto")


def test_an_address_of_another_machine_is_refused_naming_who_this_could_be() -> None:
    with pytest.raises(ServiceError) as caught:
        choose_host(Deployment.model_validate(content()), "gpu")
    assert "host gpu: its address 192.0.2.1 is none of this machine's" in str(caught.value)
    assert str(caught.value).endswith("; this machine has the address of robot")


def test_this_machine_is_the_host_whose_address_it_has() -> None:
    assert choose_host(Deployment.model_validate(content()), "robot") == "robot"
    assert choose_host(load_deployment(COMPOSE / "panda_mobile_sim.yaml"), None) is None
    with pytest.raises(ConfigError, match="the file has no hosts"):
        choose_host(load_deployment(COMPOSE / "panda_mobile_sim.yaml"), "robot")
