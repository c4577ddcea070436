#!/usr/bin/env python3
"""Changes one thing of the library at a time and looks whether a test notices.

    mutate.py                      the recorded mutant of every file of src/: the step of CI
    mutate.py --per-file 25        the first 25 of each, in an order that --seed N shuffles
    mutate.py --all                every mutant that there is: days
    mutate.py NAME...              only these layers, e.g. pose rig
    mutate.py --list NAME          the mutants of a layer, numbered
    mutate.py --only NAME:NUMBER   one mutant, and what its tests say
    mutate.py --record             writes RESULTS.md and recorded.csv of the results so far

A mutant changes a relation, a condition, an operator, a sign, a number, a return value, or
leaves a statement out; assertions and traces stay. Its file is compiled with assertions and
with the sanitizer of undefined behaviour, which traps; what it does not initialize has huge
numbers. It is linked before the library, and run against the tests of its layer, those that
call most of its functions, those of the layers that include it, and bounds. The library of
bounds counts calls, and is compiled with the mutant anew. Tests come in the order of their
time, divided by the share of this layer's mutants that each killed so far. A test that fails,
crashes or takes 20 times as long kills the mutant. Where none does and the preset asan is
built, a few tests run again with the address sanitizer, those of the layer first. A survivor
is equivalent if gcc -O2 makes the same object of it, or equivalent.txt says why no test can
kill it; any other is printed. Exit status 1 where a survivor is left or equivalent.txt is
stale.

The recorded mutant of a file is, of those that a test killed, the one of the fastest test,
and of these the first by the seed; recorded.csv names mutant and test. A file without one
has none in CI. Where it is gone from the source, the first by the seed takes its place.

Build the preset gcc-double first, and for campaigns asan with all trials
(cmake --preset asan -DRIGCAL_TEST_ONE_IN=1). Results are appended to
build/mutation/results.csv: a run that was ended goes on where it was. A mutant runs again
when its file changed, or when it survived and a test changed.
"""
import argparse
import collections
import concurrent.futures
import csv
import datetime
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/gcc-double"
ASAN = ROOT / "build/asan"
WORK = ROOT / "build/mutation"
RECORDED = pathlib.Path(__file__).with_name("recorded.csv")
REPORT = pathlib.Path(__file__).with_name("RESULTS.md")
EQUIVALENT = pathlib.Path(__file__).with_name("equivalent.txt")
SEED = 22
TESTS_MOST = 12  # tests of a mutant: of its layer and the nearest ones; then LAST
LAST = ("hostile", "bounds")
CALLERS_MOST = 4  # of these: tests of other layers that call most of its functions, none of them slow
CALLER_SECONDS = 10
ASAN_TESTS = 4  # of those, and none that takes longer without it
ASAN_SECONDS = 2
SAME = "compiler: the same"
SLOW = 20  # times the usual time of a test, and 10 s: then it hangs

RELATIONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
OPERATORS = {"&&": "||", "||": "&&", "+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "++": "--",
             "--": "++", "|=": "&=", "&=": "|="}
TOKEN = re.compile(r"""/\*.*?\*/ | //[^\n]* | "(?:\\.|[^"\\])*" | '(?:\\.|[^'\\])*' | ^[ \t]*\#(?:\\\n|[^\n])*
    | [A-Za-z_]\w* | (?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?[uUlLfF]* | 0[xX][\da-fA-F]+
    | \+\+|--|->|<<=|>>=|<=|>=|==|!=|&&|\|\||\+=|-=|\*=|/=|\|=|&=|<<|>> | \S""", re.X | re.S | re.M)

DECLARED = re.compile(r"\s*(?:static\s+)?(?:const\s+)?(?:(?:rigcal|rc)_\w+|double|float|int|size_t|u?int\d+_t)\s+\w+"
                      r"(?:[^={}]|=\s*\{[^{}]*\})*\[$")

Mutant = collections.namedtuple("Mutant", "layer number line kind start end text")


class Source:
    """A file of src/: its text, and the places that can be changed."""

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
        untouched = -1  # the end of an assertion or trace was not reached yet
        begun = 0  # the statement
        tokens = [m for m in TOKEN.finditer(self.text) if not m[0].startswith(("/*", "//"))]
        for at, token in enumerate(tokens):
            word, start, end = token[0], *token.span()
            after = tokens[at + 1][0] if at + 1 < len(tokens) else ""
            depth += (word == "{") - (word == "}")
            if word in ("RIGCAL_ASSERT", "RIGCAL_TRACE"):
                untouched = self.text.index(";", start)
            if word in (";", "{", "}") and start >= untouched:
                begun = end
            if depth > 0 and start > untouched and not word.startswith(("#", '"', "'")):
                is_binary = bool(re.match(r"[\w)\]]", before[-1:])) and before not in ("return", "case", "sizeof")
                if word in RELATIONS:
                    add("relation", start, end, RELATIONS[word])
                elif word == "-" and not is_binary:
                    add("sign", start, end, "")
                elif word in OPERATORS and (is_binary or word not in ("*", "+")) and not self.is_pointer(tokens, at):
                    add("operator", start, end, OPERATORS[word])
                elif word == "!":
                    add("condition", start, end, "")
                elif re.fullmatch(r"\d+", word) and DECLARED.match(self.text[begun:start]):
                    if int(word) > 1:  # a longer array does no harm
                        add("number", start, end, str(int(word) - 1))
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


def is_own(test: str, layer: str) -> bool:
    """Whether a test is of this layer."""
    return test == layer or test.startswith((layer + "_", f"regression_{layer}_"))


class Bench:
    """How a file is compiled, and the tests of each layer."""

    def __init__(self, build: pathlib.Path) -> None:
        self.build = build
        said = subprocess.run(["ninja", "-C", str(build), "-t", "commands"], capture_output=True, text=True)
        if said.returncode or not (build / "librigcal.a").exists():
            sys.exit(f"mutate.py: build the preset {build.name} first")
        self.compile: dict[str, list[str]] = {}
        self.counted: dict[str, list[str]] = {}  # how test_bounds compiles it
        self.link: dict[str, list[str]] = {}
        for command in said.stdout.splitlines():
            if match := re.search(r"-o CMakeFiles/rigcal\.dir/src/rigcal_(\w+)\.c\.o ", command):
                words = [w for w in shlex.split(command) if w != "-Werror" and not w.startswith(("-O", "-W", "-g"))]
                self.compile[match[1]] = [*words[:words.index("-MD")], f"-I{ROOT / 'src'}", "-w", "-O0"]
            elif match := re.search(r"-o tests/CMakeFiles/rigcal_counted\.dir/\S*/rigcal_(\w+)\.c\.o ", command):
                words = shlex.split(command)
                self.counted[match[1]] = [*words[:words.index("-MD")], "-w"]
            elif match := re.search(r" -o tests/test_(\w+) ", command):
                if (build / "tests" / f"test_{match[1]}").exists() and (
                        "src/rigcal_" not in command or match[1] == "bounds" and build != ASAN):  # none compiled again
                    self.link[match[1]] = shlex.split(command.removeprefix(": && ").removesuffix(" && :"))
        if build != ASAN:
            for words in self.compile.values():
                words += ["-DRIGCAL_ASSERTS=1", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error",
                          "-ftrivial-auto-var-init=pattern"]
        self.includes = {layer: self.included(layer) for layer in self.compile}
        self.called = {test: set(re.findall(r"\b(?:rigcal|rc)_\w+", text_of(test))) for test in self.link}
        self.lock = threading.Lock()
        self.times_file = WORK / f"times-{build.name}.json"
        self.times: dict[str, float] = json.loads(self.times_file.read_text()) if self.times_file.exists() else {}

    @staticmethod
    def included(layer: str) -> set[str]:
        texts = [(ROOT / "src" / f"rigcal_{layer}.c").read_text()]
        header = ROOT / "src" / f"rc_{layer}.h"
        if header.exists():
            texts.append(header.read_text())
        return set(re.findall(r'#include "rc_(\w+)\.h"', "".join(texts))) - {layer}

    def tests_of(self, layer: str) -> list[str]:
        """The layer's own test, the tests that call most of its functions, and those of
        layers that include it."""
        order, wave = [layer], {layer}
        while wave:
            wave = {other for other in self.includes if self.includes[other] & wave and other not in order}
            order += sorted(wave)
        of = {at: [name for name in sorted(self.link) if name == at or name.startswith((at + "_", f"regression_{at}_"))]
              for at in order}
        text = (ROOT / "src" / f"rigcal_{layer}.c").read_text()
        functions = re.findall(r"^(?!static|typedef| |#|/).*?\b((?:rigcal|rc)_\w+)\(", text, re.M)
        calls = {name: len(self.called[name].intersection(functions)) for name in self.link}
        callers = sorted((name for name in calls if calls[name] and self.times.get(name, 0) < CALLER_SECONDS),
                         key=lambda name: (-calls[name], name))
        seen = list(dict.fromkeys(of[layer] + callers[:CALLERS_MOST] + [name for at in order for name in of[at]]))
        nearest = [t for t in seen if t not in LAST][:TESTS_MOST]
        return nearest + [t for t in LAST if nearest and t in self.link]

    def time_of(self, test: str) -> float:
        """The seconds of a test without a mutant, measured once."""
        with self.lock:
            if test not in self.times:
                start = time.monotonic()
                done = subprocess.run([self.build / "tests" / f"test_{test}"], cwd=self.build / "tests",
                                      capture_output=True)
                if done.returncode:
                    sys.exit(f"mutate.py: test_{test} fails without a mutant")
                self.times[test] = time.monotonic() - start
                self.times_file.write_text(json.dumps(self.times, indent=0))
            return self.times[test]

    def killer(self, source: Source, mutant: Mutant, tests: list[str], lane: int) -> str:
        """The first test that kills the mutant, "compiler", or nothing."""
        changed, obj, program = (WORK / f"{self.build.name}-{lane}-{name}" for name in ("mutant.c", "mutant.o", "test"))
        changed.write_text(source.text[:mutant.start] + mutant.text + source.text[mutant.end:])
        command = [*self.compile[source.layer], "-o", str(obj), "-c", str(changed)]
        if subprocess.run(command, cwd=self.build, capture_output=True).returncode:
            return "compiler"
        for test in tests:
            limit = 10 + SLOW * self.time_of(test)
            words = list(self.link[test])
            words[words.index("-o") + 1] = str(program)
            if test == "bounds":
                counted = str(obj) + ".counted.o"
                subprocess.run([*self.counted[source.layer], f"-I{ROOT / 'src'}", "-o", counted, "-c", str(changed)],
                               cwd=self.build, check=True, capture_output=True)
                words = [counted if word.endswith(f"/rigcal_{source.layer}.c.o") else word for word in words]
            else:
                words.insert(words.index("librigcal.a"), str(obj))
            subprocess.run(words, cwd=self.build, check=True, capture_output=True)
            try:
                if subprocess.run([program], cwd=self.build / "tests", capture_output=True, timeout=limit).returncode:
                    return test
            except subprocess.TimeoutExpired:
                return test
        return ""


    def brief(self, layer: str, tests: list[str], usual: "Bench") -> list[str]:
        """The first few tests that do not take minutes with the address sanitizer. Those of
        the layer come first: they reach most of its lines."""
        order = sorted(tests, key=lambda test: not is_own(test, layer))
        return [test for test in order if test in self.link and usual.time_of(test) < ASAN_SECONDS][:ASAN_TESTS]

    def is_same(self, source: Source, mutant: Mutant, lane: int) -> bool:
        """Whether the compiler makes the same object of both. It does so for code that this
        build leaves out."""
        changed, obj = (WORK / f"{self.build.name}-{lane}-{name}" for name in ("mutant.c", "mutant.o"))
        made = []
        for text in (source.text, source.text[:mutant.start] + mutant.text + source.text[mutant.end:]):
            changed.write_text(text)
            words = [word for word in self.compile[source.layer] if not word.startswith(("-O", "-fsan", "-DRIGCAL_ASSERTS", "-ftri"))]
            subprocess.run([*words, "-O2", "-o", str(obj), "-c", str(changed)], cwd=self.build, check=True, capture_output=True)
            made.append(obj.read_bytes())
        return made[0] == made[1]


class Results:
    """The results so far: results.csv of this build folder. New rows are appended to it."""

    FIELDS = ["layer", "line", "kind", "key", "was", "became", "source", "tests", "killed_by", "seconds"]

    def __init__(self) -> None:
        WORK.mkdir(parents=True, exist_ok=True)
        self.path = WORK / "results.csv"
        self.lock = threading.Lock()
        self.known: dict[tuple[str, str], dict[str, str]] = {}
        self.kills: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
        if self.path.exists():
            with open(self.path, newline="") as file:
                for row in csv.DictReader(file):
                    self.take(row)
        else:
            self.path.write_text(",".join(self.FIELDS) + "\n")

    def take(self, row: dict[str, str]) -> None:
        self.known[row["layer"], row["key"]] = row
        self.kills[row["layer"]][row["killed_by"]] += 1

    def add(self, row: dict[str, str]) -> None:
        with self.lock, open(self.path, "a", newline="") as file:
            csv.DictWriter(file, self.FIELDS).writerow(row)
            self.take(row)

    def in_order(self, bench: Bench, layer: str, tests: list[str]) -> list[str]:
        """The order in which the tests are tried: the least expected time for a kill first.
        A test that ran on nothing yet counts as if it had killed one mutant of two, or one
        of ten if it belongs to another layer."""
        kills = self.kills[layer]
        total = sum(n for test, n in kills.items() if test != "compiler")

        def cost(test: str) -> float:
            usual = 0.5 if is_own(test, layer) else 0.1
            return (0.03 + bench.time_of(test)) * (total + 2) / (kills[test] + 2 * usual)
        return sorted(tests, key=cost)


def digest(*paths: pathlib.Path) -> str:
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths if path.exists())).hexdigest()[:12]


def file_of(test: str) -> pathlib.Path:
    name = test.removeprefix("regression_")
    return ROOT / "tests" / (f"test_{name}.c" if name == test else f"regression/{name}.c")


def text_of(test: str) -> str:
    path = file_of(test)
    return path.read_text() if path.exists() else ""


def digest_of_tests(tests: list[str], has_asan: bool) -> str:
    return "asan " * has_asan + "pattern " + digest(*map(file_of, sorted(tests)))


def equivalents() -> dict[tuple[str, str, str, str], str]:
    """{(layer, line, text before, text after): why}."""
    known = {}
    for number, line in enumerate(EQUIVALENT.read_text().splitlines(), 1):
        if line and not line.startswith("#"):
            parts = [part.strip() for part in line.split(" | ")]
            if len(parts) != 5 or not parts[4]:
                sys.exit(f"{EQUIVALENT.name}:{number}: layer | line | was | became | why")
            known[(*parts[:4],)] = parts[4]
    return known


def key_of(source: Source, m: Mutant) -> tuple[str, str, str, str]:
    """(layer, line, text before, text after). "+ (2)" is the second + of its line."""
    was = source.text[m.start:m.end]
    before = source.text[source.text.rfind("\n", 0, m.start) + 1:m.start].count(was)
    return (source.layer, source.line(m.line), " ".join(was.split()) + f" ({before + 1})" * (before > 0), m.text.strip())


def place_of(m: Mutant) -> str:
    return f"{m.start}:{m.text.strip()}"


def kept(results: Results, source: Source, m: Mutant, of_tests: str) -> dict[str, str] | None:
    """The result of a mutant, if it is still valid."""
    row = results.known.get((source.layer, place_of(m)))
    if row and row["source"] == digest(source.path) and (row["killed_by"] or row["tests"] == of_tests):
        return row
    return None


def shuffled(mutants: list[Mutant], source: Source, seed: int) -> list[Mutant]:
    """An order that depends only on the text of each mutant. A change of the file moves no
    other mutant."""
    def place(m: Mutant) -> str:
        return hashlib.sha256(f"{seed} {key_of(source, m)}".encode()).hexdigest()
    return sorted(mutants, key=lambda m: (place(m), m.number))


def recorded() -> dict[str, dict[str, str]]:
    if not RECORDED.exists():
        return {}
    with open(RECORDED, newline="") as file:
        return {row["layer"]: row for row in csv.DictReader(file)}


def record(results: Results, layers: list[str], known: dict[tuple[str, str, str, str], str], seed: int) -> None:
    """Writes recorded.csv and RESULTS.md."""
    rows, table, left, total = [], [], [], collections.Counter[str]()
    times = Bench(BUILD).time_of
    for layer in layers:
        source = Source(layer)
        mutants = shuffled(source.mutants(), source, seed)
        count: collections.Counter[str] = collections.Counter()
        best: tuple[float, int, dict[str, str]] | None = None
        for place, m in enumerate(mutants):
            row = results.known.get((layer, place_of(m)))
            key = key_of(source, m)
            if key in known:
                what = "equivalent"
            elif not row or row["source"] != digest(source.path):
                continue
            else:
                what = {"": "survivors", "compiler": "", SAME: "equivalent"}.get(row["killed_by"], "killed")
                total["asan"] += row["killed_by"].startswith("asan ")
                if what == "survivors":
                    left.append(f"- `{layer}`, line {m.line}: `{key[1]}`: `{key[2]}` to `{key[3]}`")
                # A shorter array is noticed by chance.
                if what == "killed" and not row["killed_by"].startswith("asan ") and source.text[m.start - 1] != "[":
                    cost = times(row["killed_by"])
                    chosen = {"layer": layer, "line": key[1], "was": key[2], "became": key[3], "test": row["killed_by"]}
                    best = min((cost, place, chosen), best or (9e9, 0, chosen), key=lambda b: b[:2])
            count[what] += bool(what)
        total += count
        if best:
            rows.append(best[2])
        tried = count["killed"] + count["survivors"]
        share = f"{100 * count['killed'] / tried:.0f}" if tried else ""
        table.append(f"| `{layer}` | {len(mutants)} | {tried + count['equivalent']} | {count['killed']} "
                     f"| {count['equivalent']} | {count['survivors']} | {share} |")
    with open(RECORDED, "w", newline="") as file:
        writer = csv.DictWriter(file, ["layer", "line", "was", "became", "test"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout
    tried = total["killed"] + total["survivors"]
    REPORT.write_text(f"""# Results of mutation

Written by `python3 tests/mutation/mutate.py --record` on {datetime.date.today()}, commit {commit.strip()}, seed {seed}.
Mutants that do not compile are not counted. "There" are all mutants of a file, "run" those whose result is known.

{tried + total['equivalent']} mutants of {len(layers)} files: {total['killed']} killed, {total['equivalent']} equivalent, """
                      f"""{total['survivors']} survivors: {100 * total['killed'] / max(tried, 1):.1f} % of those that are not equivalent are killed.
{total['asan']} of the killed were noticed by the address sanitizer alone. Why a mutant is equivalent is in equivalent.txt, or gcc
makes the same of it.

| file | there | run | killed | equivalent | survivors | killed % |
| --- | --- | --- | --- | --- | --- | --- |
""" + "\n".join(table) + "\n\n## Survivors\n\n" + ("\n".join(left) or "None.") + "\n")


def chosen_of(source: Source, options: argparse.Namespace, row: dict[str, str] | None) -> list[Mutant]:
    mutants = source.mutants()
    if options.only:
        return [mutants[int(options.only.partition(":")[2])]]
    if options.all:
        return mutants
    order = shuffled(mutants, source, options.seed)
    if options.per_file:
        return order[:options.per_file]
    if not row:
        return []
    key = (source.layer, row["line"], row["was"], row["became"])
    return ([m for m in mutants if key_of(source, m) == key] or order)[:1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("layers", nargs="*", metavar="NAME")
    parser.add_argument("--per-file", type=int)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", metavar="NAME")
    parser.add_argument("--only", metavar="NAME:NUMBER")
    parser.add_argument("--record", action="store_true")
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
    results, known = Results(), equivalents()
    bench = Bench(BUILD)
    if options.record:
        record(results, [name for name in names if bench.tests_of(name)], known, options.seed)
        return 0
    asan = Bench(ASAN) if (ASAN / "librigcal.a").exists() and (ASAN / "build.ninja").exists() else None
    layers = [name for name in (asked if asked[0] else names) if name in bench.compile and bench.tests_of(name)]
    is_ci = not (options.only or options.all or options.per_file)
    history = recorded()
    count: collections.Counter[str] = collections.Counter()
    lanes = list(range(options.jobs))

    def run(source: Source, m: Mutant) -> None:
        key, layer = key_of(source, m), source.layer
        if key in known:
            count["equivalent"] += 1
            return
        tests = bench.tests_of(layer)
        of_tests = digest_of_tests(tests, asan is not None)
        row = None if options.only or is_ci else kept(results, source, m, of_tests)
        if not row:
            lane, start = lanes.pop(), time.monotonic()
            first = history.get(layer, {}).get("test", "") if is_ci else ""
            killer = bench.killer(source, m, [first], lane) if first in bench.link else ""
            order = [] if killer else results.in_order(bench, layer, tests)
            killer = killer or bench.killer(source, m, order, lane)
            if not killer and asan and (has := asan.brief(layer, order, bench)):
                killer = asan.killer(source, m, has, lane)
                killer = killer and "asan " + killer
            if not killer and bench.is_same(source, m, lane):
                killer = SAME
            lanes.append(lane)
            row = {"layer": layer, "line": f"{m.line}", "kind": m.kind, "key": place_of(m), "was": key[2],
                   "became": key[3], "source": digest(source.path), "tests": of_tests,
                   "killed_by": killer, "seconds": f"{time.monotonic() - start:.1f}"}
            results.add(row)
        count[{"": "survive", "compiler": "compiler", SAME: "equivalent"}.get(row["killed_by"], "killed")] += 1
        if not row["killed_by"]:
            print(f"src/{source.path.name}:{m.line}: {key[2]!r} to {key[3]!r} ({m.kind}, {m.number}) survives: {key[1]}",
                  flush=True)
        elif options.only:
            print(f"killed by {row['killed_by']}")

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        sources = [Source(layer) for layer in layers]
        work = [(source, list(chosen_of(source, options, history.get(source.layer)))) for source in sources]
        turns = max(len(mutants) for _, mutants in work)
        tasks = [pool.submit(run, source, mutants[turn]) for turn in range(turns)
                 for source, mutants in work if turn < len(mutants)]
        for task in tasks:
            task.result()
    seen = count["killed"] + count["survive"]
    used = os.times()
    print(f"mutation: {count['killed']} of {seen} mutants killed in {sum(bool(mutants) for _, mutants in work)} files; "
          f"{count['equivalent']} equivalent, {count['compiler']} that do not compile; "
          f"{used.children_user + used.children_system + used.user:.0f} s of a processor")
    there = {key_of(source, m) for source in map(Source, {key[0] for key in known}) for m in source.mutants()}
    stale = [key for key in known if key not in there]
    for key in stale:
        print(f"{EQUIVALENT.name}: there is no such mutant: {' | '.join(key)}")
    return bool(count["survive"] or stale)


if __name__ == "__main__":
    sys.exit(main())
