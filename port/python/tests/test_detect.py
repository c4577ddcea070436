"""Detectors find their own corners, in the order and with the origin that rigcal states."""

from __future__ import annotations

import sys
import warnings

import image_scenes as scenes
import numpy as np
import pytest

import rigcal
from rigcal.detect import detectors, read_picture
from rigcal.detect.pictures import grey

cv2 = scenes.cv2
pupil_apriltags = pytest.importorskip("pupil_apriltags")
GRID = rigcal.AprilGrid(3, 2, 0.05, 0.3)
FACING = [np.pi, 0, 0]  # a target whose z axis comes out of it, looked at


def pose_of(target, rvec, distance=0.45):
    """cam_from_target, turned by rvec from facing the camera."""
    tilt = rigcal.Transform.from_rvec(rvec, [0, 0, 0], "cam", "x")
    if target.front[2] > 0:
        face = rigcal.Transform.from_rvec(FACING, [0, 0, 0], "x", "target")
        tilt = tilt @ face
    return scenes.looking_at(target, tilt.rvec, distance)


def seen_by(target, image, **how):
    found = rigcal.detect({"cam": [image]}, target, **how)
    return {p: np.array([u, v]) for p, u, v in zip(found.point.tolist(), found.u, found.v)}


def real(name):
    return cv2.imread(str(scenes.DATA / name), cv2.IMREAD_GRAYSCALE)


# ---- the detector's own corners on real images --------------------------------


@pytest.mark.parametrize("name", ["left01.jpg", "left11.jpg", "right05.jpg"])
def test_chessboard_is_opencvs(name):
    image = real(name)
    _, rough = cv2.findChessboardCorners(image, (9, 6))
    own = cv2.cornerSubPix(image, rough, (5, 5), (-1, -1), (3, 100, 1e-6)).reshape(-1, 2)
    found = seen_by(rigcal.Chessboard(9, 6, 0.025), image)
    assert list(found) == [str(k) for k in range(54)]
    assert np.abs(np.array(list(found.values())) - own).max() < 1e-6


def test_sector_detector_is_opencvs():
    image = real("left01.jpg")
    uv = detectors.detector(rigcal.Chessboard(9, 6, 1), {"sector": True}).corners(
        np.full((60, 80), 128, np.uint8)
    )
    assert uv is None
    board = rigcal.Chessboard(9, 6, 0.025)
    _, own = cv2.findChessboardCornersSB(image, (9, 6))
    ordered = detectors.in_order(image, own.reshape(-1, 2).astype(float), board)
    classic = np.array(list(seen_by(board, image).values()))
    assert (
        np.hypot(*(ordered - classic).T).max() < 1.0
    )  # the same corner has the same number


def test_charuco_is_opencvs():
    image = cv2.imread(str(scenes.HTML / "choriginal.jpg"))
    aruco = cv2.aruco
    board = aruco.CharucoBoard(
        (5, 7), 0.04, 0.02, aruco.getPredefinedDictionary(aruco.DICT_6X6_250)
    )
    uv, ids, _, _ = aruco.CharucoDetector(board).detectBoard(
        cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    )
    target = rigcal.Charuco(5, 7, 0.04, 0.02, "6X6_250")
    found = seen_by(target, image)
    assert list(found) == [str(k) for k in ids.ravel()]
    assert np.abs(np.array(list(found.values())) - uv.reshape(-1, 2)).max() < 1e-6
    points = np.array([target.points[name] for name in found])
    assert np.abs(points - board.getChessboardCorners()[ids.ravel()]).max() < 1e-7


def test_aruco_tags_are_opencvs():
    image = cv2.imread(str(scenes.HTML / "singlemarkersoriginal.jpg"), cv2.IMREAD_GRAYSCALE)
    aruco = cv2.aruco
    parameters = aruco.DetectorParameters()
    parameters.cornerRefinementMethod = aruco.CORNER_REFINE_SUBPIX
    own, ids, _ = aruco.ArucoDetector(
        aruco.getPredefinedDictionary(aruco.DICT_6X6_250), parameters
    ).detectMarkers(image)
    camera = rigcal.Camera(500, 500, 319.5, 239.5, size=(640, 480))
    assert len(ids) == 6
    for number, corners in zip(ids.ravel().tolist(), own):
        tag = rigcal.Tag(0.05, number, "DICT_6X6_250")
        found = seen_by(tag, image)
        assert list(found) == [f"{number}_{k}" for k in range(4)]
        uv = np.array(list(found.values()))
        assert np.abs(uv - corners.reshape(4, 2)).max() < 1e-6
        assert faces(camera, tag, uv)


def test_apriltags_are_the_librarys_less_half_a_pixel(rng):
    # a photograph with tags in it: an upright one, and one that hangs upside down
    image = real("left03.jpg")
    tags, boxes = {}, {7: (40, 60, 0), 12: (420, 280, 2)}
    for number, (left, top, turn) in boxes.items():
        drawing, _, _ = scenes.grid_drawing(rigcal.AprilGrid(1, 1, 0.05, 0.3, first=number))
        image[top : top + 128, left : left + 128] = np.rot90(
            cv2.GaussianBlur(drawing, (0, 0), 0.8)[:128, :128], turn
        )
    own = pupil_apriltags.Detector(families="tag36h11").detect(image)
    assert {tag.tag_id for tag in own} == set(boxes)
    camera = rigcal.Camera(530, 530, 319.5, 239.5, size=(640, 480))
    for tag in own:
        target = rigcal.Tag(0.05, tag.tag_id)
        found = np.array(list(seen_by(target, image).values()))
        assert np.abs(found - (tag.corners[[3, 2, 1, 0]] - 0.5)).max() < 1e-6
        tags[tag.tag_id] = found
        assert faces(camera, target, found)
    left, top, _ = boxes[7]
    expected = np.array([[24, 24], [104, 24], [104, 104], [24, 104]]) - 0.5 + [left, top]
    assert np.abs(tags[7] - expected).max() < 0.35  # not a pixel's half off, and upright
    assert tags[12][0, 1] > tags[12][2, 1]  # its top left is below


def faces(camera, target, uv):
    """Whether the pose from a view has the target's front towards the camera."""
    X = np.array(list(target.points.values()))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)  # a small tag has two poses
        return front_towards(target, rigcal.solve_pose(camera, X, uv).cam_from_world)


def front_towards(target, pose):
    middle = np.array(list(target.points.values())).mean(axis=0)
    return (pose.R @ np.array(target.front)) @ (pose.R @ middle + pose.t) < 0


# ---- order, origin and front of each -------------------------------------------

TARGETS = [
    rigcal.Chessboard(7, 4, 0.03),
    rigcal.Chessboard(7, 4, 0.03, inverted=True),
    rigcal.Charuco(4, 5, 0.04, 0.03),
    rigcal.Charuco(5, 4, 0.04, 0.03, legacy=True),
    rigcal.Charuco(4, 5, 0.04, 0.03, inverted=True),
    GRID,
    rigcal.AprilGrid(3, 2, 0.05, 0.3, "APRILTAG_36h11"),
]


@pytest.mark.parametrize("target", TARGETS, ids=lambda t: f"{t.kind}-{TARGETS.index(t)}")
@pytest.mark.parametrize("roll", [0.2, 3.0])
def test_corners_are_where_they_are_drawn(target, roll, rng):
    camera = scenes.pinhole()
    pose = pose_of(target, [0.25, -0.2, 0])
    turn = rigcal.Transform.from_rvec([0, 0, roll], [0, 0, 0], "cam", "cam")
    pose = rigcal.Transform((turn @ pose).R, (turn @ pose).t, "cam", "target")
    found = seen_by(target, scenes.show(target, camera, pose, rng))
    true = scenes.truth(target, camera, pose)
    assert len(found) >= 0.9 * len(true)
    off = np.array([found[name] - true[name] for name in found])
    assert np.abs(off).max() < 0.5
    assert np.abs(off.mean(axis=0)).max() < 0.15
    X = np.array([target.points[name] for name in found])
    solved = rigcal.solve_pose(camera, X, np.array(list(found.values())))
    assert front_towards(target, solved.cam_from_world)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("size", [(7, 4), (6, 4), (5, 5)])
def test_any_order_of_a_detector_becomes_the_same(size, inverted, rng):
    board, camera = rigcal.Chessboard(*size, 0.03, inverted), scenes.pinhole()
    pose = scenes.looking_at(board, [0.2, -0.1, 0.4], 0.4)
    image = scenes.show(board, camera, pose, rng)
    true = np.array(list(scenes.truth(board, camera, pose).values()))
    table = true.reshape(size[1], size[0], 2)
    orders = [table, table[::-1, ::-1], table[::-1], table[:, ::-1]]
    if size[0] == size[1]:
        orders += [np.rot90(table, k) for k in (1, 3)] + [table.transpose(1, 0, 2)]
    readings = [true, *(true[p] for p in board.symmetry)]
    for order in orders:
        found = detectors.in_order(image, order.reshape(-1, 2).copy(), board)
        assert any((found == reading).all() for reading in readings)


@pytest.mark.parametrize("size", [(6, 4), (5, 3), (4, 4), (5, 5)])
def test_symmetric_chessboards_are_read_from_the_front(size, rng):
    target, camera = rigcal.Chessboard(*size, 0.03), scenes.pinhole()
    assert len(target.symmetry) == (3 if size == (4, 4) else 1)
    for roll in (0.0, 1.5, 3.0):
        pose = scenes.looking_at(target, [0.0, 0.0, roll], 0.4)
        found = np.array(
            list(seen_by(target, scenes.show(target, camera, pose, rng)).values())
        )
        true = np.array(list(scenes.truth(target, camera, pose).values()))
        readings = [true, *(true[p] for p in target.symmetry)]
        assert min(np.abs(found - uv).max() for uv in readings) < 0.35


def blurred(part):
    return cv2.GaussianBlur(part, (0, 0), 4)


def reflecting(part):
    part = part.copy()
    part[7:22, 16:23] = 255
    return part


def small_reflection(part):
    part = part.copy()
    part[12:17, 15:19] = 255
    return part


@pytest.mark.parametrize(
    ("spoil", "least"), [(blurred, 1.4), (reflecting, 4), (small_reflection, 2)]
)
def test_hardly_seen_corners_have_a_larger_sigma(spoil, least, rng):
    target, camera = rigcal.Chessboard(7, 4, 0.03), scenes.pinhole()
    pose = scenes.looking_at(target, [0.2, 0.1, 0], 0.4)
    image = scenes.show(target, camera, pose, rng)
    u, v = np.round(scenes.truth(target, camera, pose)["10"]).astype(int)
    around = np.s_[v - 14 : v + 15, u - 14 : u + 15]
    image[around] = spoil(image[around])
    found = rigcal.detect({"cam": [image]}, target)
    sigma = dict(zip(found.point.tolist(), found.sigma_px))
    assert np.median(found.sigma_px) == pytest.approx(1)
    assert sigma["10"] > least
    assert max(s for name, s in sigma.items() if name != "10") < 1.3


# ---- targets ---------------------------------------------------------------------


def test_tags_on_a_body():
    up = rigcal.Transform.from_rvec([0, 0, 0], [1, 2, 3], "body", "tag")
    body = rigcal.Tags({3: up, 4: [[0, 1, 0], [1, 1, 0], [1, 0, 0], [0, 0, 0]]}, size=0.2)
    assert body.points["3_0"].tolist() == [0.9, 2.1, 3]
    assert body.points["4_2"].tolist() == [1, 0, 0]
    assert str(body) == "2 tags of tag36h11"
    assert body.symmetry == []
    with pytest.raises(rigcal.Error, match="size, the edge of a tag, is needed"):
        rigcal.Tags({3: up})
    with pytest.raises(rigcal.Error, match="there is no tag"):
        rigcal.Tags({})
    with pytest.raises(rigcal.Error, match="tag 3: shape"):
        rigcal.Tags({3: [1, 2]})


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: rigcal.Chessboard(9.5, 6, 1), "columns: a whole number"),
        (lambda: rigcal.Chessboard(2, 6, 1), "columns: 3 to 1000"),
        (lambda: rigcal.Chessboard(9, 6, 0), "square: a length above 0"),
        (lambda: rigcal.Charuco(4, 5, 0.03, 0.04), "marker: less than the square"),
        (lambda: rigcal.AprilGrid(6, 6, 0.1, -1), "spacing: a length"),
        (lambda: rigcal.Tag(0.1, id=-1), "id: a number of a tag"),
    ],
)
def test_what_is_no_target(make, text):
    with pytest.raises(rigcal.Error, match=text):
        make()


def test_detectors_refuse_what_they_do_not_know(monkeypatch):
    board, tag = rigcal.Chessboard(9, 6, 1), rigcal.Tag(1)
    for target, options, text in (
        (board, {"windw": 1}, "'windw'.* are not known"),
        (rigcal.Charuco(4, 5, 2, 1), {"no": 1}, "'no' is no parameter"),
        (tag, {"no": 1}, "unexpected keyword"),
        (rigcal.Tag(1, family="tag37"), {}, "no family of AprilTag .* no dictionary"),
        ("board", {}, "target: a Chessboard, .* not str"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            detectors.detector(target, options)
    monkeypatch.setitem(sys.modules, "pupil_apriltags", None)
    with pytest.raises(rigcal.Error, match=r'pip install "rigcal\[detect\]"'):
        detectors.detector(tag)
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(rigcal.Error, match=r'pip install "rigcal\[detect\]"'):
        detectors.detector(board)


def test_options_reach_the_detector():
    image = real("left01.jpg")
    board = rigcal.Chessboard(9, 6, 0.025)
    wide = seen_by(board, image, detector={"window": 8})
    off = [np.abs(wide[name] - uv).max() for name, uv in seen_by(board, image).items()]
    assert 0 < max(off) < 1


def test_pictures():
    image = np.zeros((4, 6, 4), np.uint16)
    image[..., :3] = 1000
    assert grey(image).shape == (4, 6)
    assert grey(image)[0, 0] == round(1000 * 255 / 1023)
    assert grey(np.full((4, 6, 1), 7, np.uint8)).tolist() == [[7] * 6] * 4
    with pytest.raises(rigcal.FileError, match="no image that OpenCV reads"):
        read_picture(__file__)
    with pytest.raises(rigcal.FileError, match="no video that OpenCV reads"):
        read_picture((__file__, 0))


@pytest.mark.parametrize(
    "target",
    [
        rigcal.Chessboard(9, 6, 0.025),
        rigcal.Charuco(4, 5, 0.054, 0.0405),
        rigcal.AprilGrid(6, 6, 0.088, 0.3),
        rigcal.Tag(0.16, family="4X4_50"),
    ],
)
def test_a_picture_of_a_few_pixels_shows_nothing(target):
    for size in ((1, 1), (2, 2), (1, 640), (2, 640), (640, 2), (12, 12), (5, 5000)):
        with pytest.raises(rigcal.Error, match="none of 1 pictures"):
            rigcal.detect({"a": [np.zeros(size, np.uint8)]}, target)


def test_options_of_detect_that_do_not_fit():
    image = np.zeros((100, 100), np.uint8)
    for options, text in (
        ({"threads": 0}, "threads: a whole number from 1"),
        ({"threads": "x"}, "threads: a whole number from 1"),
        ({"detector": 3}, "detector: options by name, not int"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.detect({"a": [image]}, rigcal.Chessboard(9, 6, 0.025), **options)
