"""multical's calibration.json. Lengths are in the board's unit.

"camera_poses" has cameras from the rig, "cam1", and from each other: "cam2_to_cam1" is,
despite the order of its words, what takes coordinates in cam1 to cam2. With "standard" and
4 coefficients the lens may be a fisheye, which the file does not say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..camera import Camera
from ..transform import Transform
from ._common import (
    LAYOUTS,
    Document,
    Files,
    Options,
    each,
    pose,
    read_layout,
    refuse,
    unmarked_lens,
    write_layout,
)
from ._node import Node
from ._text import dump_json

LAYOUT = LAYOUTS["multical"]
MODELS = ("standard", "rational", "thin_prism", "tilted")
SAME = 1e-6  # of two ways to one pose: more is a contradiction


def claims(node: Node) -> bool:
    cameras = node.value.get("cameras") if isinstance(node.value, dict) else None
    return isinstance(cameras, dict) and any(
        isinstance(part, dict) and "K" in part for part in cameras.values()
    )


def _read(document: Document, options: Options) -> list[Camera]:
    node = document.node
    cameras = {}
    for name, part in node["cameras"].mapping().items():
        model = part.get("model")
        if model is not None and model.text() not in MODELS:
            raise refuse(model, model.text(), MODELS)
        dist = part["dist"]
        lens = unmarked_lens(dist.array(), dist, options)
        cameras[name] = read_layout(part, LAYOUT, name, lens, options.scale)
    poses_node = node.get("camera_poses")
    if poses_node is None:
        return list(cameras.values())
    poses = _poses(poses_node, list(cameras), options.scale)
    return [replace(c, cam_from_rig=poses.get(n)) for n, c in cameras.items()]


read = each(_read)


def _poses(node: Node, names: Sequence[str], scale: float) -> Mapping[str, Transform]:
    """Of all cameras: those that are given, and what follows from them step by step."""
    poses: dict[str, Transform] = {}
    steps: list[tuple[Node, Transform]] = []
    for key, part in node.mapping().items():
        frames = [(a, b) for a in names for b in names if key == f"{a}_to_{b}"]
        if key not in names and not frames:
            raise part.fail("the camera is not among the cameras")
        T = pose(part["R"], part["T"], key, scale)
        if key in names:
            poses[key] = T
        else:
            steps.append((part, Transform(T.R, T.t, *frames[0])))
    for _ in range(len(steps)):
        for _, step in steps:
            for T in (step, step.inv()):
                if T.frm in poses and T.to not in poses:
                    poses[T.to] = T @ poses[T.frm]
    for part, step in steps:
        if step.to not in poses:
            raise part.fail(f"no camera_poses lead to {step.to}")
        there = step @ poses[step.frm]
        apart = np.abs(there.matrix - poses[step.to].matrix).max()
        if apart > SAME * max(1.0, float(np.abs(there.t).max())):
            raise part.fail("this contradicts the other camera_poses")
    return poses


def write(cameras: Sequence[Camera], options: Options) -> Files:
    values: dict[str, Any] = {"cameras": {}, "camera_poses": {}}
    for camera in cameras:
        parts = write_layout(camera, LAYOUT, options.scale, vector=False)
        T = {key: parts.pop(key) for key in ("R", "T") if key in parts}
        count = len(camera.dist)
        model = "rational" if count > 5 else "standard"
        if camera.lens == "brown" and count < 5:
            parts["dist"] += [0.0]
        values["cameras"][camera.name] = {"model": model, **parts}
        if T:
            values["camera_poses"][camera.name] = T
    return {"": dump_json(values)}
