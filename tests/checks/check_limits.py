#!/usr/bin/env python3
"""Refuses what has grown too large to be read, in src/ and include/.

Files, functions, arguments and structs have limits, which stand below; every struct,
union and enum of the public headers has a name, for debuggers and bindings, and no field
is kept for later. Functions are those that gcc finds (-aux-info), from the first line of
their definition to the brace that ends it.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from check_layers import ROOT, without_comments

FILE_LINES = 680  # lines of a file of src/
FUNCTION_LINES = 60
ARGUMENTS = 8
HEADER_LINES = {"rigcal.h": 850}
OTHER_HEADER_LINES = 400
STRUCTS = 20  # structs whose fields rigcal.h shows

# "/* src/rigcal_pose.c:12:NF */ static int f (int, int); /* (...) ... */": C for a
# declaration, F for a definition.
FUNCTION = re.compile(r"/\* (\S+):(\d+):[NO]([CF]) \*/ (.*?)\b(\w+) \((.*)\);")
STRUCT = re.compile(r"\bstruct (\w+) \{")


def arguments(text):
    """The number of types in a list in parentheses."""
    depth, count = 0, 1
    for character in text:
        depth += (character in "([") - (character in ")]")
        count += character == "," and depth == 0
    return 0 if text.strip() == "void" else count


def functions(source):
    """(file, line, whether it is defined there, name, number of arguments)"""
    with tempfile.NamedTemporaryFile("r") as found:
        done = subprocess.run(
            ["gcc", "-std=c99", "-fsyntax-only", "-DRIGCAL_BUILD", "-Iinclude", "-include",
             "rigcal_paper.h", "-aux-info", found.name, source],
            cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"check_limits: {source} does not compile\n{done.stderr}")
        for m in FUNCTION.finditer(found.read()):
            path = m[1]
            if path.startswith(("src/", "include/")):
                yield path, int(m[2]), m[3] == "F", m[5], arguments(m[6])


def lines_of(path, line):
    """The lines of the function whose body opens first at or after a line."""
    lines = (ROOT / path).read_text().split("\n")
    end = lines.index("}", lines.index("{", line - 1))
    start = line - 1  # back to the first line of the definition
    while start > 0 and lines[start - 1] and not lines[start - 1].endswith((";", "}", "*/", ",")) \
            and not lines[start - 1].startswith("#"):
        start -= 1
    return end - start + 1


def main():
    bad, longest, most = [], (0, ""), (0, "")
    for path in sorted((ROOT / "src").iterdir()):
        count = path.read_text().count("\n")
        if count > FILE_LINES:
            bad.append(f"src/{path.name} has {count} lines, more than {FILE_LINES}")

    seen = set()
    for source in sorted((ROOT / "src").glob("*.c")):
        for function in functions(str(source.relative_to(ROOT))):
            seen.add(function)
    if len({name for _, _, is_defined, name, _ in seen if is_defined}) < 100:
        sys.exit("check_limits: gcc finds hardly any function")
    for path, line, is_defined, name, n in sorted(seen):
        most = max(most, (n, name))
        if n > ARGUMENTS:
            bad.append(f"{path}:{line}: {name} has {n} arguments, more than {ARGUMENTS}")
        if is_defined:
            size = lines_of(path, line)
            longest = max(longest, (size, name))
            if size > FUNCTION_LINES:
                bad.append(f"{path}:{line}: {name} has {size} lines, more than {FUNCTION_LINES}")

    for path in sorted((ROOT / "include").iterdir()):
        text = path.read_text()
        limit = HEADER_LINES.get(path.name, OTHER_HEADER_LINES)
        if text.count("\n") > limit:
            bad.append(f"include/{path.name} has {text.count(chr(10))} lines, more than {limit}")
        code = without_comments(text)
        for number, line in enumerate(code.split("\n"), 1):
            nameless = re.search(r"\b(struct|union|enum)\s*(\{|$)", line)
            if nameless:
                bad.append(f"include/{path.name}:{number}: this {nameless[1]} has no name")
            if re.search(r"\b_*reserved\w*", line):
                bad.append(f"include/{path.name}:{number}: a field is reserved")
        if path.name == "rigcal.h":
            structs = len(STRUCT.findall(code))
            if structs > STRUCTS:
                bad.append(f"include/rigcal.h lays {structs} structs open, more than {STRUCTS}")

    for text in bad:
        print(text)
    if bad:
        sys.exit(f"check_limits: {len(bad)} limits are exceeded")
    print(f"the longest function has {longest[0]} lines ({longest[1]}), the most arguments "
          f"are {most[0]}, rigcal.h lays {structs} structs open")


if __name__ == "__main__":
    main()
