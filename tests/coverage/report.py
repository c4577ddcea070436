#!/usr/bin/env python3
"""What of src/ the tests do not cover, against exceptions.txt.

    python3 tests/coverage/report.py [--update] PRECISION...

reads build/coverage-PRECISION/coverage.json, which tests/coverage/run.sh writes. An item is

    never-called    a function that does not run
    never-true      a condition, loop or case that is never true
    never-false     a condition or loop that is never false
    never-alone     a condition of several in a decision that never changes its outcome by
                    itself (MC/DC)

A line that does not run, in a function that does, hangs on an item of the second or third
kind. The conditions of a decision that are never true or false are not named again as
never-alone.

With --update it rewrites exceptions.txt: what is covered goes, what is new comes as open.
"""

import argparse
import json
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXCEPTIONS = os.path.join(ROOT, "tests", "coverage", "exceptions.txt")
OPEN = "open"  # stands in place of a proof


class Source:
    """The text of a file between two places."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as f:
            self.lines = f.read().split("\n")

    def text(self, line, column, last_line, last_column):
        if line == last_line:
            part = self.lines[line - 1][column - 1:last_column - 1]
        else:
            part = " ".join([self.lines[line - 1][column - 1:],
                             *self.lines[line:last_line - 1],
                             self.lines[last_line - 1][:last_column - 1]])
        return " ".join(part.split())


def functions_of(data):
    """For each file: the range of each function, its name, and how often it ran."""
    found = {}
    for function in data["functions"]:
        name = function["name"].rsplit(":", 1)[-1]
        body = function["regions"][0]
        place = found.setdefault(function["filenames"][0], {})
        key = tuple(body[:4])
        place[key] = (name, place.get(key, (name, 0))[1] + function["count"])
    return found


def branches_of(entry):
    """For each place: how often a condition was true and false, over all copies of an
    inline function. A condition that begins with a macro has the place of the macro."""
    counts = {}
    branches = [(tuple(branch[:4]), branch) for branch in entry["branches"]]
    for expansion in entry["expansions"]:
        place = tuple(expansion["source_region"][:4])
        constant = [0] * 6
        branches += [(place, branch) for branch in expansion["branches"] or [constant]]
    for place, branch in branches:
        true, false = counts.get(place, (0, 0))
        counts[place] = (true + branch[4], false + branch[5])
    return counts


def decisions_of(entry):
    """For each place: whether each condition, in the order of the text, decided alone."""
    decisions = {}
    for record in entry["mcdc_records"]:
        place, conditions = tuple(record[:4]), record[-1]
        before = decisions.get(place, [False] * len(conditions))
        decisions[place] = [a or b for a, b in zip(before, conditions)]
    return decisions


def is_within(inner, outer):
    return outer[:2] <= inner[:2] and inner[2:] <= outer[2:]


def items_of_file(entry, functions):
    """Sorted pairs: the place, and (function, outcome, text)."""
    source = Source(entry["filename"])
    items = []
    for place, (name, count) in functions.items():
        if count == 0:
            items.append((place, name, "never-called", name))
    counts = branches_of(entry)
    missing = set()
    for place, (true, false) in counts.items():
        if true == 0 and false == 0:
            continue  # it was never reached, or is a constant: no outcome is possible
        for outcome, count in (("never-true", true), ("never-false", false)):
            if count == 0:
                missing.add(place)
                items.append((place, None, outcome, source.text(*place)))
    for decision, alone in decisions_of(entry).items():
        inside = [p for p in counts if is_within(p, decision)]
        conditions = sorted(p for p in inside
                            if not any(p != q and is_within(p, q) for q in inside))
        if len(conditions) != len(alone):
            sys.exit(f"{entry['filename']}:{decision[0]}: a decision of {len(alone)} "
                     f"conditions, of which {len(conditions)} are found")
        reached = any(sum(counts[p]) for p in conditions)
        for place, is_alone in zip(conditions, alone):
            if reached and not is_alone and place not in missing and sum(counts[place]):
                items.append((place, None, "never-alone", source.text(*place)))
    named = []
    for place, name, outcome, text in sorted(items, key=lambda item: item[0]):
        if name is None:
            name = next(n for body, (n, _) in functions.items() if is_within(place, body))
        named.append((place, name, outcome, text))
    return number_copies(named, counts, functions, source)


def number_copies(items, counts, functions, source):
    """Numbers conditions of a function that have the same text: #2, #3."""
    copies = {}
    for place in sorted(counts):
        name = next((n for body, (n, _) in functions.items() if is_within(place, body)), "")
        copies.setdefault((name, source.text(*place)), []).append(place)
    out = []
    for place, name, outcome, text in items:
        alike = copies.get((name, text), [place])
        number = alike.index(place) + 1 if place in alike else 1
        out.append((place, (name, outcome, text + (f" #{number}" if number > 1 else ""))))
    return out


def items_of(precision):
    """The items, each with its place, and the totals."""
    path = os.path.join(ROOT, "build", f"coverage-{precision}", "coverage.json")
    with open(path, encoding="utf-8") as f:
        data = json.load(f)["data"][0]
    functions = functions_of(data)
    items = {}
    for entry in data["files"]:
        name = os.path.basename(entry["filename"])
        for place, item in items_of_file(entry, functions.get(entry["filename"], {})):
            items[(name, *item)] = place
    return items, data["totals"]


def read_exceptions():
    """For each item and precision: the proof."""
    form = re.compile(r"(\S+) (\S+) (both|double|float) (never-\S+) (.*) => (.+)")
    proofs = {}
    with open(EXCEPTIONS, encoding="utf-8") as f:
        for number, line in enumerate(f, 1):
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            match = form.fullmatch(line)
            if not match:
                sys.exit(f"exceptions.txt:{number}: not FILE FUNCTION PRECISION OUTCOME "
                         f"CONDITION => PROOF")
            file, function, where, outcome, text, proof = match.groups()
            for precision in ("double", "float") if where == "both" else (where,):
                key = (file, function, outcome, text), precision
                if key in proofs:
                    sys.exit(f"exceptions.txt:{number}: twice")
                proofs[key] = proof
    return proofs


def update(seen, proofs):
    """Rewrites exceptions.txt. Items that are covered are removed, new ones are added as
    open. If only one precision was read, the entries of the other stay."""
    kept = {}
    for (item, precision), proof in proofs.items():
        if precision not in seen or item in seen[precision]:
            kept.setdefault((item, proof), []).append(precision)
    for precision, items in seen.items():
        for item in items:
            if (item, precision) not in proofs:
                kept.setdefault((item, OPEN), []).append(precision)
    with open(EXCEPTIONS, encoding="utf-8") as f:
        head = [line for line in f if line.startswith("#")]
    with open(EXCEPTIONS, "w", encoding="utf-8") as f:
        f.writelines(head)
        for (item, proof), where in sorted(kept.items()):
            word = "both" if len(where) == 2 else where[0]
            f.write(f"{item[0]} {item[1]} {word} {item[2]} {item[3]} => {proof}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--update", action="store_true",
                        help="rewrite exceptions.txt by what is seen")
    parser.add_argument("precisions", nargs="+", choices=("double", "float"))
    args = parser.parse_args()
    proofs = read_exceptions()
    failed = False
    seen = {precision: items_of(precision) for precision in args.precisions}
    if args.update:
        update({precision: items for precision, (items, _) in seen.items()}, proofs)
        proofs = read_exceptions()
    for precision, (items, totals) in seen.items():
        stale = [key for key in proofs if key[1] == precision and key[0] not in items]
        new = [item for item in items if (item, precision) not in proofs]
        n_open = sum(proofs.get((item, precision)) == OPEN for item in items)
        for file, function, outcome, text in new:
            line = items[(file, function, outcome, text)][0]
            print(f"{precision}: src/{file}:{line}: {function}: {outcome}: {text}")
        for (file, function, outcome, text), _ in stale:
            print(f"{precision}: exceptions.txt: covered, or gone: {file} {function} "
                  f"{outcome} {text}")
        failed = failed or bool(new or stale)
        shares = ", ".join(f"{kind} {totals[kind]['covered']} of {totals[kind]['count']}"
                           for kind in ("lines", "branches", "mcdc"))
        print(f"{precision}: {shares}; {len(items) - len(new) - n_open} proven exceptions, "
              f"{n_open} open, {len(new)} new, {len(stale)} stale")
    sys.exit(failed)


if __name__ == "__main__":
    main()
