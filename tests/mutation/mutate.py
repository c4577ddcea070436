#!/usr/bin/env python3
"""Changes one thing of the library at a time and looks whether a test notices.

    mutate.py                      one mutant of every file of src/, always the same
    mutate.py --per-file 25        so many of each, drawn anew by --seed N
    mutate.py --all                every mutant that there is: days
    mutate.py NAME...              only these layers, e.g. pose rig
    mutate.py --list NAME          the mutants of a layer, numbered
    mutate.py --only NAME:NUMBER   one mutant, and what its tests say

A mutant changes a relation, a condition, an operator, a sign, a number, a return value, or
leaves a statement out. The file is compiled as the preset asan does (address and undefined
behaviour sanitizers, assertions), linked before the library, and run against the test of its
layer, then of the layers that include it, nearest first. A test that fails, crashes or takes
20 times as long kills the mutant. A survivor is printed, unless equivalent.txt says why no
test can kill it. Exit status 1 where a survivor is left or equivalent.txt is stale.

Build the preset asan first. Results go to build/mutation/results.csv.
"""
import argparse
import collections
import csv
import pathlib
import random
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/asan"
WORK = ROOT / "build/mutation"
EQUIVALENT = pathlib.Path(__file__).with_name("equivalent.txt")
SEED = 22
TESTS_MOST = 8  # of a mutant: its own layer's, and the nearest that include it; then hostile
SLOW = 20  # times the usual time of a test, and 10 s: then it hangs

RELATIONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
OPERATORS = {"&&": "||", "||": "&&", "+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "++": "--",
             "--": "++", "|=": "&=", "&=": "|="}
TOKEN = re.compile(r"""/\*.*?\*/ | //[^\n]* | "(?:\\.|[^"\\])*" | '(?:\\.|[^'\\])*' | ^[ \t]*\#(?:\\\n|[^\n])*
    | [A-Za-z_]\w* | (?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?[uUlLfF]* | 0[xX][\da-fA-F]+
    | \+\+|--|->|<<=|>>=|<=|>=|==|!=|&&|\|\||\+=|-=|\*=|/=|\|=|&=|<<|>> | \S""", re.X | re.S | re.M)

Mutant = collections.namedtuple("Mutant", "layer number line kind start end text")


class Source:
    """A file of src/: its text and the places where it can be changed."""

    def __init__(self, layer: str) -> None:
        self.layer = layer
        self.path = ROOT / "src" / f"rigcal_{layer}.c"
        self.text = self.path.read_text()

    def line_of(self, at: int) -> int:
        return self.text.count("\n", 0, at) + 1

    def line(self, number: int) -> str:
        return self.text.split("\n")[number - 1].strip()

    def mutants(self) -> list[Mutant]:
        found: list[Mutant] = []

        def add(kind: str, start: int, end: int, text: str) -> None:
            found.append(Mutant(self.layer, len(found), self.line_of(start), kind, start, end, text))

        depth = 0
        before = ""
        tokens = [m for m in TOKEN.finditer(self.text) if not m[0].startswith(("/*", "//"))]
        for at, token in enumerate(tokens):
            word, start, end = token[0], *token.span()
            after = tokens[at + 1][0] if at + 1 < len(tokens) else ""
            depth += (word == "{") - (word == "}")
            if depth > 0 and not word.startswith(("#", '"', "'")):
                is_binary = bool(re.match(r"[\w)\]]", before[-1:])) and before not in ("return", "case", "sizeof")
                if word in RELATIONS:
                    add("relation", start, end, RELATIONS[word])
                elif word == "-" and not is_binary:
                    add("sign", start, end, "")
                elif word in OPERATORS and (is_binary or word not in ("*", "+")) and not self.is_pointer(tokens, at):
                    add("operator", start, end, OPERATORS[word])
                elif word == "!":
                    add("condition", start, end, "")
                elif re.fullmatch(r"\d+", word) and before not in ("case",):
                    add("number", start, end, str(int(word) + 1))
                elif re.fullmatch(r"[\d.]+(?:[eE][-+]?\d+)?", word) and before == "(":
                    add("number", start, end, f"({word} * 1.5)")
                elif word == "return" and after not in (";", ""):
                    stop = self.text.index(";", start)
                    value = self.text[end:stop].strip()
                    if re.fullmatch(r"RIGCAL_\w+|0|1", value):
                        other = {"0": "1", "1": "0", "RIGCAL_OK": "RIGCAL_ERR_RANGE"}.get(value, "RIGCAL_OK")
                        add("return", end, stop, " " + other)
                elif word in ("{", "}", ";"):
                    statement = re.match(r"\s*(?:\(void\))?[A-Za-z_][\w.>\[\]-]*(?:->|\.|\[[^;{}]*\])*[\w.>-]*\s*"
                                         r"(?:\([^;{}]*\)|[-+|&*/]?=[^=;{}][^;{}]*);", self.text[end:])
                    if statement and not re.match(r"\s*(?:const|static|return|RIGCAL_(?:ASSERT|TRACE))\b", statement[0]):
                        lead = len(statement[0]) - len(statement[0].lstrip())
                        add("statement", end + lead, end + statement.end(), ";")
            before = word
        return found

    @staticmethod
    def is_pointer(tokens: list[re.Match[str]], at: int) -> bool:
        """Whether a * after a type's name declares a pointer."""
        before = tokens[at - 1][0]
        return tokens[at][0] == "*" and (before in ("const", "int", "void", "char") or re.match(
            r"(?:rigcal_|rc_)\w*$|\w+_t$", before) is not None and tokens[at - 2][0] in (
                "const", ";", "{", "}", "(", ",", "static", "sizeof"))


class Bench:
    """How a file is compiled, and which tests a layer has."""

    def __init__(self) -> None:
        said = subprocess.run(["ninja", "-C", str(BUILD), "-t", "commands"], capture_output=True, text=True)
        if said.returncode or not (BUILD / "librigcal.a").exists():
            sys.exit("mutate.py: build the preset asan first")
        self.compile: dict[str, list[str]] = {}
        self.link: dict[str, list[str]] = {}
        for command in said.stdout.splitlines():
            if match := re.search(r"-o CMakeFiles/rigcal\.dir/src/rigcal_(\w+)\.c\.o ", command):
                words = [w for w in shlex.split(command) if w != "-Werror"]
                self.compile[match[1]] = words[:words.index("-MD")] + ["-w"]
            elif match := re.search(r" -o tests/test_(\w+) ", command):
                self.link[match[1]] = shlex.split(command.removeprefix(": && ").removesuffix(" && :"))
        self.includes = {layer: self.included(layer) for layer in self.compile}
        self.usual: dict[str, float] = {}

    @staticmethod
    def included(layer: str) -> set[str]:
        texts = [(ROOT / "src" / f"rigcal_{layer}.c").read_text()]
        header = ROOT / "src" / f"rc_{layer}.h"
        if header.exists():
            texts.append(header.read_text())
        return set(re.findall(r'#include "rc_(\w+)\.h"', "".join(texts))) - {layer}

    def tests_of(self, layer: str) -> list[str]:
        order, wave = [layer], {layer}
        while wave:
            wave = {other for other in self.includes if self.includes[other] & wave and other not in order}
            order += sorted(wave)
        named = [name for at in order for name in sorted(self.link)
                 if name == at or name.startswith((at + "_", f"regression_{at}_"))]
        seen = list(dict.fromkeys(named))
        nearest = [t for t in seen if t != "hostile"][:TESTS_MOST]
        return nearest + ["hostile"] * (bool(nearest) and "hostile" in self.link)

    def usual_time(self, test: str) -> float:
        if test not in self.usual:
            start = time.monotonic()
            done = subprocess.run([BUILD / "tests" / f"test_{test}"], cwd=BUILD / "tests", capture_output=True)
            if done.returncode:
                sys.exit(f"mutate.py: test_{test} fails without a mutant")
            self.usual[test] = time.monotonic() - start
        return self.usual[test]

    def killer(self, source: Source, mutant: Mutant) -> str:
        """The test that kills it, "compiler", or nothing."""
        WORK.mkdir(parents=True, exist_ok=True)
        changed, obj, program = WORK / "mutant.c", WORK / "mutant.o", WORK / "test"
        changed.write_text(source.text[:mutant.start] + mutant.text + source.text[mutant.end:])
        command = [*self.compile[source.layer], f"-I{ROOT / 'src'}", "-o", str(obj), "-c", str(changed)]
        if subprocess.run(command, cwd=BUILD, capture_output=True).returncode:
            return "compiler"
        for test in self.tests_of(source.layer):
            limit = 10 + SLOW * self.usual_time(test)
            words = list(self.link[test])
            words[words.index("-o") + 1] = str(program)
            words.insert(words.index("librigcal.a"), str(obj))
            subprocess.run(words, cwd=BUILD, check=True, capture_output=True)
            try:
                if subprocess.run([program], cwd=BUILD / "tests", capture_output=True, timeout=limit).returncode:
                    return test
            except subprocess.TimeoutExpired:
                return test
        return ""


def equivalents() -> dict[tuple[str, str, str, str], str]:
    """{(layer, line, what was there, what came): why}."""
    known = {}
    for number, line in enumerate(EQUIVALENT.read_text().splitlines(), 1):
        if line and not line.startswith("#"):
            parts = [part.strip() for part in line.split(" | ")]
            if len(parts) != 5 or not parts[4]:
                sys.exit(f"{EQUIVALENT.name}:{number}: layer | line | was | became | why")
            known[(*parts[:4],)] = parts[4]
    return known


def key_of(source: Source, m: Mutant) -> tuple[str, str, str, str]:
    return (source.layer, source.line(m.line), " ".join(source.text[m.start:m.end].split()), m.text.strip())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("layers", nargs="*", metavar="NAME")
    parser.add_argument("--per-file", type=int, default=1)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--list", metavar="NAME")
    parser.add_argument("--only", metavar="NAME:NUMBER")
    options = parser.parse_args()
    names = sorted(path.stem.removeprefix("rigcal_") for path in (ROOT / "src").glob("rigcal_*.c"))
    asked = options.layers or [options.list or (options.only or "").partition(":")[0]]
    for name in asked:
        if name and name not in names:
            parser.error(f"there is no layer {name}; there are {', '.join(names)}")
    if options.list:
        source = Source(options.list)
        for m in source.mutants():
            print(f"{m.number} {source.path.name}:{m.line} {m.kind}: {source.text[m.start:m.end]!r} to {m.text!r}")
        return 0
    bench, known = Bench(), equivalents()
    layers = [name for name in (asked if asked[0] else names) if name in bench.compile and bench.tests_of(name)]
    rows, used = [], set()
    for layer in layers:
        source = Source(layer)
        mutants = source.mutants()
        rng = random.Random(f"{options.seed} {layer}")
        if options.only:
            mutants = [mutants[int(options.only.partition(":")[2])]]
        elif not options.all:
            mutants = rng.sample(mutants, min(options.per_file, len(mutants)))
        for m in mutants:
            key = key_of(source, m)
            if key in known:
                used.add(key)
                rows.append([layer, m.line, m.kind, key[2], key[3], "equivalent"])
                continue
            killer = bench.killer(source, m)
            rows.append([layer, m.line, m.kind, key[2], key[3], killer or "SURVIVES"])
            if not killer:
                print(f"src/{source.path.name}:{m.line}: {key[2]!r} to {key[3]!r} ({m.kind}) survives: {key[1]}", flush=True)
    WORK.mkdir(parents=True, exist_ok=True)
    with open(WORK / "results.csv", "w", newline="") as file:
        csv.writer(file).writerows([["layer", "line", "kind", "was", "became", "killed_by"], *rows])
    count = collections.Counter("survive" if r[5] == "SURVIVES" else r[5] if r[5] in ("compiler", "equivalent")
                                else "killed" for r in rows)
    seen = count["killed"] + count["survive"]
    print(f"mutation: {count['killed']} of {seen} mutants killed in {len(layers)} files; "
          f"{count['equivalent']} equivalent, {count['compiler']} that do not compile")
    there = {key_of(source, m) for source in map(Source, {key[0] for key in known}) for m in source.mutants()}
    stale = [key for key in known if key not in there]
    for key in stale:
        print(f"{EQUIVALENT.name}: there is no such mutant: {' | '.join(key)}")
    return bool(count["survive"] or stale)


if __name__ == "__main__":
    sys.exit(main())
