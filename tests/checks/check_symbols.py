#!/usr/bin/env python3
"""Looks at what is in the objects of build/gcc-double and build/gcc-float, and builds shared
libraries of the same sources.

A shared library exports exactly the functions that the headers declare with
RIGCAL_API. Globals of the static one begin with rigcal_ or rc_. Nothing is
wanted from outside but libm, memcpy and memset. No object has writable data,
so the library is reentrant. Uses gcc and binutils.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# gcc replaces a sine and a cosine of one angle by libm's sincos.
LIBM = {"sqrt", "sin", "cos", "atan2", "fabs", "sincos"}
# The list of exported functions does not depend on the optimiser.
FLAGS = ["-std=c99", "-O0", "-fPIC", "-fvisibility=hidden", "-DRIGCAL_BUILD",
         "-DRIGCAL_SHARED", f"-I{ROOT}/include"]
LINKER = {"_init", "_fini", "_edata", "_end", "__bss_start"}
# Constants that hold addresses are in .data.rel.ro where gcc makes position-independent code
# by default: the loader writes them, the program cannot.
WRITABLE = re.compile(r"\.(data(?!\.rel\.ro)|bss|tdata|tbss|sdata|sbss)(\..*)?$")


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"check_symbols: {' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def nm(path, *options):
    """(type, name) of each symbol; type U is undefined."""
    for line in run("nm", "-P", *options, path).splitlines():
        fields = line.split()
        if len(fields) >= 2:
            yield fields[1], fields[0].split("@")[0]


def declared(define):
    """The functions that headers declare with RIGCAL_API, and those without it."""
    headers = [f for path in sorted((ROOT / "include").glob("*.h"))
               for f in ("-include", path)]
    text = run("gcc", "-E", "-P", *FLAGS, *define, "-DRIGCAL_API=RIGCAL_DECLARED", *headers,
               "-x", "c", "/dev/null")
    marked = set(re.findall(r"RIGCAL_DECLARED\b[^;(]*?\b(\w+)\s*\(", text))
    return marked, set(re.findall(r"\b(rigcal_\w+)\s*\((?!\*)", text)) - marked


def check(real, define, work):
    allowed = {name + ("f" if real == "float" else "") for name in LIBM}
    # gcc calls the last one where it protects the stack by default.
    allowed |= {"memcpy", "memset", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}
    run("ar", "x", "--output", work, ROOT / f"build/gcc-{real}/librigcal.a")
    shared = []
    for source in sorted((ROOT / "src").glob("*.c")):
        name = source.relative_to(ROOT)
        plain = work / (source.name + ".o")
        pic = work / (source.stem + ".pic.o")
        run("gcc", *FLAGS, *define, "-c", source, "-o", pic)
        shared.append(pic)

        symbols = list(nm(plain))
        for kind, symbol in symbols:
            ours = symbol.startswith(("rigcal_", "rc_"))
            if kind == "C":
                yield f"{name}: {symbol} is writable data ({real})"
            elif kind == "U" and not ours and symbol not in allowed:
                yield f"{name}: wants {symbol} from outside ({real})"
            elif kind.isupper() and kind != "U" and not ours:
                yield f"{name}: defines the global {symbol}, which is not rigcal_ or rc_ ({real})"
        for line in run("size", "-A", plain).splitlines():
            fields = line.split()
            if len(fields) == 3 and WRITABLE.match(fields[0]) and int(fields[1]):
                yield f"{name}: {fields[1]} bytes of writable data in {fields[0]} ({real})"

    library = work / "librigcal.so"
    run("gcc", "-shared", "-Wl,-z,defs", *shared, "-lm", "-o", library)
    exported = set()
    for kind, symbol in nm(library, "-D", "--defined-only"):
        if symbol not in LINKER:
            exported.add(symbol)
            if kind not in "TW":
                yield f"librigcal.so exports {symbol}, which is no function ({real})"
    promised, unmarked = declared(define)
    for symbol in sorted(unmarked):
        yield f"a header declares {symbol} without RIGCAL_API ({real})"
    for symbol in sorted(exported - promised):
        yield f"librigcal.so exports {symbol}, which no header declares RIGCAL_API ({real})"
    for symbol in sorted(promised - exported):
        yield f"a header declares {symbol}, which librigcal.so does not export ({real})"
    check.count = len(promised)


def main():
    bad = []
    for real, define in (("double", []), ("float", ["-DRIGCAL_USE_FLOAT=1"])):
        with tempfile.TemporaryDirectory() as work:
            bad += check(real, define, pathlib.Path(work))
    for text in bad:
        print(text)
    if bad or not check.count:
        sys.exit(f"check_symbols: {len(bad)} breaches, {check.count} functions declared")
    print(f"{check.count} functions exported as declared, no writable data")


if __name__ == "__main__":
    main()
