#!/usr/bin/env python3
"""Reads src/ and refuses what breaks the order of the layers.

A file may include its own header and those of layers before its own, in the
order of RIGCAL_LAYERS in CMakeLists.txt; of the C library only headers that a
freestanding compiler has, and string.h for memcpy and memset; the mathematics
comes by RIGCAL_MATH_HEADER. Nothing in src/ may ask which target it is for.

What a solver keeps is its own layer's: another layer uses only the fields that are
listed here. To find out, every file is compiled (gcc -fsyntax-only) with the public
headers in which the other fields of the other layers' solvers have other names.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PUBLIC = {path.name for path in (ROOT / "include").glob("*.h")}
SYSTEM = {"stddef.h", "stdint.h", "stdbool.h", "limits.h", "float.h", "string.h",
          "assert.h"}

# The only names that a conditional may test: our own settings, C++ in a header, and the
# compiler modes that break the library.
OWN_MACRO = re.compile(r"RIGCAL_\w+|RC_\w+|defined|__cplusplus|__FAST_MATH__|_M_FP_FAST|"
                       r"__FINITE_MATH_ONLY__|__ASSOCIATIVE_MATH__|__RECIPROCAL_MATH__|"
                       r"__NO_SIGNED_ZEROS__|FLT_EVAL_METHOD|SIZE_MAX")
# One more name, in this file only: it says whether small functions have one body.
OWN_MACRO_OF = {"rc_real.h": {"__OPTIMIZE_SIZE__"}}

# Files beside the layers. They may include what `real` may include, and no layer.
APART = ["about", "layout"]

# For each struct of a solver: its layer, and the fields that other layers may use. None:
# all fields, because the struct is data.
SOLVERS = {
    "rigcal_points": ("points", None),
    "rigcal_vertex": ("neldermead", None),
    "rigcal_neldermead": ("neldermead", {"trial", "status"}),
    "rigcal_levenberg": ("levenberg", {"want", "equations", "status", "sum", "lambda",
                                        "last_gain"}),
    "rigcal_refinement": ("refine", {"search", "cam_from_points", "H"}),
    "rigcal_moments": ("direction", {"weight", "C"}),
    "rigcal_lattice": ("seeds", set()),
    "rigcal_triple": ("seeds", {"index", "ray", "count", "poses"}),
    "rigcal_p3p": ("p3p", {"work", "x"}),
    "rigcal_descent": ("seeds", set()),
    "rigcal_optimum": ("optima", None),
    "rigcal_optima": ("optima", None),
    "rigcal_search": ("seeds", {"points", "optima", "point", "is_wide", "work",
                                "refinement"}),
    "rigcal_pose_solver": ("pose", set()),
    "rigcal_trial_poses": ("robust", set()),
    "rigcal_robust_solver": ("robust", set()),
    "rigcal_paper_solver": ("paper", set()),
    "rigcal_rig_solver": ("adjust", {"rig", "search", "phase", "is_join", "is_disconnected",
                                     "at_fault", "evals", "n", "view", "first", "placement",
                                     "n_points", "n_seen", "own_sum", "negligible", "given",
                                     "gain", "n_free", "n_used", "loss", "timed", "n_clocks",
                                     "promised", "row", "sum", "gp", "Hp", "is_trial", "is_lagging",
                                     "is_last"}),
    "rigcal_seed": ("grow", None),
    "rigcal_choose_solver": ("grow", {"check", "choice", "a", "b", "n", "row", "column", "limit",
                                      "is_relaxed"}),
    "rigcal_judge_solver": ("cost", None),
    "rigcal_cause_solver": ("cause", set()),
    "rigcal_arc": ("outline", set()),
    "rigcal_outline": ("outline", {"is_full"}),
    "rigcal_edge": ("edge", {"band", "height"}),
    "rigcal_border_end": ("spans", set()),
    "rigcal_spans_solver": ("spans", set()),
    "rigcal_point_sums": ("sight", None),
    "rigcal_point_solver": ("locate", None),
    "rigcal_border": ("border", None),
    "rigcal_consider_solver": ("consider", {"border", "column", "placement"}),
    "rigcal_columns": ("columns", None),
    "rigcal_moves": ("moved", None),
    "rigcal_faults_solver": ("faults", set()),
}
FIELD = re.compile(r"(\w+)((?:\[\w+\])*\s*[,;])")
STRUCT = re.compile(r"struct (rigcal_\w+) \{(.*?)\n\}", re.S)


def layer_order():
    text = (ROOT / "CMakeLists.txt").read_text()
    found = re.search(r"set\(RIGCAL_LAYERS\s+([^)]*)\)", text)
    return ["real"] + found[1].split()


def without_comments(text):
    """The text with comments and the contents of strings blanked. It keeps its lines."""
    def blank(match):
        if match[0].startswith('"'):
            return match[0]
        return " " + "\n" * match[0].count("\n")
    return re.sub(r'"(?:\\.|[^"\\\n])*"|/\*.*?\*/|//[^\n]*', blank, text, flags=re.S)


def offences(path, order):
    name = path.name
    found = re.fullmatch(r"(?:rigcal_(\w+)\.c|rc_(\w+)\.h)", name)
    layer = found and (found[1] or found[2])
    if layer not in order + APART:
        yield 1, "belongs to no layer in CMakeLists.txt's RIGCAL_LAYERS"
        return
    rank = 0 if layer in APART else order.index(layer)

    for number, line in enumerate(without_comments(path.read_text()).split("\n"), 1):
        directive = re.match(r"\s*#\s*(\w+)\s*(.*)", line)
        if directive and directive[1] == "include":
            included = re.match(r'(["<])([^">]+)[">]', directive[2])
            if not included:
                if directive[2].strip() != "RIGCAL_MATH_HEADER":
                    yield number, f"includes {directive[2].strip()}, which is no header"
            elif included[2] in PUBLIC:
                pass
            elif included[1] == "<":
                if included[2] == "math.h":
                    yield number, "includes math.h; it must be RIGCAL_MATH_HEADER, which a firmware can replace"
                elif included[2] not in SYSTEM:
                    yield number, f"includes {included[2]}, which the core may not use"
            else:
                other = re.fullmatch(r"rc_(\w+)\.h", included[2])
                if other and other[1] == layer and name.endswith(".c"):
                    pass
                elif not other or other[1] not in order:
                    yield number, f"includes {included[2]}, which is no layer's header"
                elif order.index(other[1]) >= rank + (layer in APART):
                    yield number, f"includes {included[2]}, which is not of a layer before {layer}"
                continue
        elif directive and directive[1] in ("if", "ifdef", "ifndef", "elif"):
            for word in re.findall(r"\b[A-Za-z_]\w*", directive[2]):
                if not OWN_MACRO.fullmatch(word) and word not in OWN_MACRO_OF.get(name, ()):
                    yield number, f"asks for {word}; what depends on the target belongs in rigcal_config.h"
        code = re.sub(r'"(?:\\.|[^"\\])*"', '""', line)
        for call in re.findall(r"\b((?:mem|str)[a-z]+)\s*\(", code):
            if call not in ("memcpy", "memset"):
                yield number, f"calls {call}; of string.h only memcpy and memset are promised to suffice"


def hide(text, layer):
    """The text of a header in which the fields that are hidden from a layer have other
    names."""
    def renamed(match):
        name, body = match[1], match[2]
        owner, shown = SOLVERS.get(name, (layer, None))
        if owner == layer or shown is None:
            return match[0]

        def hidden(field):
            return field[0] if field[1] in shown else f"{field[1]}_of_{name}{field[2]}"
        return f"struct {name} {{{FIELD.sub(hidden, body)}\n}}"
    return STRUCT.sub(renamed, without_comments(text))


def intrusions(work):
    """The fields of other layers' solvers that each file uses."""
    for path in sorted((ROOT / "src").glob("*.c")):
        layer = path.stem[len("rigcal_"):]
        for header in PUBLIC:
            (work / header).write_text(hide((ROOT / "include" / header).read_text(), layer))
        done = subprocess.run(
            ["gcc", "-std=c99", "-fsyntax-only", "-fmax-errors=0", f"-I{work}", str(path)],
            capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})
        if done.returncode == 0:
            continue
        found = re.findall(
            r"src/(\S+?):(\d+):\d+: error: '(?:const )?(?:struct |union )?(rigcal_\w+)' "
            r"[^\n]*has no member named '(\w+)'", done.stderr)
        if len(found) != len(re.findall("error:", done.stderr)):
            sys.exit(f"check_layers: {path.name} does not compile\n{done.stderr}")
        yield from ((ROOT / "src" / name, int(number),
                     f"uses {field} of {struct}, which is another layer's own")
                    for name, number, struct, field in found)


def mapped():
    """The layers that the map in CONTRIBUTING.md lists, from the top."""
    text = (ROOT / "CONTRIBUTING.md").read_text().split("## The map of the house")[1]
    return re.findall(r"^\| `(\w+)` \|", text.split("\n## ")[0], re.M)


def main():
    unknown = {m[1] for m in STRUCT.finditer(
        (ROOT / "include/rigcal_solvers.h").read_text())} - SOLVERS.keys()
    if unknown:
        sys.exit(f"check_layers: whose are {', '.join(sorted(unknown))}?")
    order = layer_order()
    files = sorted((ROOT / "src").glob("*"))
    if not files:
        sys.exit("check_layers: there is nothing in src/")
    bad = 0
    listed = [name for name in order if name not in [*APART, "real"]]
    if mapped() != listed:
        wrong = sorted(set(mapped()) ^ set(listed)) or "their order"
        print(f"CONTRIBUTING.md: its map has not the layers of CMakeLists.txt: {wrong}")
        bad += 1
    for path in files:
        for number, text in offences(path, order):
            print(f"{path.relative_to(ROOT)}:{number}: {text}")
            bad += 1
    with tempfile.TemporaryDirectory() as work:
        for path, number, text in intrusions(pathlib.Path(work)):
            print(f"{path.relative_to(ROOT)}:{number}: {text}")
            bad += 1
    if bad:
        sys.exit(f"check_layers: {bad} breaches of the layer rules")
    print(f"{len(files)} files keep the order of {len(order)} layers")


if __name__ == "__main__":
    main()
