#!/usr/bin/env python3
"""Calibrates a stereo pair through the shared library: ctypes and NumPy only.

    stereo.py LIBRARY DATA [--check REFERENCE_PAIRS]

DATA is a folder with cameras.csv and observations.csv in metres, and the first
two cameras are the pair. First of all, every struct declared here is compared with the
library's own layout of it.
"""
import argparse
import collections
import csv
import ctypes
import os
import sys

import numpy as np

# What --check allows: degrees, and metres.
ANGLE_LIMIT, DISTANCE_LIMIT = 0.05, 4e-4
POSES_MAX = 4  # RIGCAL_POSES_MAX


def declare_structs(real):
    """The structs of rigcal.h that this program uses, as NumPy types."""
    i4, address, count = np.int32, np.uintp, np.uintp
    transform = [("R", real, 9), ("t", real, 3)]
    camera = [(name, i4) for name in ("lens", "width", "height")]
    camera += [(name, real) for name in "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6".split()]
    view = [("camera", address), ("observations", address), ("sigma", address),
            ("n", count)]
    declared = {
        "rigcal_layout_entry": [("name", "S48"), ("offset", i4), ("size", i4)],
        "rigcal_transform": transform,
        "rigcal_camera": camera,
        "rigcal_observation": [("X_w", real, 3), ("uv", real, 2)],
        "rigcal_pose": [("cam_from_world", np.dtype(transform, align=True)),
                        ("sse", real), ("rms_px", real), ("probability", real)],
        "rigcal_pose_options": [("use_start", i4), ("sigma_px", real),
                                ("start", np.dtype(transform, align=True))],
        "rigcal_view": view,
        "rigcal_rig_view": [("view", np.dtype(view, align=True)), ("camera", i4),
                            ("placement", i4), ("target", i4)],
        "rigcal_view_pose": [("cam_from_target", np.dtype(transform, align=True)),
                             ("information", real, 21), ("sse", real), ("n", count),
                             ("camera", i4), ("placement", i4)],
        "rigcal_rig": [("cams_from_rig", address), ("n_cameras", count),
                       ("rig_from_placements", address), ("n_placements", count),
                       ("group", address), ("n_views", count), ("views", address),
                       ("view_source", address), ("view_poses", address),
                       ("view_pose_source", address), ("context", address),
                       ("left_out", address),
                       ("roles", address), ("priors", address),
                      ("priors_information", address), ("sigma_px", real),
                       ("work", address), ("work_capacity", count),
                       ("clocks", address), ("intrinsics_sigmas", address),
                       ("considered", address)],
        "rigcal_rig_fit": [("sum", real), ("freedom", real), ("sigma_px", real),
                           ("n_points", count), ("evals", i4), ("F", real),
                           ("freedom_between", real), ("freedom_within", real)],
    }
    return {name: np.dtype(fields, align=True)
            for name, fields in declared.items()}


def prototypes(library):
    """Pointers are addresses of NumPy arrays, which must stay; None is NULL."""
    status, pointer = ctypes.c_int32, ctypes.c_void_p
    count, index = ctypes.c_size_t, ctypes.c_int32
    for name, result, arguments in (
            ("sizeof_real", ctypes.c_int32, []),
            ("status_text", ctypes.c_char_p, [status]),
            ("layout_count", ctypes.c_int32, []),
            ("layout", status, [pointer, index]),
            ("pose_defaults", status, [pointer]),
            ("pose_solve", status, [pointer, count] + [pointer] * 4),
            ("view_pose_make", status, [pointer] * 3),
            ("rig_work", count, [count] * 3),
            ("rig_join", status, [pointer] * 2),
            ("rig_adjust", status, [pointer] * 3),
            ("transform_between", status, [pointer] * 3)):
        function = getattr(library, "rigcal_" + name)
        function.restype, function.argtypes = result, arguments


def at(array):
    return array.ctypes.data


def check_layout(library, structs):
    """Stops if a struct here differs from the library's in any field."""
    here = {}
    for name, dtype in structs.items():
        here[name] = (0, dtype.itemsize)
        for field, (kind, offset) in dtype.fields.items():
            here[name + "." + field] = (offset, kind.itemsize)
    there = {}
    entry = np.zeros(1, structs["rigcal_layout_entry"])
    for index in range(library.rigcal_layout_count()):
        must(library, library.rigcal_layout(at(entry), index), "layout")
        name = entry["name"][0].decode()
        if name.split(".")[0] in structs:
            there[name] = (int(entry["offset"][0]), int(entry["size"][0]))
    for name in sorted(here.keys() | there.keys()):
        if here.get(name) != there.get(name):
            sys.exit(f"{name}: (offset, size) is {here.get(name)} here and "
                     f"{there.get(name)} in the library")


def must(library, status, what):
    """Ends the program when a call failed, and prints the caveat of a call that did not:
    negative statuses are failures, positive ones come with a result that can be used."""
    if status != 0:
        text = f"{what}: {library.rigcal_status_text(status).decode()}"
        if status < 0:
            sys.exit(text)
        print(f"caveat: {text}", file=sys.stderr)


def rows(path):
    with open(path, encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file))


def read_cameras(path, dtype):
    names = []
    cameras = np.zeros(2, dtype)
    for camera, row in zip(cameras, rows(path)):
        names.append(row["camera"])
        for field in dtype.names:
            if field in row:
                camera[field] = float(row[field])
    return names, cameras


def read_observations(path, names, dtype):
    """Observations of each (camera, frame)."""
    views = collections.defaultdict(list)
    for row in rows(path):
        if row["camera"] in names:
            views[names.index(row["camera"]), row["frame"]].append(row)
    for key, seen in views.items():
        observed = np.zeros(len(seen), dtype)
        observed["X_w"] = [[float(r[k]) for k in "XYZ"] for r in seen]
        observed["uv"] = [[float(r[k]) for k in "uv"] for r in seen]
        views[key] = observed
    return views


def solve_views(library, structs, names, cameras, observations):
    """The views of the rig, placement by placement, and the pose of each by itself."""
    placements = {frame: k for k, frame in
                  enumerate(dict.fromkeys(frame for _, frame in observations))}
    views = np.zeros(len(observations), structs["rigcal_rig_view"])
    found = np.zeros(len(observations), structs["rigcal_view_pose"])
    options = np.zeros(1, structs["rigcal_pose_options"])
    must(library, library.rigcal_pose_defaults(at(options)), "options")
    poses = np.zeros(POSES_MAX, structs["rigcal_pose"])
    n_found = np.zeros(1, np.uintp)
    in_order = sorted(observations, key=lambda key: (placements[key[1]], key[0]))
    for k, (camera, frame) in enumerate(in_order):
        observed, view, what = (observations[camera, frame], views[k:],
                                f"camera {names[camera]}, frame {frame}")
        view["view"]["camera"][0] = at(cameras[camera:])
        view["view"]["observations"][0] = at(observed)
        view["view"]["n"][0] = len(observed)
        view["camera"][0], view["placement"][0] = camera, placements[frame]
        must(library, library.rigcal_pose_solve(
            at(poses), POSES_MAX, at(n_found), None, at(view), at(options)), what)
        must(library, library.rigcal_view_pose_make(
            at(found[k:]), at(view), at(poses)), what)
    return views, found


def right_from_left(library, structs, views, view_poses):
    """The adjusted pair, and how well it fits."""
    n_placements = int(views["placement"].max()) + 1
    cams_from_rig = np.zeros(2, structs["rigcal_transform"])
    placements = np.zeros(n_placements, structs["rigcal_transform"])
    group = np.zeros(2, np.int32)
    capacity = library.rigcal_rig_work(1, 2, n_placements)
    work = np.zeros(capacity, structs["rigcal_rig_fit"]["sum"])
    rig = np.zeros(1, structs["rigcal_rig"])
    rig["cams_from_rig"], rig["n_cameras"] = at(cams_from_rig), 2
    rig["rig_from_placements"], rig["n_placements"] = at(placements), n_placements
    rig["group"], rig["n_views"] = at(group), len(views)
    rig["views"], rig["view_poses"] = at(views), at(view_poses)
    rig["work"], rig["work_capacity"] = at(work), capacity
    fit = np.zeros(1, structs["rigcal_rig_fit"])
    must(library, library.rigcal_rig_join(at(rig), None), "join")
    if group[1] != group[0]:
        sys.exit("the two cameras never saw the target in one place")
    must(library, library.rigcal_rig_adjust(at(fit), None, at(rig)), "adjust")
    pair = np.zeros(1, structs["rigcal_transform"])
    must(library, library.rigcal_transform_between(
        at(pair), at(cams_from_rig[1:]), at(cams_from_rig)), "pair")
    return (pair["R"][0].astype(float).reshape(3, 3),
            pair["t"][0].astype(float), float(fit["sigma_px"][0]))


def angle_deg(Ra, Rb):
    return np.degrees(2 * np.arcsin(np.linalg.norm(Ra - Rb) / np.sqrt(8)))


def difference(path, names, R, t):
    for row in rows(path):
        if [row["camera_a"], row["camera_b"]] == names:
            keys = [f"R{i}{j}" for i in "123" for j in "123"]
            R_ref = np.reshape([float(row[k]) for k in keys], (3, 3))
            t_ref = np.array([float(row[k]) for k in ("tx", "ty", "tz")])
            return angle_deg(R, R_ref), np.linalg.norm(t - t_ref)
    sys.exit(f"{path} has no {names[0]}, {names[1]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("library")
    parser.add_argument("data")
    parser.add_argument("--check", metavar="REFERENCE_PAIRS")
    arguments = parser.parse_args()

    library = ctypes.CDLL(os.path.abspath(arguments.library))
    prototypes(library)
    real = {8: np.float64, 4: np.float32}[library.rigcal_sizeof_real()]
    structs = declare_structs(real)
    check_layout(library, structs)

    names, cameras = read_cameras(os.path.join(arguments.data, "cameras.csv"),
                                  structs["rigcal_camera"])
    observations = read_observations(
        os.path.join(arguments.data, "observations.csv"), names,
        structs["rigcal_observation"])
    views, view_poses = solve_views(library, structs, names, cameras, observations)
    R, t, sigma_px = right_from_left(library, structs, views, view_poses)
    print(f"python: {names[1]} from {names[0]}: baseline "
          f"{1000 * np.linalg.norm(t):.2f} mm, angle "
          f"{angle_deg(np.eye(3), R):.3f} degrees, {sigma_px:.2f} px", end="")
    if arguments.check:
        angle, distance = difference(arguments.check, names, R, t)
        print(f"; off by {angle:.3f} degrees, {1000 * distance:.2f} mm", end="")
        if not (angle <= ANGLE_LIMIT and distance <= DISTANCE_LIMIT):
            sys.exit("\nthat is too far from the reference")
    print()


if __name__ == "__main__":
    main()
