"""The pictures of each camera, and which of them were taken at the same time.

Image files are paired by the part in which their names differ, if it is the same for all
cameras: left01.jpg and right01.jpg. Otherwise they are paired by their order. Videos, and
images with times, are paired by time.
"""

from __future__ import annotations

import glob
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import _tables
from ..errors import Error, FileError
from .pictures import Image, open_video, opencv

__all__ = ["Camera", "Frame", "cameras_of", "frames_of"]

IMAGES = {
    ".bmp", ".exr", ".hdr", ".jp2", ".jpe", ".jpeg", ".jpg", ".pbm", ".pgm", ".png", ".pnm",
    ".ppm", ".sr", ".tif", ".tiff", ".webp",
}  # fmt: skip
VIDEOS = {
    ".264", ".265", ".3gp", ".avi", ".flv", ".h264", ".h265", ".hevc", ".m2ts", ".m4v",
    ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".mxf", ".ogg",
    ".ogv", ".ts", ".vob", ".webm", ".wmv", ".y4m",
}  # fmt: skip
NAMED_MOST = 4  # files that a message names
# Columns of a table of times: ours, and those of programs that record.
TIME_COLUMNS = {
    "camera": ("camera", "port", "cam_id"),
    "frame": ("frame", "frame_index"),
    "time_s": ("time_s", "frame_time", "time"),
}


@dataclass
class Camera:
    """What a source holds: pictures by the name of each.

    pictures  of images: path or array by key; of a video: (path, number) by number
    times     [s] by key, or none
    """

    name: str
    pictures: dict[str, Any] = field(default_factory=dict)
    times: dict[str, float] = field(default_factory=dict)
    video: str = ""
    is_named: bool = True  # the keys are those of files, not only an order
    count: int = 0  # of the pictures of a video
    turned: int = 0  # degrees that a video says that it is turned


@dataclass
class Frame:
    """Pictures taken at the same time: a key for each camera."""

    name: str
    keys: dict[str, str]


# ---- what is given --------------------------------------------------------------


def _natural(path: str) -> list[Any]:
    """Names in the order of the numbers in them."""
    words = re.split(r"(\d+)", os.path.basename(path))
    return [(int(w), w) if w.isdigit() else (-1, w) for w in words] + [path]


def _ending(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _holds(folder: str, name: str) -> bool:
    """Whether there is a folder of that name in a folder."""
    return os.path.isdir(os.path.join(folder, name))


def _files(source: str) -> list[str]:
    """The files of a pattern or a folder, or the file itself."""
    if os.path.isdir(source):
        found = [os.path.join(source, name) for name in os.listdir(source)]
        found = [path for path in found if _ending(path) in IMAGES | VIDEOS]
        if not found:
            inside = [name for name in sorted(os.listdir(source)) if _holds(source, name)]
            advice = f"; give its folders: {_some(inside)}" if inside else ""
            raise FileError(source, f"there is no image or video in this folder{advice}")
    elif os.path.isfile(source):
        found = [source]
    elif glob.has_magic(source):
        found = [path for path in glob.glob(source, recursive=True) if os.path.isfile(path)]
        if not found:
            raise FileError(source, "no file has a name of this pattern")
    else:
        raise FileError(source, "there is no such file or folder")
    return sorted(found, key=_natural)


def _prefix(names: Sequence[str]) -> str:
    """The common beginning of all names."""
    least, most = min(names), max(names)
    alike = (k for k, (a, b) in enumerate(zip(least, most)) if a != b)
    return least[: next(alike, len(least))]


def _common(names: Sequence[str]) -> tuple[str, str]:
    """The common beginning and end of all names. Numbers are not cut."""
    head = _prefix(names)
    tail = _prefix([name[len(head) :][::-1] for name in names])[::-1]
    return re.sub(r"\d+$", "", head), re.sub(r"^\d+", "", tail)


def _stems(paths: Sequence[str]) -> list[str]:
    return [os.path.splitext(os.path.basename(path))[0] for path in paths]


def _name_of(source: Any, paths: Sequence[str]) -> str:
    """The camera's name: that of its folder, or the common part of its files' names."""
    if isinstance(source, str) and os.path.isdir(source):
        return os.path.basename(os.path.abspath(source))
    stems = _stems(paths)
    name = stems[0] if len(stems) == 1 else _common(stems)[0]
    name = name.strip("_-. ")
    if not name and len(stems) > 1:
        name = os.path.basename(os.path.dirname(os.path.abspath(paths[0])))
    return re.sub(r"[^\w.+-]", "_", name)


def _keys(paths: Sequence[str]) -> list[str]:
    """The part in which names of files differ: "01" of left01.jpg. Empty: there is none."""
    stems = _stems(paths)
    if len(stems) == 1:
        numbers = re.findall(r"\d+", stems[0])
        return [numbers[-1] if numbers else stems[0]]
    head, tail = _common(stems)
    return [stem[len(head) : len(stem) - len(tail)].strip("_-. ") for stem in stems]


def _video(name: str, path: str, every: int) -> Camera:
    cv2 = opencv()
    video = open_video(path)
    camera = Camera(name, video=path)
    camera.turned = int(video.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
    period = 1.0 / max(float(video.get(cv2.CAP_PROP_FPS)), 1e-3)
    last = -math.inf
    number = 0
    while video.grab():
        time = float(video.get(cv2.CAP_PROP_POS_MSEC)) / 1000
        time = time if time > last else last + period
        if number % every == 0:
            key = str(number).zfill(4)
            camera.pictures[key] = (path, number)
            camera.times[key] = time
        last = time
        number += 1
    video.release()
    camera.count = number
    if not camera.pictures:
        raise FileError(path, "there is no picture in this video")
    return camera


def _camera(name: str | None, source: Any, every: int, number: int) -> Camera:
    """The camera of one source."""
    if isinstance(source, os.PathLike):
        source = os.fspath(source)
    if isinstance(source, np.ndarray) and source.ndim in (3, 4):
        source = list(source)
    if isinstance(source, str):
        paths = _files(source)
    elif isinstance(source, Iterable):
        items = list(source)
        if items and all(isinstance(item, np.ndarray) for item in items):
            keys = [str(k).zfill(4) for k in range(len(items))]
            return Camera(name or f"cam{number}", dict(zip(keys, items)), is_named=False)
        if not items or not all(isinstance(item, (str, os.PathLike)) for item in items):
            raise Error(
                f"sources[{name if name is not None else number!r}]: paths or arrays are "
                "expected, all of one kind"
            )
        paths = [os.fspath(item) for item in items]
        for path in paths:
            _tables.must_exist(path)
    else:
        raise Error(
            f"sources[{name if name is not None else number!r}]: a pattern, a folder, a "
            f"video, or a list of paths or arrays is expected, not {type(source).__name__}"
        )
    name = name or _name_of(source, paths) or f"cam{number}"
    videos = [path for path in paths if _ending(path) in VIDEOS]
    if videos and len(paths) > 1:
        raise Error(
            f"sources: camera {name} has {len(videos)} videos among {len(paths)} files; a "
            "camera has images, or one video. Give each video as a source of its own"
        )
    if videos:
        return _video(name, videos[0], every)
    for path in paths:
        if _ending(path) not in IMAGES and not opencv().haveImageReader(path):
            raise FileError(path, "this is no image that OpenCV reads, and no known video")
    keys = _keys(paths)
    is_named = len({_plain(key) for key in keys}) == len(keys)
    if not is_named:
        keys = [str(k).zfill(4) for k in range(len(paths))]
    return Camera(name, dict(zip(keys, paths)), is_named=is_named)


def cameras_of(sources: Any, every: int) -> list[Camera]:
    """The cameras that the sources of `rigcal.detect` describe."""
    if isinstance(every, bool) or not isinstance(every, int) or every < 1:
        raise Error(f"every: a whole number from 1 is expected, not {every!r}")
    if isinstance(sources, Mapping):
        named: list[tuple[str | None, Any]] = [(str(k), v) for k, v in sources.items()]
        for name, _ in named:
            _tables.check_name(str(name), f"sources[{name!r}]")
    elif isinstance(sources, (str, os.PathLike, np.ndarray)):
        named = [(None, sources)]
    elif isinstance(sources, Iterable):
        named = [(None, source) for source in sources]
        if named and isinstance(named[0][1], np.ndarray) and named[0][1].ndim == 2:
            raise Error("sources: a list of images for each camera is expected, not images")
    else:
        raise Error(f"sources: one for each camera is expected, not {sources!r}")
    if not named:
        raise Error("sources: there is no camera")
    found = [_camera(name, source, every, k) for k, (name, source) in enumerate(named)]
    names = [camera.name for camera in found]
    if len(set(names)) < len(names):
        for k, camera in enumerate(found):
            camera.name = f"cam{k}"
    return found


# ---- times ----------------------------------------------------------------------


def read_times(given: Any) -> dict[tuple[str, str], float]:
    """{(frame, camera): seconds} of a mapping, a table or a CSV file."""
    if isinstance(given, Mapping) and given and all(isinstance(k, tuple) for k in given):
        return {(str(f), str(c)): float(t) for (f, c), t in given.items()}
    table: Any = given
    if isinstance(given, (str, os.PathLike)):
        table = _tables.read(_tables.must_exist(given))  # type: ignore[arg-type]
        picked: dict[str, Any] = {}
        for name, others in TIME_COLUMNS.items():
            there = [other for other in others if other in table]
            if not there:
                raise FileError(
                    os.fspath(given),
                    f"no column {' or '.join(others)}; camera,frame,time_s are expected",
                )
            picked[name] = table[there[0]]
        try:
            picked["time_s"] = np.array([float(text) for text in picked["time_s"]])
        except ValueError as problem:
            raise FileError(os.fspath(given), f"column time_s: {problem}") from None
        table = picked
    found = _tables.columns(table, _tables.TIMES, "times")
    keys = zip(found["frame"].tolist(), found["camera"].tolist())
    return dict(zip(keys, found["time_s"].tolist()))


def _plain(key: str) -> str:
    """A number without leading zeros."""
    return str(int(key)) if key.isdecimal() else key


def _by_order(own: dict[str, float], camera: Camera) -> dict[str, float]:
    """Times by the number of the picture in the video, from 0. A table that counts
    differently, from 1 or from where the video was cut, must have one for each picture in
    order."""
    numbers = {str(k) for k in range(camera.count)}
    if len(own) != camera.count or set(own) == numbers:
        return own
    return {str(k): own[key] for k, key in enumerate(sorted(own, key=_natural))}


def give_times(cameras: Sequence[Camera], given: Mapping[tuple[str, str], float]) -> None:
    """Sets the times of pictures by camera and by frame: a picture's number or name."""
    by_camera: dict[str, dict[str, float]] = {}
    for (frame, name), time in given.items():
        by_camera.setdefault(name, {})[_plain(frame)] = time
    numbered = {re.sub(r"^.*?(\d*)$", r"\1", name): name for name in by_camera}
    for camera in cameras:
        own = by_camera.get(camera.name)
        if own is None:  # "0" is cam0
            own = by_camera.get(numbered.get(re.sub(r"^.*?(\d*)$", r"\1", camera.name), ""))
        if own is None:
            raise Error(
                f"times: there is none of camera {camera.name}; those of "
                f"{', '.join(sorted(by_camera))} are there"
            )
        if camera.video:
            own = _by_order(own, camera)
        camera.times = {}
        for key, picture in camera.pictures.items():
            words = [_plain(key)]
            if isinstance(picture, str):
                words += [os.path.basename(picture), _stems([picture])[0]]
            known = [own[word] for word in words if word in own]
            if known:
                camera.times[key] = known[0]
        missing = [key for key in camera.pictures if key not in camera.times]
        if len(missing) == len(camera.pictures):
            raise Error(
                f"times: no frame of camera {camera.name} is that of a picture: the table "
                f"has {', '.join(list(own)[:NAMED_MOST])}, ..., the pictures are "
                f"{', '.join(list(camera.pictures)[:NAMED_MOST])}, ..."
            )
        for key in missing:
            del camera.pictures[key]


# ---- frames ---------------------------------------------------------------------


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(os.path.basename(str(name)) for name in names[:NAMED_MOST])
    more = len(names) - NAMED_MOST
    return f"{shown} and {more} more" if more > 0 else shown


def _label(camera: Camera, key: str) -> str:
    picture = camera.pictures[key]
    return picture if isinstance(picture, str) else key


def frames_of(cameras: Sequence[Camera], by_time: bool) -> tuple[list[Frame], list[str]]:
    """Groups the pictures that belong together, and says what is odd."""
    if by_time:
        return _frames_by_time(cameras)
    by_name = [{_plain(key): key for key in camera.pictures} for camera in cameras]
    names = list(dict.fromkeys(name for keys in by_name for name in keys))
    common = [name for name in names if all(name in keys for keys in by_name)]
    is_named = all(camera.is_named for camera in cameras)
    if len(cameras) == 1 or (is_named and 2 * len(common) >= min(map(len, by_name))):
        return _frames_by_name(cameras, by_name, names)
    return _frames_by_order(cameras)


def _frames_by_name(
    cameras: Sequence[Camera], by_name: Sequence[Mapping[str, str]], names: Sequence[str]
) -> tuple[list[Frame], list[str]]:
    frames, told = [], []
    odd = [k for k, keys in enumerate(by_name) if "" in keys]
    for k in odd:
        path = cameras[k].pictures[by_name[k][""]]
        told.append(
            f"camera {cameras[k].name}: {_some([path])} has no number as the others have, "
            "and is left out"
        )
    for name in sorted((n for n in names if n), key=_natural):
        keys = {c.name: own[name] for c, own in zip(cameras, by_name) if name in own}
        frames.append(Frame(next(iter(keys.values())), keys))
    for camera, own in zip(cameras, by_name):
        alone = [
            _label(camera, key)
            for name, key in own.items()
            if name and sum(name in other for other in by_name) == 1
        ]
        if alone and len(cameras) > 1:
            counts = ", ".join(f"{c.name} {len(c.pictures)}" for c in cameras)
            told.append(
                f"camera {camera.name} has {len(alone)} image{'s' * (len(alone) > 1)} that "
                "no other camera has: "
                f"{_some(alone)} (images: {counts}). Images are paired by the numbers in "
                "their names"
            )
    return frames, told


def _frames_by_order(cameras: Sequence[Camera]) -> tuple[list[Frame], list[str]]:
    counts = {camera.name: len(camera.pictures) for camera in cameras}
    if len(set(counts.values())) > 1:
        counted = ", ".join(f"{name} has {n}" for name, n in counts.items())
        long = max(cameras, key=lambda c: len(c.pictures))
        extra = list(long.pictures)[min(counts.values()) :]
        raise Error(
            f"the cameras have different numbers of images, {counted}, and the names of "
            "the files do not say which belong together. The last ones of camera "
            f"{long.name} are {_some([_label(long, key) for key in extra])}: give images "
            "of one time the same number, or pass times"
        )
    columns = [list(camera.pictures) for camera in cameras]
    frames = []
    for k, row in enumerate(zip(*columns)):
        keys = dict(zip(counts, row))
        frames.append(Frame(str(k).zfill(4), keys))
    told = []
    if any(_label(c, k) != k for c in cameras for k in c.pictures):
        pairs = " with ".join(
            os.path.basename(_label(c, next(iter(c.pictures)))) for c in cameras
        )
        told.append(
            "images are paired by their order, since the numbers in their names differ: "
            f"{pairs}"
        )
    return frames, told


def period_of(camera: Camera) -> float:
    """The usual time between two pictures [s]; infinite for one picture."""
    times = np.sort(np.array(list(camera.times.values())))
    return float(np.median(np.diff(times))) if len(times) > 1 else math.inf


def _other_rates(cameras: Sequence[Camera], reference: Camera) -> Iterator[str]:
    """Videos of as many pictures as the slowest one, which are said to be faster."""
    period, count = period_of(reference), len(reference.times)
    for camera in cameras:
        own = period_of(camera)
        if own < 0.9 * period < math.inf and len(camera.times) == count:
            yield (
                f"cameras {camera.name} and {reference.name} both have {count} pictures, "
                f"one every {1000 * own:.3g} ms and one every {1000 * period:.3g} ms. If "
                "these belong together one by one, a file states a wrong rate: pass times"
            )


def _frames_by_time(cameras: Sequence[Camera]) -> tuple[list[Frame], list[str]]:
    """For each picture of the slowest camera, the nearest picture of each other camera, if
    it is within half the time between two pictures."""
    told = []
    periods = [period_of(camera) for camera in cameras]
    slow = max(range(len(cameras)), key=lambda k: (periods[k], -len(cameras[k].pictures)))
    if len({len(camera.times) for camera in cameras}) > 1:
        slow = min(
            (k for k in range(len(cameras)) if periods[k] > 0.9 * periods[slow]),
            key=lambda k: -len(cameras[k].times),
        )
    reference, within = cameras[slow], periods[slow] / 2
    frames = [Frame(key, {reference.name: key}) for key in reference.times]
    middle = np.array(list(reference.times.values()))
    for camera in cameras:
        if camera is reference:
            continue
        keys, times = list(camera.times), np.array(list(camera.times.values()))
        order = np.argsort(times)
        place = np.clip(np.searchsorted(times[order], middle), 1, max(len(times) - 1, 1))
        left, right = order[place - 1], order[np.minimum(place, len(times) - 1)]
        near = np.where(
            np.abs(times[left] - middle) <= np.abs(times[right] - middle), left, right
        )
        best: dict[int, tuple[float, int]] = {}
        for k, j in enumerate(near.tolist()):
            off = abs(float(times[j] - middle[k]))
            if off <= within and off < best.get(j, (math.inf, 0))[0]:
                best[j] = (off, k)
        for j, (_, k) in best.items():
            frames[k].keys[camera.name] = keys[j]
        if len(best) < 0.9 * len(middle):
            told.append(
                f"{len(middle) - len(best)} of {len(middle)} pictures of camera "
                f"{reference.name} have none of camera {camera.name} within "
                f"{1000 * within:.3g} ms, half the time between two pictures"
            )
    told += _other_rates(cameras, reference)
    ends = {c.name: max(c.times.values()) - min(c.times.values()) for c in cameras}
    long, short = max(ends, key=lambda n: ends[n]), min(ends, key=lambda n: ends[n])
    if ends[long] - ends[short] > 2 * periods[slow]:
        told.append(
            f"camera {long} has {ends[long] - ends[short]:.3g} s more than camera {short}. "
            "Did all begin at the same time? Else pass times"
        )
    return frames, told


# ---- pictures one after the other -------------------------------------------------


def pictures_of(camera: Camera, keys: set[str]) -> Iterator[tuple[str, Image | str]]:
    """Key and path of each picture; for a video, and for arrays, the picture itself."""
    if not camera.video:
        yield from ((k, picture) for k, picture in camera.pictures.items() if k in keys)
        return
    wanted = {number: key for key, (_, number) in camera.pictures.items() if key in keys}
    video = open_video(camera.video)
    try:
        for number in range(max(wanted, default=-1) + 1):
            if not video.grab():
                break
            if number in wanted:
                found, image = video.retrieve()
                if found:
                    yield wanted[number], image
    finally:
        video.release()
