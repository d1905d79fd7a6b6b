"""Where a source of the core can be wrong by one small thing, and how to write that."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from bench.mutants.cpp_text import (
    blanked,
    bodies,
    call_start,
    closing,
    operand_end,
    operand_start,
)

# Results that say "nothing wrong" when empty; a mutant does not ask.
CHECKED = re.compile(r"^(?:static |inline )?(Text|Evidence|Objection|bool) (?:\w+::)*(\w+)\(", re.M)
SPEECH = {"phrase", "above", "below", "broken_rule", "at", "flip"}  # these put into words only
DEFINED = re.compile(r"^(?:static |inline )*([\w:]+(?:<[\w:, ]+>)?&?) (?:\w+::)*(\w+)\(", re.M)
OR_STOPS = r",|;|\?|(?<!:):(?!:)|\breturn\b|(?<![=!<>])=(?!=)"
AND_STOPS = OR_STOPS + r"|\|\|"
NUMBER = re.compile(
    r"(?<![\w.\"'])(?:0[xX][0-9a-fA-F']+|\d[\d']*(?:\.\d*)?(?:[eE][+-]?\d+)?)[uUlL]*"
)
STATEMENT = re.compile(
    r"(?:\(void\))?(?:\+\+|--)?[\w:]+(?:<\w+>)?(?:\.|->|\[|\(|\s(?:[-+*/|&^]|<<|>>)?=\s|\+\+|--)"
)
KEYWORDS = re.compile(
    r"(?:return|if|else|for|while|do|switch|case|default|break|continue|using|static|constexpr|const"
    r"|auto|template|static_assert|FAIRLEAD_\w+)\b"
)
CONSTANT_VALUE = re.compile(r"\bconstexpr [\w:<>, ]+?(\w+) = ([^;]+);")
FUNCTIONS = {"min": "fm::least<", "max": "fm::most_of<"}
SIMPLE = {"abs": "fm::magnitude(", "sin": "fm::sine(", "cos": "fm::cosine("}


@dataclass(frozen=True)
class Mutant:
    """One wrong thing: where, and in words."""

    file: str
    line: int
    text: str  # the source line
    change: str  # for example "< becomes <="


@dataclass
class Mutations:
    """The mutants of one file and the edits that put them in. Ids count on from ``first``."""

    file: str
    source: str
    checked: dict[str, str]  # name of a function whose result can be ignored -> its type
    sizes: set[str]  # names of constants that size storage: these stay as they are
    first: int
    mutants: list[Mutant] = field(default_factory=list)
    wraps: list[tuple[int, int, str, str]] = field(default_factory=list)
    swaps: list[tuple[int, int, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Find all of them."""
        self.code = without_assertions(blanked(self.source))
        own = {name: kind for kind, name in DEFINED.findall(self.code)}
        self.checked = {
            name: kind for name, kind in self.checked.items() if own.get(name, kind) == kind
        }
        for start, end in self.regions():
            self.operators(start, end)
            self.logic(start, end)
            self.conditions(start, end)
            self.numbers(start, end)
            self.functions(start, end)
            self.checks(start, end)
            self.statements(start, end)

    def regions(self) -> Iterator[tuple[int, int]]:
        """Function bodies, and named constants that size nothing."""
        inside = bodies(self.code)
        yield from inside
        pattern = r"^ *(?:inline |static )*(constexpr) [\w:<>, ]+?(\w+) = [^;]+;"
        for found in re.finditer(pattern, self.code, re.M):
            local = any(start <= found.start() < end for start, end in inside)
            is_text = "string_view" in found[0]  # has no number, and rules ask for constant words
            if not local and not is_text and found[2] not in self.sizes:
                member = "static " in self.code[found.start() : found.start(1)]
                self.swaps.append((*found.span(1), "inline const" if member else "const"))
                yield found.start(2), found.end() - 1
        pattern = r"\bconstexpr (?!std::string_view)(?=[\w:<>, ]+?\w+(?: =|\{))"
        for found in re.finditer(pattern, self.code):
            if any(start <= found.start() < end for start, end in inside):
                self.swaps.append((found.start(), found.end(), "const "))

    def add(self, at: int, change: str) -> int:
        """A mutant at an offset; its id."""
        line = self.source.count("\n", 0, at)
        text = self.source.split("\n")[line].strip()
        self.mutants.append(Mutant(self.file, line + 1, text, change))
        return self.first + len(self.mutants) - 1

    def operators(self, start: int, end: int) -> None:
        """Comparisons, sums and products: a detour beside the operator."""
        moved = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
        other = {"==": "!=", "!=": "==", "+": "-", "-": "+", "*": "/", "/": "*"}
        tags = {"==": "Equal", "!=": "Equal", "*": "Product", "/": "Product"}
        pattern = re.compile(r"(?<=[\w)\]}\"]) (<=|>=|==|!=|[<>*/+-])(?=[ \n])")
        for found in pattern.finditer(self.code, start, end):
            op = found[1]
            if op in moved:
                tag = f"fm::Compare{{{self.add(found.start(1), f'{op} becomes {moved[op]}')}}}"
                self.add(found.start(1), f"{op} is negated")
            else:
                number = self.add(found.start(1), f"{op} becomes {other[op]}")
                tag = f"fm::{tags.get(op, 'Sum')}{{{number}}}"
            self.swaps.append((found.start(1), found.end(1), f"{op} {tag} {op}"))

    def logic(self, start: int, end: int) -> None:
        """`&&` and `||`, by De Morgan: the result and both operands flipped."""
        for found in re.finditer(r"&&|\|\|", self.code[start:end]):
            at, op = start + found.start(), found.group()
            if self.code[at - 1] != " " or self.code[at + 2] not in " \n":
                continue  # a reference to an rvalue
            left = operand_start(self.code, at, AND_STOPS if op == "&&" else OR_STOPS)
            right = at + 2 + len(self.code[at + 2 :]) - len(self.code[at + 2 :].lstrip())
            stops = AND_STOPS + "|&&" if op == "&&" else OR_STOPS + r"|\|\|"
            last = operand_end(self.code, right, stops)
            flip = f"fm::flip({self.add(at, f'{op} becomes ' + ('||' if op == '&&' else '&&'))}, "
            self.wraps.append((left, last, flip, ")"))
            self.wraps.append((left, len(self.code[:at].rstrip()), flip, ")"))
            self.wraps.append((right, last, flip, ")"))

    def conditions(self, start: int, end: int) -> None:
        """Plain conditions and `!`, negated; comparisons are among the operators."""
        for found in re.finditer(r"\b(?:if|while) \(", self.code[start:end]):
            left = start + found.end()
            right = closing(self.code, left - 1)
            inner = self.code[left:right]
            if not re.search(r" (?:[<>]=?|[=!]=|&&|\|\||=)[ \n]|^!", inner):
                number = self.add(left, "the condition is negated")
                self.wraps.append((left, right, f"fm::flip({number}, ", ")"))
        for found in re.finditer(r"!(?!=)", self.code[start:end]):
            at = start + found.start()
            self.swaps.append((at, at + 1, f"fm::Not{{{self.add(at, '! is left out')}}}->*"))

    def numbers(self, start: int, end: int) -> None:
        """Numbers and truth values, but not those of types and labels."""
        for found in re.finditer(r"\b(?:true|false)\b", self.code[start:end]):
            at = start + found.start()
            number = self.add(at, f"{found.group()} is negated")
            self.wraps.append((at, start + found.end(), f"fm::number({number}, ", ")"))
        for found in NUMBER.finditer(self.code, start, end):
            line = self.code[self.code.rfind("\n", 0, found.start()) + 1 : found.start()]
            if re.search(r"\w<[^<>;()]*$|case ", line):
                continue
            number = self.add(found.start(), f"{found.group()} becomes another number")
            self.wraps.append((found.start(), found.end(), f"fm::number({number}, ", ")"))

    def functions(self, start: int, end: int) -> None:
        """Min and max swapped, a magnitude with its sign, sine and cosine swapped."""
        for found in re.finditer(r"\bstd::(min|max)(<[\w:]+>)?\(", self.code[start:end]):
            name = found[1]
            at, bracket = start + found.start(), start + found.end() - 1
            number = self.add(at, f"{name} becomes " + ("max" if name == "min" else "min"))
            kind = found[2][1:-1] if found[2] else self.common_type(bracket)
            self.swaps.append((at, bracket + 1, f"{FUNCTIONS[name]}{kind}>({number}, "))
        for found in re.finditer(r"\bstd::(abs|sin|cos)\(", self.code[start:end]):
            at = start + found.start()
            change = {"abs": "abs is left out", "sin": "sin becomes cos", "cos": "cos becomes sin"}
            number = self.add(at, change[found[1]])
            self.swaps.append((at, start + found.end(), f"{SIMPLE[found[1]]}{number}, "))

    def common_type(self, bracket: int) -> str:
        """The type that std::min deduces from its first argument."""
        first = operand_end(self.code, bracket + 1, ",")
        return f"std::decay_t<decltype({self.source[bracket + 1 : first]})>"

    def checks(self, start: int, end: int) -> None:
        """A check is not asked, or a question is answered the other way."""
        for found in re.finditer(r"\b(\w+)\(", self.code[start:end]):
            kind = self.checked.get(found[1])
            name, bracket = start + found.start(), start + found.end() - 1
            if kind is None or found[1] in SPEECH:
                continue
            at = call_start(self.code, name)
            if re.search(r"[;{}]\s*$|\b(?!return )\w+ $", self.code[:at]):
                continue  # a statement of its own, or a declaration
            after = closing(self.code, bracket) + 1
            if kind != "bool":
                number = self.add(name, f"{found[1]} is not asked")
                self.wraps.append((at, after, f"fm::ask({number}, [&] {{ return ", "; })"))
            elif not re.search(r"!$|\b(?:if|while) \($", self.code[:at]):
                number = self.add(name, f"{found[1]} is negated")
                self.wraps.append((at, after, f"fm::flip({number}, ", ")"))

    def statements(self, start: int, end: int) -> None:
        """Calls and assignments left out."""
        for found in re.finditer(r"(?:(?<=[;{})])|(?<=\belse))\s+", self.code[start - 1 : end]):
            at = start - 1 + found.end()
            if KEYWORDS.match(self.code, at) or not STATEMENT.match(self.code, at):
                continue
            if self.code[: start - 1 + found.start()].endswith(")") and not self.is_branch(
                start - 1 + found.start() - 1
            ):
                continue
            before = self.code[start:at]
            if before.count("(") != before.count(")"):
                continue  # the head of a for
            brace = re.search(r"\{\s*$", before)
            if brace and not re.search(r"(\)|else|do|const)\s*$", before[: brace.start()]):
                continue  # a list of values
            last = operand_end(self.code, at, ";")
            number = self.add(at, "the statement is left out")
            self.wraps.append((at, last + 1, f"{{ if (!fm::on({number})) ", " }"))

    def is_branch(self, bracket: int) -> bool:
        """Whether a closing bracket ends the head of an if, for or while."""
        depth = 0
        for i in range(bracket, -1, -1):
            depth += (self.code[i] in CLOSING) - (self.code[i] in OPENING)
            if depth == 0:
                return re.search(r"\b(?:if|for|while) $", self.code[:i]) is not None
        return False

    def text(self) -> str:
        """The source with every mutant in it."""
        opens: dict[int, list[tuple[int, int, str]]] = {}
        closes: dict[int, list[tuple[int, int, str]]] = {}
        for order, (start, end, before, after) in enumerate(self.wraps):
            opens.setdefault(start, []).append((-end, order, before))
            closes.setdefault(end, []).append((-start, -order, after))
        replaced = {start: (end, new) for start, end, new in self.swaps}
        out = []
        at = 0
        while at <= len(self.source):
            out += [after for *_, after in sorted(closes.get(at, []))]
            out += [before for *_, before in sorted(opens.get(at, []))]
            if at in replaced:
                end, new = replaced[at]
                out.append(new)
                at = end
            else:
                out.append(self.source[at : at + 1])
                at += 1
        return '#include "mutants/mutant.hpp"\n' + "".join(out)


OPENING, CLOSING = "([{", ")]}"


def without_assertions(code: str) -> str:
    """Blanked code without what the compiler asserts or runs: that has to stay constant."""
    for found in re.finditer(r"\bstatic_assert\(|\bconsteval [^;{]*\{", code):
        end = closing(code, found.end() - 1) + 1
        code = code[: found.start()] + re.sub(r"[^\n]", " ", code[found.start() : end]) + code[end:]
    return code


def checked_functions(sources: list[str]) -> dict[str, str]:
    """Functions that return a fault, an objection or a truth value."""
    return {name: kind for source in sources for kind, name in CHECKED.findall(blanked(source))}


def storage_sizes(sources: list[str]) -> set[str]:
    """Constants that a template's argument, a size, an assertion or a constant array needs.

    And functions that the compiler runs.
    """
    codes = [blanked(source) for source in sources]
    pattern = (
        r"<[^<>;()]*?\b(\w+)>|\bstatic_assert\((.*?)\);|\bconstexpr std::array \w+\{(.*?)\};"
        r"|\bconsteval [^;{]*\{(.*?)\}"
    )
    found = {name for code in codes for one in re.findall(pattern, code, re.S) for name in one}
    names = {name for text in found for name in re.findall(r"\b[a-z]\w+", text)}
    given = dict(pair for code in codes for pair in re.findall(CONSTANT_VALUE, code))
    while (
        more := {name for size in names for name in re.findall(r"\b[a-z]\w+", given.get(size, ""))}
        - names
    ):
        names |= more
    return names
