"""The pitfalls of each format. The truth was found by reasoning, not computed.

Words say where the cameras are and what they see; the file says the same in its own
convention."""

import json

import numpy as np
import pytest
from format_samples import SAMPLES
from lens import project

from rigcal import FileError, load_cameras, load_target, save_cameras, save_target

QUARTER_Z = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # x goes to y
QUARTER_X = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]  # y goes to z


def pixel(camera, point):
    return project(camera, np.array([point], dtype=float))[0]


def load_json(tmp_path, value, **options):
    (tmp_path / "file.json").write_text(json.dumps(value))
    return load_cameras(tmp_path / "file.json", **options)


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_colmap_counts_from_the_corner_of_the_first_pixel(tmp_path):
    """The axis goes through the centre of the top-left pixel: 0.5, 0.5 in COLMAP."""
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 640 480 500 500 0.5 0.5\n")
    (tmp_path / "images.txt").write_text("1 1 0 0 0 0 0 0 1 a\n\n")
    camera = load_cameras(tmp_path)["a"]
    close(pixel(camera, [0, 0, 2]), [0, 0])
    close(pixel(camera, [1, 0, 500]), [1, 0])
    save_cameras(tmp_path / "out", [camera], "colmap")
    assert "500.0 500.0 0.5 0.5" in (tmp_path / "out" / "cameras.txt").read_text()


def test_colmap_quaternions_have_the_scalar_first(tmp_path):
    """A quarter turn about z: half the root of 2 in QW and QZ. X goes to Y."""
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 640 480 500 500 1 1\n")
    (tmp_path / "images.txt").write_text("1 1 0 0 1 7 8 9 1 my image.png\n\n")
    T = load_cameras(tmp_path)["my image.png"].cam_from_rig
    close(T.R, QUARTER_Z)
    close(T.apply([1, 0, 0]), [7, 9, 9])


def test_colmap_lines_of_points_are_no_images(tmp_path):
    """The second line of an image may be empty, or look like a pose."""
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 640 480 500 500 1 1\n")
    (tmp_path / "images.txt").write_text(
        "1 1 0 0 0 0 0 0 1 a\n\n2 1 0 0 0 0 0 1 1 b\n1 2 3 4 5 6 7 8 9 1 1 1\n"
        "3 1 0 0 0 0 0 2 1 c\n"
    )
    assert list(load_cameras(tmp_path)) == ["a", "b", "c"]


def matlab(**changes):
    camera = {
        "RadialDistortion": [0.1, 0.02, 0.003],
        "TangentialDistortion": [0.0004, 0.0005],
        "ImageSize": [480, 640],
        "WorldUnits": "millimeters",
        "IntrinsicMatrix": [[500, 0, 0], [0, 600, 0], [1, 1, 1]],
    }
    return {"CameraParameters1": camera, "CameraParameters2": camera, **changes}


def test_matlab_counts_from_1_and_keeps_coefficients_apart(tmp_path):
    """The axis goes through the centre of the top-left pixel: 1, 1 in MATLAB."""
    R = {"RotationOfCamera2": np.eye(3).tolist(), "TranslationOfCamera2": [0, 0, 0]}
    camera = load_json(tmp_path, matlab(**R))["cam1"]
    assert (camera.cx, camera.cy) == (0, 0)
    assert (camera.fx, camera.fy, camera.size) == (500, 600, (640, 480))
    assert camera.dist == (0.1, 0.02, 0.0004, 0.0005, 0.003)


def test_matlab_multiplies_row_vectors(tmp_path):
    """[x y z] R + t, by MATLAB's own equation, in millimetres."""
    row_R, row_t = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]]), [10, 20, 30]
    R = {"RotationOfCamera2": row_R.tolist(), "TranslationOfCamera2": row_t}
    T = load_json(tmp_path, matlab(**R))["cam2"].cam_from_rig
    row = np.array([[1.0, 2.0, 3.0]]) @ row_R + row_t
    close(T.apply([0.001, 0.002, 0.003]), row[0] / 1000)
    close(T.R, QUARTER_Z)


@pytest.mark.parametrize("name", ["R", "Rotation"])
def test_matlab_pose_of_camera_2_is_not_transposed(name, tmp_path):
    """rigidtform3d is premultiplied; MATLAB makes it of RotationOfCamera2'."""
    pose = {"PoseCamera2": {name: QUARTER_Z, "Translation": [10, 20, 30]}}
    close(load_json(tmp_path, matlab(**pose))["cam2"].cam_from_rig.R, QUARTER_Z)


def nerfstudio(matrix, **more):
    intrinsics = {"fl_x": 500, "fl_y": 500, "cx": 320.5, "cy": 240.5, "w": 640, "h": 480}
    return {
        **intrinsics,
        **more,
        "frames": [{"file_path": "a.png", "transform_matrix": matrix}],
    }


def test_nerfstudio_looks_along_minus_z_with_y_up(tmp_path):
    """A camera at (1, 2, 3) without rotation looks along the world's -z."""
    matrix = [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    camera = load_json(tmp_path, nerfstudio(matrix))["a"]
    close(camera.cam_from_rig.center, [1, 2, 3])
    close(camera.cam_from_rig.apply([1, 2, -2]), [0, 0, 5])
    close(pixel(camera, [1, 2, -2]), [320, 240])  # 320.5, 240.5 from the corner
    assert pixel(camera, [2, 2, -2])[0] > 320  # to the right
    assert pixel(camera, [1, 3, -2])[1] < 240  # up in the world is up in the image


def test_nerfstudio_fourth_coefficient_is_another(tmp_path):
    """The k4 of OPENCV there multiplies r^8. Ours belongs to the rational model's
    denominator."""
    with pytest.raises(FileError, match="k4: this model has no k4"):
        load_json(tmp_path, nerfstudio(np.eye(4).tolist(), k4=0.1))
    assert load_json(tmp_path, nerfstudio(np.eye(4).tolist(), k4=0))["a"].dist == ()


def camchain(*steps, name="T_cn_cnm1"):
    camera = {
        "camera_model": "pinhole",
        "distortion_model": "radtan",
        "distortion_coeffs": [0.1, 0.02, 0.003, 0.0004],
        "intrinsics": [500, 600, 320, 240],
        "resolution": [640, 480],
    }
    poses = [{} if step is None else {name: step} for step in steps]
    return {f"cam{i}": {**camera, **pose} for i, pose in enumerate(poses)}


def test_kalibr_multiplies_along_the_chain(tmp_path):
    """cam1 from cam0: x becomes y, then 1 along x. cam2 from cam1: y becomes z. So a point
    on cam0's x axis is on cam1's y axis and on cam2's z axis."""
    first = np.eye(4)
    first[:3, :3], first[0, 3] = QUARTER_Z, 1
    second = np.eye(4)
    second[:3, :3] = QUARTER_X
    found = load_json(tmp_path, camchain(None, first.tolist(), second.tolist()))
    close(found["cam1"].cam_from_rig.apply([5, 0, 0]), [1, 5, 0])
    close(found["cam2"].cam_from_rig.apply([5, 0, 0]), [1, 0, 5])
    save_cameras(tmp_path / "camchain.json.yaml", found, "kalibr")
    again = load_cameras(tmp_path / "camchain.json.yaml")
    close(again["cam2"].cam_from_rig.matrix, found["cam2"].cam_from_rig.matrix)


def test_kalibr_radtan_is_k1_k2_p1_p2(tmp_path):
    coefficients = load_json(tmp_path, camchain(None))["cam0"].coefficients
    assert [coefficients[k] for k in ("k1", "k2", "p1", "p2")] == [0.1, 0.02, 0.003, 0.0004]


def test_kalibr_order_is_by_number(tmp_path):
    """cam10 comes after cam9, wherever it is in the file."""
    step = np.eye(4)
    step[0, 3] = -1  # each camera is one to the right of the one before
    chain = camchain(None, *[step.tolist()] * 10)
    found = load_json(tmp_path, dict(reversed(chain.items())))
    close(found["cam10"].cam_from_rig.center, [10, 0, 0])


def test_mrcal_has_the_rotation_before_the_translation(tmp_path):
    (tmp_path / "a.cameramodel").write_text(
        "{'lens_model': 'LENSMODEL_PINHOLE', 'intrinsics': [500, 600, 320, 240],"
        f"'extrinsics': [0, 0, {np.pi / 2!r}, 1, 2, 3], 'imagersize': [640, 480]}}"
    )
    T = load_cameras(tmp_path / "a.cameramodel")["a"].cam_from_rig
    close(T.R, QUARTER_Z)
    close(T.apply([1, 0, 0]), [1, 3, 3])


@pytest.mark.parametrize("count", [0, 1, 2, 3, -1, -2])
def test_caliscope_rotation_count_turns_windows_alone(count, tmp_path):
    """The image as recorded is 640 wide, and a point on the axis is at (310.5, 250.75)."""
    text = SAMPLES["caliscope"].files["camera_array.toml"]
    (tmp_path / "a.toml").write_text(
        text.replace("rotation_count = 1", f"rotation_count = {count}")
    )
    camera = load_cameras(tmp_path / "a.toml")["1"]
    assert camera.size == (640, 480)
    axis = camera.cam_from_rig.inv().apply([0, 0, 3])
    close(pixel(camera, axis), [310.5, 250.75])


def multical(poses):
    camera = {"image_size": [640, 480], "K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]]}
    cameras = {f"cam{i}": {**camera, "dist": [0, 0, 0, 0, 0]} for i in (1, 2, 3)}
    eye = np.eye(3).tolist()
    return {
        "cameras": cameras,
        "camera_poses": {key: {"R": eye, "T": t} for key, t in poses.items()},
    }


def test_multical_2_to_1_takes_coordinates_from_1_to_2(tmp_path):
    """The format's own example: camera 2 is to the right of camera 1, so T is negative."""
    poses = {
        "cam1": [0, 0, 0],
        "cam2_to_cam1": [-0.05, 0, 0],
        "cam3_to_cam2": [-0.02, 0, 0],
    }
    found = load_json(tmp_path, multical(poses))
    close(found["cam2"].cam_from_rig.center, [0.05, 0, 0])
    close(found["cam3"].cam_from_rig.center, [0.07, 0, 0])
    assert pixel(found["cam2"], [0, 0, 1])[0] < pixel(found["cam1"], [0, 0, 1])[0]


def test_multical_goes_backwards_too(tmp_path):
    """cam3 is known, and cam2 and cam1 follow from it."""
    poses = {
        "cam2_to_cam1": [-0.05, 0, 0],
        "cam3_to_cam2": [-0.02, 0, 0],
        "cam3": [0, 0, 0],
    }
    found = load_json(tmp_path, multical(poses))
    close(found["cam1"].cam_from_rig.center, [-0.07, 0, 0])


def test_ros_projection_matrix_has_the_baseline_and_not_the_lens(tmp_path):
    """The right camera of a pair, 0.2 m to the right: P[0, 3] = -140 = -700 x 0.2."""
    text = SAMPLES["ros"].files["right.yaml"]
    camera = load_cameras(SAMPLES["ros"].put(tmp_path))["right"]
    assert (camera.fx, camera.cx) == (790, 310.5)  # of K; P has 700 and 300
    close(camera.cam_from_rig.center, [0.2, 0, 0])
    # A point straight ahead of the right camera's rectified image.
    ahead = camera.cam_from_rig.apply([0.2, 0, 5])
    close(np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]) @ ahead, [0, 0, 5])
    assert "-140.0" in text


def test_bop_is_in_millimetres(tmp_path):
    path = SAMPLES["bop"].put(tmp_path)
    close(load_cameras(path)["1"].cam_from_rig.t, [-0.2, 0.01, 0.03])
    close(load_cameras(path, scale=1)["1"].cam_from_rig.t, [-200, 10, 30])


def test_opencv_pair_is_second_from_first(tmp_path):
    """T of a pair is negative in x: the second camera is to the right."""
    T = load_cameras(SAMPLES["opencv-yaml"].put(tmp_path))["right"].cam_from_rig
    assert T.center[0] > 0
    close(T.apply([0, 0, 0]), [-0.2, 0.01, 0.03])


def test_a_file_of_four_coefficients_needs_a_word(tmp_path):
    path = SAMPLES["opencv-fisheye"].put(tmp_path)
    with pytest.raises(FileError, match='pass lens="brown" or lens="fisheye"'):
        load_cameras(path)
    assert load_cameras(path, lens="brown")["left"].coefficients["p1"] == 0.001
    assert load_cameras(path, lens="fisheye")["left"].coefficients["k3"] == 0.001


def test_rotations_of_six_digits_become_rotations(tmp_path):
    """0.707107 is half the root of 2 to six digits; the nearest rotation has all digits."""
    half = 0.707107
    chain = camchain(
        None, [[half, -half, 0, 0], [half, half, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    R = load_json(tmp_path, chain)["cam1"].cam_from_rig.R
    close(R, [[0.5**0.5, -(0.5**0.5), 0], [0.5**0.5, 0.5**0.5, 0], [0, 0, 1]])
    chain["cam1"]["T_cn_cnm1"][0][0] = 0.7072
    with pytest.raises(FileError, match=r"cam1\.T_cn_cnm1: the matrix is not a rotation"):
        load_json(tmp_path, chain)


# ==== targets of Kalibr =======================================================

APRILGRID = (
    "target_type: aprilgrid\ntagCols: 6\ntagRows: 4\ntagSize: 0.1\ntagSpacing: 0.3\n"
)
CHECKERBOARD = (
    "target_type: 'checkerboard'\ntargetCols: 3\ntargetRows: 2\n"
    "rowSpacingMeters: 0.05\ncolSpacingMeters: 0.06\n"
)
CIRCLES = "target_type: circlegrid\ntargetCols: 3\ntargetRows: 2\nspacingMeters: 0.02\n"


def test_tags_count_from_the_bottom_left(tmp_path):
    """tagSpacing is a ratio: tags of 10 cm are 13 cm apart."""
    (tmp_path / "t.yaml").write_text(APRILGRID)
    target = load_target(tmp_path / "t.yaml")
    close(target.corners(0), [[0, 0.1, 0], [0.1, 0.1, 0], [0.1, 0, 0], [0, 0, 0]])
    close(target.corners(1)[3], [0.13, 0, 0])
    close(target.corners(6)[3], [0, 0.13, 0])
    close(target.corners(23)[1], [5 * 0.13 + 0.1, 3 * 0.13 + 0.1, 0])
    assert target.points.shape == (96, 3)
    close(target.points[:3], [[0, 0, 0], [0.1, 0, 0], [0.13, 0, 0]])
    close(target.points[12], [0, 0.1, 0])


def test_checkerboard_of_kalibr_has_x_along_its_rows(tmp_path):
    (tmp_path / "t.yaml").write_text(CHECKERBOARD)
    points = load_target(tmp_path / "t.yaml").points
    close(points[[0, 1, 3]], [[0, 0, 0], [0, 0.06, 0], [0.05, 0, 0]])


@pytest.mark.parametrize("asymmetric", ["False", "True"])
def test_circlegrid(asymmetric, tmp_path):
    (tmp_path / "t.yaml").write_text(CIRCLES + f"asymmetricGrid: {asymmetric}\n")
    points = load_target(tmp_path / "t.yaml").points
    if asymmetric == "True":
        close(points[[1, 3]], [[0.04, 0, 0], [0.02, 0.02, 0]])
    else:
        close(points[[1, 3]], [[0, 0.02, 0], [0.02, 0, 0]])


@pytest.mark.parametrize(
    "text",
    [
        APRILGRID,
        CHECKERBOARD,
        CIRCLES + "asymmetricGrid: True\n",
    ],
)
def test_a_target_is_written_and_read_again(text, tmp_path):
    (tmp_path / "t.yaml").write_text(text)
    target = load_target(tmp_path / "t.yaml")
    save_target(tmp_path / "u.yaml", target)
    assert load_target(tmp_path / "u.yaml") == target
    np.testing.assert_array_equal(load_target(tmp_path / "u.yaml").points, target.points)
