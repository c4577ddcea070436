"""Poses, compared with the truth of simulated scenes, and one view with many."""

from __future__ import annotations

import ctypes
import dataclasses
import gc
import threading
import warnings

import numpy as np
import pytest
from conftest import angle, numpy_project, seen, transforms

import rigcal
from rigcal import Status
from rigcal._layout import VIEWS
from rigcal._library import lib


def test_exact_pixels_give_the_true_pose(camera, target, truth):
    pose = rigcal.solve_pose(camera, target, seen(camera, truth, target))
    assert angle(pose.cam_from_world.R, truth.R) < 1e-9
    assert np.allclose(pose.cam_from_world.t, truth.t, atol=1e-9)
    assert pose.status == Status.RIGCAL_OK
    assert (pose.warnings, pose.others, pose.inliers, pose.bad) == ([], [], None, None)
    assert pose.rms_px < 1e-7
    assert pose.sse < 1e-12
    assert pose.probability == pytest.approx(1)
    assert (pose.cam_from_world.to, pose.cam_from_world.frm) == ("left", "world")
    assert "left_from_world" in repr(pose)


def test_a_fisheye(fisheye, target, truth):
    pose = rigcal.solve_pose(fisheye, target, seen(fisheye, truth, target))
    assert angle(pose.cam_from_world.R, truth.R) < 1e-8
    assert pose.cam_from_world.to == "cam"


def test_a_camera_without_size_solves_alike(camera, target, truth):
    uv = seen(camera, truth, target)
    sizeless = dataclasses.replace(camera, size=None)
    assert np.array_equal(
        rigcal.solve_pose(sizeless, target, uv).cam_from_world.R,
        rigcal.solve_pose(camera, target, uv).cam_from_world.R,
    )


def jacobian(camera, T, X):
    """Central differences of all pixels by (w, dt)."""
    columns = []
    for k in range(6):
        ends = []
        for step in (1e-6, -1e-6):
            d = np.zeros(6)
            d[k] = step
            turn = rigcal.Transform.from_rvec(d[:3], np.zeros(3))
            ends.append(numpy_project(camera, X @ (turn.R @ T.R).T + T.t + d[3:]).ravel())
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.column_stack(columns)


def test_covariance_is_that_of_differences(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.3, rng)
    pose = rigcal.solve_pose(camera, target, uv, sigma_px=0.3)
    J = jacobian(camera, pose.cam_from_world, target)
    Sigma = 0.09 * np.linalg.inv(J.T @ J)
    assert np.allclose(pose.covariance, Sigma, rtol=1e-5, atol=1e-6 * Sigma.max())
    assert np.allclose(pose.sigma_rotation, np.sqrt(np.diag(Sigma))[:3], rtol=1e-5)
    assert np.allclose(pose.sigma_translation, np.sqrt(np.diag(Sigma))[3:], rtol=1e-5)
    assert pose.sigma_px == 0.3
    # The centre is -R^T t: by w it moves by R^T [t]x, by dt by -R^T.
    R, t = pose.cam_from_world.R, pose.cam_from_world.t
    cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])
    by = np.hstack([-R.T @ cross, -R.T])
    assert np.allclose(pose.sigma_center, np.sqrt(np.diag(by @ Sigma @ by.T)), rtol=1e-5)


def test_sigma_weighs_the_points(camera, target, truth, rng):
    uv = seen(camera, truth, target)
    uv[3] += 1
    sigma = np.ones(len(uv))
    sigma[3] = 1e6
    pose = rigcal.solve_pose(camera, target, uv, sigma=sigma)
    assert angle(pose.cam_from_world.R, truth.R) < 1e-6


def test_a_start_leads_to_the_pose_near_it(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.2, rng)
    free = rigcal.solve_pose(camera, target, uv)
    near = rigcal.solve_pose(camera, target, uv, start=truth, sigma_px=0.2)
    assert angle(free.cam_from_world.R, near.cam_from_world.R) < 1e-6


def test_a_start_decides_between_two_poses(camera, rng):
    corners = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * 0.05
    truth = rigcal.Transform.from_rvec([0.4, 0.2, 0.1], [0.05, -0.02, 5], "left", "world")
    uv = seen(camera, truth, corners, 0.2, rng)
    with pytest.warns(rigcal.Caveat, match="RIGCAL_AMBIGUOUS"):
        free = rigcal.solve_pose(camera, corners, uv, sigma_px=0.5)
    (other,) = free.others
    assert angle(free.cam_from_world.R, other.cam_from_world.R) > 0.1
    for pose in (free, other):
        start = pose.cam_from_world
        near = rigcal.solve_pose(camera, corners, uv, start=start, sigma_px=0.5)
        assert angle(near.cam_from_world.R, start.R) < 1e-6
        assert not near.others


def test_robust_leaves_out_wrong_points(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.2, rng)
    uv[[2, 7]] += 30
    pose = rigcal.solve_pose(
        camera, target, uv, robust=True, threshold_px=2, samples=99, seed=3, max_units=5000
    )
    assert np.flatnonzero(~pose.inliers).tolist() == [2, 7]
    clean = np.delete(np.arange(12), [2, 7])
    alone = rigcal.solve_pose(camera, target[clean], uv[clean])
    assert np.allclose(pose.cam_from_world.R, alone.cam_from_world.R, atol=1e-9)
    assert np.allclose(pose.covariance, alone.covariance, rtol=1e-6)


def test_robust_covariance_has_the_sigmas_of_the_inliers(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.2, rng)
    uv[0] += 30
    sigma = np.linspace(0.5, 2, 12)
    pose = rigcal.solve_pose(
        camera, target, uv, sigma=sigma, sigma_px=0.2, robust=True, threshold_px=3
    )
    assert not pose.inliers[0]
    J = jacobian(camera, pose.cam_from_world, target)
    keep = np.repeat(pose.inliers, 2)
    W = 1 / (0.2 * np.repeat(sigma, 2)[keep]) ** 2
    Sigma = np.linalg.inv(J[keep].T @ (W[:, None] * J[keep]))
    assert np.allclose(pose.covariance, Sigma, rtol=1e-4, atol=1e-6 * Sigma.max())


FLAT = np.array([[x, y, 0.0] for x in (-0.05, 0.05) for y in (-0.05, 0.05)])


def ambiguous(camera, rng):
    """A small flat target far away, which has a second pose."""
    T = rigcal.Transform.from_rvec([0.15, 0.1, 0], [0, 0, 2.5], "left", "world")
    return seen(camera, T, FLAT, 0.5, rng)


def test_an_ambiguous_pose_warns_and_has_others(camera, rng):
    uv = ambiguous(camera, rng)
    with pytest.warns(rigcal.Caveat, match="RIGCAL_AMBIGUOUS"):
        pose = rigcal.solve_pose(camera, FLAT, uv, sigma_px=0.5)
    assert pose.warnings == ["RIGCAL_AMBIGUOUS"]
    assert len(pose.others) == 1
    total = pose.probability + sum(other.probability for other in pose.others)
    assert total == pytest.approx(1)
    with pytest.raises(rigcal.Error, match="not known"):
        _ = pose.others[0].covariance


def test_failures_name_status_argument_and_shape(camera, target, truth):
    uv = seen(camera, truth, target)
    bad = uv.copy()
    bad[4, 1] = np.nan
    with pytest.raises(rigcal.Error, match=r"uv: .*\(12, 2\)") as caught:
        rigcal.solve_pose(camera, target, bad)
    assert caught.value.name == "RIGCAL_ERR_NOT_FINITE"
    assert caught.value.bad == 4
    with pytest.raises(rigcal.Error, match=r"X \(2, 3\)") as caught:
        rigcal.solve_pose(camera, target[:2], uv[:2])
    assert caught.value.name == "RIGCAL_ERR_TOO_FEW"
    line = np.outer(np.arange(5.0), [1, 0, 0])
    with pytest.raises(rigcal.Error) as caught:
        rigcal.solve_pose(camera, line, seen(camera, truth, line * 0.1))
    assert caught.value.name == "RIGCAL_ERR_COLLINEAR"


def test_options_that_do_not_go_together(camera, target, truth):
    uv = seen(camera, truth, target)
    with pytest.raises(rigcal.Error, match="start"):
        rigcal.solve_pose(camera, target, uv, robust=True, start=truth)
    with pytest.raises(rigcal.Error, match="robust=True"):
        rigcal.solve_pose(camera, target, uv, seed=2)
    for name, value in (("sigma_px", 0), ("sigma_px", "x"), ("start", 3)):
        with pytest.raises(rigcal.Error, match=name):
            rigcal.solve_pose(camera, target, uv, **{name: value})
    wrong = {"samples": 0, "max_units": 0, "seed": -1, "threshold_px": np.nan}
    for name, value in wrong.items():
        with pytest.raises(rigcal.Error, match=name):
            rigcal.solve_pose(camera, target, uv, robust=True, **{name: value})


# ---- many ----------------------------------------------------------------------


def views(camera, target, rng, count, noise=0.3):
    uv = [seen(camera, T, target, noise, rng) for T in transforms(rng, count)]
    return np.stack(uv)


def same(pose, poses, k):
    """Bit for bit."""
    return (
        np.array_equal(pose.cam_from_world.R, poses.R[k])
        and np.array_equal(pose.cam_from_world.t, poses.t[k])
        and pose.status == poses.status[k]
        and pose.rms_px == poses.rms_px[k]
        and pose.sse == poses.sse[k]
        and pose.probability == poses.probability[k]
    )


@pytest.mark.parametrize("threads", [1, 2, None])
def test_a_batch_is_the_poses_one_by_one(camera, target, rng, threads):
    uv = views(camera, target, rng, 600)
    poses = rigcal.solve_poses(camera, target, uv, threads=threads)
    assert len(poses) == 600
    assert not poses.status.any()
    for k in range(0, 600, 37):
        assert same(rigcal.solve_pose(camera, target, uv[k]), poses, k)
        assert same(poses[k], poses, k)


def test_all_forms_of_a_batch_agree(camera, target, rng):
    uv = views(camera, target, rng, 5)
    X = np.broadcast_to(target, (5, 12, 3))
    one = rigcal.solve_poses(camera, target, uv)
    forms = {
        "dense": rigcal.solve_poses(camera, X, uv),
        "lists": rigcal.solve_poses(camera, list(X), list(uv)),
        "one target": rigcal.solve_poses(camera, target, list(uv)),
        "offsets": rigcal.solve_poses(
            camera, X.reshape(-1, 3), uv.reshape(-1, 2), n=[12] * 5
        ),
        "offsets of one": rigcal.solve_poses(camera, target, uv.reshape(-1, 2), n=[12] * 5),
        "cameras": rigcal.solve_poses([camera], target, uv, camera_of=np.zeros(5, int)),
        "strides": rigcal.solve_poses(camera, target, np.asfortranarray(uv)),
        "sigma": rigcal.solve_poses(camera, target, uv, sigma=np.ones((5, 12))),
    }
    for name, poses in forms.items():
        assert np.array_equal(poses.R, one.R), name
        assert np.array_equal(poses.t, one.t), name


def test_ragged_views(camera, rng):
    targets = [rng.uniform(-0.3, 0.3, (n, 3)) for n in (5, 30, 9)]
    cameras = [camera, dataclasses.replace(camera, fx=700, name="right")]
    of = [0, 1, 0]
    truths = list(transforms(rng, 3))
    uv = [seen(cameras[c], T, X) for c, T, X in zip(of, truths, targets)]
    sigma = np.concatenate([np.ones(len(X)) for X in targets])
    poses = rigcal.solve_poses(
        cameras, targets, uv, camera_of=of, sigma=sigma, covariance=True
    )
    for k, T in enumerate(truths):
        assert angle(poses.R[k], T.R) < 1e-8
    assert [poses[k].cam_from_world.to for k in range(3)] == ["left", "right", "left"]
    single = rigcal.solve_pose(cameras[1], targets[1], uv[1])
    assert np.array_equal(single.covariance, poses.covariance[1])
    assert np.array_equal(single.covariance, poses[1].covariance)
    assert np.array_equal(poses.sigma_rotation[1], single.sigma_rotation)
    assert np.array_equal(poses.sigma_center[1], single.sigma_center)


def test_cameras_of_a_long_batch(camera, target, rng):
    """More views than a slice has."""
    cameras = [camera, dataclasses.replace(camera, fx=700, cy=250)]
    of = np.arange(600) // 7 % 2
    truths = list(transforms(rng, 600))
    uv = np.stack([seen(cameras[c], T, target) for c, T in zip(of, truths)])
    poses = rigcal.solve_poses(cameras, target, uv, camera_of=of)
    assert max(angle(R, T.R) for R, T in zip(poses.R, truths)) < 1e-7


def test_a_bad_view_does_not_stop_the_others(camera, target, rng):
    uv = views(camera, target, rng, 6)
    uv[2, 5, 0] = np.inf
    uv[4] = uv[4, 0]  # one pixel
    poses = rigcal.solve_poses(camera, target, uv, covariance=True, most=2)
    assert poses.names[2] == "RIGCAL_ERR_NOT_FINITE"
    assert poses.bad[2] == 5
    assert np.isnan(poses.R[2]).all()
    assert np.isnan(poses.t[2]).all()
    assert np.isnan(poses.covariance[2]).all()
    assert poses.n_found[2] == 0
    assert poses.status[4] != 0
    assert not poses.status[[0, 1, 3, 5]].any()
    with pytest.raises(rigcal.Error, match="view 2") as caught:
        poses[2]
    assert caught.value.bad == 5
    assert poses[-1].status == 0
    with pytest.raises(IndexError):
        poses[6]


def test_a_batch_of_robust_poses(camera, target, rng):
    uv = views(camera, target, rng, 4, 0.2)
    uv[1, 3] += 50
    uv[3, [0, 8]] -= 40
    poses = rigcal.solve_poses(
        camera, target, uv, robust=True, threshold_px=2, covariance=True
    )
    assert np.argwhere(~poses.inliers).tolist() == [[1, 3], [3, 0], [3, 8]]
    single = rigcal.solve_pose(camera, target, uv[3], robust=True, threshold_px=2)
    assert same(single, poses, 3)
    assert np.array_equal(single.inliers, poses[3].inliers)
    assert np.array_equal(single.covariance, poses.covariance[3])
    uv[0] = rng.uniform(0, 400, (12, 2))
    poses = rigcal.solve_poses(camera, target, uv, robust=True, threshold_px=2)
    assert poses.names[0] == "RIGCAL_ERR_NO_CONSENSUS"
    assert not poses.inliers[0].any()


def test_most_keeps_the_other_poses(camera, rng):
    uv = np.stack([ambiguous(camera, rng) for _ in range(3)])
    one = rigcal.solve_poses(camera, FLAT, uv, sigma_px=0.5)
    two = rigcal.solve_poses(camera, FLAT, uv, sigma_px=0.5, most=4)
    assert np.array_equal(one.R, two.R)
    assert two.n_found.tolist() == [2, 2, 2]
    assert len(two[0].others) == 1
    assert len(one[0].others) == 0
    with pytest.raises(rigcal.Error, match="covariance=True"):
        _ = one.covariance


def test_no_view_at_all(camera, target):
    assert len(rigcal.solve_poses(camera, target, np.zeros((0, 12, 2)))) == 0
    assert len(rigcal.solve_poses(camera, target, [])) == 0
    empty = (
        rigcal.solve_poses(camera, target, np.zeros((3, 0, 2)), covariance=True)
        if False
        else None
    )
    assert empty is None


def test_views_without_a_point_fail_by_themselves(camera, target, truth):
    uv = seen(camera, truth, target)
    poses = rigcal.solve_poses(camera, [target, target[:0]], [uv, uv[:0]])
    assert poses.names == ["RIGCAL_OK", "RIGCAL_ERR_TOO_FEW"]


# ---- memory ----------------------------------------------------------------------


def spied(monkeypatch, name):
    """Records the fields of struct rigcal_batch_views at each call of a function of
    batch.h."""
    calls, real = [], getattr(lib, name)

    def call(solved, work, views, n, options):
        fields = (ctypes.c_char * VIEWS.itemsize).from_address(views)
        calls.append((np.frombuffer(bytes(fields), VIEWS)[0], n))
        return real(solved, work, views, n, options)

    monkeypatch.setattr(lib, name, call)
    return calls


def test_contiguous_arrays_are_not_copied(camera, target, rng, monkeypatch):
    uv = views(camera, target, rng, 300)
    calls = spied(monkeypatch, "batch_poses")
    sigma = np.ones((300, 12))
    for array in (uv, target, sigma):
        array.setflags(write=False)
    rigcal.solve_poses(camera, target, uv, sigma=sigma, threads=1)
    rigcal.solve_pose(camera, target, uv[7], sigma=sigma[7])
    assert [n for _, n in calls] == [256, 44, 1]
    for fields, n in calls:
        pixels, factors = (uv[7], sigma[7]) if n == 1 else (uv, sigma)
        assert fields["X"] == target.ctypes.data
        assert fields["uv"] == pixels.ctypes.data
        assert fields["sigma"] == factors.ctypes.data


def test_arrays_may_be_freed_in_any_order(camera, rng):
    X = rng.uniform(-0.3, 0.3, (12, 3))
    T = next(transforms(rng, 1))
    poses = rigcal.solve_poses(camera, X, np.stack([seen(camera, T, X)] * 3), most=2)
    one = rigcal.solve_pose(camera, X, seen(camera, T, X))
    R, pose = poses.R, poses[1]
    expected = R.copy()
    del X, poses
    gc.collect()
    for _ in range(20):
        np.full(10000, np.nan)
    assert np.array_equal(R, expected)
    assert np.array_equal(pose.cam_from_world.R, expected[1])
    del pose, R
    gc.collect()
    assert np.array_equal(one.cam_from_world.R, expected[0])


def test_one_pose_does_not_change_with_the_next(camera, target, rng):
    first = rigcal.solve_pose(
        camera, target, seen(camera, next(transforms(rng, 1)), target)
    )
    kept = first.rms_px, first.covariance.copy()
    big = rng.uniform(-0.3, 0.3, (500, 3))
    rigcal.solve_pose(camera, big, seen(camera, next(transforms(rng, 1)), big))
    assert first.rms_px == kept[0]
    assert np.array_equal(first.covariance, kept[1])


def test_threads_of_the_caller(camera, target, rng):
    uv = views(camera, target, rng, 40)
    expected = rigcal.solve_poses(camera, target, uv).R
    wrong = []

    def work(a):
        for k in range(a, 40, 4):
            pose = rigcal.solve_pose(camera, target, uv[k])
            if not np.array_equal(pose.cam_from_world.R, expected[k]):
                wrong.append(k)

    workers = [threading.Thread(target=work, args=(a,)) for a in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert wrong == []


def test_an_exception_in_a_slice_comes_out(camera, target, rng, monkeypatch):
    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(lib, "batch_poses", fail)
    uv = np.zeros((2000, 12, 2))
    for threads in (1, 2):
        with pytest.raises(KeyboardInterrupt):
            rigcal.solve_poses(camera, target, uv, threads=threads)


# ---- tags, blame, diagnosis -----------------------------------------------------------

CORNERS = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * 0.05


def test_tags(camera, rng):
    flip = rigcal.Transform.from_rvec(
        [np.pi * 0.9, 0.3, 0.1], [0.05, 0, 0.8], "left", "tag"
    )
    uv = seen(camera, flip, CORNERS)
    pose = rigcal.solve_tag(camera, uv, 0.1)
    assert angle(pose.cam_from_world.R, flip.R) < 1e-6
    assert pose.cam_from_world.frm == "tag"
    tags = rigcal.solve_tags(camera, np.stack([uv, uv[::-1], uv]), 0.1)
    assert tags.names[1] == "RIGCAL_ERR_MIRRORED"
    assert np.array_equal(tags.R[2], pose.cam_from_world.R)
    assert np.array_equal(tags[0].covariance, pose.covariance)
    with pytest.raises(rigcal.Error, match="corners") as caught:
        rigcal.solve_tag(camera, uv[::-1], 0.1)
    assert caught.value.name == "RIGCAL_ERR_MIRRORED"
    with pytest.raises(rigcal.Error, match="size"):
        rigcal.solve_tag(camera, uv, -1)
    with pytest.raises(rigcal.Error, match="camera"):
        rigcal.solve_tags("left", uv[None], 0.1)


def test_tag_covariance_is_that_of_its_corners(camera):
    flip = rigcal.Transform.from_rvec([np.pi * 0.9, 0.3, 0.1], [0.05, 0, 0.8])
    uv = seen(camera, flip, CORNERS)
    tag = rigcal.solve_tag(camera, uv, 0.1, sigma_px=0.2)
    J = jacobian(camera, tag.cam_from_world, CORNERS)
    assert np.allclose(tag.covariance, 0.04 * np.linalg.inv(J.T @ J), rtol=1e-4)
    uv[0] += 0.3
    tag = rigcal.solve_tag(camera, uv, 0.1)
    assert tag.sigma_px == pytest.approx(
        np.sqrt(tag.sse / 2)
    )  # of 8 numbers and 6 unknowns


def test_blame_finds_the_wrong_point(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.2, rng)
    uv[6] += [9, -7]
    found = rigcal.blame(camera, target, uv, sigma_px=0.2)
    assert found.verdict == rigcal.BlameVerdicts.RIGCAL_BLAME_SURE
    assert found.point == 6
    assert found.rms_without[6] == pytest.approx(found.rms_without_px)
    assert found.rms_without[6] == np.nanmin(found.rms_without)
    assert found.rms_px > 1 > found.rms_without_px
    assert not found.is_rest_poor
    assert found.probability > 0.99


def test_diagnose_finds_mirrored_coordinates_and_units(camera, target, truth, rng):
    uv = seen(camera, truth, target, 0.1, rng)
    mirrored = rigcal.diagnose(camera, target * [1, 1, -1], uv)
    assert mirrored.verdict == rigcal.DiagnosisVerdicts.RIGCAL_DIAGNOSIS_MIRRORED
    assert mirrored.rms_mirrored_px < 0.3
    assert mirrored.is_handed
    fine = rigcal.diagnose(camera, target, uv, sigma=np.ones(12), sigma_px=0.1)
    assert fine.verdict == rigcal.DiagnosisVerdicts.RIGCAL_DIAGNOSIS_CONSISTENT
    assert fine.units is None
    scaled = rigcal.diagnose(camera, target * 1000, uv, start=truth)
    assert scaled.verdict == rigcal.DiagnosisVerdicts.RIGCAL_DIAGNOSIS_UNITS
    assert scaled.units == 1000


def test_diagnose_needs_a_size_and_a_camera(camera, target, truth):
    uv = seen(camera, truth, target)
    with pytest.raises(rigcal.Error, match="size"):
        rigcal.diagnose(dataclasses.replace(camera, size=None), target, uv)
    with pytest.raises(rigcal.Error, match="camera"):
        rigcal.blame(None, target, uv)
    with pytest.raises(rigcal.Error, match=r"\(3, 3\)") as caught:
        rigcal.blame(camera, target[:3], uv[:3])
    assert caught.value.name == "RIGCAL_ERR_TOO_FEW"


def test_no_caveat_no_warning(camera, target, truth):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rigcal.solve_pose(camera, target, seen(camera, truth, target))
