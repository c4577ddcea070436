"""Files of other programs, changed at random: each is read, or refused by a FileError. What
is read can be written as rigcal's own file, and comes back as the same numbers.

    python fuzz_files.py [FILES [SEED]]     100 000 files; prints one line of a table

A change moves, repeats, removes or indents a line, puts a word into the text that means
something in one of the formats, takes a piece out, or puts in a piece of another format.
test_fuzz.py reads some hundred of one seed.
"""

from __future__ import annotations

import pathlib
import random
import re
import sys
import tempfile
import time
import warnings

from format_samples import SAMPLES, Sample

import rigcal

SEED = 1
NO_MORE = re.compile(r"(?:, -?0\.0)*\]$")
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
WORDS = [
    "nan", "inf", "-1", "0", "1e400", "1e31", "9" * 400, "1_0", "0x10", "1,5", ".5", "5.",
    '"x"', "[]", "{}", "[[", "null", "true", "~", "''", "2024-01-01", "- a", "? x", "&a",
    "*a", "<<: *a", "!!python/object:os.system", "---", "...", "%", "|", ">", "=", "#", ":",
    "\t", "'", '"', "\\", "\\u0000", "<", '<!ENTITY x "y">', "&x;", "\n\n", "\r\n", "\0",
    "\x85", "\u2028", "\ufeff", "\U0001f600", "é",
]  # fmt: skip
TEXTS = [text for sample in SAMPLES.values() for text in sample.files.values()]


def changed_lines(text: str, dice: random.Random) -> str:
    lines = text.splitlines(keepends=True) or [""]
    a, b = dice.randrange(len(lines)), dice.randrange(len(lines))
    kind = dice.randrange(4)
    if kind == 0:
        lines.insert(b, lines[a])
    elif kind == 1:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 2:
        del lines[a]
    else:
        lines[a] = " " * dice.randrange(5) + lines[a]
    return "".join(lines)


def changed(text: str, dice: random.Random) -> str:
    kind = dice.randrange(6)
    start = dice.randrange(len(text) + 1)
    end = min(len(text), start + int(dice.expovariate(1 / 12)))
    if kind == 0:
        return changed_lines(text, dice)
    if kind == 1:
        other = dice.choice(TEXTS)
        at = dice.randrange(len(other))
        return text[:start] + other[at : at + dice.randrange(200)] + text[end:]
    if kind == 2:
        return text[:start] + text[start:end] * dice.choice([0, 2, 3, 50]) + text[end:]
    if kind == 3 and (numbers := list(NUMBER.finditer(text))):
        start, end = dice.choice(numbers).span()
    elif kind == 4:
        end = start
    return text[:start] + dice.choice(WORDS) + text[end:]


def spoil(path: pathlib.Path, dice: random.Random) -> None:
    text = path.read_text(encoding="utf-8")
    for _ in range(dice.choice([1, 1, 1, 1, 2, 4])):
        text = changed(text, dice)
    data = bytearray(text.encode())
    if data and dice.random() < 0.1:
        data[dice.randrange(len(data))] = dice.randrange(256)
    path.write_bytes(data)


def numbers_of(cameras: dict[str, rigcal.Camera]) -> list[object]:
    """Without the zeros at the end of a list of coefficients."""
    return [
        (name, c.fx, c.fy, c.cx, c.cy, c.size, NO_MORE.sub("", repr(list(c.dist))), c.lens)
        + ((c.cam_from_rig.R.tolist(), c.cam_from_rig.t.tolist()) if c.cam_from_rig else ())
        for name, c in cameras.items()
    ]


def written_and_read(cameras: dict[str, rigcal.Camera], folder: pathlib.Path) -> None:
    """A camera's name may be one that a table can not have: then nothing is written."""
    again = folder / "again"
    again.mkdir()
    try:
        rigcal.save_cameras(again, cameras, format="rigcal")
    except rigcal.Error:
        assert not list(again.iterdir())
        return
    back = rigcal.load_cameras(again)
    assert numbers_of(back) == numbers_of(cameras), f"{back}\n{cameras}"


def one_file(sample: Sample, dice: random.Random) -> bool:
    """Whether the spoilt file is read."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        path = sample.put(folder)
        file = dice.choice(list(sample.files))
        spoil(folder / file, dice)
        try:
            cameras = rigcal.load_cameras(path, **sample.options)
        except rigcal.FileError:
            return False
        except Exception as error:
            text = (folder / file).read_bytes()
            raise AssertionError(f"{file}: {error!r}\n{text!r}") from error
        written_and_read(cameras, folder)
        return True


def run(files: int, seed: int) -> int:
    """How many are read."""
    dice = random.Random(seed)
    samples = list(SAMPLES.values())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rigcal.Caveat)
        return sum(one_file(dice.choice(samples), dice) for _ in range(files))


def main() -> None:
    files = int(sys.argv[1]) if len(sys.argv) > 1 else 10**5
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else SEED
    begin = time.perf_counter()
    read = run(files, seed)
    minutes = (time.perf_counter() - begin) / 60
    print(
        f"| {seed} | {files} | {read} | {files - read} | {len(SAMPLES)} | "
        f"{rigcal.__version__}, Python {sys.version.split()[0]} | {minutes:.0f} min |"
    )


if __name__ == "__main__":
    main()
