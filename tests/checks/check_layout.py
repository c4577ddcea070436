#!/usr/bin/env python3
"""Compares RC_LAYOUT of src/rc_layout.h with the public headers.

Every struct of the headers stands there, in their order, with each of its fields in order.
A solver stands there without fields. Whatever else rigcal_solvers.h defines is a part of a
solver, and does not.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = ["rigcal.h", "rigcal_measure.h", "rigcal_rig.h", "rigcal_choose.h",
           "rigcal_judge.h", "rigcal_clocks.h", "rigcal_consider.h", "rigcal_faults.h",
           "rigcal_paper.h"]
SOLVER = re.compile(r"struct (rigcal_(?:\w+_solver|neldermead)) \{")
STRUCT = re.compile(r"struct (rigcal_\w+) \{(.*?)\n\}", re.S)
FIELD = re.compile(r"\*?(\w+)(?:\[\w+\])*\s*(?=[,;])")
ENTRY = re.compile(r"\b([SM])\((\w+)(?:, (\w+))?\)")


def without_comments(text):
    return re.sub(r"/\*.*?\*/", "", text, flags=re.S)


def header(name):
    return without_comments((ROOT / "include" / name).read_text())


def wanted():
    """The names of structs and fields, "struct" and "struct.field"."""
    names, solvers = [], set()
    for name in HEADERS + ["rigcal_solvers.h"]:
        solvers |= set(SOLVER.findall(header(name)))
    for name in HEADERS:
        for struct, body in STRUCT.findall(header(name)):
            if struct not in solvers:
                names.append(struct)
                names += [f"{struct}.{field}" for field in FIELD.findall(body)]
    return names, solvers


def main():
    listed = without_comments((ROOT / "src/rc_layout.h").read_text())
    listed = listed[listed.index("#define RC_LAYOUT"):].replace("RC_LAYOUT(S, M)", "")
    listed = [f"{struct}.{field}" if kind == "M" else struct
              for kind, struct, field in ENTRY.findall(listed)]
    names, solvers = wanted()
    bad = [f"{name} is not in RC_LAYOUT" for name in names + sorted(solvers)
           if name not in listed]
    bad += [f"RC_LAYOUT has {name}, which is in no header, or is a solver's own"
            for name in listed if name not in names and name not in solvers]
    bad += [f"RC_LAYOUT has {name} twice" for name in sorted(set(listed))
            if listed.count(name) > 1]
    if not bad and [name for name in listed if name not in solvers] != names:
        bad = ["RC_LAYOUT is not in the order of the headers"]
    for text in bad:
        print(text)
    if bad:
        sys.exit(f"check_layout: {len(bad)} faults")
    print(f"{sum('.' not in name for name in listed)} structs, "
          f"{sum('.' in name for name in listed)} fields, as in the headers")


if __name__ == "__main__":
    main()
