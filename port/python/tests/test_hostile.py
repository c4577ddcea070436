"""Any input gives an answer, or an Error that names the argument and its shape."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
from conftest import exact_rig
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import rigcal

FEW = settings(
    max_examples=25,
    deadline=None,
    database=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
CAMERA = rigcal.Camera(
    800, 790, 320, 240, size=(640, 480), dist=(-0.1, 0.01, 1e-3, -5e-4, 2e-3)
)
RIG = exact_rig(2)
X_OF = np.random.default_rng(3).uniform(-0.3, 0.3, (6, 3))
UV_OF = np.random.default_rng(4).uniform(0, 400, (6, 2))
HUGE = np.broadcast_to(np.float64(1), (2**40, 3))
HUGE_PIXELS = np.broadcast_to(np.float64(1), (2**40, 2))

NUMBERS = st.floats(allow_nan=True, allow_infinity=True, width=64)


def arrays(columns):
    """Arrays of numbers, some of the right shape."""
    shapes = st.one_of(
        st.tuples(st.integers(0, 12), st.just(columns)),
        npst.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4),
    )
    kinds = st.sampled_from(
        ["f8", "f4", "f2", ">f8", "i4", "u1", "?", "c16", "O", "U3", "M8[s]"]
    )
    made = kinds.flatmap(
        lambda kind: npst.arrays(
            np.dtype(kind),
            shapes,
            elements=st.none() | st.integers() if kind == "O" else None,
        )
    )
    return st.one_of(made, made.map(strange), st.sampled_from(OBJECTS))


def strange(array):
    """The same array with other strides and read-only."""
    out = np.asfortranarray(array)[::-1] if array.ndim else array
    out.setflags(write=False)
    return out


OBJECTS = [
    None,
    3,
    "text",
    [],
    [[1, 2], [3]],
    {"a": 1},
    [[None]],
    HUGE,
    HUGE_PIXELS,
    np.nan,
]

# Every function by what it takes: the arguments that are tried, and their columns.
CALLS = {
    "solve_pose": (
        lambda a, b: rigcal.solve_pose(CAMERA, a, b),
        ("X", X_OF, 3),
        ("uv", UV_OF, 2),
    ),
    "robust": (
        lambda a, b: rigcal.solve_pose(CAMERA, a, b, robust=True),
        ("X", X_OF, 3),
        ("uv", UV_OF, 2),
    ),
    "sigma": (
        lambda a, b: rigcal.solve_pose(CAMERA, X_OF, a, sigma=b),
        ("uv", UV_OF, 2),
        ("sigma", np.ones(6), 6),
    ),
    "solve_poses": (
        lambda a, b: rigcal.solve_poses(CAMERA, a, b),
        ("X", X_OF, 3),
        ("uv", UV_OF[None], 2),
    ),
    "offsets": (
        lambda a, b: rigcal.solve_poses(CAMERA, X_OF, a, n=b),
        ("uv", UV_OF, 2),
        ("n", [6], 1),
    ),
    "camera_of": (
        lambda a, b: rigcal.solve_poses([CAMERA], X_OF, a, camera_of=b),
        ("uv", UV_OF[None], 2),
        ("camera_of", [0], 1),
    ),
    "blame": (
        lambda a, b: rigcal.blame(CAMERA, a, b),
        ("X", X_OF, 3),
        ("uv", UV_OF, 2),
    ),
    "diagnose": (
        lambda a, b: rigcal.diagnose(CAMERA, a, b),
        ("X", X_OF, 3),
        ("uv", UV_OF, 2),
    ),
    "tags": (
        lambda a, b: rigcal.solve_tags(CAMERA, a, b),
        ("corners", UV_OF[None, :4], 2),
        ("size", 0.1, 1),
    ),
    "tag": (
        lambda a, _: rigcal.solve_tag(CAMERA, a, 0.1),
        ("corners", UV_OF[:4], 2),
        ("", 0, 1),
    ),
    "project": (
        lambda a, b: rigcal.project(CAMERA, a, b),
        ("X", X_OF, 3),
        ("cam_from_world", None, 3),
    ),
    "rays": (
        lambda a, b: (rigcal.pixel_to_ray(CAMERA, a), rigcal.undistort(CAMERA, b)),
        ("uv", UV_OF, 2),
        ("uv", UV_OF, 2),
    ),
    "distort": (lambda a, _: rigcal.distort(CAMERA, a), ("uv", UV_OF, 2), ("", 0, 1)),
    "triangulate": (
        lambda a, b: RIG.triangulate({"c0": a, "c1": b}, sigma_px=1),
        ("uv", UV_OF, 2),
        ("uv", UV_OF, 2),
    ),
    "stacked": (
        lambda a, b: RIG.triangulate(a, sigma_px=b),
        ("uv", np.stack([UV_OF, UV_OF]), 2),
        ("sigma_px", 1.0, 2),
    ),
    "transfer": (
        lambda a, b: exact_rig(3).transfer(0, a, 1, b, 2, sigma_px=1),
        ("uv_a", UV_OF, 2),
        ("uv_b", UV_OF, 2),
    ),
    "band": (
        lambda a, b: RIG.band(0, a, 1, sigma_px=1, depth=b).curve(3),
        ("uv", UV_OF, 2),
        ("depth", (1, 2), 2),
    ),
    "spans": (
        lambda a, _: RIG.spans(0, a, 1, sigma_px=1),
        ("uv", UV_OF, 2),
        ("", 0, 1),
    ),
    "search": (
        lambda a, b: RIG.band(0, UV_OF, 1, sigma_px=1).search(a, b),
        ("uv_b", UV_OF, 2),
        ("most", 3, 1),
    ),
    "test": (
        lambda a, b: (
            RIG.band(0, UV_OF[0], 1, sigma_px=1).test(a),
            RIG.band(0, UV_OF, 1, sigma_px=1).test(b),
        ),
        ("uv_b", UV_OF, 2),
        ("uv_b", UV_OF, 2),
    ),
}  # fmt: skip


def answer(call, a, b):
    """None, or the text of the Error. Anything else fails the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            call(a, b)
        except rigcal.Error as error:
            return str(error)
    return None


@pytest.mark.parametrize("name", CALLS)
@FEW
@given(data=st.data())
def test_one_argument_is_anything(name, data):
    call, (first, good_a, columns_a), (second, good_b, columns_b) = CALLS[name]
    value = data.draw(arrays(columns_a))
    # An empty list has no views. Then it is the other argument that does not fit.
    text = answer(call, value, good_b)
    assert text is None or re.search(rf"\b({first}|{second or first})\b", text), text
    if second:
        value = data.draw(arrays(columns_b))
        text = answer(call, good_a, value)
        assert text is None or re.search(rf"\b{second}\b", text), text


@FEW
@given(
    X=npst.arrays(np.float64, (7, 3), elements=NUMBERS),
    uv=npst.arrays(np.float64, (7, 2), elements=NUMBERS),
)
def test_any_numbers(X, uv):
    for call, (first, _, _), (second, _, _) in (CALLS["solve_pose"], CALLS["robust"]):
        text = answer(call, X, uv)
        assert text is None or re.search(rf"\b({first}|{second})\b", text)
    poses = rigcal.solve_poses(CAMERA, X, uv[None], covariance=True)
    assert (poses.status[0] >= 0) == np.isfinite(poses.R[0]).all()
    found = RIG.triangulate({"c0": uv, "c1": uv[::-1]}, sigma_px=1)
    assert np.array_equal(found.status >= 0, np.isfinite(found.X).all(1))
    pixels = rigcal.project(CAMERA, X)
    assert np.array_equal(pixels.status >= 0, np.isfinite(pixels.uv).all(1))
    lines = RIG.match_line(0, uv, 1, sigma_px=1, n=5)
    assert np.array_equal(lines.status >= 0, lines.n_places > 0)
    RIG.spans(0, uv, 1, sigma_px=1)


@pytest.mark.parametrize("name", ["solve_pose", "blame", "diagnose"])
def test_an_element_that_is_not_finite_names_its_argument(name):
    call = CALLS[name][0]
    for value in (np.nan, np.inf):
        X, uv = X_OF.copy(), UV_OF.copy()
        X[2, 1] = value
        assert re.match(r"RIGCAL_ERR_NOT_FINITE: X: .*\(6, 3\)", answer(call, X, uv))
        uv[1, 0] = value
        assert re.match(r"RIGCAL_ERR_NOT_FINITE: uv: .*\(6, 2\)", answer(call, X_OF, uv))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.zeros((6, 3)), r"uv: shape \(n, 2\) is expected, not \(6, 3\)"),
        (np.zeros(6), r"uv: shape \(n, 2\) is expected, not \(6,\)"),
        (np.zeros((6, 2), complex), r"uv: .*complex128 of shape \(6, 2\)"),
        ([["a", "b"]], r"uv: .*<U1 of shape \(1, 2\)"),
        ([[1, 2], [3]], r"uv: numbers of shape \(n, 2\)"),
        (HUGE_PIXELS, r"uv: shape \(1099511627776, 2\) has more than 2\^28"),
        (UV_OF[:5], r"X has shape \(6, 3\) and uv \(5, 2\)"),
    ],
)
def test_texts(value, text):
    assert re.match(text, answer(CALLS["solve_pose"][0], X_OF, value))


def test_counts_that_do_not_fit():
    pixels = np.zeros((6, 2))
    for n, text in (
        ([5], "sum of n is 5"),
        ([-1, 7], "n: 0 to"),
        ([2.5], "n: whole numbers"),
        ([[6]], r"n: .*\(1, 1\)"),
        ([2, 4], "view 0 has 2 pixels"),
        ([2**40], "n: 0 to"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.solve_poses(CAMERA, X_OF[:4], pixels, n=n)
    with pytest.raises(rigcal.Error, match="view 1 has 5 pixels"):
        rigcal.solve_poses(CAMERA, X_OF, [UV_OF, UV_OF[:5]])
    with pytest.raises(rigcal.Error, match=r"X has views of \[6, 5\] points"):
        rigcal.solve_poses(CAMERA, [X_OF, X_OF[:5]], [UV_OF, UV_OF])
    with pytest.raises(rigcal.Error, match=r"uv\[1\]: shape"):
        rigcal.solve_poses(CAMERA, X_OF, [UV_OF, X_OF])


def test_cameras_that_do_not_fit():
    views = UV_OF[None]
    for camera, options, text in (
        ("cam", {}, "camera"),
        ([], {}, "camera"),
        ([CAMERA, 3], {}, "camera: int"),
        ([CAMERA, CAMERA], {}, "camera_of"),
        ([CAMERA], {"camera_of": [1]}, "camera_of: 0 to 0"),
        ([CAMERA], {"camera_of": [0, 0]}, r"camera_of: .*\(2,\)"),
        ([CAMERA], {"camera_of": [-1]}, "camera_of"),
        (CAMERA, {"most": 5}, "most"),
        (CAMERA, {"most": 1.5}, "most"),
        (CAMERA, {"threads": 0}, "threads"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.solve_poses(camera, X_OF, views, **options)
    with pytest.raises(rigcal.Error, match="camera"):
        rigcal.solve_pose("cam", X_OF, UV_OF)


def layouts(array):
    """The same numbers in other memory."""
    sliced = np.full([2 * n for n in array.shape], 7.0)[tuple([np.s_[::2]] * array.ndim)]
    sliced[...] = array
    odd = np.frombuffer(bytearray(array.nbytes + 1), np.float64, array.size, 1)
    odd = odd.reshape(array.shape)
    odd[...] = array
    assert not odd.flags.aligned
    return {
        "sliced": sliced,
        "reversed": np.ascontiguousarray(array[::-1])[::-1],
        "Fortran": np.asfortranarray(array),
        "big-endian": array.astype(">f8"),
        "not aligned": odd,
        "no mask": np.ma.masked_array(array),
        "list": array.tolist(),
    }


@pytest.mark.parametrize("name", ["solve_pose", "project", "distort"])
def test_equal_numbers_give_the_same_bits(name):
    call, (_, good_a, _), (_, good_b, _) = CALLS[name]

    def numbers(a, b):
        out = call(a, b)
        pose = getattr(out, "cam_from_world", None)
        return [np.asarray(x) for x in ((pose.R, pose.t) if pose else out)]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = numbers(good_a, good_b)
        for layout, array in layouts(good_a).items():
            other = layouts(good_b)[layout] if isinstance(good_b, np.ndarray) else good_b
            for x, y in zip(expected, numbers(array, other)):
                assert x.tobytes() == y.tobytes(), layout


@pytest.mark.parametrize("name", CALLS)
def test_masked_elements_are_not_read(name):
    call, (first, good, _), (_, other, _) = CALLS[name]
    if not isinstance(good, np.ndarray):
        return
    masked = np.ma.masked_array(good, mask=np.zeros(good.shape, bool))
    masked[..., 0, 0] = np.ma.masked
    text = answer(call, masked, other)
    assert text is not None
    assert re.search(rf"\b{first}\b.*masked", text), text


def test_sigma_has_the_form_of_the_views():
    sizes, rng = (6, 4, 5), np.random.default_rng(5)
    parts = [UV_OF[:n] for n in sizes]
    X, sigma = [X_OF[:n] for n in sizes], [rng.uniform(0.5, 2, n) for n in sizes]
    listed = rigcal.solve_poses(CAMERA, X, parts, sigma=sigma)
    joined = rigcal.solve_poses(CAMERA, X, parts, sigma=np.concatenate(sigma))
    assert np.array_equal(listed.sse, joined.sse, equal_nan=True)
    for k, n in enumerate(sizes):
        one = rigcal.solve_poses(CAMERA, X_OF[:n], UV_OF[None, :n], sigma=sigma[k][None])
        assert np.array_equal(one.sse, listed.sse[k : k + 1], equal_nan=True)
    assert np.isfinite(listed.sse).any()
    for wrong, text in (
        (sigma[:2], "sigma: 3 views"),
        ([*sigma[:2], np.ones(4)], r"sigma\[2\]: shape \(5,\)"),
        (np.ones(14), r"sigma: shape \(15,\)"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.solve_poses(CAMERA, X, parts, sigma=wrong)


def test_one_array_of_targets_and_a_list_of_views():
    X, uv = np.stack([X_OF, X_OF + 0.01]), np.stack([UV_OF, UV_OF + 1])
    mixed = rigcal.solve_poses(CAMERA, X, list(uv))
    assert np.array_equal(mixed.t, rigcal.solve_poses(CAMERA, X, uv).t, equal_nan=True)


def test_options_that_contradict():
    for call in (rigcal.solve_pose, rigcal.solve_poses):
        uv = UV_OF if call is rigcal.solve_pose else UV_OF[None]
        for option in ("threshold_px", "samples", "seed", "max_units"):
            with pytest.raises(rigcal.Error, match=option):
                call(CAMERA, X_OF, uv, **{option: 3})
    with pytest.raises(rigcal.Error, match="camera: a Camera is expected, not list"):
        rigcal.solve_pose([CAMERA], X_OF, UV_OF)
    with pytest.raises(rigcal.Error, match="sigma_px: a number is expected, not str"):
        rigcal.solve_pose(CAMERA, X_OF, UV_OF, sigma_px="0.5")
    seen = np.stack([UV_OF, UV_OF])
    for option in ("keep_all", "distances"):
        for value in ("no", None, np.ones(3)):
            with pytest.raises(rigcal.Error, match=option):
                RIG.triangulate(seen, sigma_px=1, **{option: value})


def test_cameras_of_a_rig_that_do_not_fit():
    for cameras in (None, 3, CAMERA, [3], {"a": None}):
        with pytest.raises(rigcal.Error, match="camera"):
            rigcal.CalibratedRig.from_cameras(cameras)
    with pytest.raises(rigcal.Error, match="names: 2 are expected, not int"):
        rigcal.CalibratedRig.from_bytes(RIG.to_bytes(), 3)
    for a, b, text in (("x", 0, "a: there is no camera 'x'"), (0, 7, "b: a whole number")):
        with pytest.raises(rigcal.Error, match=text):
            RIG.band(a, UV_OF, b, sigma_px=1)
        with pytest.raises(rigcal.Error, match=text):
            RIG.pair(a, b)
        with pytest.raises(rigcal.Error, match=text):
            RIG.transfer(a, UV_OF, b, UV_OF, 1, sigma_px=1)


@pytest.mark.parametrize("value", [None, 3, True, 1.5, np.ones(2), 1j])
def test_what_is_no_path(value):
    one = {"a": CAMERA}
    target = rigcal.Target("aprilgrid", 6, 6, 0.088, 0.3)
    for call in (
        lambda: rigcal.load(value),
        lambda: rigcal.load_cameras(value),
        lambda: rigcal.load_target(value),
        lambda: rigcal.save_cameras(value, one),
        lambda: rigcal.save_target(value, target),
    ):
        with pytest.raises(rigcal.Error, match="path: a path is expected"):
            call()


def test_things_to_save_that_are_none(tmp_path):
    for value in (None, 3, "x"):
        with pytest.raises(rigcal.Error, match="target: a Target is expected"):
            rigcal.save_target(tmp_path / "a.yaml", value)
    for value in (None, 3, [3]):
        with pytest.raises(rigcal.Error, match="cameras: "):
            rigcal.save_cameras(tmp_path / "a.yaml", value)
    assert not list(tmp_path.iterdir())
    for where in (None, 3, {"a": np.zeros((4, 3))}, [1, 2]):
        with pytest.raises(rigcal.Error, match="where: "):
            rigcal.Tags(where)
