"""Cameras and errors."""

import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from rigcal import Camera, Caveat, Error, FileError, Transform

GOOD = {"fx": 500, "fy": 510, "cx": 320, "cy": 240}


def test_a_camera_has_its_parts_as_plain_numbers():
    camera = Camera(
        **GOOD, size=np.array([640, 480]), dist=np.array([[0.1, 0.2, 0.3, 0.4]])
    )
    assert camera == Camera(500.0, 510.0, 320.0, 240.0, (640, 480), (0.1, 0.2, 0.3, 0.4))
    assert type(camera.fx) is float
    assert type(camera.size[0]) is int
    assert camera.matrix.tolist() == [[500, 0, 320], [0, 510, 240], [0, 0, 1]]
    assert Camera.from_matrix(camera.matrix, size=(640, 480), dist=camera.dist) == camera
    assert hash(camera) == hash(replace(camera, extra={"a": []}))
    assert pickle.loads(pickle.dumps(camera)) == camera
    with pytest.raises(FrozenInstanceError):
        camera.fx = 1


def test_coefficients_have_the_library_s_names():
    names = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]
    brown = Camera(**GOOD, dist=range(1, 9)).coefficients
    assert brown == dict(zip(names, range(1, 9)))
    fisheye = Camera(**GOOD, dist=(1, 2, 3, 4), lens="fisheye").coefficients
    assert fisheye == {
        "k1": 1,
        "k2": 2,
        "k3": 3,
        "k4": 4,
        "p1": 0,
        "p2": 0,
        "k5": 0,
        "k6": 0,
    }
    assert not any(Camera(**GOOD).coefficients.values())


@pytest.mark.parametrize("count", [12, 14])
def test_coefficients_of_longer_models_may_be_zero(count):
    dist = [*range(1, 9), *[0.0] * (count - 8)]
    assert Camera(**GOOD, dist=dist).dist == tuple(range(1, 9))
    for k in range(8, count):
        what = "thin prism" if k < 12 else "tilted sensor"
        with pytest.raises(Error, match=f"{what} .*is not supported"):
            Camera(**GOOD, dist=[*dist[:k], 0.1, *dist[k + 1 :]])


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"fx": 0}, "fx: a focal length above 0"),
        ({"fy": -1}, "fy: a focal length above 0"),
        ({"fx": 1e10}, "fx: a focal length"),
        ({"fx": np.nan}, "fx: an element is NaN"),
        ({"fx": "wide"}, "fx: numbers"),
        ({"fx": [500, 510]}, r"fx: shape \(\)"),
        ({"cx": np.inf}, "cx: an element is NaN or infinite"),
        ({"cy": 2e9}, "cy: the principal point"),
        ({"size": (640,)}, r"size: shape \(2,\)"),
        ({"size": (640, 0)}, "size: whole pixels, 1 to 1000000, are expected, not 0"),
        ({"size": (640.5, 480)}, "size: whole pixels"),
        ({"size": (640, 2000000)}, "size: whole pixels"),
        ({"size": "big"}, "size: numbers"),
        ({"dist": (1, 2, 3)}, "dist: 0, 4, 5 or 8 coefficients are expected, not 3"),
        ({"dist": (1, 2, 3, np.nan)}, "dist: an element is NaN"),
        ({"dist": (1, 2, 3, 1e10)}, "dist: a coefficient is beyond 1e9"),
        ({"dist": "k"}, "dist: numbers"),
        ({"dist": None}, "dist: "),
        ({"dist": [1j, 0, 0, 0]}, "dist: numbers"),
        ({"dist": (1, 2, 3, 4, 5), "lens": "fisheye"}, "a fisheye has 4 coefficients"),
        ({"lens": "omni"}, 'lens: "brown" or "fisheye" is expected, not \'omni\''),
        ({"name": 3}, "name: text"),
        ({"cam_from_rig": np.eye(4)}, "cam_from_rig: a Transform"),
    ],
)
def test_what_is_no_camera(changes, what):
    with pytest.raises(Error, match=what):
        Camera(**{**GOOD, **changes})


@pytest.mark.parametrize(
    ("K", "what"),
    [
        ([[500, 1, 320], [0, 510, 240], [0, 0, 1]], "skew is not supported, and it is 1"),
        ([[500, 0, 320], [1, 510, 240], [0, 0, 1]], "fx 0 cx, 0 fy cy, 0 0 1"),
        ([[500, 0, 0], [0, 510, 0], [320, 240, 1]], "fx 0 cx, 0 fy cy, 0 0 1"),
        (np.eye(2), r"K: shape \(3, 3\)"),
    ],
)
def test_what_is_no_matrix_of_a_camera(K, what):
    with pytest.raises(Error, match=what):
        Camera.from_matrix(K)


def test_a_camera_with_its_pose():
    T = Transform.identity("left", "rig")
    assert Camera(**GOOD, cam_from_rig=T, name="left") != Camera(**GOOD, name="left")


def test_errors_have_their_parts():
    error = Error("a point is not in front of the camera", "RIGCAL_ERR_BEHIND", 3)
    assert str(error) == "RIGCAL_ERR_BEHIND: a point is not in front of the camera"
    assert (error.name, error.text, error.bad) == (
        *("RIGCAL_ERR_BEHIND", "a point is not in front of the camera"),
        3,
    )
    assert isinstance(error, ValueError)
    again = pickle.loads(pickle.dumps(error))
    assert (again.name, again.text, again.bad) == (error.name, error.text, 3)
    file = FileError("a.yaml", "what")
    assert (str(file), file.path, file.what, file.name) == (
        "a.yaml: what",
        "a.yaml",
        "what",
        "",
    )
    assert str(pickle.loads(pickle.dumps(file))) == "a.yaml: what"
    assert issubclass(FileError, Error)
    assert issubclass(Caveat, UserWarning)
