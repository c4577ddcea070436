"""Pixels, rays, points and lines, compared with NumPy's formulas and with brute force."""

from __future__ import annotations

import copy
import ctypes
import dataclasses
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import exact_rig, numpy_project, seen

import rigcal
from rigcal import Status
from rigcal._library import lib

# ---- pixels and rays -----------------------------------------------------------


def points(rng, n=200):
    X = rng.uniform(-0.5, 0.5, (n, 3))
    X[:, 2] = rng.uniform(1, 3, n)
    return X


@pytest.mark.parametrize("lens", ["camera", "fisheye"])
def test_project_and_back(lens, rng, request):
    cam = request.getfixturevalue(lens)
    X = points(rng)
    uv, status = rigcal.project(cam, X)
    assert not status.any()
    assert np.allclose(uv, numpy_project(cam, X), atol=1e-9)
    rays, status = rigcal.pixel_to_ray(cam, uv)
    assert not status.any()
    assert np.allclose(rays, X / np.linalg.norm(X, axis=1)[:, None], atol=1e-9)
    straight, status = rigcal.undistort(cam, uv)
    pinhole = X[:, :2] / X[:, 2:] * [cam.fx, cam.fy] + [cam.cx, cam.cy]
    assert np.allclose(straight, pinhole, atol=1e-7)
    assert np.allclose(rigcal.distort(cam, straight).uv, uv, atol=1e-7)


def test_project_from_the_world(camera, truth, target):
    uv, status = rigcal.project(camera, target, truth)
    assert not status.any()
    assert np.allclose(uv, seen(camera, truth, target), atol=1e-9)


def test_items_that_fail_are_nan_and_have_a_status(camera):
    X = np.array([[0, 0, 1.0], [0, 0, -1], [np.nan, 0, 1], [0.1, 0, 1]])
    uv, status = rigcal.project(camera, X)
    names = [Status(s).name for s in status]
    assert names[1:3] == ["RIGCAL_ERR_BEHIND", "RIGCAL_ERR_NOT_FINITE"]
    assert np.isnan(uv).all(axis=1).tolist() == [False, True, True, False]
    rays, status = rigcal.pixel_to_ray(exact_rig(1)[0], [[0, 0], [np.inf, 0], [1e8, 0]])
    assert status.tolist()[:2] == [0, Status.RIGCAL_ERR_NOT_FINITE]
    assert status[2] == Status.RIGCAL_ERR_NO_RAY
    assert np.isnan(rays[1:]).all()


def test_cameras_that_are_none(truth, target):
    with pytest.raises(rigcal.Error, match="camera"):
        rigcal.project({"fx": 1}, target)
    with pytest.raises(rigcal.Error, match="cam_from_world"):
        rigcal.project(rigcal.Camera(1, 1, 0, 0), target, np.eye(4))


# ---- points ----------------------------------------------------------------------


def sightings(rig, X, noise=0.0, rng=None):
    return {n: seen(c, c.cam_from_rig, X, noise, rng) for n, c in rig.cameras.items()}


def in_front(rng, n=50):
    return rng.uniform(-0.4, 0.4, (n, 3)) + [0, 0, 2.5]


@pytest.mark.parametrize("threads", [1, 2])
def test_exact_pixels_give_the_true_points(rng, threads):
    rig, X = exact_rig(), in_front(rng, 600)
    uv = sightings(rig, X)
    found = rig.triangulate(uv, sigma_px=0.2, threads=threads)
    assert not found.status.any()
    assert np.allclose(found.X, X, atol=1e-9)
    assert found.used.all()
    assert len(found) == 600
    assert (found.rms_px < 1e-6).all()
    assert (found.freedom == 3).all()
    assert (found.chi2 < 1e-6).all()
    a, b = X - rig["c0"].cam_from_rig.center, X - rig["c2"].cam_from_rig.center
    cosine = (a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    assert np.allclose(found.parallax, np.arccos(cosine), atol=1e-9)
    stacked = rig.triangulate(np.stack(list(uv.values())), sigma_px=0.2)
    assert np.array_equal(stacked.X, found.X)


def test_sigma_of_a_point_is_that_of_differences(rng):
    rig, X = exact_rig(), in_front(rng, 4)
    found = rig.triangulate(sightings(rig, X), sigma_px={"c0": 0.1, "c1": 0.2, "c2": 0.4})
    for k, x in enumerate(X):
        H = np.zeros((3, 3))
        for camera, sigma in zip(rig.cameras.values(), (0.1, 0.2, 0.4)):
            J = np.column_stack(
                [
                    np.ravel(
                        seen(camera, camera.cam_from_rig, x[None] + d)
                        - seen(camera, camera.cam_from_rig, x[None] - d)
                    )
                    / 2e-6
                    for d in 1e-6 * np.eye(3)
                ]
            )
            H += J.T @ J / sigma**2
        assert np.allclose(found.Sigma[k], np.linalg.inv(H), rtol=1e-4, atol=1e-10)
        assert np.allclose(found.sigma[k], np.sqrt(np.diag(np.linalg.inv(H))), rtol=1e-4)
    assert np.array_equal(found.Sigma, found.Sigma_noise)


def test_missing_wrong_and_bad_views(rng):
    rig, X = exact_rig(4), in_front(rng, 6)
    uv = sightings(rig, X)
    uv["c1"][0] = np.nan  # not seen
    uv["c2"][1] += 60  # wrong
    for name in ("c1", "c2", "c3"):
        uv[name][2] = np.nan  # seen by one
    uv["c0"][3, 0] = np.nan  # half a pixel
    found = rig.triangulate(uv, sigma_px=0.2)
    assert found.used[0].tolist() == [True, False, True, True]
    assert found.used[1].tolist() == [True, True, False, True]
    names = [Status(s).name for s in found.status]
    assert names[:4] == [
        "RIGCAL_OK",
        "RIGCAL_VIEWS_LEFT_OUT",
        "RIGCAL_ERR_TOO_FEW",
        "RIGCAL_ERR_NOT_FINITE",
    ]
    assert np.isnan(found.X[2:4]).all()
    assert not found.used[2:4].any()
    assert np.allclose(np.delete(found.X, [2, 3], 0), np.delete(X, [2, 3], 0), atol=1e-8)
    kept = rig.triangulate(uv, sigma_px=0.2, keep_all=True)
    assert kept.used[1].all()
    assert kept.status[1] == Status.RIGCAL_POOR_FIT
    two = rig.triangulate({"c0": uv["c0"][:1], "c3": uv["c3"][:1]}, sigma_px=0.2)
    assert two.used.tolist() == [[True, False, False, True]]
    assert rig.triangulate(uv, sigma_px=0.2, parallax_least=1.5).status[0] < 0


def test_distances(rng):
    rig, X = exact_rig(), in_front(rng, 30)
    uv = sightings(rig, X)
    found = rig.triangulate(uv, sigma_px=0.2, distances=True)
    d, sigma = found.distance(3, 7)
    assert d == pytest.approx(np.linalg.norm(X[3] - X[7]))
    along = (X[3] - X[7]) / d
    assert sigma == pytest.approx(
        np.sqrt(along @ (found.Sigma[3] + found.Sigma[7]) @ along)
    )
    again = rig.triangulate(uv, sigma_px=0.2, distances=True)
    assert found.distance(3, 7, again) == (d, sigma)
    with pytest.raises(rigcal.Error, match="other: Points are expected, not int"):
        found.distance(0, 1, 3)
    with pytest.raises(rigcal.Error, match="distances=True"):
        rig.triangulate(uv, sigma_px=0.2).distance(0, 1)
    with pytest.raises(rigcal.Error, match="another rig"):
        found.distance(0, 1, exact_rig().triangulate(uv, sigma_px=0.2, distances=True))
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_COINCIDENT"):
        found.distance(3, 3)
    uv["c0"][:] = uv["c1"][:] = np.nan
    with pytest.raises(rigcal.Error, match="point 0"):
        rig.triangulate(uv, sigma_px=0.2, distances=True).distance(0, 1)


READ = "import pickle, sys; print(*pickle.load(sys.stdin.buffer).distance(3, 7))"


def test_points_that_are_copied_measure_distances(rng, tmp_path):
    rig = exact_rig()
    uv = sightings(rig, in_front(rng, 30))
    found = rig.triangulate(uv, sigma_px=0.2, distances=True)
    expected = found.distance(3, 7)
    data, copied = pickle.dumps(found), copy.deepcopy(found)
    found._gains.view(np.uint8)[:] = 0xFF  # nobody reads the first points any more
    assert copied.distance(3, 7) == pickle.loads(data).distance(3, 7) == expected
    command = [sys.executable, "-c", READ]
    there = subprocess.run(command, input=data, capture_output=True, cwd=tmp_path)
    assert there.returncode == 0
    assert tuple(map(float, there.stdout.split())) == expected


def test_the_calibrations_error_counts(stereo, rng):
    X = rng.uniform(-0.1, 0.1, (20, 3)) + [0, 0, 0.5]
    uv = sightings(stereo, X)
    found = stereo.triangulate(uv, distances=True)
    assert (found.sigma[:, 2] > np.sqrt(found.Sigma_noise[:, 2, 2])).all()
    # The error of the calibration affects a length less than its ends.
    _, sigma = found.distance(0, 1)
    along = (X[0] - X[1]) / np.linalg.norm(X[0] - X[1])
    assert sigma < np.sqrt(along @ (found.Sigma[0] + found.Sigma[1]) @ along)


def test_triangulate_says_what_is_wrong(rng):
    rig, X = exact_rig(2), in_front(rng, 3)
    uv = sightings(rig, X)
    with pytest.raises(rigcal.Error, match="sigma_px: this rig does not know"):
        rig.triangulate(uv)
    with pytest.raises(rigcal.Error, match="'cX'"):
        rig.triangulate({"cX": uv["c0"]}, sigma_px=1)
    with pytest.raises(rigcal.Error, match=r"uv\['c1'\].*\(3, 3\)"):
        rig.triangulate({"c0": uv["c0"], "c1": X}, sigma_px=1)
    with pytest.raises(rigcal.Error, match="as many pixels"):
        rig.triangulate({"c0": uv["c0"], "c1": uv["c1"][:2]}, sigma_px=1)
    with pytest.raises(rigcal.Error, match="as many pixels"):
        rig.triangulate({}, sigma_px=1)
    with pytest.raises(rigcal.Error, match=r"uv.*\(3, 3, 2\)"):
        rig.triangulate(np.zeros((3, 3, 2)), sigma_px=1)
    with pytest.raises(rigcal.Error, match="sigma_px"):
        rig.triangulate(uv, sigma_px=[1, -1])
    with pytest.raises(rigcal.Error, match=r"sigma_px\['c1'\]"):
        rig.triangulate(uv, sigma_px={"c0": 1, "c1": "x"})
    assert len(rig.triangulate({"c0": uv["c0"][:0]}, sigma_px=1)) == 0


def test_triangulate_does_not_copy(rng, monkeypatch):
    rig = exact_rig(2)
    uv = np.ascontiguousarray(np.stack(list(sightings(rig, in_front(rng, 9)).values())))
    uv.setflags(write=False)
    seen_at, real = [], lib.batch_points

    def call(points, used, status, gains, s, where, n):
        pointers = (ctypes.c_uint64 * 2).from_address(where)
        seen_at.extend(pointers)
        return real(points, used, status, gains, s, where, n)

    monkeypatch.setattr(lib, "batch_points", call)
    rig.triangulate(uv, sigma_px=1)
    assert seen_at == [uv[0].ctypes.data, uv[1].ctypes.data]


def test_transfer_to_a_third_camera(stereo_bytes, rng):
    rig, X = exact_rig(3), in_front(rng, 5)
    uv = sightings(rig, X)
    exact = rig.transfer("c0", uv["c0"], "c1", uv["c1"], "c2", sigma_px=0.2)
    # Without a joint covariance there is no answer, and every status says so.
    assert (exact.status == Status.RIGCAL_ERR_STATE).all()
    assert np.isnan(exact.uv).all()
    held = np.array([1, 0, 0], np.uint8)
    Sigma = np.zeros(12 * 13 // 2)
    Sigma[[k * (k + 3) // 2 for k in range(12)]] = 1e-8
    rig = rigcal.CalibratedRig(
        rig.names, rig._mounted, held=held, Sigma=Sigma, sigma_px=0.2
    )
    there = rig.transfer("c0", uv["c0"], "c1", uv["c1"], "c2")
    assert not there.status.any()
    assert np.allclose(there.uv, uv["c2"], atol=1e-7)
    assert np.allclose(there.X, X, atol=1e-9)
    assert (np.linalg.eigvalsh(there.Sigma) > 0).all()
    assert (there.chi2 < 1e-9).all()
    assert there.Sigma_X.shape == (5, 3, 3)
    with pytest.raises(rigcal.Error, match="uv_a has shape"):
        rig.transfer("c0", uv["c0"][:2], "c1", uv["c1"], "c2")


# ---- lines, bands, spans ------------------------------------------------------------


def test_the_match_is_on_the_line_and_in_the_band(rng):
    rig, X = exact_rig(2), in_front(rng, 40)
    uv = sightings(rig, X)
    lines = rig.match_line("c0", uv["c0"], "c1", depth=(1, 6), n=400, sigma_px=0.3)
    assert not lines.status.any()
    assert (lines.n_places == 400).all()
    # The nearest place of the curve, by the step between places.
    gap = np.linalg.norm(lines.uv - uv["c1"][:, None], axis=2).min(1)
    step = np.linalg.norm(np.diff(lines.uv, axis=1), axis=2).max(1)
    assert (gap <= step).all()
    bands = rig.band("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3)
    tested = bands.test(uv["c1"])
    assert tested.is_inside.all()
    assert not tested.status.any()
    assert (np.abs(tested.distance_px) < 1e-6).all()
    assert np.allclose(tested.depth, np.linalg.norm(X, axis=1), rtol=1e-6)
    assert tested.index.tolist() == list(range(40))
    far = rig.band("c0", uv["c0"], "c1", depth=(4, 6), sigma_px=0.3).test(uv["c1"])
    assert not far.is_inside.any()
    assert np.isfinite(lines.half_width).all()
    assert np.allclose(np.linalg.norm(lines.across, axis=2), 1)
    assert (np.diff(lines.depth, axis=1) > 0).all()


def test_a_wider_probability_is_a_wider_band(rng):
    rig, X = exact_rig(2), in_front(rng, 2)
    uv = sightings(rig, X)
    half = rig.match_line("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3, probability=0.5)
    most = rig.match_line("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3)
    # Quantiles of a normal distribution, both sides: 0.6745 and 2.5758.
    assert np.allclose(most.half_width / half.half_width, 2.5758 / 0.6745, rtol=1e-4)


def test_one_band_tests_many_pixels(rng):
    rig, X = exact_rig(2), in_front(rng, 8)
    uv = sightings(rig, X)
    one = rig.band("c0", uv["c0"][3], "c1", sigma_px=0.3)
    assert len(one) == 1
    tested = one.test(uv["c1"])
    each = [one.test(uv["c1"][k : k + 1]).chi2[0] for k in range(8)]
    assert np.array_equal(tested.chi2, each, equal_nan=True)
    with pytest.raises(rigcal.Error, match=r"uv_b.*\(3, 2\)"):
        rig.band("c0", uv["c0"], "c1", sigma_px=0.3).test(uv["c1"][:3])


def test_search_is_the_test_of_all_pairs(rng):
    rig, X = exact_rig(2), in_front(rng, 70)
    uv = sightings(rig, X, 0.3, rng)
    candidates = np.vstack([[[np.nan, 5], [1e8, 0]], uv["c1"]])
    bands = rig.band("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3)
    found = bands.search(candidates, most=5, threads=2)
    for k in range(70):
        one = rig.band("c0", uv["c0"][k], "c1", depth=(1, 6), sigma_px=0.3)
        tested = one.test(uv["c1"])
        inside = np.flatnonzero(tested.is_inside)
        best = inside[np.argsort(tested.score[inside])][:5]
        assert found.index[k, : len(best)].tolist() == (best + 2).tolist()
        assert (found.index[k, len(best) :] == -1).all()
        assert found.n_inside[k] == len(inside)
        assert np.allclose(found.score[k, : len(best)], tested.score[best])
    assert np.isnan(found.chi2[found.index < 0]).all()
    none = bands.search(np.zeros((0, 2)))
    assert (none.index == -1).all()
    assert (none.n_inside == 0).all()


@pytest.mark.parametrize("threads", [1, 2])
def test_spans_have_every_pixel_of_the_band(rng, threads):
    rig, X = exact_rig(2), in_front(rng, 40)
    uv = sightings(rig, X)
    bands = rig.band("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3)
    spans = bands.spans(threads)
    assert not spans.status.any()
    assert len(spans) == 40
    v, u = np.mgrid[0:480:1, 0:640:3]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    for k in (0, 33, 39):
        one = rig.band("c0", uv["c0"][k], "c1", depth=(1, 6), sigma_px=0.3)
        inside = one.test(pixels).is_inside.reshape(480, -1)
        mask = spans.mask(k)
        assert mask.shape == (480, 640)
        assert mask[:, ::3][inside].all()
        # At most one more at each end of a span.
        assert mask.sum() <= 3 * inside.sum() + 4 * len(spans[k])
        rows, first, last = one.spans()[0].T
        assert np.array_equal(spans[k], np.column_stack([rows, first, last]))
    same = rig.spans("c0", uv["c0"], "c1", depth=(1, 6), sigma_px=0.3)
    assert np.array_equal(same.begin, spans.begin)
    assert np.array_equal(same.first, spans.first)


def test_spans_of_wide_bands_find_room(rng):
    """A band over all rows, several times: more spans than the first guess has room for."""
    cams = [
        rigcal.Camera(
            300,
            300,
            320,
            240,
            size=(640, 480),
            name=f"v{k}",
            cam_from_rig=rigcal.Transform(np.eye(3), [0, -0.5 * k, 0], f"v{k}", "rig"),
        )
        for k in range(2)
    ]
    rig = rigcal.CalibratedRig.from_cameras(cams)
    uv = rng.uniform([0, 0], [640, 480], (32, 2))
    spans = rig.spans("v0", uv, "v1", sigma_px=1.0, threads=1)
    alone = [rig.spans("v0", uv[k], "v1", sigma_px=1.0)[0] for k in range(32)]
    assert sum(map(len, alone)) > 4 * 480 + 64
    for k in range(32):
        assert np.array_equal(spans[k], alone[k])


def test_bands_that_are_none():
    rig = exact_rig(2)
    uv = np.array([[320.0, 240], [np.nan, 0], [1e8, 0]])
    bands = rig.band("c0", uv, "c1", sigma_px=0.3)
    names = [Status(s).name for s in bands.status]
    assert names == ["RIGCAL_OK", "RIGCAL_ERR_NOT_FINITE", "RIGCAL_ERR_NO_RAY"]
    assert bands.curve(4).status.tolist() == bands.status.tolist()
    assert bands.curve(4).n_places.tolist()[1:] == [0, 0]
    assert np.isnan(bands.curve(4).uv[1:]).all()
    assert bands.search(uv[:1]).status.tolist() == bands.status.tolist()
    spans = bands.spans()
    assert spans.status.tolist() == bands.status.tolist()
    assert len(spans[1]) == 0
    assert not spans.mask(2).any()
    empty = rig.spans("c0", np.zeros((0, 2)), "c1", sigma_px=0.3)
    assert len(empty) == 0
    assert empty.begin.tolist() == [0]


def test_band_says_what_is_wrong():
    rig = exact_rig(2)
    uv = [[320.0, 240]]
    for options, what in (
        ({"depth": (2, 1)}, "depth"),
        ({"depth": 3}, "depth"),
        ({"depth": (-1, 1)}, "depth"),
        ({"probability": 2}, "probability"),
        ({}, "sigma_px"),
    ):
        with pytest.raises(rigcal.Error, match=what):
            rig.band("c0", uv, "c1", **{"sigma_px": 0.3, **options} if options else {})
    with pytest.raises(rigcal.Error, match="one camera"):
        rig.band("c0", uv, 0, sigma_px=1)
    sizeless = [dataclasses.replace(c, size=None) for c in rig.cameras.values()]
    without = rigcal.CalibratedRig.from_cameras(sizeless)
    assert without["c1"].size is None
    with pytest.raises(rigcal.Error, match="size"):
        without.spans("c0", uv, "c1", sigma_px=1)


def test_noise_of_the_rig_and_of_its_cameras(stereo):
    uv = [[320.0, 240]]
    assert np.allclose(stereo.noise_px(), stereo.sigma_px)
    known = stereo.match_line("left", uv, "right")
    # sigma_px of a stored rig contains sqrt(F). Noise that the caller states does not.
    stated = stereo.sigma_px / np.sqrt(stereo.F)
    again = stereo.match_line("left", uv, "right", sigma_px=stated)
    assert np.allclose(known.half_width, again.half_width, equal_nan=True)
    stereo.noise = np.full(2, stated)
    again = stereo.match_line("left", uv, "right")
    assert np.allclose(known.half_width, again.half_width, equal_nan=True)
    assert np.allclose(stereo.noise_px(), stated)


# ---- the rig itself -----------------------------------------------------------------


def test_stored_bytes_come_back(stereo, stereo_bytes):
    assert stereo.to_bytes() == stereo_bytes
    assert stereo.sequence == 1
    assert rigcal.CalibratedRig.from_bytes(stereo_bytes).names == ["cam0", "cam1"]
    rig = exact_rig(3)
    back = rigcal.CalibratedRig.from_bytes(rig.to_bytes(), rig.names)
    assert back.to_bytes() == rig.to_bytes()
    for name in rig.names:
        assert back[name] == rig[name]
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_DAMAGED"):
        rigcal.CalibratedRig.from_bytes(stereo_bytes[:-1])
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_FOREIGN"):
        rigcal.CalibratedRig.from_bytes(b"nothing of ours, but as long as a header is")
    with pytest.raises(rigcal.Error, match="names"):
        rigcal.CalibratedRig.from_bytes(stereo_bytes, ["left"])


def test_pairs_and_covariances(stereo):
    pair = stereo.pair("left", "right")
    right, left = stereo["right"].cam_from_rig, stereo["left"].cam_from_rig
    direct = right @ left.inv()
    assert np.allclose(pair.transform.R, direct.R)
    assert np.allclose(pair.transform.t, direct.t)
    assert (pair.transform.to, pair.transform.frm) == ("right", "left")
    assert np.allclose(pair.covariance, stereo.covariance("right"))  # left is held
    assert not stereo.covariance("left").any()
    assert not stereo.covariance("left", "right").any()
    assert stereo.held.tolist() == [True, False]
    assert stereo.group.tolist() == [0, 0]
    rig = exact_rig(2)
    assert rig.pair(0, 1).covariance is None
    with pytest.raises(rigcal.Error, match="covariance"):
        rig.covariance(0)
    apart = rigcal.CalibratedRig(rig.names, rig._mounted, group=[0, 1])
    with pytest.raises(rigcal.Error, match="RIGCAL_DISCONNECTED"):
        apart.pair(0, 1)


def test_own_covariances_of_stored_cameras(rng):
    rig = exact_rig(2)
    A = rng.normal(size=(6, 6)) * 1e-3
    rig._mounted["Sigma"][1], rig._mounted["has_Sigma"][1] = (A @ A.T).ravel(), 1
    back = rigcal.CalibratedRig.from_bytes(rig.to_bytes())
    assert np.allclose(back.covariance(1), A @ A.T, rtol=1e-12)


def test_rigs_that_are_none():
    rig = exact_rig(2)
    with pytest.raises(rigcal.Error, match=r"there is no camera 'x'.*c0, c1"):
        rig["x"]
    with pytest.raises(rigcal.Error, match="camera"):
        rig[2]
    with pytest.raises(rigcal.Error, match="cam_from_rig"):
        rigcal.CalibratedRig.from_cameras({"a": rigcal.Camera(1, 1, 0, 0)})
    with pytest.raises(rigcal.Error, match="names"):
        rigcal.CalibratedRig(["a", "a"], rig._mounted)
    with pytest.raises(rigcal.Error, match="mounted"):
        rigcal.CalibratedRig(["a", "b"], np.zeros(2))
    with pytest.raises(rigcal.Error, match="Sigma"):
        rigcal.CalibratedRig(["a", "b"], rig._mounted, Sigma=[1, 2], sigma_px=1)
    assert len(rig) == 2


def test_lenses_keep_their_coefficients(fisheye):
    pose = rigcal.Transform.identity("f", "rig")
    cams = {
        "f": dataclasses.replace(fisheye, name="f", cam_from_rig=pose),
        "r": rigcal.Camera(
            500,
            500,
            320,
            240,
            size=(640, 480),
            dist=(0.1, 0.2, 0, 0, 0, 0, 0, 0.3),
            name="r",
            cam_from_rig=rigcal.Transform.identity("r"),
        ),
        "p": rigcal.Camera(
            500,
            500,
            9,
            9,
            size=(20, 20),
            name="p",
            cam_from_rig=rigcal.Transform.identity("p"),
        ),
    }
    rig = rigcal.CalibratedRig.from_cameras(cams)
    assert rig.cameras == cams
