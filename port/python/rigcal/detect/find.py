"""The work of `rigcal.detect`: reads every picture, searches it, and checks the result."""

from __future__ import annotations

import os
import threading
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from .. import _tables
from .._arrays import whole
from .._threads import THREADS_MAX
from ..errors import Error
from ..transform import Array
from . import mistakes
from .detections import Detections
from .detectors import Seen, detector
from .pictures import Image, Looks, depth_of, grey, looks_of, read_picture
from .sources import (
    Camera,
    Frame,
    cameras_of,
    frames_of,
    give_times,
    pictures_of,
    read_times,
)
from .targets import Charuco, Chessboard, Tag, Target

__all__ = ["find"]

LEAST = 4  # points that a view needs, not on a line
LEAST_CHARUCO = 6  # corners between markers that are hardly seen are worth little
LOOKED_AT = 4  # pictures of a camera that are looked at again where something is odd
NAMED_MOST = 4


@dataclass
class Look:
    """The result for one picture."""

    seen: Seen
    looks: Looks
    depth: int
    width: float  # of its sharpest edges [px]
    more: tuple[int, int]  # columns and rows by which the board is larger


class _Searcher:
    """Searches pictures. Each thread has its own detector."""

    def __init__(self, target: Target, options: Mapping[str, Any] | None) -> None:
        self.target, self.options = target, options
        self.local = threading.local()
        detector(target, options)  # an Error before any work

    def __call__(self, picture: Any) -> Look:
        if not hasattr(self.local, "detector"):
            self.local.detector = detector(self.target, self.options)
        image: Image = read_picture(picture)
        looks = looks_of(image, picture if isinstance(picture, str) else "")
        plain = grey(image)
        seen: Seen = self.local.detector(plain)
        more = (0, 0)
        part = plain
        if seen.pixels:
            uv = np.array(list(seen.pixels.values()))
            if isinstance(self.target, Chessboard):
                more = mistakes.beyond(plain, uv, self.target)
            low, high = uv.min(axis=0).astype(int), uv.max(axis=0).astype(int) + 2
            part = plain[max(low[1], 0) : high[1], max(low[0], 0) : high[0]]
        return Look(seen, looks, depth_of(image), mistakes.edge_width(part), more)


def _searched(
    cameras: Sequence[Camera],
    keys: Mapping[str, set[str]],
    search: Callable[[Any], Look],
    threads: int,
    tell: Callable[[str], None],
) -> dict[tuple[str, str], Look]:
    """What was seen in each picture, by camera and key."""
    total = sum(map(len, keys.values()))
    found: dict[tuple[str, str], Look] = {}
    waiting: deque[tuple[tuple[str, str], Any, Future[Look]]] = deque()

    def take() -> None:
        key, picture, future = waiting.popleft()
        try:
            found[key] = future.result()
        except Error as problem:
            if isinstance(picture, str) and picture in problem.text:
                raise
            where = picture if isinstance(picture, str) else f"{key[0]}, {key[1]}"
            raise Error(f"{where}: {problem.text}") from None
        tell(f"searching pictures: {len(found)} of {total}")

    def pictures() -> Iterator[tuple[tuple[str, str], Any]]:
        for camera in cameras:
            for key, picture in pictures_of(camera, keys[camera.name]):
                yield (camera.name, key), picture

    with ThreadPoolExecutor(threads) as pool:
        try:
            for key, picture in pictures():
                waiting.append((key, picture, pool.submit(search, picture)))
                if len(waiting) >= 4 * threads:
                    take()
            while waiting:
                take()
        finally:
            for _, _, future in waiting:
                future.cancel()
    return found


# ---- what is odd ------------------------------------------------------------------


def _names(keys: Sequence[str], camera: Camera) -> str:
    shown = []
    for key in keys[:NAMED_MOST]:
        picture = camera.pictures.get(key)
        shown.append(os.path.basename(picture) if isinstance(picture, str) else key)
    more = len(keys) - NAMED_MOST
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def _is(keys: Sequence[str]) -> str:
    return "is" if len(keys) == 1 else "are"


def size_of(camera: Camera, looks: Mapping[str, Look]) -> tuple[int, int]:
    """The size of a camera's pictures. Error if they differ."""
    counts = Counter(look.looks.size for look in looks.values())
    (size, _), *others = counts.most_common()
    if others:
        odd = [key for key, look in looks.items() if look.looks.size != size]
        other = looks[odd[0]].looks.size
        what = "turned by 90 degrees" if other == size[::-1] else "of another size"
        raise Error(
            f"camera {camera.name}: {_names(odd, camera)} has {other[0]} x {other[1]} "
            f"pixels, {what}; the others have {size[0]} x {size[1]}. The pictures of a "
            "camera have one size"
        )
    return size


def check_size(name: str, size: tuple[int, int], wanted: Any, turned: int = 0) -> None:
    """Error unless the pictures have the size of the camera's intrinsics."""
    if wanted is None or tuple(wanted) == size:
        return
    text = (
        f"camera {name}: its pictures have {size[0]} x {size[1]} pixels, its intrinsics "
        f"are for {wanted[0]} x {wanted[1]}"
    )
    if size == tuple(wanted)[::-1]:
        said = f" (the file says that they are turned by {turned})" if turned else ""
        raise Error(
            f"{text}: they are turned by 90 degrees{said}. Intrinsics are of the picture "
            "as it is stored: turn the pictures back, or make the intrinsics of turned ones"
        )
    x, y = size[0] / wanted[0], size[1] / wanted[1]
    if abs(x / y - 1) < 0.01:
        raise Error(
            f"{text}: they are scaled by {x:.4g}. Use pictures of the full size, or "
            "multiply fx, fy, cx + 0.5 and cy + 0.5 by that factor"
        )
    raise Error(f"{text}: they are cropped or of another camera")


def _oddities(camera: Camera, looks: Mapping[str, Look]) -> Iterator[str]:
    """Doubts about a camera's pictures that do not depend on the target."""
    channels = Counter(look.looks.channels > 1 for look in looks.values())
    name = camera.name
    if len(channels) > 1:
        yield (
            f"camera {name}: {channels[True]} pictures are in colour and {channels[False]} "
            "are grey; all are read as grey. Are they of one camera?"
        )
    deep = [look for look in looks.values() if look.looks.bits == 16]
    if deep:
        bits = Counter(look.depth for look in deep).most_common(1)[0][0]
        yield (
            f"camera {name}: {len(deep)} pictures have 16 bits a value, of which {bits} "
            "are in use; they are scaled to 8 for the detector"
        )
    turned = [key for key, look in looks.items() if look.looks.turned]
    if turned:
        yield (
            f"camera {name}: {_names(turned, camera)} says in its EXIF that it is turned "
            f"by {looks[turned[0]].looks.turned} degrees. It is read as it is stored, "
            "which is right for intrinsics that were made so"
        )
    if camera.turned:
        yield (
            f"camera {name}: the video says that it is turned by {camera.turned} degrees. "
            "It is read as it is stored, which is right for intrinsics that were made so"
        )
    blurred = [key for key, look in looks.items() if look.width > mistakes.BLURRED]
    if blurred and any(look.seen.pixels for look in looks.values()):
        widths = [looks[key].width for key in blurred]
        without = sum(not looks[key].seen.pixels for key in blurred)
        yield (
            f"camera {name}: {_names(blurred, camera)} {_is(blurred)} blurred: edges are "
            f"{np.median(widths):.0f} px wide; the target is not found in {without} of "
            f"{len(blurred)}"
        )
    cut = [key for key, look in looks.items() if look.looks.is_cut]
    if cut:
        yield (
            f"camera {name}: {_names(cut, camera)} {_is(cut)} cut off: the file ends "
            "before the image does, and the rest of it is grey. Copy it again"
        )


def _again(camera: Camera, keys: Sequence[str]) -> list[Any]:
    """Some of the pictures, spread evenly, as grey images."""
    step = max(1, len(keys) // LOOKED_AT)
    return [grey(read_picture(camera.pictures[key])) for key in keys[::step][:LOOKED_AT]]


def _doubts(
    camera: Camera, looks: Mapping[str, Look], target: Target, usable: Mapping[str, Any]
) -> Iterator[str]:
    """Doubts about the target in a camera's pictures."""
    name, missed = camera.name, [key for key in looks if key not in usable]
    if isinstance(target, Charuco) and usable and len(missed) >= len(looks) / 2:
        better = mistakes.is_better(_again(camera, missed), target)
        if better:
            yield f"camera {name}: {target} is seen in {len(usable)} pictures; {better}"
    if isinstance(target, Chessboard) and usable:
        sharp = [key for key in usable if looks[key].width <= mistakes.BLURRED]
        odd = Counter(looks[key].more for key in sharp if looks[key].more != (0, 0))
        if odd and 2 * sum(odd.values()) > len(usable):
            images = _again(camera, list(usable))
            size = mistakes.size_shown(images, target)
            shown = f"{size[0]} x {size[1]} inner corners" if size else "another number"
            yield (
                f"camera {name}: the board is not of {target.columns} x {target.rows} "
                f"inner corners: in {sum(odd.values())} of {len(usable)} pictures it seems "
                f"to have {shown}"
            )


def _in_two(
    camera: Camera, looks: Mapping[str, Look], target: Target, usable: Mapping[str, Any]
) -> list[str]:
    """Names pictures that show two boards."""
    if not isinstance(target, Chessboard):
        return [key for key in looks if looks[key].seen.twice]

    def has_two(key: str) -> bool:
        image = grey(read_picture(camera.pictures[key]))
        return mistakes.second_board(image, usable[key][1], target)

    keys = list(usable)
    step = max(1, len(keys) // LOOKED_AT)
    if not any(has_two(key) for key in keys[::step][:LOOKED_AT]):
        return []
    return [key for key in keys if has_two(key)]


def _why_nothing(cameras: Sequence[tuple[Camera, list[str], bool]], target: Target) -> str:
    """The message about cameras that never saw the target."""
    names = ", ".join(camera.name for camera, _, _ in cameras)
    count = sum(len(keys) for _, keys, _ in cameras)
    text = f"camera {names}: {target} is in none of {count} pictures"
    for camera, keys, has_two in cameras[:1]:
        if has_two:
            return f"camera {names}: no picture of {count} shows one target alone"
        why = mistakes.why_nothing(_again(camera, keys), target)
        text += f"; {why}" if why else ""
    return text


# ---- all of it ----------------------------------------------------------------------


def _usable(
    look: Look, points: Mapping[str, Array], least: int
) -> tuple[list[str], Array, Array] | None:
    """Points of a view, their pixels and sigmas; None if they fix no pose."""
    seen = look.seen
    names = [name for name in seen.pixels if name in points]
    if len(names) < least:
        return None
    X = np.array([points[name] for name in names])
    if np.linalg.matrix_rank(X - X.mean(axis=0), tol=1e-6 * float(np.abs(X).max() + 1)) < 2:
        return None
    sigma = dict(zip(seen.pixels, seen.sigma_px))
    return (
        names,
        np.array([seen.pixels[n] for n in names]),
        np.array([sigma[n] for n in names]),
    )


def _with_id(target: Target, looks: Mapping[Any, Look]) -> Target:
    """A tag with the number that was seen, if none was given."""
    if not isinstance(target, Tag) or target.id is not None:
        return target
    counts = Counter(number for look in looks.values() for number in look.seen.tags)
    if not counts:
        return target
    if len(counts) > 1:
        raise Error(
            f"target: tags {sorted(counts)[:8]} are seen: say which one is meant, "
            "Tag(..., id=...), or give Tags"
        )
    return Tag(target.size, next(iter(counts)), target.family)


def crossed(cameras: Sequence[Camera]) -> Iterator[str]:
    """Sources whose files are named as another camera is."""
    names = {camera.name for camera in cameras}
    for camera in cameras:
        paths = [path for path in camera.pictures.values() if isinstance(path, str)]
        first = os.path.basename(camera.video or (paths[0] if paths else ""))
        others = [name for name in names - {camera.name} if first.startswith(name)]
        if others and not first.startswith(camera.name):
            yield (
                f"camera {camera.name} is given {first}, and there is a camera "
                f"{others[0]}: are the two swapped?"
            )


def named_alike(cameras: Sequence[Camera], known: Mapping[str, Any]) -> list[str]:
    """Gives sources the names of cameras with known intrinsics: by name, or in order."""
    names = [camera.name for camera in cameras]
    if set(names) <= set(known):
        return []
    if len(names) != len(known):
        raise Error(
            f"sources: {', '.join(names)} are {len(names)} cameras, and the intrinsics "
            f"are of {len(known)}: {', '.join(known)}. Name the sources: "
            "{camera: source}, or camera=SOURCE. In a shell a pattern is put in quotes"
        )
    pairs = dict(zip(names, known))
    for camera, name in zip(cameras, known):
        camera.name = name
    told = ", ".join(f"{source} is camera {name}" for source, name in pairs.items())
    return [f"sources are named in the order of the intrinsics: {told}"]


def find(
    sources: Any,
    target: Target,
    times: Any,
    every: int,
    known: Mapping[str, Any] | None,
    options: Mapping[str, Any] | None,
    threads: int | None,
    tell: Callable[[str], None],
) -> Detections:
    """See `rigcal.detect`."""
    search = _Searcher(target, options)
    cameras = cameras_of(sources, every)
    told = named_alike(cameras, known) if known else []
    told += crossed(cameras)
    if times is not None:
        give_times(cameras, read_times(times))
    timed = all(camera.times for camera in cameras)
    frames, odd = frames_of(cameras, timed)
    told += odd
    keys: dict[str, set[str]] = {camera.name: set() for camera in cameras}
    for frame in frames:
        for name, key in frame.keys.items():
            keys[name].add(key)
    threads = min(os.cpu_count() or 1, 16) if threads is None else threads
    threads = whole(threads, "threads", 1, THREADS_MAX)
    found = _searched(cameras, keys, search, threads, tell)
    target = _with_id(target, found)
    points = target.points
    least = LEAST_CHARUCO if isinstance(target, Charuco) else LEAST
    sizes: dict[str, tuple[int, int]] = {}
    views: dict[tuple[str, str], tuple[list[str], Array, Array]] = {}
    nothing: list[tuple[Camera, list[str], bool]] = []
    for camera in cameras:
        looks = {key: look for (name, key), look in found.items() if name == camera.name}
        if not looks:
            raise Error(f"camera {camera.name}: none of its pictures belongs to a frame")
        sizes[camera.name] = size_of(camera, looks)
        if known and camera.name in known:
            check_size(
                camera.name, sizes[camera.name], known[camera.name].size, camera.turned
            )
        told += _oddities(camera, looks)
        tried = {key: _usable(look, points, least) for key, look in looks.items()}
        usable = {key: view for key, view in tried.items() if view is not None}
        told += _doubts(camera, looks, target, usable)
        two = _in_two(camera, looks, target, usable)
        if two:
            told.append(
                f"camera {camera.name}: {_names(two, camera)} shows two boards, or a tag "
                "twice; it is not known which is meant, and "
                f"{'it is' if len(two) == 1 else 'they are'} left out. Show one at a time"
            )
            usable = {key: view for key, view in usable.items() if key not in two}
        if not usable:
            nothing.append((camera, list(looks), bool(two)))
        views.update({(camera.name, key): view for key, view in usable.items()})
    if nothing:
        why = _why_nothing(nothing, target)
        if not views:
            raise Error("\n".join([why, *told]))
        told.append(why)
    return _table(target, cameras, frames, views, sizes, timed, told)


def _table(
    target: Target,
    cameras: Sequence[Camera],
    frames: Sequence[Frame],
    views: Mapping[tuple[str, str], tuple[list[str], Array, Array]],
    sizes: dict[str, tuple[int, int]],
    timed: bool,
    told: list[str],
) -> Detections:
    rows: dict[str, list[Any]] = {name: [] for name in Detections.columns}
    images, times = {}, {}
    points = target.points
    usual = float(np.median(np.concatenate([sigma for _, _, sigma in views.values()])))
    by_name = {camera.name: camera for camera in cameras}
    for frame in frames:
        for name, key in frame.keys.items():
            camera = by_name[name]
            images[name, frame.name] = camera.pictures[key]
            if (name, key) not in views:
                continue
            if timed:
                times[frame.name, name] = camera.times[key]
            seen, uv, sigma = views[name, key]
            for point, x, s in zip(seen, uv, sigma):
                X = points[point]
                row = (frame.name, name, point, *X.tolist(), *x.tolist(), float(s) / usual)
                for column, value in zip(rows.values(), row):
                    column.append(value)
    columns: dict[str, Any] = {
        name: _tables.ids(np.array(column, dtype=object), name)
        if name in _tables.IDS
        else np.array(column, dtype=np.float64)
        for name, column in rows.items()
    }
    return Detections(
        **columns,
        target=target,
        sizes=sizes,
        times=times if timed else None,
        images=images,
        warnings=told,
    )
