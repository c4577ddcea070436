#!/usr/bin/env python3
"""Compiles and runs the C programs of README.md.

Each ```c block that defines main is compiled against the library, as strictly
as the library itself, and run; what it prints must be the ```text block that
follows it, word for word.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FLAGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion",
         "-Wdouble-promotion", "-Wshadow", "-Werror", f"-I{ROOT}/include"]
BLOCK = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.S | re.M)


def run(*command):
    return subprocess.run([str(c) for c in command], cwd=ROOT,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=3600)


def main():
    readme = (ROOT / "README.md").read_text()
    blocks = [(m[1], m[2], readme.count("\n", 0, m.start()) + 1)
              for m in BLOCK.finditer(readme)]
    programs = 0
    for k, (language, code, line) in enumerate(blocks):
        if language != "c" or not re.search(r"\bmain\s*\(", code):
            continue
        programs += 1
        where = f"README.md:{line}"
        if k + 1 == len(blocks) or blocks[k + 1][0] != "text":
            sys.exit(f"{where}: no ```text block with the output follows the program")
        with tempfile.TemporaryDirectory() as work:
            source, program = pathlib.Path(work, "readme.c"), pathlib.Path(work, "readme")
            source.write_text(code)
            built = run("gcc", *FLAGS, source, *sorted((ROOT / "src").glob("*.c")),
                        "-lm", "-o", program)
            if built.returncode:
                sys.exit(f"{where}: the program does not compile\n{built.stdout}")
            ran = run(program)
        expected = blocks[k + 1][1]
        if ran.returncode:
            sys.exit(f"{where}: the program ends with status {ran.returncode}\n{ran.stdout}")
        if ran.stdout.split() != expected.split():
            sys.exit(f"{where}: the program prints\n{ran.stdout}\nREADME.md says\n{expected}")
    if not programs:
        sys.exit("README.md: there is no ```c block that defines main")
    print(f"{programs} program{'s' * (programs != 1)} of README.md, output as printed there")


if __name__ == "__main__":
    main()
