#!/usr/bin/env python3
"""The constants of src/: where they stand, and whether the gate notices a change of each.

  constants.py --check        for CI: every constant has a unit and a reason, none stands
                              outside its block, CONSTANTS.md lists them all, and the gate
                              notices a sample of them halved and doubled
  constants.py [NAME...]      halves and doubles every constant (or those named), and says
                              which counters of the gate change
  constants.py --write        the same of all, and writes CONSTANTS.md

A block begins with the heading "/* ---- constants ---- */" and ends at the first thing that
is none. A constant is a comment "/* UNIT: REASON */" and a definition, "#define NAME VALUE"
or "enum { NAME = VALUE };".

CC names the compiler, gcc otherwise. Exit status 1 where anything is wrong.
"""

import argparse
import concurrent.futures
import os
import pathlib
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
GATE = pathlib.Path("tests/gate/gate.c")
DOCUMENT = ROOT / "CONSTANTS.md"
FLAGS = ["-O1", "-std=c99", "-ffp-contract=off", "-DRIGCAL_BUILD",
         "-DRIGCAL_CONFIG_FILE=<count_hooks.h>"]
SAMPLE, SEED = 3, 20  # How many constants --check changes, and which.
JOBS = 2
LIMIT = 120  # seconds of a run of the gate, after which it hangs

# Constants whose change is not noticed, and why that does no harm.
HARMLESS = {
    "adjust.RANK_TOL": "rounding: a smaller pivot is nothing but rounding too",
    "grow.SURE_LEAST": "a guard: with half of it one placement by chance would do",
    "grow.SURE_RUNG": "a guard: no pair of the scenes is sure by chance at a higher rung",
    "adjust.PASSES_MAX": "it bounds the worst case: no scene takes over 51",
    "camera.RAY_TERMS": "more terms only take time; with half of them rays are wrong",
    "score.RC_HALVINGS": "rounding: half of them are still within 1e-9 of the median",
    "judge.ROUNDS": "more rounds only take time: each names a view of every placement",
    "lens.WALK_MAX": "it bounds the worst case: no scene takes over 512",
    "lens.NEAR_STEPS": "more steps only take time: a pixel takes 3",
    "lens.WALK_LEFT": "rounding: the steps of a proof add up to the whole way, or to much less",
    "p3p.DEPTH_MIN": "rounding: the camera would touch the point",
    "p3p.LEAD_LEAST": "it keeps a division by rounding, and powers of its result, from overflowing",
    "p3p.CUBE_LEAST": "rounding: no root of a scene has so small a cube",
    "robust.MISFIT_LEAST": "one true pose in ten has less; chance decides there anyway",
    "sample.COUNTED_MAX": "it keeps a product from overflowing; 86 points have SAMPLES_MAX",
    "robust.ROUNDS": "it bounds the worst case: no scene takes over 4",
    "refine.PART": "a start by 24 points is as near as one by 12",
    "rotation.POLAR_ITERATIONS_MAX": "it bounds the worst case: no scene takes over 20",
    "tag.FRONT_LEAST": "no tag had a pose from the front beside one from behind: a guard",
    "triangulate.RC_TRIANGULATION_EVALS": "it bounds the worst case: no scene takes over 25",
}

# Numbers outside the blocks that decide nothing: the file, a pattern of the line, what the
# number is.
FACTS = [
    ("rc_real.h", r"RC_EPS \w+_EPSILON", "the type's own rounding"),
    ("rc_real.h", r"RC_PI RC\(3\.14", "pi"),
    ("rc_linalg.h", r"RC_SYM6_", "the layout of a matrix"),
    ("rc_linalg.h", r"define RC_IS_UNIT", "a precondition that is asserted"),
    ("rc_elimination.h", r"RC_NONE_ELIMINATED = 3", "the number of angles"),
    ("rc_p3p.h", r"RC_P3P_MAX = 4", "solutions that there can be"),
    ("rc_adjust.h", r"RC_RIG_DONE = 1", "the phases of a search"),
    ("rigcal_grow.c", r"CHECKING = 1", "the phases of a search"),
    ("rigcal_measure.c", r"CHECK = 1", "the phases of a search"),
    ("rc_evidence.h", r"RC_PAIRS = 3", "parameters that are tested together"),
    ("rc_sight.h", r"RC_SIGHT_REALS = 43", "the layout of a struct"),
    ("rigcal_clocks.c", r"PARTS = 18", "the layout of memory to work in"),
    ("rigcal_consider.c", r"SLOT_SINCE = 6", "the layout of memory to work in"),
    ("rigcal_logs.c", r"ROOT_2|LOG_2", "root and logarithm of 2"),
    ("rigcal_logs.c", r"rc_max\(y, RC_EPS / 2\)", "the least sum of 1 and a number"),
    ("rigcal_logs.c", r"LOG_CHUNK", "a power of 2 by which a number is divided first"),
    ("rigcal_chance.c", r"QUOTIENT_TERMS|^ +[{]*(1, )?RC", "coefficients of a quotient"),
    ("rigcal_chance.c", r"c \* d - 1[)] <= RC_EPS", "a fraction that no longer changes"),
    ("rigcal_chance.c", r"EXPECTED_UNIT RC", "a power of 2 in which numbers are counted"),
    ("rigcal_agree.c", r"RC_E RC", "e"),
    ("rc_agree.h", r"RC_AGREE_BINS = 16", "the layout of a struct"),
    ("rigcal_outline.c", r"width > RC_EPS", "rounding of a parameter"),
    ("rigcal_chance.c", r"rc_max[(]1 [+] x, RC_EPS[)]", "rounding of 1"),
    ("rigcal_spans.c", r"stride > RC_EPS", "a step of 0"),
    ("rigcal_times.c", r"RC_EPS \* rc_max", "rounding of a time"),
    ("rc_choose.h", r"define RC_CLAIM_REALS 39", "the layout of a struct"),
    ("rc_cost.h", r"RC_JUDGE_DONE = 1", "the phases of a search"),
    ("rigcal_cost.c", r"BLOCK_G = 21", "the layout of a block"),
    ("rigcal_judge.c", r"OUT = 1, OUT_TO_SEE", "marks of a view"),
    ("rc_score.h", r"define RC_SCORE_NONE", "below every score that there is"),
    ("rigcal_camera.c", r"enum \{ P1 = 6", "the layout of a struct"),
    ("rigcal_lens.c", r"enum \{ N_DEGREE = 4", "degrees of the lens's polynomials"),
    ("rigcal_diagnose.c", r"UNITS\[4\] = ", "ratios of units of length"),
    ("rigcal_camera.c", r"rr > RC_EPS \* RC_EPS", "rounding squared"),
    ("rigcal_seeds.c", r"TOO_WIDE = 2", "a bit"),
    ("rigcal_tag.c", r"16 \* RC_EPS \* rc_vec3_max_abs", "rounding of a product of vectors"),
    ("rigcal_seeds.c", r"GOLDEN\[2\] = ", "the golden angle"),
    ("rigcal_bytes.c", r"DROPPED = 52 - 23", "the form of IEEE numbers"),
    ("rigcal_direction.c", r"EXTENT_LEAST \* RC_EPS", "rounding squared"),
    ("rigcal_pairs.c", r"PAIRS_LEAST = 3", "a pair for each unknown angle"),
    ("rigcal_pairs.c", r"size \* RC_EPS <= RC_SHAPE_ROUNDING", "rounding of a coordinate"),
    ("rigcal_points.c", r"\* RC_EPS <= RC_SHAPE_ROUNDING", "rounding of a coordinate"),
]


class Constant:
    """One constant: its place, and its parts."""

    def __init__(self, path, name, value, unit, why, span):
        self.path, self.name, self.value = path, name, value
        self.unit, self.why, self.span = unit, why, span

    @property
    def layer(self):
        return re.sub(r"^(rigcal|rc)_|\.[ch]$", "", self.path.name)

    @property
    def key(self):
        return f"{self.layer}.{self.name}"


HEADING = re.compile(r"/\* ---- constants -+ \*/\n")
ENTRY = re.compile(
    r"\s*/\*(?P<comment>(?:[^*]|\*(?!/))*)\*/\s*\n(?:#if[^\n]*\n)?"
    r"(?:#define (?P<macro>\w+) (?P<macro_value>[^\n]+)"
    r"|enum \{ (?P<name>\w+) = (?P<name_value>[^,}]+?) \};)\n"
    r"(?:#else\n#define [^\n]*\n#endif\n)?")


def read(path):
    """The constants of a file, the end of their block, and what is wrong with it."""
    text = path.read_text()
    heading = HEADING.search(text)
    if heading is None:
        return [], (0, 0), []
    found, wrong, at = [], [], heading.end()
    while True:
        entry = ENTRY.match(text, at)
        if entry is None:
            break
        comment = re.sub(r"\s*\n \* ?", " ", entry["comment"]).strip()
        if re.match(r"----", comment):
            break
        name = entry["macro"] or entry["name"]
        unit, colon, why = comment.partition(": ")
        if not colon:
            break  # this comment belongs to what follows the block
        if len(unit) > 60 or len(why) < 8:
            wrong.append(f"{path.name}: {name}: no unit, or no reason")
        kind = "macro_value" if entry["macro"] else "name_value"
        found.append(Constant(path, name, entry[kind].strip(), unit, why, entry.span(kind)))
        at = entry.end()
    if not found:
        wrong.append(f"{path.name}: a block of constants without any")
    return found, (heading.start(), at), wrong


def sources():
    return sorted([*(ROOT / "src").glob("*.c"), *(ROOT / "src").glob("*.h")])


def all_constants():
    constants, wrong = [], []
    for path in sources():
        found, block, complaints = read(path)
        constants += found
        wrong += complaints + strays(path, block)
    # The constants of a header and of its source together.
    return sorted(constants, key=lambda c: c.layer), wrong


# Numbers that decide something: a float that is not 0, 1, 2 or a half; a multiple of
# rounding; a named number.
STRAYS = [
    re.compile(r"RC\((?!-?(?:0|1|2|3|0\.5|-0\.5)\))-?\d[\d.e+-]*\)"),
    re.compile(r"\bRC_EPS\b"),
    re.compile(r"\bRC_TOL\((?!for_)"),
    re.compile(r"^#define \w+ \(?\d"),
    re.compile(r"\benum \{ \w+ = (?!0\b)[\d(]"),
]


def strays(path, block):
    """Finds numbers that decide something and stand outside the block."""
    text = path.read_text()
    text = text[:block[0]] + re.sub(r"[^\n]", "", text[block[0]:block[1]]) + text[block[1]:]
    text = re.sub(r"/\*.*?\*/", lambda m: re.sub(r"[^\n]", "", m[0]), text, flags=re.S)
    wrong = []
    for number, line in enumerate(text.splitlines(), 1):
        if any(stray.search(line) for stray in STRAYS) and not any(
                path.name == name and re.search(fact, line) for name, fact, _ in FACTS):
            wrong.append(f"{path.name}:{number}: a number outside the block of constants: "
                         f"{line.strip()}")
    return wrong


# ---- the gate, built with one constant changed ----------------------------------


class Bench:
    """Compiles the library and the gate once. After a change one file is compiled again."""

    def __init__(self, folder, real):
        self.folder = pathlib.Path(folder) / real
        self.folder.mkdir()
        self.cc = shlex.split(os.environ.get("CC", "gcc"))
        self.flags = [*FLAGS, *(["-DRIGCAL_USE_FLOAT=1"] if real == "float" else [])]
        self.files = [*sorted((ROOT / "src").glob("rigcal_*.c")), ROOT / GATE]
        self.objects = {path: self.folder / (path.stem + ".o") for path in self.files}
        with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
            list(pool.map(lambda path: self.compile(path, self.objects[path]), self.files))
        self.expected = self.run(self.objects, self.folder / "gate")

    def compile(self, path, out, headers=None):
        include = [headers] if headers else []
        include += [ROOT / "src", ROOT / "include", ROOT / "tests/support"]
        subprocess.run([*self.cc, *self.flags, *[f"-I{i}" for i in include], "-c", path, "-o",
                        out], check=True)

    def run(self, objects, program):
        subprocess.run([*self.cc, *objects.values(), "-lm", "-o", program], check=True)
        try:
            seen = subprocess.run([program], capture_output=True, text=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            return {"hangs": "yes"}
        if seen.returncode != 0:
            return {"crashes": "yes"}
        return dict(line.split(" ", 1) for line in seen.stdout.splitlines()
                    if not line.startswith("stack."))

    def changed(self, constant, by):
        """The counters that differ after the change of a constant: {name: (expected,
        seen)}."""
        with tempfile.TemporaryDirectory(dir=self.folder) as work:
            work = pathlib.Path(work)
            text = constant.path.read_text()
            begin, end = constant.span
            # the value alone, because it may be that of an enum
            value = f"(({constant.value}) {by})"
            text = text[:begin] + value + text[end:]
            objects = dict(self.objects)
            (work / "src").mkdir()
            if constant.path.suffix == ".h":
                for path in sources():  # an include in "" is searched first in the folder
                                        # of the includer
                    shutil.copy(path, work / "src")
                (work / "src" / constant.path.name).write_text(text)
                for path in self.files:
                    copy = work / "src" / path.name
                    if path == ROOT / GATE:
                        shutil.copy(path, copy)
                    objects[path] = work / (path.stem + ".o")
                    self.compile(copy, objects[path], work / "src")
            else:
                copy = work / "src" / constant.path.name
                copy.write_text(text)
                objects[constant.path] = work / "changed.o"
                self.compile(copy, objects[constant.path])
            seen = self.run(objects, work / "gate")
        names = {**self.expected, **seen}
        return {name: (self.expected.get(name), seen.get(name)) for name in names
                if self.expected.get(name) != seen.get(name)}


def number(text):
    try:
        return float(text.split()[0])
    except (AttributeError, ValueError, IndexError):
        return 0.0


def tell(expected, changes):
    """A change of counters in a few words."""
    if not changes:
        return "nothing"
    if "hangs" in changes:
        return "the gate hangs"
    if "crashes" in changes:
        return "the gate crashes"
    told = []
    for end, words in ((".misses", "misses"), (".wrong_ok", "wrong OK")):
        by = sum(number(seen) - number(was) for name, (was, seen) in changes.items()
                 if name.endswith(end))
        if by:
            told.append(f"{words} {by:+.0f}")
    groups = {".steps", ".calls", ".misses", ".wrong_ok", ".found"}
    statuses = [name for name in changes if re.search(r"\.[A-Z]", name)]
    if statuses:
        moved = sum(abs(number(seen) - number(was))
                    for was, seen in (changes[name] for name in statuses)) / 2
        told.append(f"statuses {moved:.0f}")
    for end, words in ((".steps", "steps"), (".calls", "calls")):
        before = sum(number(value) for name, value in expected.items() if name.endswith(end))
        by = sum(number(seen) - number(was) for name, (was, seen) in changes.items()
                 if name.endswith(end))
        if any(name.endswith(end) for name in changes):
            told.append(f"{words} {100 * by / before:+.2g} %")
    edges = [name for name in changes
             if name not in statuses and not any(name.endswith(end) for end in groups)]
    if edges:
        was, seen = changes[edges[0]]
        more = f" and {len(edges) - 1} more" if len(edges) > 1 else ""
        told.insert(0, f"`{edges[0]}` {was} to {seen}{more}")
    return ", ".join(told) if told else f"{len(changes)} counters"


WAYS = ("/ 2", "* 2")


def measure(benches, constants):
    """{key: [halved, doubled]}: what the gate notices, in words. If it notices nothing in
    double, what it notices in float."""
    told = {c.key: ["nothing", "nothing"] for c in constants}
    for real, bench in benches.items():
        with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
            jobs = {(c.key, way): pool.submit(bench.changed, c, by) for c in constants
                    for way, by in enumerate(WAYS) if told[c.key][way] == "nothing"}
        for (key, way), job in jobs.items():
            if job.result():
                words = tell(bench.expected, job.result())
                told[key][way] = words if real == "double" else f"{real}: {words}"
    return told


def missed(told):
    return [f"{key}: nothing notices it {how}" for key, ways in told.items()
            for how, words in zip(("halved", "doubled"), ways)
            if words == "nothing" and key not in HARMLESS]


# ---- the document ----------------------------------------------------------------

INTRODUCTION = """# Constants

The numbers in `src/` that decide what the library does. Each layer lists its own in one
block at the top of its file. The last two columns tell what changes when the number is
halved or doubled, as `tests/gate/gate.c` counts it in double, or else in float. A name in
`code` is a counter, often an edge: the input at which a status changes. "Misses" are scenes
whose pose is not among those found. "Wrong OK" are scenes with a wrong first pose and the
status OK. "Statuses" are scenes that get another status. "Steps" and "calls" (of math
functions) are work.

Written by `python3 tests/gate/constants.py --write`.
"""


def cell(text):
    return text.replace("|", "\\|")


def document(constants, told):
    lines = [INTRODUCTION.rstrip("\n")]
    layer = None
    for c in constants:
        if c.layer != layer:
            layer = c.layer
            lines += [f"\n## {layer}\n", "| constant | value | unit | why | halved | doubled |",
                      "| --- | --- | --- | --- | --- | --- |"]
        halved, doubled = (cell(words) for words in told[c.key])
        lines.append(f"| {c.name} | `{cell(c.value)}` | {cell(c.unit)} | {cell(c.why)} | "
                     f"{halved} | {doubled} |")
    if HARMLESS:
        lines.append("\n## Harmless\n\nNot noticed when halved or doubled, and why that does "
                     "no harm.\n\n| constant | why |\n| --- | --- |")
        lines += [f"| {key} | {why} |" for key, why in HARMLESS.items()]
    return "\n".join(lines) + "\n"


def is_listed(constants):
    """Whether CONSTANTS.md has every constant with its value, unit and reason, and no other."""
    text = DOCUMENT.read_text() if DOCUMENT.exists() else ""
    wanted = {f"| {c.name} | `{cell(c.value)}` | {cell(c.unit)} | {cell(c.why)} |"
              for c in constants}
    listed = set(re.findall(r"^(\| \w+ \| `.*?` \| .*? \| .*? \|) .* \| .* \|$", text, re.M))
    return [f"CONSTANTS.md: not as in src/: {row}" for row in sorted(wanted ^ listed)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    constants, wrong = all_constants()
    known = {c.key for c in constants}
    wrong += [f"HARMLESS: there is no {key}" for key in HARMLESS if key not in known]
    if len(HARMLESS) > 20:
        wrong.append("HARMLESS: more than 20")
    if arguments.check:
        wrong += is_listed(constants)
        chosen = random.Random(SEED).sample([c for c in constants if c.path.suffix == ".c"],
                                            SAMPLE)
    elif arguments.names:
        chosen = [c for c in constants if c.name in arguments.names or c.key in arguments.names
                  or c.layer in arguments.names]
    else:
        chosen = constants
    with tempfile.TemporaryDirectory() as folder:
        told = measure({real: Bench(folder, real) for real in ("double", "float")}, chosen)
    if not arguments.check:
        for c in chosen:
            print(f"{c.key:32s} {c.value:28s} halved: {told[c.key][0]}; "
                  f"doubled: {told[c.key][1]}")
    wrong += missed(told)
    for complaint in wrong:
        print(complaint)
    if arguments.write:
        DOCUMENT.write_text(document(constants, told))
    print(f"constants: {len(constants)}, {len(chosen)} of them changed, {len(wrong)} faults")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
