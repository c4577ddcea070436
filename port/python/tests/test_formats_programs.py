"""The programs that formats belong to read our files, and project points alike.

OpenCV is needed for these tests. aniposelib, pycolmap and mrcal are used where they are."""

import numpy as np
import pytest
from format_samples import BROWN, BROWN4, FISHEYE, RATIONAL, SAMPLES, truth
from lens import points, project

from rigcal import load_cameras, load_target, save_cameras

cv2 = pytest.importorskip("cv2")

PIXEL = 1e-9
X = points()


def cv2_project(K, dist, R, t, lens, X=X):
    rvec = cv2.Rodrigues(np.asarray(R, dtype=np.float64))[0]
    call = cv2.fisheye.projectPoints if lens == "fisheye" else cv2.projectPoints
    arguments = (rvec, np.asarray(t, np.float64).reshape(3, 1), np.asarray(K, np.float64))
    return call(X.reshape(-1, 1, 3), *arguments, np.asarray(dist, np.float64))[0][:, 0]


def assert_projects(camera, uv, X=X):
    assert np.abs(project(camera, X) - uv).max() < PIXEL


# ==== OpenCV ==================================================================

LENSES = [("brown", BROWN4), ("brown", BROWN), ("brown", RATIONAL), ("fisheye", FISHEYE)]


@pytest.mark.parametrize("ending", ["yml", "xml", "json"])
@pytest.mark.parametrize(("lens", "dist"), LENSES)
def test_opencv_reads_our_pair(lens, dist, ending, tmp_path):
    cameras = truth(dist, lens)
    save_cameras(tmp_path / f"pair.{ending}", cameras, "opencv")
    storage = cv2.FileStorage(str(tmp_path / f"pair.{ending}"), cv2.FILE_STORAGE_READ)
    for i, (name, camera) in enumerate(cameras.items(), 1):
        K, D = (storage.getNode(f"{key}{i}").mat() for key in "MD")
        assert storage.getNode(f"camera_name{i}").string() == name
        assert storage.getNode(f"image_width{i}").real() == 640
        R, t = np.eye(3), np.zeros(3)
        if i == 2:
            R, t = storage.getNode("R").mat(), storage.getNode("T").mat()
        assert_projects(camera, cv2_project(K, D, R, t, lens))


@pytest.mark.parametrize("ending", ["yml", "xml", "json"])
@pytest.mark.parametrize(("lens", "dist"), LENSES)
def test_we_read_a_pair_of_opencv(lens, dist, ending, tmp_path):
    path = str(tmp_path / f"pair.{ending}")
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_WRITE)
    left, right = truth(dist, lens).values()
    R, t = right.cam_from_rig.R, right.cam_from_rig.t.reshape(3, 1)
    storage.write("note", "two cameras: left, right")
    storage.write("cameraMatrix1", left.matrix)
    storage.write("distCoeffs1", np.array([left.dist]))
    storage.write("cameraMatrix2", right.matrix)
    storage.write("distCoeffs2", np.array([right.dist]).T)
    storage.write("R", R)
    storage.write("T", t)
    storage.write("E", np.zeros((0, 0)))
    storage.write("scale", 1e-5)
    storage.release()
    found = load_cameras(path, lens=lens)
    for camera, pose in ((left, (np.eye(3), np.zeros(3))), (right, (R, t))):
        assert_projects(
            found[camera.name], cv2_project(camera.matrix, camera.dist, *pose, lens)
        )


@pytest.mark.parametrize("count", [12, 14])
def test_opencv_longer_models_with_zeros_are_the_rational_one(count, tmp_path):
    path = str(tmp_path / "a.yml")
    dist = np.array([[*RATIONAL[0], *[0.0] * (count - 8)]])
    storage = cv2.FileStorage(path, cv2.FILE_STORAGE_WRITE)
    storage.write("K", truth()["left"].matrix)
    storage.write("D", dist)
    storage.release()
    uv = cv2_project(truth()["left"].matrix, dist, np.eye(3), np.zeros(3), "brown")
    assert_projects(load_cameras(path)["a"], uv)


@pytest.mark.parametrize("name", SAMPLES)
def test_every_sample_projects_as_opencv_projects_it(name, tmp_path):
    """Compares the truth of a sample, given to OpenCV as numbers, with the file after
    reading."""
    sample = SAMPLES[name]
    found = load_cameras(sample.put(tmp_path), **sample.options)
    for key, camera in sample.truth.items():
        R, t = np.eye(3), np.zeros(3)
        if camera.cam_from_rig is not None:
            R, t = camera.cam_from_rig.R, camera.cam_from_rig.t
        dist = camera.dist or np.zeros(4)
        assert_projects(found[key], cv2_project(camera.matrix, dist, R, t, camera.lens))


def test_ros_rectified_pair_is_what_opencv_rectifies(tmp_path):
    """camera_info of a pair as the calibrator makes it. P gives the depth of a point from
    both rectified images. The poses read from the files must give the same pixels."""
    left, right = truth().values()
    R, t = right.cam_from_rig.R, right.cam_from_rig.t
    args = [np.array(a) for c in (left, right) for a in (c.matrix, c.dist)]
    rectified = cv2.stereoRectify(*args, (640, 480), R, t.reshape(3, 1), alpha=0)
    R1, R2, P1, P2 = rectified[:4]
    paths = []
    for camera, rect, P in ((left, R1, P1), (right, R2, P2)):
        paths.append(tmp_path / f"{camera.name}.yaml")
        values = {"k": camera.matrix, "d": np.array(camera.dist), "r": rect, "p": P}
        lines = [f"{key}: {value.ravel().tolist()}" for key, value in values.items()]
        head = f"width: 640\nheight: 480\ncamera_name: {camera.name}\n"
        paths[-1].write_text(head + "distortion_model: plumb_bob\n" + "\n".join(lines))
    found = load_cameras(paths)
    between = found["right"].cam_from_rig @ found["left"].cam_from_rig.inv()
    np.testing.assert_allclose(between.R, R, atol=1e-12)
    np.testing.assert_allclose(between.t, t, atol=1e-12)
    # A point in the rectified frame, by P2 and without distortion.
    point = np.array([0.1, -0.2, 2.0, 1.0])
    u, v, w = P2 @ point
    ray = R2 @ found["right"].cam_from_rig.apply(point[:3])
    assert P2[0, 0] * ray[0] / ray[2] + P2[0, 2] == pytest.approx(u / w, abs=PIXEL)
    assert P2[1, 1] * ray[1] / ray[2] + P2[1, 2] == pytest.approx(v / w, abs=PIXEL)


# ==== Anipose, COLMAP, mrcal ==================================================


@pytest.mark.parametrize(("lens", "dist"), LENSES)
def test_aniposelib_reads_our_toml(lens, dist, tmp_path):
    cameras_of = pytest.importorskip("aniposelib.cameras")
    cameras = truth(dist, lens)
    save_cameras(tmp_path / "Calib.toml", cameras)
    group = cameras_of.CameraGroup.load(str(tmp_path / "Calib.toml"))
    for other in group.cameras:
        assert_projects(cameras[other.get_name()], other.project(X).reshape(-1, 2))
    group.dump(str(tmp_path / "theirs.toml"))
    for name, camera in load_cameras(tmp_path / "theirs.toml").items():
        assert_projects(camera, project(cameras[name], X))


@pytest.mark.parametrize(("lens", "dist"), LENSES)
def test_pycolmap_reads_our_model(lens, dist, tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    cameras = truth(dist, lens)
    save_cameras(tmp_path / "ours", cameras, "colmap")
    model = pycolmap.Reconstruction(str(tmp_path / "ours"))
    for image in model.images.values():
        X_cam = image.cam_from_world() * X
        uv = np.array([model.cameras[image.camera_id].img_from_cam(x) for x in X_cam])
        assert_projects(cameras[image.name], uv.reshape(-1, 2) - 0.5)
    (tmp_path / "theirs").mkdir()
    model.write_text(str(tmp_path / "theirs"))
    found = load_cameras(tmp_path / "theirs")
    for name, camera in cameras.items():
        assert_projects(found[name], project(camera, X))


@pytest.mark.parametrize(
    "model",
    ["SIMPLE_RADIAL", "RADIAL", "SIMPLE_FISHEYE", "FISHEYE"]
    + ["SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"],
)
def test_pycolmap_projects_its_smaller_models_alike(model, tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    camera = pycolmap.Camera.create_from_model_name(1, model, 500.0, 640, 480)
    params = camera.params
    params[-1] += 0.07 if "RADIAL" in model else 0.0
    camera.params = params
    words = " ".join(map(repr, params.tolist()))
    (tmp_path / "cameras.txt").write_text(f"1 {model} 640 480 {words}\n")
    uv = np.array([camera.img_from_cam(x) for x in X]).reshape(-1, 2)
    assert_projects(load_cameras(tmp_path)["1"], uv - 0.5)


@pytest.mark.parametrize("dist", [BROWN4, BROWN, RATIONAL, ((), ())])
def test_mrcal_reads_our_model(dist, tmp_path):
    mrcal = pytest.importorskip("mrcal")
    camera = truth(dist)["right"]
    path = str(tmp_path / "right.cameramodel")
    save_cameras(path, [camera])
    model = mrcal.cameramodel(path)
    X_cam = mrcal.transform_point_rt(model.extrinsics_rt_fromref(), X)
    assert_projects(camera, mrcal.project(X_cam, *model.intrinsics()))
    model.write(str(tmp_path / "theirs.cameramodel"))
    (found,) = load_cameras(tmp_path / "theirs.cameramodel").values()
    assert (
        np.abs(project(found, X) - project(camera, X)).max() < 1e-5
    )  # it writes 10 digits


# ==== targets =================================================================


def test_a_tag_of_an_aprilgrid_is_seen_as_opencv_sees_it(tmp_path):
    """Corners in the order of a detector: solvePnP of a square finds the tag upright."""
    (tmp_path / "target.yaml").write_text(
        "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n"
    )
    corners = load_target(tmp_path / "target.yaml").corners(3)
    assert corners[:, 2].tolist() == [0, 0, 0, 0]
    square = corners - corners.mean(axis=0)
    expected = [[-0.05, 0.05], [0.05, 0.05], [0.05, -0.05], [-0.05, -0.05]]
    np.testing.assert_allclose(square[:, :2], expected, atol=1e-15)
    flipped = corners * [1, -1, -1] + [0, 0, 1]  # x right, y down, z forward
    uv = flipped[:, :2] / flipped[:, 2:] * 500
    ok, _, t = cv2.solvePnP(
        square, uv, np.diag([500.0, 500, 1]), None, flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    assert ok
    np.testing.assert_allclose(t[2], 1.0, atol=1e-6)
