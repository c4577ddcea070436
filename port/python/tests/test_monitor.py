"""A monitor that watches a rig of known truth."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from conftest import angle, exact_rig, seen

import rigcal
from rigcal import Status


@pytest.fixture
def rig():
    """Three cameras: the first is held, the others are known to 1e-4 rad and length."""
    bare = exact_rig(3)
    Sigma = np.zeros(12 * 13 // 2)
    Sigma[[k * (k + 3) // 2 for k in range(12)]] = 1e-8
    return rigcal.CalibratedRig(
        bare.names, bare._mounted, held=[1, 0, 0], Sigma=Sigma, sigma_px=0.2
    )


def watch(monitor, cameras, rng, frames):
    """Runs frames of 30 points. Returns the last report."""
    names = list(cameras)
    for _ in range(frames):
        X = rng.uniform(-0.6, 0.6, (30, 3)) + [0, 0, 2.5]
        uv = {n: seen(c, c.cam_from_rig, X, 0.2, rng) for n, c in cameras.items()}
        for a, b in ((0, 1), (1, 2), (0, 2)):
            status = monitor.add_matches(names[a], uv[names[a]], names[b], uv[names[b]])
            assert not status.any()
        report = monitor.end_frame(1 / 30)
        if report.alarm:
            return report
    return report


def bumped(rig, name, rad):
    cameras = rig.cameras
    c = cameras[name]
    turn = rigcal.Transform.from_rvec([rad, 0, 0], [0, 0, 0], name, name)
    cameras[name] = rigcal.Camera(
        c.fx,
        c.fy,
        c.cx,
        c.cy,
        size=c.size,
        dist=c.dist,
        name=name,
        cam_from_rig=turn @ c.cam_from_rig,
    )
    return cameras


def test_a_bumped_camera_is_named_and_solved(rig, rng):
    monitor = rig.monitor(common=0.0)
    quiet = watch(monitor, rig.cameras, rng, 60)
    assert not quiet.alarm
    assert quiet.frames == 60
    assert quiet.rows == 60 * 90
    assert quiet.n_blind == 0
    assert quiet.noise == pytest.approx(1, abs=0.1)
    assert monitor.report() == quiet
    now = bumped(rig, "c1", np.radians(0.5))
    report = watch(monitor, now, rng, 60)
    assert report.alarm
    assert report.body == "c1"
    for _ in range(5):
        watch(monitor, now, rng, 1)
    assert monitor.report().confidence > 0.9
    assert monitor.body("c1").blame > 0.9
    assert monitor.body(0).blame < 0.1
    monitor.moved("c1")
    assert not monitor.report().alarm
    watch(monitor, now, rng, 30)
    found = monitor.rig()["c1"].cam_from_rig
    assert angle(found.R, now["c1"].cam_from_rig.R) < np.radians(0.05)
    pair = monitor.pair("c0", "c1")
    direct = found @ rig["c0"].cam_from_rig.inv()
    assert np.allclose(pair.transform.R, direct.R, atol=1e-12)
    assert pair.covariance.shape == (6, 6)
    back = rigcal.CalibratedRig.from_bytes(monitor.rig().to_bytes(), rig.names)
    assert np.allclose(back["c1"].cam_from_rig.R, found.R)
    assert back.held.tolist() == [True, False, False]


def test_dismiss_ends_an_alarm(rig, rng):
    monitor = rig.monitor(common=0.0)
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_STATE"):
        monitor.dismiss()
    watch(monitor, rig.cameras, rng, 10)
    assert watch(monitor, bumped(rig, "c2", 0.01), rng, 60).alarm
    monitor.dismiss()
    assert not monitor.report().alarm


def test_targets(rig, rng):
    monitor = rig.monitor(targets=1)
    X = rng.uniform(-0.3, 0.3, (10, 3))
    place = rigcal.Transform.from_rvec([0.2, 0.1, 0], [0, 0, 2.5], "rig", "target0")
    for name, camera in rig.cameras.items():
        uv = seen(camera, camera.cam_from_rig @ place, X, 0.2, rng)
        assert monitor.add_view(name, X, uv) == Status.RIGCAL_OK
    monitor.end_frame()
    pair = monitor.pair("target0", "c0")
    direct = rig["c0"].cam_from_rig @ place
    assert angle(pair.transform.R, direct.R) < 0.01
    assert not monitor.body("target0").is_blind
    monitor.lift(0)
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_RANGE"):
        monitor.pair("target0", "c0")
    with pytest.raises(rigcal.Error, match=r"X \(10, 3\).*") as caught:
        monitor.add_view("c0", X, np.full((10, 2), np.inf))
    assert caught.value.name == "RIGCAL_ERR_NOT_FINITE"


def test_bad_matches_have_a_status_and_change_nothing(rig, rng):
    monitor = rig.monitor()
    status = monitor.add_matches("c0", [[np.nan, 0], [1e8, 0]], "c1", [[1.0, 1], [1, 1]])
    assert [Status(s).name for s in status] == [
        "RIGCAL_ERR_NOT_FINITE",
        "RIGCAL_ERR_NO_RAY",
    ]
    assert monitor.end_frame().rows == 0
    assert (monitor.add_matches("c0", [[5.0, 5]], "c0", [[5.0, 5]]) < 0).all()


def test_a_monitor_can_be_pickled(rig, rng):
    monitor = rig.monitor()
    watch(monitor, rig.cameras, rng, 3)
    again = pickle.loads(pickle.dumps(monitor))
    assert again.report() == monitor.report()
    a, b = np.random.default_rng(5), np.random.default_rng(5)
    assert watch(monitor, rig.cameras, a, 3) == watch(again, rig.cameras, b, 3)


def test_what_cannot_be_watched(rig):
    with pytest.raises(rigcal.Error, match="RIGCAL_ERR_STATE"):
        exact_rig(2).monitor()
    with pytest.raises(rigcal.Error, match="rig"):
        rigcal.Monitor("rig")
    for options in ({"walk": 1}, {"arl0_frames": 1}, {"targets": 17}, {"wrong": np.nan}):
        with pytest.raises(rigcal.Error):
            rig.monitor(**options)
    monitor = rig.monitor()
    with pytest.raises(rigcal.Error, match="'x'"):
        monitor.body("x")
    with pytest.raises(rigcal.Error, match="uv_a has shape"):
        monitor.add_matches("c0", np.zeros((2, 2)), "c1", np.zeros((3, 2)))
    with pytest.raises(rigcal.Error, match="X has shape"):
        monitor.add_view("c0", np.zeros((2, 3)), np.zeros((3, 2)))
    with pytest.raises(rigcal.Error, match="seconds"):
        monitor.end_frame(-1)
    with pytest.raises(rigcal.Error, match="sigma_px"):
        monitor.add_matches("c0", [[1, 1]], "c1", [[1, 1]], sigma_px=0)
