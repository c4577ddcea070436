"""Files of cameras: each is read correctly, written, and read again."""

import os
import warnings
from dataclasses import replace

import numpy as np
import pytest
from format_samples import BROWN4, FISHEYE, NONE, RATIONAL, SAMPLES, SIZE, truth

import rigcal
from rigcal import Camera, FileError, Transform, load_cameras, save_cameras

EXACT = 1e-12


def assert_same(found, expected, tolerance=EXACT):
    """Names, sizes and lenses must be equal, numbers within the tolerance."""
    assert list(found) == list(expected)
    for name, camera in expected.items():
        other = found[name]
        assert (other.name, other.size, other.lens) == (name, camera.size, camera.lens)
        for key in ("fx", "fy", "cx", "cy"):
            assert getattr(other, key) == pytest.approx(getattr(camera, key), abs=tolerance)
        assert list(other.coefficients.values()) == pytest.approx(
            list(camera.coefficients.values()), abs=tolerance
        )
        if camera.cam_from_rig is None:
            assert other.cam_from_rig is None
        else:
            T = other.cam_from_rig
            assert (T.to, T.frm) == (name, "rig")
            np.testing.assert_allclose(T.matrix, camera.cam_from_rig.matrix, atol=tolerance)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_file_says_what_its_author_meant(name, tmp_path):
    sample = SAMPLES[name]
    path = sample.put(tmp_path)
    assert_same(load_cameras(path, **sample.options), sample.truth)
    assert_same(load_cameras(path, sample.format, **sample.options), sample.truth)


@pytest.mark.parametrize("name", SAMPLES)
def test_what_was_read_is_written_and_read_again(name, tmp_path):
    sample = SAMPLES[name]
    (tmp_path / "in").mkdir()
    cameras = load_cameras(sample.put(tmp_path / "in"), **sample.options)
    out = tmp_path / "out" / next(iter(sample.files))
    if len(sample.files) > 1:
        out = f"{tmp_path}{os.sep}out{os.sep}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save_cameras(out, cameras, sample.format)
        again = load_cameras(out)
        assert_same(again, sample.truth)
        save_cameras(out, again, sample.format)
    assert_same(load_cameras(out), again)


PATHS = {
    "opencv": "rig.xml",
    "kalibr": "camchain.yaml",
    "anipose": "Calib.toml",
    "caliscope": "camera_array.toml",
    "matlab": "rig.mat",
    "nerfstudio": "transforms.json",
    "multical": "calibration.json",
    "bop": "scene_camera.json",
    "rigcal": "cameras.csv",
}
NAMES = {"kalibr": ("cam0", "cam1"), "matlab": ("cam1", "cam2")}
LENSES = {
    "none": (NONE, "brown"),
    "brown": (BROWN4, "brown"),
    "rational": (RATIONAL, "brown"),
    "fisheye": (FISHEYE, "fisheye"),
}
REFUSED = {
    "kalibr": ["rational"],
    "matlab": ["rational", "fisheye"],
    "nerfstudio": ["rational"],
    "bop": ["brown", "rational", "fisheye"],
}


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("format", PATHS)
def test_every_lens_is_kept_or_refused(format, lens, tmp_path):
    cameras = truth(*LENSES[lens], NAMES.get(format, ("left", "right")))
    path = tmp_path / PATHS[format]
    if lens in REFUSED.get(format, []):
        with pytest.raises(FileError, match=r"left|cam0|cam1"):
            save_cameras(path, cameras)
        assert os.listdir(tmp_path) == []
        return
    save_cameras(path, cameras)
    options = {"lens": "fisheye"} if (format, lens) == ("multical", "fisheye") else {}
    expected = cameras
    if format == "rigcal":
        expected = {n: replace(c, cam_from_rig=None) for n, c in cameras.items()}
    if format == "bop":
        expected = {n: replace(c, size=None) for n, c in cameras.items()}
    assert_same(load_cameras(path, **options), expected)


@pytest.mark.parametrize(
    ("format", "name"), [("mrcal", "right.cameramodel"), ("ros", "r.yaml")]
)
@pytest.mark.parametrize("lens", LENSES)
def test_one_camera_a_file_takes_a_placeholder(format, name, lens, tmp_path):
    cameras = truth(*LENSES[lens])
    path = tmp_path / ("{name}-" + name)
    if (format, lens) == ("mrcal", "fisheye"):
        with pytest.raises(FileError, match="left: the camera model"):
            save_cameras(path, cameras, format)
        return
    if format == "ros":
        cameras = {n: replace(c, cam_from_rig=None) for n, c in cameras.items()}
    save_cameras(path, cameras, format)
    paths = sorted(tmp_path.iterdir())
    found = load_cameras(paths)
    if format == "mrcal":  # the file has no name but its own
        expected = {f"{n}-right": replace(c, name=f"{n}-right") for n, c in cameras.items()}
        expected = {
            n: replace(c, cam_from_rig=Transform(c.cam_from_rig.R, c.cam_from_rig.t, n))
            for n, c in expected.items()
        }
        assert_same(found, expected)
    else:
        assert_same(found, cameras)
    with pytest.raises(FileError, match="holds one camera"):
        save_cameras(tmp_path / name, cameras, format)


def turned(seed, name, shift=1.0):
    rng = np.random.default_rng(seed)
    return Transform.from_rvec(rng.normal(size=3), shift * rng.normal(size=3), name, "rig")


@pytest.mark.parametrize(
    ("format", "path"),
    [
        ("kalibr", "camchain.yaml"),
        ("anipose", "a.toml"),
        ("caliscope", "b.toml"),
        ("colmap", "model"),
        ("nerfstudio", "t.json"),
        ("multical", "m.json"),
        ("rigcal", "csv/"),
        ("bop", "b.json"),
    ],
)
def test_five_cameras_and_a_rig_that_is_none_of_them(format, path, tmp_path):
    cameras = [
        Camera(
            700 + i,
            710 + i,
            330.25,
            250.125,
            SIZE,
            (),
            name=name,
            cam_from_rig=turned(i, name),
        )
        for i, name in enumerate(["a", "cam0", "b_to_c", "c", "d-1"])
    ]
    save_cameras(os.path.join(tmp_path, path), cameras, format)
    expected = {c.name: c for c in cameras}
    if format == "bop":
        expected = {n: replace(c, size=None) for n, c in expected.items()}
    found = load_cameras(os.path.join(tmp_path, path))
    assert_same(found, expected)


@pytest.mark.parametrize("format", ["opencv", "matlab"])
def test_a_pair_has_its_first_camera_as_rig(format, tmp_path):
    names = NAMES.get(format, ("left", "right"))
    cameras = [
        replace(c, cam_from_rig=turned(i, c.name))
        for i, c in enumerate(truth(names=names).values())
    ]
    with pytest.warns(rigcal.Caveat, match="is its first camera, ") as caught:
        save_cameras(tmp_path / PATHS[format], cameras)
    assert caught[0].filename == __file__
    found = list(load_cameras(tmp_path / PATHS[format]).values())
    assert found[0].cam_from_rig == Transform.identity(names[0], "rig")
    expected = cameras[1].cam_from_rig @ cameras[0].cam_from_rig.inv()
    np.testing.assert_allclose(found[1].cam_from_rig.matrix, expected.matrix, atol=EXACT)


# ==== what belongs to one format ==============================================


def test_opencv_pair_in_two_files(tmp_path):
    text = SAMPLES["opencv-yaml"].files["stereo.yml"]
    head, extrinsics = text[: text.index("R: ")], text[text.index("R: ") :]
    (tmp_path / "intrinsics.yml").write_text(head)
    time = 'calibration_time: "Sunday"\n'  # a key that both files have
    (tmp_path / "extrinsics.yml").write_text(f"%YAML:1.0\n---\n{time}{extrinsics}")
    both = [tmp_path / "intrinsics.yml", tmp_path / "extrinsics.yml"]
    assert_same(load_cameras(both), truth())
    assert_same(load_cameras(both[:1]), truth(pose=False))
    with pytest.raises(FileError, match=r"cameramatrix1|camera_?matrix"):
        load_cameras(both[1])


def test_opencv_cameras_in_a_file_each(tmp_path):
    for name, camera in truth(pose=False).items():
        save_cameras(tmp_path / f"{name}.yml", [camera], "opencv")
    paths = [tmp_path / "left.yml", tmp_path / "right.yml"]
    assert_same(load_cameras(paths), truth(pose=False))


def test_opencv_cameras_of_two_sizes_and_lenses(tmp_path):
    cameras = truth()
    other = replace(cameras["right"], size=(320, 200), lens="fisheye", dist=FISHEYE[1])
    cameras["right"] = other
    for name in ("a.yml", "a.xml", "a.json"):
        save_cameras(tmp_path / name, cameras, "opencv")
        assert_same(load_cameras(tmp_path / name), cameras)


def test_opencv_without_size(tmp_path):
    cameras = truth(size=None)
    save_cameras(tmp_path / "a.yml", cameras, "opencv")
    assert_same(load_cameras(tmp_path / "a.yml"), cameras)


def test_opencv_warns_of_a_pose_that_it_cannot_hold(tmp_path):
    with pytest.warns(rigcal.Caveat, match="right: .* left out"):
        save_cameras(tmp_path / "a.yml", [truth()["right"]], "opencv")


def test_opencv_has_two_cameras_at_most(tmp_path):
    cameras = [replace(truth()["left"], name=name) for name in "abc"]
    with pytest.raises(FileError, match="one camera or two"):
        save_cameras(tmp_path / "a.yml", cameras, "opencv")


def test_ros_warns_of_a_pose_that_is_not_rectified(tmp_path):
    with pytest.warns(rigcal.Caveat, match="right: .* left out"):
        save_cameras(tmp_path / "a.yaml", [truth()["right"]], "ros")
    assert load_cameras(tmp_path / "a.yaml")["right"].cam_from_rig is None


@pytest.mark.parametrize(
    ("old", "new"),
    [("binning_x: 0", "binning_x: 2"), ("x_offset: 0", "x_offset: 16")],
)
def test_ros_warns_of_a_part_of_the_image(old, new, tmp_path):
    text = SAMPLES["ros-message"].files["info.yaml"].replace(old, new)
    (tmp_path / "info.yaml").write_text(text)
    with pytest.warns(rigcal.Caveat, match="full image") as caught:
        load_cameras(tmp_path / "info.yaml")
    assert caught[0].filename == __file__


def test_ros_2_writes_small_letters(tmp_path):
    text = SAMPLES["ros-message"].files["info.yaml"]
    for letter in "DKRP":
        text = text.replace(f"\n{letter}: ", f"\n{letter.lower()}: ")
    (tmp_path / "info.yaml").write_text(text)
    assert_same(load_cameras(tmp_path / "info.yaml"), SAMPLES["ros-message"].truth)


def test_ros_driver_without_calibration_leaves_zeros(tmp_path):
    text = SAMPLES["ros-message"].files["info.yaml"]
    zeros = "R: [0, 0, 0, 0, 0, 0, 0, 0, 0]"
    text = text.replace("R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]", zeros)
    (tmp_path / "info.yaml").write_text(
        text.replace('  frame_id: "cam_optical"', "  frame_id: ''")
    )
    found = load_cameras(tmp_path / "info.yaml")
    assert found["info"].cam_from_rig is None


def test_kalibr_keeps_the_imu(tmp_path):
    imu = "  T_cam_imu:\n" + "".join(
        f"  - [{row}]\n"
        for row in ("0, 1, 0, 1", "-1, 0, 0, 2", "0, 0, 1, 3", "0, 0, 0, 1")
    )
    text = SAMPLES["kalibr"].files["camchain.yaml"].replace("cam0:\n", "cam0:\n" + imu)
    (tmp_path / "camchain.yaml").write_text(text)
    first = load_cameras(tmp_path / "camchain.yaml")
    save_cameras(tmp_path / "b-camchain.yaml", first)
    again = load_cameras(tmp_path / "b-camchain.yaml")["cam0"].extra
    assert again["T_cam_imu"][1] == [-1, 0, 0, 2]
    assert again["timeshift_cam_imu"] == -0.005
    assert again["rostopic"] == "/cam0/image_raw"


def test_kalibr_chain_by_the_imu_alone(tmp_path):
    text = SAMPLES["kalibr"].files["camchain.yaml"].replace("T_cn_cnm1", "T_cam_imu")
    identity = "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    (tmp_path / "c.yaml").write_text(text.replace("cam0:\n", "cam0:\n" + identity))
    assert_same(load_cameras(tmp_path / "c.yaml"), SAMPLES["kalibr"].truth)


def test_kalibr_one_camera(tmp_path):
    text = SAMPLES["kalibr"].files["camchain.yaml"]
    (tmp_path / "c.yaml").write_text(text[: text.index("cam1:")])
    assert list(load_cameras(tmp_path / "c.yaml")) == ["cam0"]
    camera = replace(truth(BROWN4)["left"], cam_from_rig=None)
    save_cameras(tmp_path / "d-camchain.yaml", [camera])
    assert load_cameras(tmp_path / "d-camchain.yaml")["left"].dist == BROWN4[0]


def test_anipose_in_millimetres(tmp_path):
    path = SAMPLES["anipose"].put(tmp_path)
    found = load_cameras(path, scale=0.001)
    assert_same(found, truth(scale=0.001))
    save_cameras(tmp_path / "Calib.toml", found, "pose2sim", scale=0.001)
    assert_same(load_cameras(tmp_path / "Calib.toml"), truth())


def test_caliscope_keeps_what_its_windows_need(tmp_path):
    found = load_cameras(SAMPLES["caliscope"].put(tmp_path))
    save_cameras(tmp_path / "camera_array.toml", found)
    assert load_cameras(tmp_path / "camera_array.toml")["1"].extra == found["1"].extra
    assert found["1"].extra["rotation_count"] == 1


def test_mrcal_older_names(tmp_path):
    text = SAMPLES["mrcal"].files["right.cameramodel"]
    text = text.replace("'lens_model'", "'distortion_model'").replace(
        "LENSMODEL", "DISTORTION"
    )
    (tmp_path / "right.cameramodel").write_text(text)
    assert_same(load_cameras(tmp_path / "right.cameramodel"), SAMPLES["mrcal"].truth)
    newer = (
        SAMPLES["mrcal"].files["right.cameramodel"].replace("'extrinsics'", "'rt_cam_ref'")
    )
    (tmp_path / "right.cameramodel").write_text(newer)
    assert_same(load_cameras(tmp_path / "right.cameramodel"), SAMPLES["mrcal"].truth)


def test_colmap_without_images_has_no_poses(tmp_path):
    (tmp_path / "cameras.txt").write_text(SAMPLES["colmap"].files["cameras.txt"])
    assert_same(load_cameras(tmp_path), truth(BROWN4, names=("1", "2"), pose=False))
    assert_same(
        load_cameras(tmp_path / "cameras.txt"), truth(BROWN4, names=("1", "2"), pose=False)
    )


@pytest.mark.parametrize(
    ("line", "lens", "f", "dist"),
    [
        ("SIMPLE_PINHOLE 640 480 800 321 241", "brown", (800, 800), ()),
        ("PINHOLE 640 480 800 810 321 241", "brown", (800, 810), ()),
        ("SIMPLE_RADIAL 640 480 800 321 241 0.1", "brown", (800, 800), (0.1, 0, 0, 0)),
        ("RADIAL 640 480 800 321 241 0.1 0.2", "brown", (800, 800), (0.1, 0.2, 0, 0)),
        (
            "FULL_OPENCV 640 480 800 810 321 241 .1 .2 .3 .4 .5 .6 .7 .8",
            "brown",
            (800, 810),
            (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8),
        ),
        ("SIMPLE_FISHEYE 640 480 800 321 241", "fisheye", (800, 800), (0, 0, 0, 0)),
        ("FISHEYE 640 480 800 810 321 241", "fisheye", (800, 810), (0, 0, 0, 0)),
        (
            "SIMPLE_RADIAL_FISHEYE 640 480 800 321 241 .1",
            "fisheye",
            (800, 800),
            (0.1, 0, 0, 0),
        ),
        (
            "RADIAL_FISHEYE 640 480 800 321 241 .1 .2",
            "fisheye",
            (800, 800),
            (0.1, 0.2, 0, 0),
        ),
    ],
)
def test_colmap_models(line, lens, f, dist, tmp_path):
    (tmp_path / "cameras.txt").write_text(f"7 {line}\n")
    expected = Camera(*f, 320.5, 240.5, SIZE, dist, lens, "7")
    assert load_cameras(tmp_path) == {"7": expected}


def test_colmap_single_rigs_do_not_count(tmp_path):
    files = {**SAMPLES["colmap"].files, "rigs.txt": "# rigs\n1 1 CAMERA 1\n2 1 CAMERA 2\n"}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert_same(load_cameras(tmp_path), truth(BROWN4))


def test_colmap_rig_without_a_pose_and_with_an_imu(tmp_path):
    rigs = "1 3 IMU 1 CAMERA 1 0 CAMERA 2 1 1 0 0 0 1 2 3\n"
    for name, text in {**SAMPLES["colmap"].files, "rigs.txt": rigs}.items():
        (tmp_path / name).write_text(text)
    found = load_cameras(tmp_path)
    assert found["1"].cam_from_rig is None
    assert found["2"].cam_from_rig.t.tolist() == [1, 2, 3]


def test_matlab_in_inches_and_by_focal_length(tmp_path):
    text = SAMPLES["matlab-json"].files["rig.json"]
    text = text.replace("millimeters", "inches").replace(
        '"IntrinsicMatrix": [[790, 0, 0], [0, 795, 0], [311.5, 251.75, 1]]',
        '"FocalLength": [790, 795], "PrincipalPoint": [311.5, 251.75], "Skew": 0',
    )
    (tmp_path / "a.json").write_text(text)
    found = load_cameras(tmp_path / "a.json")
    assert_same({"cam1": found["cam1"]}, {"cam1": truth(names=("cam1", "cam2"))["cam1"]})
    assert found["cam2"].cx == 310.5
    np.testing.assert_allclose(
        found["cam2"].cam_from_rig.t, np.array([-200, 10, 30]) * 0.0254
    )
    np.testing.assert_array_equal(
        load_cameras(tmp_path / "a.json", scale=1)["cam2"].cam_from_rig.t, [-200, 10, 30]
    )


def test_matlab_one_camera_without_size(tmp_path):
    (tmp_path / "cam.json").write_text(
        '{"p": {"K": [[800, 0, 321.5], [0, 810, 241.25], [0, 0, 1]], "ImageSize": [],'
        ' "RadialDistortion": [0.1, 0.2], "TangentialDistortion": [0, 0]}}'
    )
    expected = Camera(800, 810, 320.5, 240.25, None, (0.1, 0.2, 0, 0), name="cam")
    assert load_cameras(tmp_path / "cam.json") == {"cam": expected}
    with pytest.raises(FileError, match="image size"):
        save_cameras(tmp_path / "b.mat", [expected])
    save_cameras(tmp_path / "one.mat", [replace(expected, size=SIZE)])
    assert load_cameras(tmp_path / "one.mat")["one"].dist == (0.1, 0.2, 0, 0)


def test_nerfstudio_intrinsics_at_the_top(tmp_path):
    (tmp_path / "t.json").write_text(
        '{"camera_model": "OPENCV_FISHEYE", "fl_x": 800, "fl_y": 810, "cx": 321,'
        ' "cy": 240.75,'
        ' "w": 640, "h": 480, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4, "frames": [{'
        ' "file_path": "a/0.png", "transform_matrix":'
        ' [[1,0,0,0],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]}, {"file_path": "b/0.png",'
        ' "transform_matrix": [[1,0,0,0],[0,-1,0,0],[0,0,-1,0]]}]}'
    )
    found = load_cameras(tmp_path / "t.json")
    expected = [
        Camera(
            *(800, 810, 320.5, 240.25, SIZE, (0.1, 0.2, 0.3, 0.4), "fisheye", name),
            Transform.identity(name, "rig"),
        )
        for name in ("a/0.png", "b/0.png")
    ]
    assert_same(found, {c.name: c for c in expected})
    save_cameras(tmp_path / "transforms.json", found)
    assert_same(load_cameras(tmp_path / "transforms.json"), found)


def test_nerfstudio_has_one_model_and_needs_poses(tmp_path):
    a, b = truth().values()
    b = replace(b, lens="fisheye", dist=FISHEYE[1])
    with pytest.raises(FileError, match="one lens model"):
        save_cameras(tmp_path / "transforms.json", [a, b])
    with pytest.raises(FileError, match="left: this format needs cam_from_rig"):
        save_cameras(tmp_path / "transforms.json", [replace(a, cam_from_rig=None)])


def test_multical_without_poses(tmp_path):
    cameras = truth(pose=False)
    save_cameras(tmp_path / "calibration.json", cameras)
    assert_same(load_cameras(tmp_path / "calibration.json"), cameras)


def test_rigcal_intrinsics_and_poses_in_a_list(tmp_path):
    SAMPLES["rigcal"].put(tmp_path)
    both = [tmp_path / "rig.csv", tmp_path / "cameras.csv"]
    assert_same(load_cameras(both), truth(RATIONAL))
    assert_same(load_cameras(both[1]), truth(RATIONAL, pose=False))
    with pytest.raises(FileError, match="poses alone"):
        load_cameras(both[0])


def test_rigcal_takes_what_the_program_takes(tmp_path):
    (tmp_path / "cameras.csv").write_bytes(
        b"\xef\xbb\xbfcamera,cx,cy,fx,fy,height,width,note\r\n\r\na,1,2,3,4,6,5,x\r\n"
    )
    expected = Camera(3, 4, 1, 2, (5, 6), (), "brown", "a")
    assert load_cameras(tmp_path / "cameras.csv") == {"a": expected}
    with pytest.raises(FileError, match="blanks"):
        save_cameras(tmp_path / "b.csv", {"left eye": expected})


def test_stored_bytes_are_left_to_the_library(tmp_path, monkeypatch):
    from rigcal.formats import stored

    monkeypatch.setattr(stored, "load_bytes", None)
    monkeypatch.setattr(stored, "save_bytes", None)
    (tmp_path / "rig.bin").write_bytes(b"RIGC\1\0\0\0")
    with pytest.raises(FileError, match="compiled library"):
        load_cameras(tmp_path / "rig.bin")
    with pytest.raises(FileError, match="compiled library"):
        save_cameras(tmp_path / "b.bin", truth())
    monkeypatch.setattr(stored, "load_bytes", lambda data: list(truth().values()))
    monkeypatch.setattr(stored, "save_bytes", lambda cameras: b"RIGC" + bytes(len(cameras)))
    assert_same(load_cameras(tmp_path / "rig.bin"), truth())
    save_cameras(tmp_path / "b.bin", truth())
    assert (tmp_path / "b.bin").read_bytes() == b"RIGC\0\0"


# ==== the two calls ===========================================================


def test_names_of_a_mapping_count(tmp_path):
    camera = truth()["left"]
    save_cameras(tmp_path / "calibration.json", {"a": camera, "b": camera})
    assert list(load_cameras(tmp_path / "calibration.json")) == ["a", "b"]


@pytest.mark.parametrize(
    ("path", "cameras", "options", "what"),
    [
        ("a.yaml", truth(), {}, "pass format="),
        ("a.yaml", truth(), {"format": "opnecv"}, "opnecv"),
        ("a.yaml", {}, {"format": "opencv"}, "no camera to write"),
        ("a.yaml", [1], {"format": "opencv"}, "a Camera is expected, not int"),
        ("a.csv", [truth()["left"]] * 2, {}, "left is there twice"),
        ("a.csv", {"": truth()["left"]}, {}, "needs a name"),
        ("a.csv", {"a\nb": truth()["left"]}, {}, "needs a name"),
        ("{name}.xml", {"a/b": truth()["left"]}, {}, "cannot be that of a file"),
        ("a.csv", truth(), {"scale": 0}, "scale"),
        ("a.csv", truth(), {"scale": "1"}, "scale"),
        ("a.csv", truth(size=None), {}, "left: this format needs the image size"),
        ("model", {"a  b": truth()["left"]}, {"format": "colmap"}, "blanks"),
        (
            "a.mat",
            list(truth().values()) * 1 + [replace(truth()["left"], name="c")],
            {},
            "two",
        ),
        ("a.xml", truth(pose=False), {}, "left: this format needs cam_from_rig"),
    ],
)
def test_what_cannot_be_written(path, cameras, options, what, tmp_path):
    with pytest.raises(FileError, match=what):
        save_cameras(tmp_path / path, cameras, **options)
    assert os.listdir(tmp_path) == []


def test_a_place_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file" / "a.csv"):
        with pytest.raises(FileError):
            save_cameras(path, truth(), "multical")


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"format": "opnecv"}, "opnecv"),
        ({"format": "kalibr"}, "yaml or json is expected for kalibr"),
        ({"lens": "wide"}, "wide"),
        ({"lens": "fisheye"}, "left: the file says that its lens is brown"),
        ({"scale": -1}, "scale"),
        ({"scale": float("nan")}, "scale"),
    ],
)
def test_options_that_do_not_fit(options, what, tmp_path):
    with pytest.raises(FileError, match=what):
        load_cameras(SAMPLES["anipose"].put(tmp_path), **options)


def test_files_that_do_not_belong_together(tmp_path):
    paths = [SAMPLES[name].put(tmp_path) for name in ("anipose", "kalibr")]
    with pytest.raises(FileError, match="several formats: anipose, kalibr"):
        load_cameras(paths)
    with pytest.raises(FileError, match="left is there twice"):
        load_cameras([paths[0], paths[0]])
    with pytest.raises(rigcal.Error, match="no file in the list"):
        load_cameras([])


def test_a_folder_of_two_formats_needs_a_word(tmp_path):
    SAMPLES["rigcal"].put(tmp_path)
    SAMPLES["colmap"].put(tmp_path)
    with pytest.raises(FileError, match='format="colmap" or format="rigcal"'):
        load_cameras(tmp_path)
    assert list(load_cameras(tmp_path, "colmap")) == ["left", "right"]
    assert load_cameras(tmp_path, "rigcal")["left"].dist == RATIONAL[0]


def test_folders_without_cameras(tmp_path):
    with pytest.raises(FileError, match=r"without cameras.csv and cameras.txt"):
        load_cameras(tmp_path)
    (tmp_path / "cameras.bin").write_bytes(b"\1")
    with pytest.raises(FileError, match="model_converter"):
        load_cameras(tmp_path)


def test_two_formats_in_one_document_need_a_word(tmp_path):
    text = SAMPLES["multical"].files["calibration.json"]
    both = text.rstrip()[:-1] + ', "frames": [{"transform_matrix": []}]}'
    (tmp_path / "a.json").write_text(both)
    with pytest.raises(FileError, match='pass format="nerfstudio" or format="multical"'):
        load_cameras(tmp_path / "a.json")
    assert_same(load_cameras(tmp_path / "a.json", "multical"), truth())


def test_content_counts_and_not_the_name(tmp_path):
    for name in SAMPLES:
        sample = SAMPLES[name]
        if len(sample.files) == 1:
            (tmp_path / "file.dat").write_text(next(iter(sample.files.values())))
            assert len(load_cameras(tmp_path / "file.dat", **sample.options)) >= 1


def test_a_list_of_colmap_is_no_folder(tmp_path):
    path = SAMPLES["colmap"].put(tmp_path) / "cameras.txt"
    with pytest.raises(FileError, match="give one folder"):
        load_cameras([path, path])


def test_colmap_counts_blank_lines_for_nothing(tmp_path):
    sample = SAMPLES["colmap-rigs"]
    for name, text in sample.files.items():
        (tmp_path / name).write_text("\n" + text + "\n\n")
    assert_same(load_cameras(tmp_path), sample.truth)


def test_matlab_without_units_is_in_millimetres(tmp_path):
    text = SAMPLES["matlab-json"].files["rig.json"].replace("WorldUnits", "Unit")
    (tmp_path / "rig.json").write_text(text)
    assert_same(load_cameras(tmp_path / "rig.json"), SAMPLES["matlab-json"].truth)


def test_line_ends_of_windows_do_no_harm(tmp_path):
    for name, sample in SAMPLES.items():
        folder = tmp_path / name
        folder.mkdir()
        for file, text in sample.files.items():
            (folder / file).write_bytes(text.replace("\n", "\r\n").encode())
        path = folder if len(sample.files) > 1 else folder / next(iter(sample.files))
        assert_same(load_cameras(path, **sample.options), sample.truth)
