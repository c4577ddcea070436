"""Sources: which pictures are found, how cameras are named, and which pictures belong
together."""

from __future__ import annotations

import struct

import image_scenes as scenes
import numpy as np
import pytest

import rigcal
from rigcal.detect import sources
from rigcal.detect.pictures import exif_turn

cv2 = scenes.cv2
BOARD = rigcal.Chessboard(5, 4, 0.03)


@pytest.fixture(scope="module")
def image():
    return scenes.show(
        BOARD, scenes.pinhole(size=(240, 180), focal=300),
        scenes.looking_at(BOARD, [0.2, -0.1, 0.1], 0.35), np.random.default_rng(1),
    )  # fmt: skip


def write(folder, names, image):
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        cv2.imwrite(str(folder / name), image)
    return folder


def names_of(found):
    return {key: str(picture).rsplit("/", 1)[-1] for key, picture in found.images.items()}


def test_folders_are_cameras_and_numbers_are_frames(tmp_path, image):
    for side in ("left", "right"):
        write(tmp_path / side, ["img_2.png", "img_10.png"], image)
    found = rigcal.detect([tmp_path / "left", str(tmp_path / "right")], BOARD)
    assert found.cameras == ["left", "right"]
    assert found.frames == ["2", "10"]
    assert found.sizes == {"left": (240, 180), "right": (240, 180)}
    assert names_of(found)["right", "10"] == "img_10.png"
    assert len(found) == 80
    assert found.warnings == []
    assert found.times is None


def test_patterns_and_numbers_of_several_digits(tmp_path, image):
    write(tmp_path, ["cam0_0068.png", "cam0_0074.png", "cam1_68.png", "cam1_74.png"], image)
    found = rigcal.detect([str(tmp_path / f"cam{k}_*.png") for k in (0, 1)], BOARD)
    assert found.cameras == ["cam0", "cam1"]
    assert found.frames == ["0068", "0074"]
    assert names_of(found)["cam1", "0074"] == "cam1_74.png"


def test_lists_of_paths_and_arrays(tmp_path, image):
    write(tmp_path, ["a1.png", "a2.png"], image)
    paths = [tmp_path / "a2.png", tmp_path / "a1.png"]
    found = rigcal.detect({"left": paths, "right": [image, image]}, BOARD)
    assert len(found.views) == 4
    assert "paired by their order" in found.warnings[0]
    assert found.images["right", "0001"] is image
    assert rigcal.detect([np.stack([image] * 2)], BOARD).cameras == ["cam0"]


def test_one_folder_longer(tmp_path, image):
    write(tmp_path / "a", ["1.png", "2.png", "3.png", "4.png"], image)
    write(tmp_path / "b", ["1.png", "3.png", "4.png"], image)
    with pytest.warns(rigcal.Caveat, match=r"camera a has 1 image .* 2.png \(images: a 4"):
        found = rigcal.detect([tmp_path / "a", tmp_path / "b"], BOARD)
    assert names_of(found)["b", "3"] == "3.png"


def test_one_folder_longer_without_common_numbers(tmp_path, image):
    write(tmp_path / "a", ["101.png", "102.png", "103.png"], image)
    write(tmp_path / "b", ["7.png", "8.png"], image)
    with pytest.raises(rigcal.Error, match=r"a has 3, b has 2, .* camera a are 103.png"):
        rigcal.detect([tmp_path / "a", tmp_path / "b"], BOARD)


def test_a_file_without_number_is_left_out(tmp_path, image):
    for side in "ab":
        write(tmp_path, [f"{side}.png", f"{side}1.png", f"{side}2.png"], image)
    with pytest.warns(rigcal.Caveat, match=r"camera a: a.png has no number"):
        found = rigcal.detect([str(tmp_path / "a*.png"), str(tmp_path / "b*.png")], BOARD)
    assert found.frames == ["1", "2"]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "there is no camera"),
        (5, "one for each camera"),
        ({"a": 5}, r"sources\['a'\]: a pattern, a folder"),
        ({"a": []}, "paths or arrays"),
        ({"a b": "x"}, "a name without"),
        (["/nowhere"], "no such file or folder"),
        (["/nowhere/*.png"], "no file has a name of this pattern"),
        ([["/nowhere/1.png"]], "there is no such file"),
        ([np.zeros((4, 5), np.uint8)], "a list of images for each camera"),
    ],
)
def test_what_is_no_source(given, text):
    with pytest.raises(rigcal.Error, match=text):
        rigcal.detect(given, BOARD)


def test_what_is_no_image(tmp_path, image):
    with pytest.raises(rigcal.Error, match="no image or video in this folder"):
        rigcal.detect([tmp_path], BOARD)
    (tmp_path / "a1.png").write_text("no image")
    with pytest.raises(rigcal.FileError, match=r"a1.png: this is no image"):
        rigcal.detect([tmp_path], BOARD)
    with pytest.raises(rigcal.Error, match="every: a whole number"):
        rigcal.detect([tmp_path], BOARD, every=0)
    for bad, text in (
        (np.zeros((4, 5)), "uint8 or uint16"),
        (np.zeros((2, 2, 2), "u1"), "an image"),
    ):
        with pytest.raises(rigcal.Error, match=text):
            rigcal.detect({"a": [bad]}, BOARD)


def test_videos_are_paired_by_time(tmp_path, image):
    blank = np.full_like(image, 90)
    slow = scenes.write_video(tmp_path / "slow.avi", [image] * 6, fps=10)
    fast = scenes.write_video(tmp_path / "fast.avi", [image, blank, blank] * 6, fps=30)
    found = rigcal.detect([slow, fast], BOARD)
    assert found.cameras == ["slow", "fast"]
    assert len(found.views) == 12
    assert found.images["fast", "0002"] == (fast, 6)
    assert found.times["0002", "fast"] == pytest.approx(0.2)
    assert found.warnings == []
    assert rigcal.detect.__module__ == "rigcal.detect"
    from rigcal.detect import read_picture

    assert read_picture((fast, 6)).shape == (180, 240, 3)
    with pytest.raises(rigcal.FileError, match="picture 99 cannot be read"):
        read_picture((fast, 99))
    half = rigcal.detect([slow], BOARD, every=2)
    assert half.frames == ["0000", "0002", "0004"]


def test_times_of_a_table_pair_pictures(tmp_path, image):
    # camera b began two pictures later, and the third of a has none
    a = scenes.write_video(tmp_path / "a.avi", [image] * 6)
    b = scenes.write_video(tmp_path / "b.avi", [image] * 4)
    rows = [("a", k, 0.1 * k) for k in range(6)] + [
        ("b", k, 0.1 * k + 0.21) for k in range(4)
    ]
    text = "camera,frame,time_s\n" + "".join(f"{c},{f:04d},{t}\n" for c, f, t in rows)
    (tmp_path / "times.csv").write_text(text)
    with pytest.warns(
        rigcal.Caveat,
        match="2 of 6 pictures of camera a have none of camera b within 50 ms",
    ):
        found = rigcal.detect([a, b], BOARD, times=tmp_path / "times.csv")
    assert found.images["b", "0003"] == (b, 1)
    assert found.times["0003", "b"] == pytest.approx(0.31)
    for first in (0, 1, 64):  # frames may be counted from elsewhere
        times = {(str(f + first), c): t for c, f, t in rows}
        with pytest.warns(rigcal.Caveat):
            assert rigcal.detect([a, b], BOARD, times=times).times == found.times


def test_times_of_other_programs(tmp_path, image):
    paths = [scenes.write_video(tmp_path / f"cam{k}.avi", [image] * 3) for k in (0, 1)]
    rows = [f"{i},{port},{i},{0.2 * i + 0.01 * port}" for i in range(3) for port in (0, 1)]
    path = tmp_path / "history.csv"
    path.write_text("sync_index,port,frame_index,frame_time\n" + "\n".join(rows) + "\n")
    found = rigcal.detect(paths, BOARD, times=path)
    assert found.times["0001", "cam1"] == pytest.approx(0.21)
    path.write_text("port,frame_index\n0,0\n")
    with pytest.raises(rigcal.FileError, match="no column time_s or frame_time or time"):
        rigcal.detect(paths, BOARD, times=path)
    path.write_text("camera,frame,time_s\n0,0,x\n")
    with pytest.raises(rigcal.FileError, match="column time_s"):
        rigcal.detect(paths, BOARD, times=path)
    with pytest.raises(rigcal.Error, match="none of camera cam1; those of cam0"):
        rigcal.detect(paths, BOARD, times={("0", "cam0"): 0.0})
    with pytest.raises(rigcal.Error, match="no frame of camera cam0 is that of a picture"):
        rigcal.detect(paths, BOARD, times={("9", "cam0"): 0.0, ("0", "cam1"): 0.0})


def test_images_with_times(tmp_path, image):
    write(tmp_path, [f"{side}{k}.png" for side in "ab" for k in (1, 2)], image)
    times = {
        (f"{side}{k}.png", side): k + 0.01 * (side == "b") for side in "ab" for k in (1, 2)
    }
    found = rigcal.detect(
        [str(tmp_path / f"{side}*.png") for side in "ab"], BOARD, times=times
    )
    assert found.times[("2", "b")] == pytest.approx(2.01)


def test_a_camera_has_one_video(tmp_path, image):
    scenes.write_video(tmp_path / "a.avi", [image] * 2)
    scenes.write_video(tmp_path / "b.avi", [image] * 2)
    with pytest.raises(rigcal.Error, match="2 videos among 2 files"):
        rigcal.detect([tmp_path], BOARD)
    (tmp_path / "c.avi").write_bytes(b"")
    with pytest.raises(rigcal.FileError, match="no video that OpenCV reads"):
        rigcal.detect([tmp_path / "c.avi"], BOARD)


def test_sources_have_the_names_of_the_intrinsics(tmp_path, image):
    for side in ("left", "right"):
        write(tmp_path / side, ["1.png", "2.png"], image)
    both = [tmp_path / "left", tmp_path / "right"]
    cameras = {n: scenes.pinhole(n, (240, 180), 300) for n in ("cam0", "cam1")}
    with pytest.warns(rigcal.Caveat, match="left is camera cam0, right is camera cam1"):
        assert rigcal.detect(both, BOARD, cameras=cameras).cameras == ["cam0", "cam1"]
    named = {n: scenes.pinhole(n, (240, 180), 300) for n in ("right", "left")}
    assert rigcal.detect(both, BOARD, cameras=named).cameras == ["left", "right"]
    with pytest.raises(rigcal.Error, match="are 2 cameras, and the intrinsics are of 1"):
        rigcal.detect(both, BOARD, cameras={"x": cameras["cam0"]})
    write(tmp_path / "other/left", ["1.png"], image)
    found = rigcal.detect([tmp_path / "left", tmp_path / "other/left"], BOARD)
    assert set(found.sizes) == {"cam0", "cam1"}


def test_progress(image):
    lines = []
    rigcal.detect({"a": [image] * 3}, BOARD, progress=lines.append, threads=1)
    assert lines == [f"searching pictures: {k} of 3" for k in (1, 2, 3)]


def test_table(tmp_path, image):
    found = rigcal.detect({"a": [image]}, BOARD)
    assert dict(found)["u"] is found.u
    assert set(found.keys()) == {
        "frame",
        "camera",
        "point",
        "X",
        "Y",
        "Z",
        "u",
        "v",
        "sigma_px",
    }
    assert repr(found) == "Detections(20 points, 1 views, ['a'])"
    with pytest.raises(KeyError):
        found["w"]
    found.times = {("0000", "a"): 1.5}
    found.save(tmp_path / "d.csv")
    found.save_times(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "frame,camera,time_s\n0000,a,1.5\n"
    again = rigcal.Detections.load(tmp_path / "d.csv")
    for name in found.columns:
        assert (again[name] == found[name]).all()
    for save in (found.save, found.save_times):
        with pytest.raises(rigcal.FileError):
            save(tmp_path / "no" / "d.csv")


@pytest.mark.parametrize("order", ["<", ">"])
def test_exif(tmp_path, order):
    head = (b"II" if order == "<" else b"MM") + struct.pack(order + "HI", 42, 8)
    for value, degrees in ((1, 0), (6, 90), (3, 180)):
        entries = struct.pack(order + "HHHIHH", 2, 0x0100, 3, 1, 5, 0)
        entries += struct.pack(order + "HHIHH", 0x0112, 3, 1, value, 0)
        path = tmp_path / "x.jpg"
        path.write_bytes(b"\xff\xd8\xff\xe1\0\x40Exif\0\0" + head + entries)
        assert exif_turn(str(path)) == degrees
    path.write_bytes(b"\xff\xd8\xff\xe1\0\x40Exif\0\0" + head + b"\xff\xff")
    assert exif_turn(str(path)) == 0
    assert exif_turn(str(tmp_path)) == 0


def test_a_picture_that_is_too_late_has_no_partner():
    def camera(name, *times):
        keys = [str(k) for k in range(len(times))]
        return sources.Camera(name, dict(zip(keys, keys)), dict(zip(keys, times)))

    late = [0.01, 0.11, 0.262, 0.31, 0.41]  # the third by more than half of 0.101 s
    pair = [camera("a", 0.0, 0.101, 0.202, 0.303, 0.404), camera("b", *late)]
    frames, told = sources.frames_of(pair, by_time=True)
    assert [frame.keys.get("b") for frame in frames] == ["0", "1", None, "3", "4"]
    assert [frame.keys["a"] for frame in frames] == ["0", "1", "2", "3", "4"]
    assert "1 of 5 pictures of camera a have none of camera b" in told[0]


def test_names_of_cameras():
    assert sources._common(["left01", "left02"]) == ("left", "")
    assert sources._keys(["a/x1_left.png", "a/x12_left.png"]) == ["1", "12"]


def test_videos_of_as_many_pictures_and_another_rate():
    def camera(name, count, period):
        keys = [str(k) for k in range(count)]
        return sources.Camera(
            name, dict(zip(keys, keys)), {k: period * int(k) for k in keys}
        )

    _, told = sources.frames_of([camera("a", 9, 0.1), camera("b", 9, 0.04)], by_time=True)
    text = "cameras b and a both have 9 pictures, one every 40 ms and one every 100 ms"
    assert sum(text in line for line in told) == 1
    _, told = sources.frames_of([camera("a", 9, 0.1), camera("b", 18, 0.05)], by_time=True)
    assert not any("both have" in line for line in told)


def test_files_of_other_endings(tmp_path, image):
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(rigcal.FileError, match=r"notes\.txt: this is no image that OpenCV"):
        rigcal.detect([tmp_path / "notes.txt"], BOARD)
    cv2.imwrite(str(tmp_path / "a.png"), image)
    (tmp_path / "a.png").rename(tmp_path / "a.picture")  # it is looked into
    assert len(rigcal.detect([tmp_path / "a.picture"], BOARD)) == 20
