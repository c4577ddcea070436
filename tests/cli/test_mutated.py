"""calibrate and triangulate of files with random damage: no crash, and nothing half-written.

Each run damages one file of a small rig in one to three places. RIGCAL_MUTATIONS says how many
runs there are: 2000 with the sanitizers, 200 otherwise.
The search for leaks takes half of a run's time, so it is done in every fourth run.
"""
import os
import random
import unittest

from cli_support import OUTPUTS, SANITIZED, STEREO, CliTest, rigcal, write

RUNS = int(os.environ.get("RIGCAL_MUTATIONS") or (2000 if SANITIZED else 200))
WORDS = [b"", b"nan", b"inf", b"-inf", b"1e999", b"-0", b"1e-320", b"0x1p3", b"abc", b"\"", b"\"a,b\"", b"\xff\xfe",
         b"\xef\xbb\xbf", b"\x00", b" ", b"#", b"-1", b"4294967296", b"99999999999999999999", b"1.7e308", b"left", b"01"]


def small_rig():
    """Two cameras, three frames, every fifth corner."""
    with open(STEREO + "/cameras.csv", "rb") as file:
        cameras = file.read()
    with open(STEREO + "/observations.csv", "rb") as file:
        first, *rows = file.read().splitlines(keepends=True)
    kept = [r for r in rows if r.split(b",")[0] in (b"01", b"03", b"05") and int(r.split(b",")[2]) % 5 == 0]
    return {"cameras.csv": cameras, "observations.csv": first + b"".join(kept)}


def damaged(rng, data):
    """The file with one place altered: a byte, a word, a column, a line, or its end."""
    lines = data.splitlines(keepends=True)
    kind = rng.randrange(9)
    if not lines or not data:
        return rng.choice(WORDS)
    at, byte = rng.randrange(len(lines)), rng.randrange(len(data))
    if kind == 0:
        return data[:byte] + bytes([rng.randrange(256)]) + data[byte + 1:]
    if kind == 1:
        return data[:byte] + rng.choice(WORDS) + data[byte:]
    if kind == 2:
        return data[:byte] + data[byte + rng.randrange(1, 40):]
    if kind == 3:
        return data[:byte]
    if kind == 4:
        lines.insert(rng.randrange(len(lines) + 1), lines[at])
    elif kind == 5:
        del lines[at]
    elif kind == 6:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        cells = lines[at].rstrip(b"\r\n").split(b",")
        cell = rng.randrange(len(cells))
        if kind == 7:
            cells[cell] = rng.choice(WORDS)
        else:
            cells.insert(cell, cells[rng.randrange(len(cells))])
        lines[at] = b",".join(cells) + b"\n"
    return b"".join(lines)


class TestMutated(CliTest):
    def test_damaged_files_are_refused_by_name_or_calibrated_whole(self):
        rng = random.Random(18)
        files = small_rig()
        refused = 0
        for run_number in range(RUNS):
            name = rng.choice(sorted(files))
            data = files[name]
            for _ in range(rng.randrange(1, 4)):
                data = damaged(rng, data)
            paths = {n: write(self.folder, n, data if n == name else content) for n, content in files.items()}
            out = os.path.join(self.folder, f"out{run_number}")
            run = rigcal("calibrate", "--cameras", paths["cameras.csv"], "--observations", paths["observations.csv"],
                         "--out", out, errors="replace",
                         env={**os.environ, "ASAN_OPTIONS": f"detect_leaks={int(run_number % 4 == 0)}"})
            about = f"run {run_number}, {name}:\n{data!r}\n{run.stderr}"
            self.assertIn(run.returncode, (0, 1, 2), about)
            written = sorted(os.listdir(out)) if os.path.isdir(out) else []
            if run.returncode == 0:
                self.assertEqual(written, sorted(OUTPUTS), about)
            else:
                refused += 1
                first = run.stderr.split("\n", 1)[0]
                self.assertRegex(first, r"(cameras|observations)\.csv:|camera|frame|view|point", about)
                self.assertIn(written, ([], sorted(OUTPUTS)), about)
        self.assertGreater(refused, RUNS // 4)
        self.assertLess(refused, RUNS)


if __name__ == "__main__":
    unittest.main()
