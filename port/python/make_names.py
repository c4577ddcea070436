#!/usr/bin/env python3
"""Writes rigcal/_names.py: the statuses and constants of the headers.

    python3 port/python/make_names.py [--check]

--check writes nothing, and fails where the file is not what it would write.
"""

from __future__ import annotations

import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
INCLUDE = HERE.parents[1] / "include"
OUT = HERE / "rigcal/_names.py"
# Headers that are only for the library and the published procedure.
SKIPPED = {"rigcal_solvers.h", "rigcal_config.h", "rigcal_paper.h"}
HEAD = '''"""Statuses and constants of the C headers. Made by make_names.py: do not edit."""

from __future__ import annotations

import enum
from typing import Final
'''


def statuses(text: str) -> list[tuple[str, int, str]]:
    table = text[text.index("#define RIGCAL_STATUSES(S)") : text.index("typedef int32_t")]
    table = re.sub(r"/\*.*?\*/", "", table.replace("\\\n", "\n"), flags=re.S)
    found = re.findall(r'S\((\w+), (-?\d+),((?:\s*"(?:[^"\\]|\\.)*")+)\s*\)', table)
    return [
        (name, int(number), "".join(re.findall(r'"(.*?)"', texts)))
        for name, number, texts in found
    ]


def enums(text: str) -> list[tuple[str, list[tuple[str, int]]]]:
    """Every enum: its name and its members."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    found = []
    for name, body in re.findall(r"\benum rigcal_(\w+) \{(.*?)\}", text, flags=re.S):
        members, value = [], -1
        for item in (part.strip() for part in body.split(",")):
            if not re.match(r"RIGCAL_\w+( = |$)", item):
                continue
            member, _, number = item.partition(" = ")
            value = eval(number, {}, dict(members)) if number else value + 1
            members.append((member, value))
        if members:
            found.append((name, members))
    return found


def wrapped(text: str, indent: str) -> str:
    """A text as Python literals, one for each line."""
    words, lines = text.split(" "), [""]
    for word in words:
        if len(indent) + len(lines[-1]) + len(word) > 84:
            lines.append("")
        lines[-1] += word + " "
    lines[-1] = lines[-1][:-1]
    return "".join(f'{indent}"{line}"\n' for line in lines)


def enum_class(name: str, doc: str, members: list[tuple[str, int]]) -> str:
    body = "".join(f"    {member} = {value}\n" for member, value in members)
    return f'\n\nclass {name}(enum.IntEnum):\n    """{doc}"""\n\n{body}'


def names() -> str:
    main = (INCLUDE / "rigcal.h").read_text(encoding="utf-8")
    listed = statuses(main)
    constants: list[tuple[str, int]] = []
    classes = enum_class(
        "Status",
        "What a function says: 0 done, above 0 done with a caveat, below 0 failed.",
        [(name, number) for name, number, _ in listed],
    )
    classes += (
        "\n    @property\n    def text(self) -> str:\n"
        '        """What is wrong, and what to do."""\n        return TEXTS[self]\n'
    )
    for path in sorted(INCLUDE.glob("*.h")):
        if path.name in SKIPPED:
            continue
        text = path.read_text(encoding="utf-8")
        for name, members in enums(text):
            if name.endswith("_limits"):
                constants += members
            elif name != "statuses":
                title = "".join(part.capitalize() for part in name.split("_"))
                classes += enum_class(title, f"enum rigcal_{name} of {path.name}.", members)
    out = HEAD + "\n"
    out += "".join(f"{name}: Final = {value}\n" for name, value in constants) + classes
    out += "\n\nTEXTS: Final = {\n"
    for name, _, text in listed:
        out += f"    Status.{name}: (\n{wrapped(text, ' ' * 8)}    ),\n"
    return out + "}\n"


def main() -> None:
    text = names()
    if sys.argv[1:] == ["--check"]:
        if OUT.read_text(encoding="utf-8") != text:
            sys.exit(f"{OUT.name} is not of these headers: run make_names.py")
    else:
        OUT.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
