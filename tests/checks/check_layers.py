#!/usr/bin/env python3
"""Reads the includes of src/ and refuses what breaks the order of the layers.

A file may include its own header and those of layers before its own, in the
order of RIGCAL_LAYERS in CMakeLists.txt; of the C library only headers that a
freestanding compiler has, and string.h for memcpy and memset; the mathematics
comes by RIGCAL_MATH_HEADER. Nothing in src/ may ask which target it is for.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PUBLIC = {"rigcal.h", "rigcal_config.h"}
SYSTEM = {"stddef.h", "stdint.h", "stdbool.h", "limits.h", "float.h", "string.h"}

# A conditional may ask for these only: our own settings, C++ in a header, and
# the compiler's modes that break the library.
OWN_MACRO = re.compile(r"RIGCAL_\w+|RC_\w+|defined|__cplusplus|__FAST_MATH__|_M_FP_FAST|"
                       r"__FINITE_MATH_ONLY__|__ASSOCIATIVE_MATH__|__RECIPROCAL_MATH__|"
                       r"__NO_SIGNED_ZEROS__|FLT_EVAL_METHOD")


def layer_order():
    text = (ROOT / "CMakeLists.txt").read_text()
    found = re.search(r"set\(RIGCAL_LAYERS\s+([^)]*)\)", text)
    return ["real"] + found[1].split()


def without_comments(text):
    """Comments and the insides of strings blanked, lines kept."""
    def blank(match):
        if match[0].startswith('"'):
            return match[0]
        return " " + "\n" * match[0].count("\n")
    return re.sub(r'"(?:\\.|[^"\\\n])*"|/\*.*?\*/|//[^\n]*', blank, text, flags=re.S)


def offences(path, order):
    name = path.name
    found = re.fullmatch(r"(?:rigcal_(\w+)\.c|rc_(\w+)\.h)", name)
    layer = found and (found[1] or found[2])
    if layer not in order + ["about"]:
        yield 1, "belongs to no layer in CMakeLists.txt's RIGCAL_LAYERS"
        return
    rank = 1 if layer == "about" else order.index(layer)

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
                if not other or other[1] not in order:
                    yield number, f"includes {included[2]}, which is no layer's header"
                elif order.index(other[1]) > rank or (
                        order.index(other[1]) == rank and name.endswith(".h")) or (
                        order.index(other[1]) == rank and layer == "about"):
                    yield number, f"includes {included[2]}, which is not of a layer before {layer}"
                continue
        elif directive and directive[1] in ("if", "ifdef", "ifndef", "elif"):
            for word in re.findall(r"\b[A-Za-z_]\w*", directive[2]):
                if not OWN_MACRO.fullmatch(word):
                    yield number, f"asks for {word}; what depends on the target belongs in rigcal_config.h"
        code = re.sub(r'"(?:\\.|[^"\\])*"', '""', line)
        for call in re.findall(r"\b((?:mem|str)[a-z]+)\s*\(", code):
            if call not in ("memcpy", "memset"):
                yield number, f"calls {call}; of string.h only memcpy and memset are promised to suffice"


def main():
    order = layer_order()
    files = sorted((ROOT / "src").glob("*"))
    if not files:
        sys.exit("check_layers: there is nothing in src/")
    bad = 0
    for path in files:
        for number, text in offences(path, order):
            print(f"{path.relative_to(ROOT)}:{number}: {text}")
            bad += 1
    if bad:
        sys.exit(f"check_layers: {bad} breaches of the layer rules")
    print(f"{len(files)} files keep the order of {len(order)} layers")


if __name__ == "__main__":
    main()
