"""calibrate's column turned: targets that look the same from several sides."""
import os
import unittest

import numpy as np

from cli_support import (FLOAT, Camera, CliTest, angle_deg, camera_row, compose, content, read,
                         relative, rotation, transforms, write)

STILL = np.eye(3), np.zeros(3)
CAMERAS = {"a": STILL, "b": (rotation(0, 0.3, 0.05), np.array([-1.2, 0.1, 0.2])),
           "c": (rotation(0.1, -0.4, 0), np.array([1.4, 0, 0.3]))}
DELAYS = {"a": 0.0, "b": 0.02, "c": -0.012}  # s
FPS = 15


def turned_number(columns, rows):
    """For each point of a board by rows: the point that it becomes."""
    number = np.arange(columns * rows).reshape(rows, columns)
    return (np.rot90(number) if columns == rows else np.rot90(number, 2)).ravel()


def place(t):
    """The place of the target, smooth in time."""
    return (rotation(0.35 * np.sin(2.1 * t), 0.15 + 0.35 * np.cos(1.7 * t), 0.4 * np.sin(1.3 * t)),
            np.array([0.4 * np.sin(2.6 * t), 0.3 * np.cos(2.2 * t), 6 + 0.5 * np.sin(1.9 * t)]))


class TestTurned(CliTest):
    def made(self, columns=4, rows=4, seed=1, frames=12, delays=None, noise_px=0.05, part=0.4):
        """The files of a board. In each view the points are named from a random side."""
        rng = np.random.default_rng(seed)
        X = np.array([[0.3 * x, 0.3 * y, 0] for y in range(rows) for x in range(columns)])
        X -= X.mean(axis=0) - [0.1, 0.2, 0]
        turn = turned_number(columns, rows)
        lines, times = ["frame,camera,point,X,Y,Z,u,v,turned"], ["frame,camera,time_s"]
        self.n_turned = 0
        for frame in range(frames):
            for name, pose in CAMERAS.items():
                late = (delays or {}).get(name, 0)
                R, t = compose(pose, place(frame / FPS + late if delays else 0.3 * frame))
                uv = Camera(camera_row(name)).project(X @ R.T + t)
                uv += rng.normal(0, noise_px, uv.shape)
                number = np.arange(len(X))
                if rng.random() < part:
                    self.n_turned += 1
                    for _ in range(int(rng.integers(1, 4 if columns == rows else 2))):
                        number = turn[number]
                for k, p in zip(number, uv.tolist()):
                    x = ",".join(repr(float(v)) for v in X[k])
                    lines.append(f"{frame},{name},p{k},{x},{p[0]!r},{p[1]!r},p{turn[k]}")
                times.append(f"{frame},{name},{frame / FPS!r}")
        table = [camera_row(n) for n in CAMERAS]
        write(self.folder, "cameras.csv", "\n".join([",".join(table[0]), *(",".join(
            str(v) for v in row.values()) for row in table)]))
        write(self.folder, "times.csv", "\n".join(times))
        write(self.folder, "observations.csv", "\n".join(lines))
        return self.folder

    def off(self):
        found = transforms(self.result("rig.csv"), "camera")
        return max(angle_deg(relative(found[n], found["a"])[0], CAMERAS[n][0]) for n in "bc")

    def test_views_read_from_any_side_give_the_true_rig(self):
        for columns, rows, sides in ((4, 4, 4), (5, 3, 2), (4, 6, 2)):
            with self.subTest(board=(columns, rows)):
                run = self.calibrate_set(self.made(columns, rows))
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertRegex(run.stderr, rf"\Arigcal: the target looks the same from {sides} "
                                 r"sides: \d+ of 36 views were read from another side than the "
                                 r"rest, and are turned\n\Z")
                self.assertLess(self.off(), 0.05)
                self.assertFalse([r for r in read(self.result("residuals.csv"))
                                  if r["left_out"] == "1" or float(r["error_px"]) > 1])

    def test_without_the_column_views_contradict(self):
        folder = self.made(5, 3)
        text = content(folder, "observations.csv")
        write(folder, "observations.csv", "\n".join(
            line.rsplit(",", 1)[0] for line in text.split("\n")))
        run = self.calibrate_set(folder)
        self.assertEqual(run.returncode, 1)
        self.assertIn("are numbered in reverse", run.stderr)

    def test_views_that_are_read_alike_stay_as_they_are(self):
        run = self.calibrate_set(self.made(5, 3, part=0))
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        given = read(os.path.join(self.folder, "observations.csv"))
        place_of = {r["point"]: r["X"] for r in given}
        for r in read(self.result("residuals.csv")):
            self.assertAlmostEqual(float(r["X"]), float(place_of[r["point"]]), delta=1e-6)

    def test_a_motion_is_followed_through_readings(self):
        """The reading changes at random from frame to frame, for each camera."""
        folder = self.made(5, 3, frames=30, delays=DELAYS)
        run = self.calibrate_set(folder, "--times", os.path.join(folder, "times.csv"), "--clocks")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertLess(self.off(), 0.1)
        for r in read(self.result("clocks.csv")):
            self.assertAlmostEqual(float(r["offset"] or 0), DELAYS[r["camera"]],
                                   delta=0.003 if FLOAT else 0.001)

    def test_one_place_does_not_tell(self):
        run = self.calibrate_set(self.made(5, 3, frames=1))
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "the frames do not tell which is meant for b and c\n"
                         "rigcal:   show it in more places")

    def test_what_is_wrong_is_named(self):
        folder = self.made(5, 3, frames=3, part=0)
        path = os.path.join(folder, "observations.csv")
        head, *lines = content(folder, "observations.csv").split("\n")
        n = len(lines)

        def spoilt(change):
            made = [line.split(",") for line in lines]
            for k, fields in enumerate(made):
                change(k, fields)
            write(folder, "observations.csv", "\n".join([head, *map(",".join, made)]))
            run = self.calibrate_set(folder)
            self.assertEqual(run.returncode, 2, run.stderr)
            return run.stderr

        def cell(line, text):
            return lambda k, fields: fields.__setitem__(8, text) if k == line else None

        def of_point(name, text):
            return lambda k, f: f.__setitem__(8, text) if f[2] == name else None

        for change, text in (
                (cell(n - 1, "p3"), f":{n + 1}: column turned: point p14 is p3 here, and p0 on a"),
                (cell(4, ""), ":6: column turned"),
                (of_point("p3", "p99"), ":5: column turned: point p99, which p3 becomes, is in no"),
                (of_point("p3", "p10"), "is not itself again after as many turns as the other"),
                (lambda k, f: f.__setitem__(8, f"p{(int(f[2][1:]) + 1) % 15}"),
                 "is not itself again after as many turns as the other"),
                (lambda k, f: f.__setitem__(8, {"p0": "p1", "p1": "p0"}.get(f[2], f[2])),
                 "column turned: no turn of the target takes every point to the one that"),
                (lambda k, f: f.__setitem__(3, "9") if k >= n // 2 and f[2] == "p3" else None,
                 "has other coordinates X, Y, Z")):
            with self.subTest(text=text):
                told = spoilt(change)
                self.assertIn(f"{path}:", told)
                self.assertIn(text, told)


if __name__ == "__main__":
    unittest.main()
