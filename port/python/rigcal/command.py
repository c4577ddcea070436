"""The command `rigcal`: that of the C program, for files of every format.

The program does the work. Other formats are first converted to its own CSV.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

from . import _tables
from .calibrate import PROGRESS, joined, made_of, program, run
from .errors import Caveat, Error, FileError
from .formats import FORMATS, load_cameras, save_cameras
from .html import check_path, write_page
from .plots import need
from .rig import Fault, Rig, load

__all__ = ["main"]

DONE, GEOMETRY, USAGE = 0, 1, 2  # exit statuses, as of the program
WARNING_SHOWN = 5  # faults that diagnose prints

HELP = """\
rigcal - where each camera of a rig is, from a few points of known shape

Files of cameras, of --cameras, --rig and --prior, may have any of these formats:
{formats}.
One file with poses serves as --cameras and --rig both.

  rigcal diagnose    --cameras FILE --observations FILE [options of calibrate]
  rigcal convert     FILE... FILE [--from FORMAT] [--to FORMAT] [--scale FACTOR]
                     [--lens brown|fisheye]
  rigcal report      FOLDER|FILE [--out rig.html] [--title TEXT]
  rigcal calibrate   --html FILE [--title TEXT] [options of the program]

diagnose says what is wrong with a recording, why, and what to do, without the tables of
calibrate. Its exit status is that of calibrate.

convert reads cameras of one format and writes them in another: the last file. A folder of
calibrate --out is read too. The names of files tell the formats, or --from and --to do.
  --scale      multiplies lengths that are read.
  --lens       that of a file of four coefficients which does not say it.

{detect}
report writes one page: the verdict, what to do next, pictures, tables. It reads a folder of
calibrate --out, or any file of a rig. calibrate --html writes the same page. The page needs
Matplotlib (pip install rigcal[plot]); the C program by itself has no --html.

The other commands are those of the program:

"""

# Options of the program: True where one takes a value.
OPTIONS = {
    command: {name.rstrip("!"): not name.endswith("!") for name in names.split()}
    for command, names in {
        "calibrate": "cameras observations out sigma threshold seed hold prior times "
        "sigma-time intrinsics-sigma method weigh! robust! clocks! drift! "
        "estimate-intrinsics! progress!",
        "triangulate": "cameras rig observations targets sigma",
        "line": "cameras rig from to pixel depth sigma probability candidates",
        "monitor": "rig matches observations times sigma arl0 common wrong walk",
    }.items()
}
COMMANDS = (
    "calibrate", "detect", "diagnose", "triangulate", "line", "monitor", "convert",
    "report",
)  # fmt: skip
NO_VALUE = object()


class _UsageError(Exception):
    pass


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise _UsageError(message)


def _say(text: str) -> None:
    print(f"rigcal: {text}", file=sys.stderr)


# ---- the program's own commands -------------------------------------------------


def _options(command: str, arguments: Sequence[str]) -> dict[str, list[str]] | None:
    """Values by option. None: an option is wrong, and the program says why."""
    parser = _Parser(add_help=False)
    for name, takes_value in OPTIONS[command].items():
        if takes_value:
            parser.add_argument("--" + name, action="append", nargs="?", const=NO_VALUE)
        else:
            parser.add_argument("--" + name, action="append_const", const="")
    try:
        known, rest = parser.parse_known_args(list(arguments))
    except _UsageError:  # an abbreviation of several
        return None
    found = {key.replace("_", "-"): value for key, value in vars(known).items() if value}
    single = all(len(value) == 1 for key, value in found.items() if key != "hold")
    if rest or not single or any(NO_VALUE in value for value in found.values()):
        return None
    return found


def _is_foreign(path: str) -> bool:
    """Whether it is a file of cameras that the program cannot read."""
    if os.path.isdir(path):
        return True
    return os.path.isfile(path) and not path.endswith(".csv") and not _tables.is_own(path)


class _Converted:
    """The options, with files of the program in place of files of other formats."""

    def __init__(self, folder: str) -> None:
        self.folder = pathlib.Path(folder)
        self.names: dict[str, str] = {}  # the user's file, by ours

    def file(self, option: str, name: str, path: str) -> str:
        """Makes the program's file from one of another format."""
        ours = self.folder / option / name
        if not ours.is_file():
            cameras = _read(path)
            ours.parent.mkdir(parents=True)
            save_cameras(os.fspath(ours.parent) + os.sep, cameras, "rigcal")
            if not ours.is_file():
                raise FileError(path, "no camera in it has a pose")
        self.names[os.fspath(ours)] = path
        return os.fspath(ours)

    def options(self, command: str, given: dict[str, list[str]]) -> dict[str, list[str]]:
        changed = dict(given)
        if "rig" in OPTIONS[command] and "cameras" in OPTIONS[command]:
            both = given.get("cameras") or given.get("rig")
            if both and len({"cameras", "rig"} & set(given)) == 1 and _is_foreign(both[0]):
                changed["cameras"] = changed["rig"] = both
        for option in ("cameras", "rig", "prior"):
            if (
                option in changed
                and _is_foreign(changed[option][0])
                and command != "monitor"
            ):
                name = "cameras.csv" if option == "cameras" else "rig.csv"
                changed[option] = [self.file(option, name, changed[option][0])]
        return changed

    def in_words_of_user(self, line: str) -> str:
        for ours, path in self.names.items():
            line = line.replace(ours, path)
        return line


def _program(*arguments: str) -> int:
    """Runs the program itself with our standard streams. Returns its exit status."""
    try:
        return subprocess.call([program(), *arguments])
    except OSError as problem:
        raise Error(f"the program rigcal cannot be run: {problem}") from None


def _pass_on(command: str, arguments: Sequence[str]) -> int:
    given = _options(command, arguments)
    with tempfile.TemporaryDirectory(prefix="rigcal-") as folder:
        converted = _Converted(folder)
        changed = converted.options(command, given) if given is not None else None
        if not converted.names or changed is None:
            return _program(command, *arguments)
        status, text, messages = _call(command, changed)
        for line in messages:
            print(converted.in_words_of_user(line), file=sys.stderr)
        sys.stdout.write(text)
        return status


def _call(command: str, options: dict[str, list[str]]) -> tuple[int, str, list[str]]:
    """Runs the program, with a bar on a terminal, or with lines of progress."""
    words = [command, *(["--progress"] if command == "calibrate" else [])]
    for name, values in options.items():
        if name != "progress":
            words += [
                f"--{name}" + (f"={v}" if OPTIONS[command][name] else "") for v in values
            ]
    return run(words, _tell_line if "progress" in options else None)


def _tell_line(text: str) -> None:
    print(f"{PROGRESS}{text}", file=sys.stderr)


# ---- ours -----------------------------------------------------------------------


def _read(path: str, **how: Any) -> dict[str, Any]:
    """Cameras of a file; of a folder of calibrate --out."""
    if os.path.isfile(os.path.join(path, "summary.json")):
        return load(path).cameras
    return load_cameras(path, **how)


@contextlib.contextmanager
def _caveats_told() -> Iterator[None]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", Caveat)
        try:
            yield
        finally:
            for warning in caught:
                _say(str(warning.message))


def _convert(arguments: Sequence[str]) -> int:
    parser = _Parser("rigcal convert", add_help=False)
    parser.add_argument("files", nargs="+", metavar="FILE")
    for name, known in (("from", FORMATS), ("to", FORMATS)):
        parser.add_argument("--" + name, choices=list(known), dest=name + "_format")
    parser.add_argument("--scale", type=float)
    parser.add_argument("--lens", choices=["brown", "fisheye"])
    given = parser.parse_args(list(arguments))
    *sources, target = given.files
    if not sources:
        raise _UsageError("convert takes the file to read and the file to write")
    how = {"format": given.from_format, "scale": given.scale, "lens": given.lens}
    with _caveats_told():
        with _options_named("--from"):
            if len(sources) == 1:
                cameras = _read(sources[0], **how)
            else:
                cameras = load_cameras(sources, **how)
        with _options_named("--to"):
            save_cameras(target, cameras, given.to_format)
    return DONE


@contextlib.contextmanager
def _options_named(format_option: str) -> Iterator[None]:
    """Replaces names of arguments in an Error by those of options."""
    try:
        yield
    except FileError as problem:
        what = problem.what.replace("format=", f"{format_option}=").replace(
            "lens=", "--lens="
        )
        raise FileError(problem.path, what) from None


def _value_of(fault: Fault) -> str:
    return ", ".join(f"{v:.4g} +- {s:.2g}" for v, s in zip(fault.values, fault.sigmas))


def _told(rig: Rig) -> Iterator[str]:
    """Prints the findings of diagnose."""
    for text in rig.warnings:
        what, _, advice = text.partition("; ")
        yield what
        if advice:
            yield "  " + advice
    if not rig.warnings:
        yield "no view, camera or point is wrong"
    for view in rig.left_out:
        yield f"left out of the rig: {view.camera} in frame {view.frame}"
    if rig.sqrt_f is None:
        yield "the views have nothing in common that could disagree"
    else:
        yield f"the views disagree {rig.sqrt_f:.2f} times more than noise: {rig.verdict}"
        yield rig.cause
    seen = [fault for fault in rig.faults if fault.p == fault.p][:WARNING_SHOWN]
    if seen:
        yield "likeliest faults of the rig as a whole, and p, the chance by noise alone:"
    for fault in seen:
        where = " ".join(x for x in (fault.camera, fault.frame) if x)
        explains = ", explains" if fault.explains else ""
        name = f"{fault.name} {where}".strip()
        yield f"  {name}: {_value_of(fault)}, p {fault.p:.2g}{explains}"
    for text in rig.advice:
        yield f"next: {text}"


def _diagnose(arguments: Sequence[str]) -> int:
    given = _options("calibrate", arguments)
    for option in ("cameras", "observations"):
        if given is not None and option not in given:
            raise _UsageError(f"diagnose needs --{option}")
    if given is None:
        raise _UsageError(
            "diagnose has the options of calibrate, each once and with its value"
        )
    with tempfile.TemporaryDirectory(prefix="rigcal-") as folder:
        converted = _Converted(folder)
        changed = converted.options("calibrate", given)
        changed.setdefault("out", [os.path.join(folder, "out")])
        status, report, messages = _call("calibrate", changed)
        told = joined(converted.in_words_of_user(line) for line in messages)
        if status not in (DONE, GEOMETRY) or not report:
            for line in messages:
                print(converted.in_words_of_user(line), file=sys.stderr)
            return status
        rig = Rig.from_folder(changed["out"][0], report, told)
    print("\n".join(_told(rig)))
    return status


# ---- images -----------------------------------------------------------------------


def _detect(arguments: Sequence[str]) -> int:
    from .detect.command import add_target, detect_images

    parser = _Parser("rigcal detect", add_help=False, allow_abbrev=False)
    parser.add_argument("sources", nargs="+", metavar="SOURCE")
    add_target(parser)
    parser.add_argument("--out", required=True)
    parser.add_argument("--times-out")
    with _caveats_told():
        return detect_images(parser.parse_args(list(arguments)))


def _calibrate_images(arguments: Sequence[str]) -> int:
    from .detect.command import add_target, calibrate_images

    parser = _Parser("rigcal calibrate", add_help=False, allow_abbrev=False)
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--images", nargs="+", metavar="SOURCE")
    which.add_argument("--videos", nargs="+", metavar="SOURCE")
    add_target(parser)
    for name, takes_value in OPTIONS["calibrate"].items():
        if name in ("cameras", "times", "progress", "observations"):
            continue
        if name == "hold":
            parser.add_argument("--hold", action="append", default=[])
        elif takes_value:
            kind = {"seed": int, "sigma": float, "threshold": float, "sigma-time": float}
            default = "ml" if name == "method" else None
            parser.add_argument("--" + name, type=kind.get(name, str), default=default)
        else:
            parser.add_argument("--" + name, action="store_true")
    parser.add_argument("--html")
    with _caveats_told():
        return calibrate_images(parser.parse_args(list(arguments)))


def _is_of_images(arguments: Sequence[str]) -> bool:
    """Whether calibrate starts from images."""
    words = [word.partition("=")[0] for word in arguments]
    return "--images" in words or "--videos" in words


def _report(arguments: Sequence[str]) -> int:
    parser = _Parser("rigcal report", add_help=False)
    parser.add_argument("rig", nargs="+", metavar="FOLDER|FILE")
    parser.add_argument("--out", default="rig.html")
    parser.add_argument("--title")
    given = parser.parse_args(list(arguments))
    if len(given.rig) > 1:
        raise _UsageError("report takes one folder of calibrate --out, or one file")
    check_path(given.out)
    need()
    with _caveats_told():
        rig = load(given.rig[0])
        write_page(rig, given.out, given.title)
    print(given.out)
    return DONE


def _paged(arguments: Sequence[str]) -> int:
    """calibrate --html: calibrates, and writes a page with the result."""
    parser = _Parser(add_help=False, allow_abbrev=False)
    parser.add_argument("--html")
    parser.add_argument("--title")
    page, rest = parser.parse_known_args(list(arguments))
    given = _options("calibrate", rest)
    if given is None or not {"cameras", "observations"} <= set(given):
        return _program("calibrate", *rest)  # it says why not
    check_path(page.html)
    need()
    with tempfile.TemporaryDirectory(prefix="rigcal-") as folder:
        converted = _Converted(folder)
        changed = converted.options("calibrate", given)
        changed.setdefault("out", [os.path.join(folder, "out")])
        status, report, messages = _call("calibrate", changed)
        told = [converted.in_words_of_user(line) for line in messages]
        for line in told:
            print(line, file=sys.stderr)
        sys.stdout.write(report)
        if status in (DONE, GEOMETRY) and report:
            rig = Rig.from_folder(changed["out"][0], report, joined(told))
            words = [
                f"--{name}" + (f"={v}" if OPTIONS["calibrate"][name] else "")
                for name, values in given.items()
                for v in values
            ]
            rig.made = made_of(given["cameras"][0], given["observations"][0], words)
            write_page(rig, page.html, page.title)
            print(page.html, file=sys.stderr)
    return status


def _help() -> int:
    from .detect import command

    print(HELP.format(formats=", ".join(FORMATS), detect=command.HELP), end="")
    sys.stdout.flush()
    return _program("--help")


def _run(arguments: Sequence[str]) -> int:
    known = f"{', '.join(COMMANDS[:-1])} or {COMMANDS[-1]}"
    if not arguments:
        raise _UsageError(f"give a command: {known}")
    command, *rest = arguments
    if command in ("--help", "-h") or (
        command in ("diagnose", "convert", "detect", "report") and "--help" in rest
    ):
        return _help()
    if command == "--version":
        return _program(command)
    if command == "detect":
        return _detect(rest)
    if command == "calibrate" and _is_of_images(rest):
        return _calibrate_images(rest)
    if command == "convert":
        return _convert(rest)
    if command == "diagnose":
        return _diagnose(rest)
    if command == "report":
        return _report(rest)
    if command == "calibrate" and any(word.startswith("--html") for word in rest):
        return _paged(rest)
    if command not in OPTIONS:
        raise _UsageError(f'there is no command "{command}": the commands are {known}')
    return _pass_on(command, rest)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command; returns the exit status."""
    try:
        status = _run(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
    except _UsageError as problem:
        _say(str(problem))
        _say("run rigcal --help for the commands and their options")
        return USAGE
    except FileError as problem:
        print(problem, file=sys.stderr)
        return USAGE
    except Error as problem:
        _say(str(problem))
        return USAGE
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return USAGE
    return 128 - status if status < 0 else status
