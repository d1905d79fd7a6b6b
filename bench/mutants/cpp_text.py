"""C++ as text: what is code in it, where brackets close, how far an operand reaches.

No parser: the core is laid out by clang-format and written plainly, and a mutation that would not
compile is found by the compiler.
"""

from __future__ import annotations

import re

OPEN, CLOSE = "([{", ")]}"
BODY = re.compile(r"(\)|\belse|\bdo)\s*(const|noexcept|override|->\s*[\w:<>]+|\s)*$")
INITIALISED = re.compile(r"\)\s*(noexcept\s*)?:[^;{}]*(\([^;{}]*\)|\{[^;{}]*\})\s*$")


def blanked(source: str) -> str:
    """The source with comments, strings and preprocessor lines blanked, at the same offsets."""
    pattern = r'//[^\n]*|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|^[ \t]*#(?:\\\n|[^\n])*'

    def blank(found: re.Match[str]) -> str:
        text = found.group()
        if text[0] in "\"'":
            return text[0] + "_" * (len(text) - 2) + text[-1]
        return re.sub(r"[^\n]", " ", text)

    return re.sub(pattern, blank, source, flags=re.MULTILINE)


def closing(code: str, at: int) -> int:
    """Offset of the bracket that closes the one at ``at``."""
    depth = 0
    for i in range(at, len(code)):
        if code[i] in OPEN:
            depth += 1
        elif code[i] in CLOSE:
            depth -= 1
            if depth == 0:
                return i
    raise ValueError(f"the bracket at {at} never closes")


def bodies(code: str) -> list[tuple[int, int]]:
    """Spans of the outermost function bodies."""
    found = []
    at = 0
    while (at := code.find("{", at)) >= 0:
        head = re.split(r"[;}](?!\s*[,{])", code[:at])[-1]
        if BODY.search(head) or INITIALISED.search(head):
            end = closing(code, at)
            found.append((at + 1, end))
            at = end
        at += 1
    return found


def operand_start(code: str, at: int, stops: str) -> int:
    """Where the operand that ends before ``at`` starts: behind an opening bracket or a stop."""
    first = max(0, at - 2000)
    ends = {first + found.end() for found in re.finditer(stops, code[first : at + 2])}
    depth = 0
    i = at
    while i > 0:
        char = code[i - 1]
        if char in CLOSE:
            depth += 1
        elif char in OPEN:
            if depth == 0:
                break
            depth -= 1
        elif depth == 0 and i in ends:
            break
        i -= 1
    return i + len(code[i:at]) - len(code[i:at].lstrip())


def operand_end(code: str, at: int, stops: str) -> int:
    """Where the operand that starts at ``at`` ends: before a closing bracket or a stop."""
    stop = re.compile(stops)
    depth = 0
    for i in range(at, len(code)):
        if code[i] in OPEN:
            depth += 1
        elif code[i] in CLOSE:
            if depth == 0:
                return len(code[:i].rstrip())
            depth -= 1
        elif depth == 0 and stop.match(code, i):
            return len(code[:i].rstrip())
    return len(code)


def call_start(code: str, at: int) -> int:
    """Where the chain ``a.b()->c`` starts whose last name starts at ``at``."""
    i = at
    while found := re.search(r"((?:\n\s*)?(?:\.|->)|::)$", code[:i]):
        i -= len(found.group())
        while code[i - 1] in CLOSE:
            i = matching_open(code, i - 1)
        i -= len(re.search(r"\w*$", code[:i]).group())  # type: ignore[union-attr]
    return i


def matching_open(code: str, at: int) -> int:
    """Offset of the bracket that the one at ``at`` closes."""
    depth = 0
    for i in range(at, -1, -1):
        if code[i] in CLOSE:
            depth += 1
        elif code[i] in OPEN:
            depth -= 1
            if depth == 0:
                return i
    raise ValueError(f"the bracket at {at} never opens")
