"""Which mutants a line of C++ has, and how they are written."""

from __future__ import annotations

import pytest

from bench.mutants.mutations import Mutations, storage_sizes

FUNCTION = "int f(int a, int b) {{\n  {}\n}}\n"


def mutated(line: str) -> tuple[list[str], str]:
    found = Mutations("f.cpp", FUNCTION.format(line), {"covers": "bool", "check": "Text"}, set(), 1)
    return [mutant.change for mutant in found.mutants], found.text().splitlines()[2].strip()


@pytest.mark.parametrize(
    ("line", "changes", "text"),
    [
        (
            "return a < b;",
            ["< becomes <=", "< is negated"],
            "return a < fm::Compare{1} < b;",
        ),
        ("return a - b;", ["- becomes +"], "return a - fm::Sum{1} - b;"),
        (
            "return a && b;",
            ["&& becomes ||"],
            "return fm::flip(1, fm::flip(1, a) && fm::flip(1, b));",
        ),
        ("return !a;", ["! is left out"], "return fm::Not{1}->*a;"),
        ("a = b;", ["the statement is left out"], "{ if (!fm::on(1)) a = b; }"),
        ("if (x.covers(a)) return b;", ["the condition is negated"], None),
        (
            "return check(a);",
            ["check is not asked"],
            "return fm::ask(1, [&] { return check(a); });",
        ),
        (
            "return Cells(a)\n      .check(b);",
            ["check is not asked"],
            "return fm::ask(1, [&] { return Cells(a)",
        ),
        ("return std::min(a, b);", ["min becomes max"], None),
        ("return 5;", ["5 becomes another number"], "return fm::number(1, 5);"),
        ("std::array<int, 5> a;", [], "std::array<int, 5> a;"),
        ('say(a, "a < b && c");  // a < b', ["the statement is left out"], None),
        ("for (int i : list) f(i);", ["the statement is left out"], None),
    ],
)
def test_a_line_has_its_mutants(line: str, changes: list[str], text: str | None) -> None:
    found = mutated(line)
    assert found[0] == changes
    assert text is None or found[1] == text


def test_nested_mutants_keep_their_brackets() -> None:
    changes, text = mutated("return a || (b && !a);")
    assert changes == ["|| becomes &&", "&& becomes ||", "! is left out"]
    assert text.count("(") == text.count(")")


def test_a_constant_that_sizes_storage_stays_a_constant() -> None:
    source = "constexpr int rows = 4;\nconstexpr int slots = 5;\n"
    found = Mutations("f.cpp", source, {}, {"rows"}, 1)
    assert [mutant.text for mutant in found.mutants] == ["constexpr int slots = 5;"]
    assert "constexpr int rows = 4;" in found.text()


def test_constants_that_a_constant_array_lists_stay_constants() -> None:
    source = (
        "inline constexpr int one = 1,\n                     two = 2;\n"
        "inline constexpr std::array both{one,\n                                 two};\n"
        "inline constexpr int three = 3;\n"
    )
    found = Mutations("f.hpp", source, {}, storage_sizes([source]), 1)
    assert [mutant.text for mutant in found.mutants] == ["inline constexpr int three = 3;"]


def test_what_the_compiler_runs_stays_constant() -> None:
    source = (
        'constexpr std::string_view rule = "still";\n'
        "struct Rule {\n"
        "  static constexpr int longest = 60;\n"
        "  consteval Rule(int a) : size(a) { if (a > longest) throw 1; }\n"
        "};\n"
        "int f() {\n"
        '  constexpr std::string_view other = "still";\n'
        "  return g(rule, other);\n"
        "}\n"
    )
    found = Mutations("f.cpp", source, {}, storage_sizes([source]), 1)
    text = found.text()
    assert text.count("constexpr std::string_view") == 2
    assert "constexpr int longest = 60;" in text
    assert "if (a > longest) throw 1;" in text
