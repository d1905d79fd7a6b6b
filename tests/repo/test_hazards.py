"""The table of checks is that of the core, and a C++ test comes close to the limit of each."""

from __future__ import annotations

from fairlead.wire.gate_checks import CHECKS
from tests.repo.core_tests import asked_codes, core_tests, declared_codes


def test_the_table_of_checks_has_every_code_in_order() -> None:
    assert list(CHECKS) == sorted(declared_codes().values())


def test_every_check_has_cpp_tests_that_name_it() -> None:
    named = {code for test in core_tests() for code in test.codes}
    assert {f"G{code:03d}" for code in asked_codes() - named} == set()


def test_every_check_of_a_number_is_tested_close_to_its_limit() -> None:
    swept = {code for test in core_tests() if test.sweeps for code in test.codes}
    numbers = {code for code, check in CHECKS.items() if not check.counts} & asked_codes()
    assert {f"G{code:03d}" for code in numbers - swept} == set()
