"""Each check of the gate answers a hazard, and a C++ test comes close to its limit."""

from __future__ import annotations

from fairlead.wire.verdict_text import CHECKS
from tests.hazards.sources import asked_codes, core_tests, declared_codes
from tests.hazards.table import HAZARDS


def test_every_code_has_one_hazard_in_the_order_of_the_codes() -> None:
    assert [one.code for one in HAZARDS] == sorted(declared_codes().values())


def test_every_code_is_said_in_words_to_the_operator() -> None:
    assert asked_codes() - set(CHECKS) == set()


def test_every_check_has_cpp_tests_that_name_it() -> None:
    named = {code for test in core_tests() for code in test.codes}
    assert {f"G{code:03d}" for code in asked_codes() - named} == set()


def test_every_check_of_a_number_is_tested_close_to_its_limit() -> None:
    swept = {code for test in core_tests() if test.sweeps for code in test.codes}
    numbers = {one.code for one in HAZARDS if not one.counts} & asked_codes()
    assert {f"G{code:03d}" for code in numbers - swept} == set()
