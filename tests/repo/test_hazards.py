"""The table of checks is that of the core, and a C++ test comes close to the limit of each."""

from __future__ import annotations

from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.verdict_text import is_rule
from tests.repo.core_tests import asked_codes, core_rules, core_tests, declared_codes


def test_the_table_of_checks_has_every_code_in_order() -> None:
    assert list(CHECKS) == sorted(declared_codes().values())


def test_every_check_has_cpp_tests_that_name_it() -> None:
    named = {code for test in core_tests() for code in test.codes}
    assert {f"G{code:03d}" for code in asked_codes() - named} == set()


def test_every_check_of_a_number_is_tested_close_to_its_limit() -> None:
    swept = {code for test in core_tests() if test.sweeps for code in test.codes}
    numbers = {code for code, check in CHECKS.items() if not check.counts} & asked_codes()
    assert {f"G{code:03d}" for code in numbers - swept} == set()


def test_every_check_of_a_magnitude_has_a_cpp_test_that_asks_for_its_unit() -> None:
    tests = core_tests()
    unasked = [
        f"G{code:03d}"
        for code, check in CHECKS.items()
        if check.units
        and not any(set(check.units) & test.units for test in tests if code in test.codes)
    ]
    assert unasked == []


def test_what_a_check_is_said_to_find_is_what_the_core_finds() -> None:
    rules = {(rule.code, rule.words) for rule in core_rules()}
    odd = {
        code: check.example
        for code, check in CHECKS.items()
        if (check.example.unit not in check.units)
        and (code, check.example.limit_source) not in rules
        and code != 1  # whose words are those of a fault of a frame
    }
    assert odd == {}
    assert [
        code for code, check in CHECKS.items() if is_rule(check.example) == bool(check.units)
    ] == []
