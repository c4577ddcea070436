"""Random calls of the package, by its own interface: every call gives an answer or an
Error, and leaves what it was given as it was.

    python fuzz.py [CALLS [SEED]]     1 000 000 calls; prints one line of a table

Arguments are those of a call that works, of which one or two are changed: other shapes,
types and strides, Fortran's order, negative and zero strides, read-only, byte-swapped,
huge, NaN, None, and things that are no arrays. test_fuzz.py makes some thousand calls of
one seed.
"""

from __future__ import annotations

import faulthandler
import sys
import time
import warnings
from typing import Any

import numpy as np
from conftest import exact_rig

import rigcal

SEED = 1
rng = np.random.default_rng(SEED)
RIG = exact_rig(3)
STORED = exact_rig(2).to_bytes()
KINDS = ["f8", "f4", "f2", ">f8", "<i4", ">i2", "u1", "?", "c16", "O", "U3", "M8[s]", "g"]
NUMBERS = [
    0, -0.0, 1, -1, np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 5e-324, 1e30, 1e9,
    2**31, 2**63, 1e-9, 0.5, 640,
]  # fmt: skip
OBJECTS: list[Any] = [
    None, 3, -1, 2**70, 1.5, "text", b"text", "", [], (), [[]], [[1, 2], [3]], {"a": 1},
    {1}, [[None]], np.nan, True, 1j, object(), int, range(6), Ellipsis, slice(1),
    np.zeros(()), np.zeros(0), np.zeros((0, 3)), np.zeros((0, 2)), np.zeros((2, 0)),
    np.broadcast_to(np.float64(1), (2**40, 3)), np.broadcast_to(np.float64(1), (2**40, 2)),
    np.ma.masked_array(np.ones((6, 2)), mask=True), memoryview(b"12"),
    np.zeros(3, [("x", "f8")]), np.datetime64("2020"), "left", "c0", "c1",
]  # fmt: skip


# ---- arguments that work --------------------------------------------------------


def camera() -> rigcal.Camera:
    return CAMERAS[rng.integers(len(CAMERAS))]


CAMERAS = [
    rigcal.Camera(800, 790, 320, 240, (640, 480), (-0.1, 0.01, 1e-3, -5e-4, 2e-3)),
    rigcal.Camera(300, 301, 320, 240, (640, 480), (0.02, -0.01, 1e-3, 0), "fisheye"),
    rigcal.Camera(700, 700, 320, 240),
    rigcal.Camera(1, 1, 0, 0),
]


def points(n: int) -> Any:
    return rng.uniform(-0.3, 0.3, (n, 3))


def pixels(n: int) -> Any:
    return rng.uniform(0, 480, (n, 2))


def seen(n: int, k: Any = 0) -> tuple[Any, Any]:
    """Points, and their pixels in camera k; in half of the cases random pixels."""
    X, turn = (
        points(n),
        rigcal.Transform.from_rvec(rng.normal(0, 0.3, 3), [0, 0, 1.5], "c", "w"),
    )
    uv = rigcal.project(k if k else CAMERAS[0], X, turn).uv
    return X, uv + rng.normal(0, 0.3, uv.shape) if rng.random() < 0.5 else pixels(n)


def transform() -> rigcal.Transform:
    return rigcal.Transform.from_rvec(rng.normal(size=3), rng.normal(size=3))


MONITOR: list[rigcal.Monitor] = []


def monitor() -> rigcal.Monitor:
    if not MONITOR or rng.random() < 0.01:
        MONITOR[:] = [rigcal.Monitor(RIG, int(rng.integers(0, 3)))]
    return MONITOR[0]


def some(n: int = 8) -> int:
    return int(rng.integers(3, n + 3))


def two_seen() -> list[Any]:
    n = some()
    return [pixels(n), pixels(n)]


# For each: a function, and what makes its arguments.
CALLS: dict[str, tuple[Any, Any]] = {
    "solve_pose": (
        lambda c, X, uv, s, p, r, t: rigcal.solve_pose(
            c, X, uv, sigma=s, sigma_px=p, robust=r, start=t
        ),
        lambda: [CAMERAS[0], *seen(some()), None, None, bool(rng.random() < 0.3), None],
    ),
    "solve_poses": (
        lambda c, X, uv, n, r, v, k: rigcal.solve_poses(
            c, X, uv, n=n, robust=r, covariance=v, threads=k
        ),
        lambda: [
            CAMERAS[0], *(lambda X, uv: (X, np.stack([uv, uv])))(*seen(some())),
            None, False, True, 1,
        ],
    ),
    "blame": (rigcal.blame, lambda: [CAMERAS[0], *seen(some())]),
    "diagnose": (rigcal.diagnose, lambda: [CAMERAS[0], *seen(some())]),
    "solve_tags": (rigcal.solve_tags, lambda: [camera(), pixels(4)[None], 0.1]),
    "solve_tag": (rigcal.solve_tag, lambda: [camera(), pixels(4), 0.1]),
    "project": (rigcal.project, lambda: [camera(), points(some()), transform()]),
    "pixel_to_ray": (rigcal.pixel_to_ray, lambda: [camera(), pixels(some())]),
    "undistort": (rigcal.undistort, lambda: [camera(), pixels(some())]),
    "distort": (rigcal.distort, lambda: [camera(), pixels(some())]),
    "Camera": (
        lambda *a: rigcal.Camera(*a).coefficients,
        lambda: [800, 800, 320, 240, (640, 480), [0.1, 0, 0, 0], "brown", "a", None],
    ),
    "Camera.from_matrix": (
        rigcal.Camera.from_matrix,
        lambda: [np.array([[800, 0, 320], [0, 800, 240], [0, 0, 1.0]])],
    ),
    "Transform": (
        lambda *a: repr(rigcal.Transform(*a).inv()),
        lambda: [transform().R, rng.normal(size=3), "a", "b"],
    ),
    "from_rvec": (rigcal.Transform.from_rvec, lambda: list(rng.normal(size=(2, 3)))),
    "from_quat": (
        rigcal.Transform.from_quat_wxyz,
        lambda: [transform().quat_wxyz, rng.normal(size=3)],
    ),
    "from_matrix": (rigcal.Transform.from_matrix, lambda: [transform().matrix]),
    "apply": (lambda X: transform().apply(X), lambda: [points(some())]),
    "from_bytes": (
        lambda data: rigcal.CalibratedRig.from_bytes(data).to_bytes(),
        lambda: [damaged(STORED)],
    ),
    "triangulate": (
        lambda a, b, s: RIG.triangulate({"c0": a, 1: b}, sigma_px=s),
        lambda: [*two_seen(), 1.0],
    ),
    "stacked": (
        lambda uv, s: exact_rig(2).triangulate(uv, sigma_px=s),
        lambda: [np.stack(two_seen()), 1.0],
    ),
    "transfer": (
        lambda a, uv, b, uv_b, c, s: RIG.transfer(a, uv, b, uv_b, c, sigma_px=s),
        lambda: [0, *(lambda u, v: (u, "c1", v))(*two_seen()), 2, 1.0],
    ),
    "band": (
        lambda a, uv, b, s, d, n: RIG.band(a, uv, b, sigma_px=s, depth=d).curve(n),
        lambda: [0, pixels(some()), 1, 1.0, (1, 2), 3],
    ),
    "search": (
        lambda uv, uv_b, n: RIG.band(0, uv, 1, sigma_px=1).search(uv_b, n),
        lambda: [*two_seen(), 3],
    ),
    "test": (lambda uv, b: RIG.band(0, uv, 1, sigma_px=1).test(b), two_seen),
    "spans": (
        lambda a, uv, b, s: RIG.spans(a, uv, b, sigma_px=s),
        lambda: [0, pixels(2), 1, 1.0],
    ),
    "match_line": (
        lambda a, uv, b, s, n: RIG.match_line(a, uv, b, sigma_px=s, n=n),
        lambda: [0, pixels(some()), 1, 1.0, 5],
    ),
    "pair": (RIG.pair, lambda: [0, "c1"]),
    "covariance": (RIG.covariance, lambda: [0, 1]),
    "Monitor": (rigcal.Monitor, lambda: [RIG, 1]),
    "add_matches": (
        lambda *a: monitor().add_matches(*a),
        lambda: [0, *(lambda u, v: (u, 1, v))(*two_seen()), 1.0],
    ),
    "add_view": (
        lambda *a: monitor().add_view(*a),
        lambda: [int(rng.integers(3)), *seen(some(), RIG["c0"]), 0, 1.0],
    ),
    "end_frame": (lambda s: monitor().end_frame(s), lambda: [0.1]),
    "body": (lambda k: monitor().body(k), lambda: [1]),
    "moved": (lambda k: monitor().moved(k), lambda: [1]),
    "lift": (lambda k: monitor().lift(k), lambda: [0]),
    "monitor.pair": (lambda a, b: monitor().pair(a, b), lambda: [0, 1]),
    "monitor.rig": (lambda: (monitor().report(), monitor().rig()), lambda: []),
}  # fmt: skip


# ---- and what is made of them --------------------------------------------------------


def damaged(data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(int(rng.integers(0, 4))):
        out[rng.integers(len(out))] = rng.integers(256)
    return bytes(out[: rng.integers(len(out) + 1)] if rng.random() < 0.3 else out)


def strides(array: Any) -> Any:
    """The same numbers, or some of them, with other strides."""
    way = rng.integers(7)
    if way == 0:
        return np.asfortranarray(array)
    if way == 1:
        return array[::-1]
    if way == 2:
        return np.repeat(array, 2, axis=-1)[..., ::2]
    if way == 3:
        return np.flip(array)
    if way == 4:
        return np.broadcast_to(array[:1], array.shape)
    if way == 5:  # at an address that is not aligned for its type
        raw = np.zeros(array.nbytes + 1, np.uint8)
        raw[1:] = np.frombuffer(array.tobytes(), np.uint8)
        return raw[1:].view(array.dtype).reshape(array.shape)
    return array[..., ::-1]


def changed(value: Any) -> Any:
    """Something else in place of this argument."""
    way = rng.integers(8)
    usual = isinstance(value, np.ndarray) and value.ndim > 0 and value.dtype.kind in "fiu"
    if way == 0 or not usual or not 0 < value.size < 10**6:
        return (
            OBJECTS[rng.integers(len(OBJECTS))]
            if way
            else NUMBERS[rng.integers(len(NUMBERS))]
        )
    if way == 1:
        return value.astype(KINDS[rng.integers(len(KINDS))])
    if way == 2:
        shape = tuple(rng.integers(0, 7, rng.integers(0, 5)))
        return np.resize(value, shape)
    if way == 3:
        return value[: rng.integers(len(value) + 1)]
    if way == 4:
        return value.tolist()
    if way == 5:
        return strides(value)
    value = np.array(value, float)
    for _ in range(int(rng.integers(1, 4))):
        value.flat[rng.integers(value.size)] = NUMBERS[rng.integers(len(NUMBERS))]
    return value * 10.0 ** rng.integers(-300, 300) if way == 6 else value


def record(value: Any) -> Any:
    """What must be the same afterwards."""
    if isinstance(value, np.ndarray) and value.size < 10**6 and value.dtype.kind != "O":
        return value.shape, value.strides, value.tobytes()
    return repr(value) if isinstance(value, (list, tuple, dict, set)) else None


def one_call(counts: dict[str, int]) -> None:
    name = NAMES[rng.integers(len(NAMES))]
    function, make = CALLS[name]
    arguments = make()
    for _ in range(int(rng.integers(0, 3)) if arguments else 0):
        k = rng.integers(len(arguments))
        arguments[k] = changed(arguments[k])
    for value in arguments:
        if isinstance(value, np.ndarray) and rng.random() < 0.3:
            value.flags.writeable = False
    before = [record(value) for value in arguments]
    try:
        function(*arguments)
        counts["answers"] += 1
    except rigcal.Error:
        counts["errors"] += 1
    except Exception as error:
        text = f"{name}: {type(error).__name__}: {error}"
        raise AssertionError(f"{text}\n{arguments!r}") from error
    if before != [record(value) for value in arguments]:
        raise AssertionError(f"{name} changed its arguments: {arguments!r}")
    counts[name] = counts.get(name, 0) + 1


NAMES = list(CALLS)


def run(calls: int, seed: int) -> dict[str, int]:
    global rng
    rng = np.random.default_rng(seed)
    MONITOR.clear()
    counts = {"answers": 0, "errors": 0}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for _ in range(calls):
            one_call(counts)
    return counts


def main() -> None:
    faulthandler.enable()
    calls = int(sys.argv[1]) if len(sys.argv) > 1 else 10**6
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else SEED
    begin = time.perf_counter()
    counts = run(calls, seed)
    minutes = (time.perf_counter() - begin) / 60
    print(
        f"| {seed} | {calls} | {counts['answers']} | {counts['errors']} | {len(NAMES)} | "
        f"{rigcal.__version__}, Python {sys.version.split()[0]}, NumPy {np.__version__} | "
        f"{minutes:.0f} min |"
    )


if __name__ == "__main__":
    main()
