#!/usr/bin/env python3
"""Writes the whole library as one header and one source.

    python3 port/single_file/amalgamate.py FOLDER

makes FOLDER/rigcal.h out of all headers of include/, and FOLDER/rigcal.c out of the
headers and sources of src/, in the order of RIGCAL_PARTS in CMakeLists.txt. Files of
these names are replaced only if this program made them. A name that a source keeps to
itself and another file uses as well is given the layer's name as a prefix; the macros
of a source end with it.
"""
import pathlib
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
MADE_BY = "Made by port/single_file/amalgamate.py"

TOKENS = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.M)


def parts():
    """RIGCAL_PARTS of CMakeLists.txt."""
    text = (ROOT / "CMakeLists.txt").read_text()
    words = {name: re.search(rf"set\({name}\s+([^)]*)\)", text)[1]
             for name in ("RIGCAL_LAYERS", "RIGCAL_PARTS")}
    return words["RIGCAL_PARTS"].replace("${RIGCAL_LAYERS}", words["RIGCAL_LAYERS"]).split()


def version():
    text = (ROOT / "include/rigcal.h").read_text()
    return ".".join(re.search(rf"#define RIGCAL_VERSION_{part} +(\d+)", text)[1]
                    for part in ("MAJOR", "MINOR", "PATCH"))


def bare(text):
    """The text with comments and literals blanked. All other characters keep their place."""
    return TOKENS.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def outermost(text):
    """The statements at file scope. What is inside their braces is left out, except in an
    enum, because its constants are names of file scope."""
    code = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", "", bare(text), flags=re.M)
    depth, statement, is_enum = 0, "", None
    for piece in re.split(r"([{};])", code):
        if piece == "{":
            depth += 1
            if depth == 1:
                is_enum = re.match(r"\s*(typedef\s+)?enum\b", statement)
                statement += piece
                continue
        elif piece == "}":
            depth -= 1
            if depth == 0 and re.search(r"\)\s*\{$", statement):
                yield statement
                statement = ""
                continue
        if depth == 0 or is_enum:
            statement += piece
        if piece == ";" and depth == 0:
            yield statement
            statement = ""


def private_names(text):
    """What a source defines for itself at file scope: functions, objects, types and
    constants of enums."""
    names = []
    for statement in outermost(text):
        if "enum" in statement and "{" in statement:
            for constant in re.search(r"\{([^}]*)\}", statement)[1].split(","):
                names += re.findall(r"\w+", constant)[:1]
        names += re.findall(r"\b(?:struct|enum|union)\s+(\w+)\s*\{", statement)
        if re.match(r"\s*typedef\b", statement):
            function = re.search(r"\(\s*\*\s*(\w+)\s*\)", statement)
            names += [function[1]] if function else re.findall(r"(\w+)[\[\]\w]*\s*;$", statement)
        else:
            declarator = re.split(r"[=({\[;]", statement, maxsplit=1)[0]
            if re.search(r"\bstatic\b", declarator):
                names += re.findall(r"\w+", declarator)[-1:]
    return {n for n in names if not n.startswith(("rigcal_", "rc_", "RIGCAL_"))}


def words(text):
    return set(re.findall(r"\b[A-Za-z_]\w*", bare(text)))


def renamed(text, names, prefix):
    """The text with the names prefixed. Fields of structs and literals do not change."""
    if not names:
        return text
    code = bare(text)
    pattern = re.compile(r"(?<![\w.>])(" + "|".join(sorted(names)) + r")\b")
    out, last = [], 0
    for m in pattern.finditer(code):
        out += [text[last:m.start()], prefix, m[0]]
        last = m.end()
    return "".join(out) + text[last:]


def without_own_includes(text):
    return re.sub(r'^#include "[^"]*"[^\n]*\n', "", text, flags=re.M)


def banner(name):
    return f"\n/* {'=' * 8} {name} {'=' * (62 - len(name))} */\n\n"


def head(name, what):
    licence = (ROOT / "LICENSE").read_text().strip()
    licence = "\n".join(" *" + (" " + line if line else "") for line in licence.split("\n"))
    return (f"/* {name} - rigcal {version()}, {what}\n"
            f" *\n * {MADE_BY}: change the files it was made of.\n"
            f" *\n{licence}\n */\n")


def public_header():
    """rigcal.h, with the included text in place of each include, then the headers that it
    does not include."""
    headers = {path.name: path.read_text() for path in (ROOT / "include").glob("*.h")}
    taken = set()

    def whole(name):
        taken.add(name)
        return re.sub(r'^#include "([^"]+)"[^\n]*\n', lambda m: (
            "" if m[1] in taken else whole(m[1]) if m[1] in headers else m[0]),
            headers[name], flags=re.M)

    text = head("rigcal.h", "the whole interface.") + whole("rigcal.h")
    for name in sorted(headers):
        text += "" if name in taken else "\n" + whole(name)
    return text


def source():
    order = parts()
    headers = [ROOT / f"src/rc_{part}.h" for part in ["real"] + order]
    headers = [path for path in headers if path.exists()]
    sources = [ROOT / f"src/rigcal_{part}.c" for part in order]
    forgotten = set((ROOT / "src").glob("*")) - set(headers) - set(sources)
    if forgotten:
        sys.exit("amalgamate: not of RIGCAL_PARTS in CMakeLists.txt: " +
                 ", ".join(sorted(path.name for path in forgotten)))

    texts = {path: path.read_text() for path in headers + sources}
    used = {path: words(text) for path, text in texts.items()}
    out = [head("rigcal.c", "the whole library."), "#ifndef RIGCAL_BUILD\n",
           "#define RIGCAL_BUILD\n#endif\n#include \"rigcal.h\"\n"]
    for path in headers:
        out += [banner(path.name), without_own_includes(texts[path])]
    for path in sources:
        others = set().union(*(used[other] for other in texts if other != path))
        text = without_own_includes(texts[path])
        prefix = path.stem[len("rigcal_"):] + "_"
        out += [banner(path.name),
                renamed(text, private_names(text) & others, prefix).strip("\n"), "\n\n"]
        out += [f"#undef {name}\n" for name in dict.fromkeys(MACRO.findall(bare(text)))]
    return "".join(out)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    texts = {folder / "rigcal.h": public_header(), folder / "rigcal.c": source()}
    for path in texts:
        if path.exists() and MADE_BY not in path.read_text():
            sys.exit(f"amalgamate: {path} exists and was not made by this program")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as work:
        for path, text in texts.items():
            pathlib.Path(work, path.name).write_text(text)
        for path in texts:
            pathlib.Path(work, path.name).replace(path)
    text = texts[folder / "rigcal.c"]
    print(f"{folder}/rigcal.h and {folder}/rigcal.c, {text.count(chr(10))} lines, "
          f"rigcal {version()}")


if __name__ == "__main__":
    main()
