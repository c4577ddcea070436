"""Mistakes that people make: each is named."""

from __future__ import annotations

import re
import warnings

import image_scenes as scenes
import numpy as np
import pytest
from conftest import ROOT

import rigcal
from rigcal.detect import mistakes
from rigcal.detect.pictures import grey, read_picture

cv2 = scenes.cv2
CAMERAS = ROOT / "examples/data/opencv_stereo/cameras.csv"
LEFT, RIGHT = (str(scenes.DATA / f"{side}0*.jpg") for side in ("left", "right"))
BOARD = rigcal.Chessboard(9, 6, 0.025)
FEW = ("01", "03", "05", "07")


def pictures(side, numbers=FEW):
    return [str(scenes.DATA / f"{side}{number}.jpg") for number in numbers]


def quiet(call, *given, **how):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", rigcal.Caveat)
        result = call(*given, **how)
    return result, [str(w.message) for w in caught]


@pytest.fixture(scope="module")
def stereo():
    return quiet(rigcal.detect, {"left": LEFT, "right": RIGHT}, BOARD)[0]


@pytest.fixture(scope="module")
def rig(stereo):
    return quiet(rigcal.calibrate, CAMERAS, stereo)[0]


def test_wrong_board_size():
    for size in ((10, 7), (9, 5)):
        with pytest.raises(
            rigcal.Error, match="the images show a chessboard of 9 x 6 inner"
        ):
            rigcal.detect(
                {"left": pictures("left", FEW[:2])}, rigcal.Chessboard(*size, 0.025)
            )


def test_board_of_which_a_part_is_found():
    with pytest.warns(rigcal.Caveat, match=r"not of 8 x 6 .* seems to have 9 x 6 inner"):
        rigcal.detect({"left": pictures("left")}, rigcal.Chessboard(8, 6, 0.025))


def test_wrong_square(stereo, rig):
    known = {name: rig[name] for name in rig}
    X = {axis: 1.2 * stereo[axis] for axis in "XYZ"}
    large = rigcal.Detections(
        **{**dict(stereo), **X}, target=rigcal.Chessboard(9, 6, 0.030)
    )
    text = "all lengths are 1.2 of those. Is a square 0.025, not 0.03?"
    assert text in quiet(rigcal.calibrate, known, large)[1][0]
    # without a rig that is known it cannot be seen, and a right one is not blamed
    assert quiet(rigcal.calibrate, CAMERAS, large)[1] == []
    assert quiet(rigcal.calibrate, known, stereo)[1] == []


def test_left_and_right_swapped(rig):
    swapped, _ = quiet(rigcal.detect, {"left": RIGHT, "right": LEFT}, BOARD)
    _, told = quiet(rigcal.calibrate, CAMERAS, swapped)
    assert "left and right fit with the other's intrinsics" in told[0]
    _, told = quiet(rigcal.calibrate, {name: rig[name] for name in rig}, swapped)
    assert "the file with left and right exchanged: are their images swapped?" in told[1]
    with pytest.warns(rigcal.Caveat, match="camera left is given right01.jpg"):
        rigcal.detect(
            {"left": pictures("right", ["01"]), "right": pictures("left", ["01"])}, BOARD
        )


def test_blurred_images():
    images = [cv2.GaussianBlur(read_picture(path), (0, 0), 9) for path in pictures("left")]
    with pytest.raises(rigcal.Error, match=r"the images are blurred: .* px wide"):
        rigcal.detect({"left": images}, BOARD)
    sharp = [read_picture(path) for path in pictures("left")]
    with pytest.warns(rigcal.Caveat, match=r"camera left: 0000 is blurred: .* in 1 of 1"):
        rigcal.detect({"left": images[:1] + sharp}, BOARD)
    assert max(mistakes.edge_width(image) for image in sharp) < 4


def test_images_blurred_by_motion():
    """Blur in one direction: edges along it stay sharp."""
    sharp = [read_picture(path) for path in pictures("left")]
    for kernel in (np.ones((1, 19)) / 19, np.ones((19, 1)) / 19, np.eye(19) / 19):
        moved = cv2.filter2D(sharp[0], -1, kernel)
        assert mistakes.edge_width(moved) > mistakes.BLURRED
        with pytest.warns(rigcal.Caveat, match="camera left: 0000 is blurred: edges are"):
            rigcal.detect({"left": [moved, *sharp[1:]]}, BOARD)
    # and it is not taken for another board where all are blurred
    kernel = np.eye(25) / 25
    moved = [
        cv2.filter2D(read_picture(p), -1, kernel) for p in pictures("left", ("01", "14"))
    ]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rigcal.detect({"left": [*moved, sharp[1]]}, BOARD)
    assert [str(w.message)[:37] for w in caught] == [
        "camera left: 0000, 0001 are blurred: "
    ]


def test_a_picture_that_is_upside_down():
    cameras = rigcal.load_cameras(CAMERAS)
    left, right = ([read_picture(path) for path in pictures(s)] for s in ("left", "right"))
    left[1] = np.rot90(left[1], 2).copy()
    found, _ = quiet(rigcal.detect, {"left": left, "right": right}, BOARD)
    _, told = quiet(rigcal.calibrate, cameras, found)
    assert told[0].startswith("camera left in frame 0001: its picture is upside down")
    assert not any("upside" in text for text in told[1:])


@pytest.mark.parametrize("board", [(9, 6), (8, 6), (8, 5)])
def test_a_camera_whose_pictures_are_mirrored(board):
    target = rigcal.Chessboard(*board, 0.03)
    cameras, images = scenes.moving_rig(target, 6, (0, 0, 0), 3.0)
    images["cam1"] = [np.ascontiguousarray(x[:, ::-1]) for x in images["cam1"]]
    bare = {n: rigcal.Camera(c.fx, c.fy, c.cx, c.cy, c.size) for n, c in cameras.items()}
    found, _ = quiet(rigcal.detect, images, target)
    _, told = quiet(rigcal.calibrate, bare, found)
    assert any(text.startswith("are the pictures of cam1 mirrored?") for text in told), told


def test_markers_in_a_mirror():
    for target in (rigcal.Charuco(5, 4, 0.05, 0.037), rigcal.AprilGrid(3, 2, 0.05, 0.3)):
        image = (
            shown(target, 1)[0] if isinstance(target, rigcal.Charuco) else facing(target)
        )
        with pytest.raises(
            rigcal.Error, match=r"mirrored, 1 of the images have \d+ corners"
        ):
            rigcal.detect({"a": [np.ascontiguousarray(image[:, ::-1])]}, target)


def test_a_source_that_is_given_twice(stereo):
    left = pictures("left")
    twice = {"left": left, "right": [*left[:3], pictures("right")[3]]}
    _, told = quiet(rigcal.calibrate, CAMERAS, quiet(rigcal.detect, twice, BOARD)[0])
    assert told[0].startswith(
        "cameras left and right have the same picture in 3 of 4 frames"
    )
    assert not any("twice" in text for text in quiet(rigcal.calibrate, CAMERAS, stereo)[1])


def test_files_that_are_broken(tmp_path):
    data = (scenes.DATA / "left01.jpg").read_bytes()
    (tmp_path / "left1.jpg").write_bytes(b"")
    with pytest.raises(
        rigcal.FileError, match=r"left1\.jpg: this is no image .*: the file is empty"
    ):
        rigcal.detect([tmp_path], BOARD)
    (tmp_path / "left1.jpg").write_bytes(data)
    (tmp_path / "left2.jpg").write_bytes(data[: len(data) // 2])
    with pytest.warns(rigcal.Caveat, match=r"left2\.jpg is cut off"):
        rigcal.detect([tmp_path], BOARD)
    (tmp_path / "a.mp4").write_bytes(b"")
    (tmp_path / "b.mp4").write_bytes(b"no video")
    for name, text in (
        ("a", "this is no video that OpenCV reads: the file is empty"),
        ("b", "this is no video that OpenCV reads"),
    ):
        with pytest.raises(rigcal.FileError, match=rf"{name}\.mp4: {text}"):
            rigcal.detect([tmp_path / f"{name}.mp4"], BOARD)


def test_a_folder_of_folders(tmp_path):
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
    with pytest.raises(
        rigcal.FileError, match="in this folder; give its folders: left, right"
    ):
        rigcal.detect([tmp_path], BOARD)


def test_another_kind_of_board():
    whole = read_picture(pictures("left", FEW[:1])[0])
    images = [cv2.resize(whole, (320, 240), interpolation=cv2.INTER_AREA)]
    for target, text in (
        (rigcal.Chessboard(12, 9, 0.025), "show a chessboard of 9 x 6 inner corners"),
        (rigcal.Charuco(5, 4, 0.04, 0.03), "9 x 6 inner corners: is it a Chessboard"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.detect({"left": images}, target)
    charuco = shown(rigcal.Charuco(5, 4, 0.05, 0.037), 2)
    with pytest.raises(
        rigcal.Error, match="markers of 4X4_1000 are there: is it a ChArUco"
    ):
        rigcal.detect({"left": charuco}, rigcal.Chessboard(7, 5, 0.05))


def test_no_detection():
    image = cv2.resize(read_picture(str(scenes.DATA / "fruits.jpg")), (240, 180))
    with pytest.raises(
        rigcal.Error, match="inner corners is in none of 2 pictures; is the"
    ):
        rigcal.detect({"left": [image, image]}, BOARD)
    dark = (cv2.resize(image, (120, 90)) // 12).astype(np.uint8)
    with pytest.raises(rigcal.Error, match="little contrast"):
        rigcal.detect({"left": [dark]}, BOARD)
    bigger = cv2.resize(image, (640, 480))
    with pytest.warns(rigcal.Caveat, match="camera right: a chessboard .* in none of 4"):
        rigcal.detect({"left": pictures("left"), "right": [bigger] * 4}, BOARD)


def test_two_boards_in_an_image():
    left = [read_picture(path) for path in pictures("left")]
    two = [np.hstack([left[0], left[1]]), *(np.hstack([x, x // 2 + 60]) for x in left[2:])]
    one = np.hstack([left[1], np.full_like(left[1], 128)])
    with pytest.warns(rigcal.Caveat, match=r"camera left: 0000, .* shows two boards"):
        found = rigcal.detect({"left": [*two, one]}, BOARD)
    assert found.frames == ["0003"]
    with pytest.raises(rigcal.Error, match="no picture of 3 shows one target alone"):
        rigcal.detect({"left": two}, BOARD)


def test_a_tag_twice():
    drawing, _, _ = scenes.grid_drawing(rigcal.AprilGrid(1, 1, 0.05, 0.3, first=3))
    image = np.hstack([drawing, drawing])
    with pytest.raises(rigcal.Error, match=r"shows one target alone\n.* or a tag twice"):
        rigcal.detect({"a": [image]}, rigcal.Tag(0.1, 3))


def test_rotated_video(tmp_path):
    images = [read_picture(path) for path in pictures("left")]
    path = scenes.write_video(tmp_path / "left.mp4", images)
    data = bytearray((tmp_path / "left.mp4").read_bytes())
    matrix = data.index(b"tkhd") + 4 + 40  # of a track: its picture is turned by 90 degrees
    turned = [0, 1 << 16, 0, -(1 << 16), 0, 0, 480 << 16, 0, 1 << 30]
    data[matrix : matrix + 36] = b"".join(
        (x % (1 << 32)).to_bytes(4, "big") for x in turned
    )
    (tmp_path / "left.mp4").write_bytes(data)
    with pytest.warns(
        rigcal.Caveat, match="the video says that it is turned by (90|270) degr"
    ):
        found = rigcal.detect([path], BOARD)
    assert found.sizes == {"left": (640, 480)}
    upright = {"left": scenes.pinhole("left", (480, 640))}
    with pytest.raises(rigcal.Error, match=r"turned by 90 degrees \(the file says"):
        rigcal.detect([path], BOARD, cameras=upright)


def test_images_of_another_size(stereo):
    cameras = rigcal.load_cameras(CAMERAS)
    turned = [np.rot90(read_picture(path)).copy() for path in pictures("left", ["01"])]
    small = [
        cv2.resize(read_picture(path), (320, 240)) for path in pictures("left", ["01"])
    ]
    cut = [read_picture(path)[:400] for path in pictures("left", ["01"])]
    right = pictures("right", ["01"])
    for images, text in (
        (
            turned,
            "480 x 640 pixels, its intrinsics are for 640 x 480: they are turned by 90",
        ),
        (small, "they are scaled by 0.5"),
        (cut, "they are cropped"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.detect({"left": images, "right": right}, BOARD, cameras=cameras)
    with pytest.raises(
        rigcal.Error, match="0001 has 480 x 640 pixels, turned by 90 degrees"
    ):
        rigcal.detect({"left": [read_picture(right[0]), *turned]}, BOARD)
    half = {n: scenes.pinhole(n, (320, 240)) for n in ("left", "right")}
    with pytest.raises(rigcal.Error, match="they are scaled by 2"):
        rigcal.calibrate(half, stereo)
    with pytest.raises(rigcal.Error, match="left, right are not among the cameras, a"):
        rigcal.calibrate({"a": half["left"]}, stereo)


def test_grey_and_colour():
    images = [read_picture(path) for path in pictures("left")]
    mixed = [cv2.cvtColor(images[0], cv2.COLOR_GRAY2BGR), *images[1:]]
    mixed[1] = cv2.cvtColor(images[1], cv2.COLOR_GRAY2BGRA)
    with pytest.warns(rigcal.Caveat, match="2 pictures are in colour and 2 are grey"):
        found = rigcal.detect({"left": mixed}, BOARD)
    plain = rigcal.detect({"left": images}, BOARD)
    assert np.abs(found.u - plain.u).max() < 1e-3


def test_16_bit_png(tmp_path):
    images = [read_picture(path) for path in pictures("left", FEW[:2])]
    for k, image in enumerate(images):
        cv2.imwrite(str(tmp_path / f"{k}.png"), image.astype(np.uint16) * 16)
    with pytest.warns(
        rigcal.Caveat, match="2 pictures have 16 bits a value, of which 12 are"
    ):
        found = rigcal.detect({"left": tmp_path}, BOARD)
    plain = rigcal.detect({"left": images}, BOARD)
    assert np.abs(found.u - plain.u).max() < 0.1


def test_turned_by_exif(tmp_path):
    data = (scenes.DATA / "left01.jpg").read_bytes()
    exif = b"\xff\xe1\0\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01"
    exif += b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    (tmp_path / "left1.jpg").write_bytes(data[:2] + exif + data[2:])
    with pytest.warns(rigcal.Caveat, match="left1.jpg says in its EXIF .* by 90 degrees"):
        found = rigcal.detect([str(tmp_path / "left*.jpg")], BOARD)
    assert found.sizes == {"left1": (640, 480)}


# ---- other targets --------------------------------------------------------------


def shown(target, count=3):
    camera, rng = scenes.pinhole(), np.random.default_rng(2)
    tilts = ([0.2, 0.1 * k, 0.1] for k in range(count))
    return [
        scenes.show(target, camera, scenes.looking_at(target, r, 0.5), rng) for r in tilts
    ]


@pytest.mark.parametrize(
    ("is_", "given", "text"),
    [
        ({"inverted": True}, {}, "with inverted=True there are"),
        ({"rows": 4, "legacy": True}, {"rows": 4}, "with legacy=True there are"),
        ({}, {"columns": 5, "rows": 4}, "with columns=4, rows=5 there are"),
        (
            {},
            {"dictionary": "5X5_100"},
            "markers of 4X4_1000 are there: is 5X5_100 the right",
        ),
    ],
)
def test_charuco_of_another_pattern(is_, given, text):
    plain = {"columns": 4, "rows": 5, "square": 0.05, "marker": 0.037}
    images = shown(rigcal.Charuco(**{**plain, **is_}))
    with pytest.raises(rigcal.Error, match=text):
        rigcal.detect({"a": images}, rigcal.Charuco(**{**plain, **given}))


def facing(target):
    camera, rng = scenes.pinhole(), np.random.default_rng(2)
    return scenes.show(target, camera, scenes.looking_at(target, [np.pi, 0, 0], 0.45), rng)


def test_tags_of_other_numbers_and_families():
    image = facing(rigcal.AprilGrid(3, 2, 0.05, 0.3, first=10))
    for target, text in (
        (rigcal.Tag(0.05, id=3), r"tags of the family, with the numbers \[10, 11"),
        (rigcal.Tag(0.05), r"tags \[10, 11, .* are seen: say which"),
        (rigcal.AprilGrid(3, 2, 0.05, 0.3, "tag25h9"), "there are tags of tag36h11"),
        (
            rigcal.AprilGrid(3, 2, 0.05, 0.3, "5X5_50"),
            "markers of APRILTAG_36h11 are there",
        ),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.detect({"a": [image]}, target)
    one = facing(rigcal.AprilGrid(1, 1, 0.1, 0.3, first=9))
    assert rigcal.detect({"a": [one]}, rigcal.Tag(0.1)).target == rigcal.Tag(0.1, 9)
    with pytest.raises(rigcal.Error, match="a tag of tag36h11 is in none"):
        rigcal.detect({"a": [np.full((90, 120), 90, np.uint8)]}, rigcal.Tag(0.1))


def test_words_of_messages_are_plain():
    images = [grey(read_picture(pictures("left")[0]))]
    text = mistakes.why_nothing(images, rigcal.Chessboard(10, 7, 1))
    assert re.fullmatch(r"the images show .*: count the corners .*, not the squares", text)
    assert mistakes.why_nothing([], BOARD) == ""
    assert mistakes.edge_width(np.full((20, 20), 9, np.uint8)) == 0
    assert mistakes.edge_width(np.full((2, 20), 9, np.uint8)) == 0
