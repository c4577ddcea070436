"""Broken files must give "file: what" as a FileError, and nothing else."""

import json
import random
import re

import numpy as np
import pytest
from format_samples import COLMAP_RIGS, SAMPLES, Sample

from rigcal import Error, FileError, load_cameras, load_target

# ==== the same numbers, spoilt, in every format ===============================

# For each sample: the file; a focal length, a coefficient, the image width, an element of
# the rotation and one of the translation, as they are written there; and what is not a
# number there.
PLACES = {
    "opencv-yaml": (
        "stereo.yml",
        "790.",
        "-0.28",
        "640",
        "0.6, 0., 0.8",
        "-0.2, 0.01",
        ".Nan",
    ),
    "opencv-xml": ("stereo.xml", "790.", "-0.28", "640", "0.6 0. 0.8", "-0.2 0.01", ".Nan"),
    "opencv-camera": ("left.yml", "800.", "-0.3", "640", "", "", ".Inf"),
    "opencv-fisheye": (
        "pair.yml",
        "790.",
        "-0.28",
        "640",
        "0.6, 0., 0.8",
        "-0.2, 0.01",
        ".Inf",
    ),
    "ros": ("right.yaml", "790.0", "-0.28", "640", "-0.6, 0.0, 0.8", "-140.0", ".nan"),
    "ros-message": ("info.yaml", "800.0", "-0.3", "640", "R: [1.0", "-0.3", ".nan"),
    "kalibr": ("camchain.yaml", "790.0", "-0.03", "640", "0.6, 0.0, 0.8", "-0.2", ".nan"),
    "anipose": (
        "calibration.toml",
        "790.0",
        "-0.28",
        "640",
        "-0.6435011087932844",
        "-0.2",
        "nan",
    ),
    "pose2sim": (
        "Calib.toml",
        "790.0",
        "-0.28",
        "640.0",
        "-0.6435011087932844",
        "-0.2",
        "inf",
    ),
    "caliscope": (
        "camera_array.toml",
        "790.0",
        "-0.28",
        "640",
        "-0.64350110879",
        "-0.2",
        "nan",
    ),
    "caliscope-old": (
        "config.toml",
        "790.0",
        "-0.28",
        "640",
        "0.6, 0.0, 0.8",
        "-0.2",
        "-inf",
    ),
    "mrcal": (
        "right.cameramodel",
        "790.0",
        "-0.28",
        "640",
        "-0.6435011087932844",
        "-0.2",
        "nan",
    ),
    "colmap": ("cameras.txt", "790", "-0.28", "640", "", "", "nan"),
    "matlab-json": ("rig.json", "790", "-0.28", "640", "[-0.6, 0, 0.8]", "-200", "NaN"),
    "nerfstudio": (
        "transforms.json",
        "790.0",
        "-0.28",
        "640",
        "-0.6, 0.0, -0.8",
        "-0.144",
        "NaN",
    ),
    "multical": (
        "calibration.json",
        "790.0",
        "-0.28",
        "640",
        "0.6, 0.0, 0.8",
        "-0.2",
        "Infinity",
    ),
    "bop": ("scene_camera.json", "790.0", "", "", "0.6, 0.0, 0.8", "-200.0", "-Infinity"),
    "rigcal": ("cameras.csv", "790", "-0.28", "640", "", "", "nan"),
}
IS_VECTOR = ("anipose", "pose2sim", "caliscope", "mrcal")


def spoilt(name):
    """For a sample, (what was done, the file, its text), each with one wrong number."""
    file, f, k, width, rotation, t, nan = PLACES[name]
    text = SAMPLES[name].files[file]

    def put(old, new, what):
        assert old in text, (name, old)
        yield what, file, text.replace(old, new, 1)

    def number(old, what):
        for new in (nan, '"x"', "1e400", "[]", "1e31", "2;5"):
            yield from put(old, new, f"{what} {new}")

    yield from number(f, "focal")
    for new in ("0.0", "-790.0", "1e10", "true", "null", "{}"):
        yield from put(f, new, f"focal {new}")
    if k:
        yield from number(k, "coefficient")
        yield from put(k, "1e10", "coefficient 1e10")
    if width:
        for new in ("0", "-640", "640.5", "2000000", '"wide"', nan):
            yield from put(width, new, f"width {new}")
    if rotation and name not in IS_VECTOR:
        yield from put(
            rotation, rotation.replace("0.8", "0.9").replace("1.0", "1.1"), "rotation"
        )
        yield from put(
            rotation, rotation.replace("0.8", "-0.8").replace("1.0", "-1.0"), "mirror"
        )
    if rotation and name in IS_VECTOR:
        yield from put(rotation, "1e7", "a long turn")
        yield from put(rotation, f"{nan}", "turn")
    if t and name != "ros-message":
        for case in number(t, "translation"):
            # 1e31 is 1e28 m when it is divided by a focal length or in millimetres
            if "1e31" not in case[0] or name not in ("ros", "matlab-json", "bop"):
                yield case


# ==== broken in the way of the format =========================================

EDITS = {
    "opencv-yaml": [
        ("M1: ", "N1: ", "matrix1|is missing"),
        ("M2: ", "N2: ", "cameramatrix2 .* is missing"),
        ("R: ", "Q: ", "r or rotation"),
        ("T: ", "Q: ", "t or translation"),
        ("D1: ", "B1: ", "distortioncoefficients1 .* is missing"),
        ("D2: ", "xi2: ", '"omni" is not supported'),
        ("imageSize: ", "xi: 1.2\nimageSize: ", '"omni" is not supported'),
        ("rows: 3", "rows: 4", "rows x cols"),
        ("rows: 3", "rows: -3", "whole number"),
        ("cols: 5", "cols: 4", "rows x cols"),
        ("   rows: 3\n", "", "rows is missing"),
        ("   data: [ 800., 0., 320.5, 0., 810., 240.25, 0., 0., 1. ]\n", "", "numbers"),
        ("800., 0., 320.5", "800., 5., 320.5", "skew"),
        ("0., 0., 1. ]", "0., 1., 1. ]", "0 0 1"),
        ("M2: ", "M1: ", "M1 is there twice"),
        ("M2: ", "m1: ", "twice, spelt in two ways"),
        ("!!opencv-matrix", "!!opencv-nd-matrix", "line 5: no YAML"),
        ("[ 640, 480 ]", "[ 640 ]", "shape"),
        ("[ 640, 480 ]", "wide", "numbers"),
        ("---\n", "---\nlens: [\n", "no YAML"),
        ("0.05 ]", "0.05, 0., 0., 0., 1. ]", "rows x cols|coefficients"),
        (
            "   cols: 5\n   dt: d\n   data: [ -0.28, 0.08,",
            "   cols: 4\n   data: [ 0.08,",
            "pass",
        ),
        (
            "   cols: 5\n   dt: d\n   data: [ -0.28,",
            "   cols: 6\n   data: [ 1, -0.28,",
            "6",
        ),
    ],
    "opencv-xml": [
        ("<opencv_storage>", "<storage>", "no XML"),
        ("</opencv_storage>", "", "no XML"),
        ("opencv_storage", "storage", "no XML"),
        ("<rows>3</rows>", "<rows>4</rows>", "rows x cols"),
        ("<rows>3</rows>", "<rows>three</rows>", "numbers"),
        ("<rows>3</rows>", "", "rows is missing"),
        ("cameraMatrix2", "cameraMatrix1", "no XML"),
        ("<R type_id", "<Q type_id", "no XML"),
        (
            '<?xml version="1.0"?>',
            "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b 'c'>]>",
            "<!",
        ),
        ("790. 0. 310.5", "790. &b; 310.5", "no XML"),
        ("790. 0. 310.5", "790. 1. 310.5", "skew"),
        ("790. 0. 310.5 0.", "790. 0. 310.5", "rows x cols"),
        ("<T type_id", '<R type_id="opencv-matrix"/><T type_id', "R is there twice"),
        ("640 480", "640", "shape"),
        ("640 480", "<a/>", "named|numbers|expected"),
    ],
    "opencv-camera": [
        ("camera_matrix: ", "camera_matrices: ", "no known format"),
        ("image_height: 480\n", "", "imageheight is missing"),
        ("fisheye_model: 0", "fisheye_model: 1", "4 coefficients"),
        ("fisheye_model: 0", "fisheye_model: maybe", "numbers"),
        ("rows: 3", "rows: 2", "rows x cols"),
        ("rows: 5\n   cols: 1", "rows: 5", "cols is missing"),
        ("0.05 ]", "]", "rows x cols"),
        ("%YAML:1.0\n---", "%YAML:1.0\n--- {", "no YAML"),
        ("flags: 0", "flags: 0\nflags: 1", "flags is there twice"),
        ("flags: 0", "\tflags: 0", "no YAML"),
        ("flags: 0", "flags: *gone", "no YAML"),
        ("flags: 0", "flags: 2001-99-99", "no YAML"),
        ("flags: 0", "? [a, b]\n: 1", "no YAML|hashable"),
    ],
    "opencv-fisheye": [
        ("data: [ -0.28, 0.08,", "data: [ 0.08,", "rows x cols"),
        (
            "cols: 4\n   dt: d\n   data: [ -0.28,",
            "cols: 5\n   data: [ 1, -0.28,",
            "4 coefficients",
        ),
        ("R: ", "R2: ", "r or rotation"),
        ("D1: ", "M1: ", "M1 is there twice"),
    ],
    "ros": [
        (
            "distortion_model: plumb_bob",
            "distortion_model: thin_prism_fisheye",
            "thin_prism",
        ),
        ("distortion_model: plumb_bob", "distortion_model: kb8", "kb8"),
        ("distortion_model: plumb_bob", "distortion_model: [1]", "text"),
        ("distortion_model: plumb_bob", "distortion_model:", "distortion_model is missing"),
        ("distortion_model: plumb_bob", "distortion_model: equidistant", "4 coefficients"),
        ("camera_matrix:", "kamera_matrix:", "no known format"),
        ("image_width: 640\n", "", "image_width or width is missing"),
        ("image_height: 480\n", "", "image_height or height is missing"),
        ("camera_name: right", "camera_name: [right]", "text"),
        ("cols: 5\n", "cols: 4\n", "rows x cols"),
        ("0.0015, -0.02]", "0.0015, -0.02, 3]", "rows x cols"),
        (
            "distortion_coefficients",
            "distortions",
            " or D or d is missing",
        ),
        ("-140.0, 0.0, 700.0", "-140.0, 0.0, 0.0", "rectified"),
        ("1.0, 0.0]", "1.0, 7.0]", "rectified"),
        ("cols: 4\n  data: [700.0, 0.0,", "cols: 3\n  data: [0.0,", "rows x cols|shape"),
        ("790.0, 0.0, 310.5", "790.0, 1.0, 310.5", "skew"),
        ("camera_matrix:\n", "camera_matrix:\n  rows: 3\n", "rows is there twice"),
        (
            "rectification_matrix:\n  rows: 3",
            "rectification_matrix:\n  rows: 9",
            "rows x cols",
        ),
    ],
    "ros-message": [
        ("0.003]", "0.003, 0.1, 0.0, 0.0, 0.0]", "thin prism"),
        ("0.003]", "0.003, 0, 0, 0, 0, 0.1, 0]", "tilted"),
        ("0.003]", "0.003, 0]", "9"),
        ("  width: 0", "  width: half", "numbers"),
        ("binning_x: 0", "binning_x: {}", "one number"),
        ("roi:\n", "roi: 7\nrest:\n", "named values"),
        ("header:\n", "header: 7\nrest:\n", "named values"),
        ("K: [800.0,", "K: [", "shape"),
        ("K: [800.0", "K: [[800.0]", "equal rows"),
    ],
    "kalibr": [
        ("camera_model: pinhole", "camera_model: omni", '"omni" is not supported'),
        ("camera_model: pinhole", "camera_model: ds", '"ds" is not supported'),
        ("camera_model: pinhole", "camera_model: eucm", '"eucm" is not supported'),
        (
            "distortion_model: equidistant",
            "distortion_model: fov",
            '"fov" is not supported',
        ),
        ("distortion_model: equidistant", "distortion_model: 5", '"5" is not supported'),
        ("  distortion_model: equidistant\n", "", "cam0: distortion_model is missing"),
        ("cam1:", "cam0:", "cam0 is there twice"),
        ("cam1:", "left:", "left: the cameras of a camchain are cam0"),
        ("T_cn_cnm1:", "T_cn_c0:", "cam1: T_cn_cnm1 is missing"),
        ("  - [0.0, 1.0, 0.0, 0.01]\n", "", "T_cn_cnm1: the last row|shape|not a rotation"),
        ("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 0.1, 1.0]", "last row"),
        ("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 1.0]", "equal rows"),
        ("intrinsics: [800.0,", "intrinsics: [", r"cam0.intrinsics: shape \(4,\)"),
        ("intrinsics: [800.0", "intrinsics: [[800.0]", "equal rows"),
        ("resolution: [640, 480]", "resolution: [640]", "resolution"),
        ("resolution: [640, 480]\n", "\n", "resolution is missing"),
        ("distortion_coeffs: [-0.02,", "distortion_coeffs: [", r"shape \(4,\)"),
        ("cam_overlaps: [1]", "cam_overlaps: [1", "no YAML"),
        ("cam0:\n", "cam0: 5\nrest:\n", "camchain are cam0"),
        ("  camera_model: pinhole", "camera_model: pinhole", "no YAML"),
    ],
    "anipose": [
        ('name = "right"', 'name = "left"', "left is there twice"),
        ('name = "right"', "name = 1.5", "text"),
        ("distortions = [ -0.28", "distortion = [ -0.28", "cam_1: distortions is missing"),
        ('name = "right"', 'name = ""', "text"),
        ("[cam_1]", "[cam_0]", "no TOML"),
        ("[cam_1]", "[cam_1", "no TOML"),
        ("matrix = [ [ 790", "matrices = [ [ 790", "matrix is missing"),
        (
            "rotation = [ 0.0, -0.64",
            "rot = [ 0.0, -0.64",
            "one of rotation and translation",
        ),
        ("translation = [ -0.2", "trans = [ -0.2", "one of rotation and translation"),
        ("translation = [ -0.2,", "translation = [", r"shape \(3,\)"),
        ("rotation = [ 0.0, -0.64", "rotation = [ -0.64", r"shape \(3, 3\)"),
        ("[ 0.0, 795.0, 250.75,], [", "[ 0.0, 795.0,], [", "equal rows"),
        ("[ 0.0, 795.0, 250.75,], ", "", r"shape \(3, 3\)"),
        ("790.0, 0.0, 310.5", "790.0, 3.0, 310.5", "skew"),
        ("0.0, 0.0, 1.0,],]\ndist", "0.0, 0.0, 2.0,],]\ndist", "0 0 1"),
        ("-0.28, 0.08, -0.0005,", "-0.0005,", "3"),
        ("-0.02,]", "-0.02, 0, 0, 0, 1, 0, 0, 0,]", "thin prism"),
        ("size = [ 640, 480,]", "size = 640", "size"),
        ("size = [ 640, 480,]", "size = [ 1979-05-27, 480,]", "numbers"),
        ("error = 0.42", "error = 0.42.1", "no TOML"),
        ("error = 0.42", "error = 0.42\nfisheye", "no TOML"),
    ],
    "pose2sim": [
        ("fisheye = false", "fisheye = 'no'", "true or false"),
        ("fisheye = false", "fisheye = falsch", "no TOML"),
        ("-0.28, 0.08", "-0.28, 0.08, 1, 2, 3, 4, 5", "9"),
    ],
    "caliscope": [
        ("[cameras.1]", "[cameras.0]", "no TOML"),
        ("[cameras.1]", "[cameras]", "no TOML|named values"),
        ("matrix = [[790", "matric = [[790", "cameras.1: matrix is missing"),
        ("rotation = [0.0, -0.64", "rotation = [[0.0, -0.64", "no TOML"),
        ("ignore = false", "ignore = 'no'", "true or false"),
        ("cam_id = 0", "cam_id = 0\ncam_id = 1", "no TOML"),
        ("-0.28, 0.08, -0.0005", "-0.28", "3"),
        ("[[790.0, 0.0, 310.5], ", "[", r"shape \(3, 3\)"),
    ],
    "caliscope-old": [
        ("[cam_1]", "[cam_0]", "no TOML"),
        ("[ 0.6, 0.0, 0.8,],]", "[ 0.6, 0.0,],]", "equal rows"),
        ("[ 0.6, 0.0, 0.8,],]", "]", r"shape \(3, 3\)"),
        ("ignore = true", "ignore = false", "matrix is missing"),
        ("2023-03-31T09:56:43.193358", "2023-33-31T09:56:43", "no TOML"),
    ],
    "mrcal": [
        ("LENSMODEL_OPENCV8", "LENSMODEL_CAHVOR", "CAHVOR. is not supported"),
        (
            "LENSMODEL_OPENCV8",
            "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30_Ny=20_fov_x_deg=170",
            "SPLINED_STEREOGRAPHIC",
        ),
        ("LENSMODEL_OPENCV8", "LENSMODEL_OPENCV12", "shape"),
        ("LENSMODEL_OPENCV8", "LENSMODEL_LATLON", "LATLON"),
        ("LENSMODEL_OPENCV8", "LENSMODEL_OPENCV5", "shape"),
        (
            "'lens_model':  'LENSMODEL_OPENCV8',",
            "'lens_model': LENSMODEL_OPENCV8,",
            "no JSON|lens",
        ),
        ("'intrinsics':", "'intrinsic':", "intrinsics is missing"),
        ("'imagersize':", "'imagesize':", "imagersize is missing"),
        ("'extrinsics': [ 0.0,", "'extrinsics': [", r"extrinsics: shape \(2, 3\)"),
        ("'icam_intrinsics': 1", "'imagersize': 1", "imagersize is there twice"),
        ("'icam_intrinsics': 1", "'icam_intrinsics': open('a')", "no Python dictionary"),
        ("'icam_intrinsics': 1", "'icam_intrinsics': 1 +", "no Python dictionary"),
        ("'icam_intrinsics': 1", "'icam_intrinsics' 1", "no Python dictionary"),
        ("'icam_intrinsics': 1", "**{}", "no Python dictionary"),
        ("'icam_intrinsics': 1", "[]: 1", "no Python dictionary"),
        ("'icam_intrinsics': 1", "a.b: 1", "no Python dictionary"),
        ("'intrinsics': [", "'intrinsics': [ b'1',", "numbers"),
        ("'imagersize': [ 640, 480,]", "'imagersize': 640", "imagersize"),
        ("'imagersize': [ 640, 480,]", "'imagersize': [ 640, 480, 3]", "imagersize"),
        ("b'0Z9lw',\n}", "b'0Z9lw',\n", "no Python dictionary"),
        ("{\n", "{\n{\n", "no Python dictionary"),
    ],
    "colmap": [
        ("2 OPENCV 640", "1 OPENCV 640", "line 5: camera 1 is there twice"),
        ("2 OPENCV 640", "2 FOV 640", '"FOV" is not supported'),
        ("2 OPENCV 640", "2 THIN_PRISM_FISHEYE 640", "THIN_PRISM_FISHEYE"),
        ("2 OPENCV 640", "2 RAD_TAN_THIN_PRISM_FISHEYE 640", "RAD_TAN"),
        ("2 OPENCV 640", "2 SIMPLE_DIVISION 640", "SIMPLE_DIVISION"),
        ("2 OPENCV 640", "2 EUCM 640", "EUCM"),
        ("2 OPENCV 640", "2 FULL_OPENCV 640", "shape"),
        ("2 OPENCV 640", "2 PINHOLE 640", "shape"),
        ("2 OPENCV 640", "two OPENCV 640", "line 5: CAMERA_ID MODEL"),
        ("2 OPENCV 640", "OPENCV 640", "line 5: CAMERA_ID MODEL"),
        ("2 OPENCV 640", "2 opencv 640", "line 5: CAMERA_ID MODEL"),
        ("2 OPENCV 640", "2", "line 5: CAMERA_ID MODEL"),
        ("0.0015\n", "\n", "shape"),
        ("1 OPENCV 640", "x", "no known format|expected"),
        ("1 OPENCV 640", "# 1 OPENCV 640", "images.txt: line 4: camera 1 is not in"),
    ],
    "matlab-json": [
        ('"CameraParameters2"', '"CameraParameters3"', "CameraParameters2 is missing"),
        ('"CameraParameters2"', '"CameraParameters1"', "CameraParameters1 is there twice"),
        ('"RotationOfCamera2"', '"RotationOfCamera3"', "RotationOfCamera2 is missing"),
        ('"TranslationOfCamera2"', '"Translation"', "TranslationOfCamera2 is missing"),
        ('"RotationOfCamera2"', '"PoseCamera2"', "named values"),
        ('"RadialDistortion": [-0.28', '"Radial": [-0.28', "RadialDistortion is missing"),
        ("[-0.28, 0.08, -0.02]", "[-0.28]", "2 or 3 coefficients"),
        ("[-0.28, 0.08, -0.02]", "[-0.28, 0.08, -0.02, 0.1]", "2 or 3 coefficients"),
        ("[-0.0005, 0.0015]", "[-0.0005]", r"shape \(2,\)"),
        ('"TangentialDistortion": [-0', '"Tan": [-0', "TangentialDistortion is missing"),
        ('"millimeters"', '"furlongs"', "furlongs.*pass scale="),
        ('"millimeters"', "5", "pass scale="),
        ('"IntrinsicMatrix": [[790', '"Matrix": [[790', "FocalLength is missing"),
        ("[790, 0, 0]", "[790, 1, 0]", "0 cx|skew"),
        ("[790, 0, 0]", "[790, 0]", "equal rows"),
        ("[790, 0, 0], ", "", r"shape \(3, 3\)"),
        ("[311.5, 251.75, 1]", "[311.5, 251.75, 2]", "0 0 1"),
        ('"ImageSize": [480, 640]', '"ImageSize": [480]', "ImageSize"),
        ('"ImageSize": [480, 640]', '"ImageSize": "big"', "ImageSize"),
        ("[-200, 10, 30]", "[-200, 10]", r"shape \(3,\)"),
        ("[-200, 10, 30]", "[-200, 10, 30", "no JSON"),
    ],
    "nerfstudio": [
        (
            '"camera_model": "OPENCV"',
            '"camera_model": "EQUIRECTANGULAR"',
            "EQUIRECTANGULAR",
        ),
        ('"camera_model": "OPENCV"', '"camera_model": "FISHEYE624"', "FISHEYE624"),
        ('"camera_model": "OPENCV"', '"camera_model": 4', '"4" is not supported'),
        ('"camera_model": "OPENCV"', '"camera_model": {}', "text"),
        (
            '"camera_model": "OPENCV"',
            '"camera_model": "OPENCV_FISHEYE"',
            "p1: this model has no",
        ),
        ('"frames": [', '"frame": [', "no known format"),
        ('"k1": -0.28', '"k4": 0.1', "k4: this model has no k4"),
        ('"k1": -0.28', '"k5": 0.1', "k5: this model has no k5"),
        ('"w": 640,', "", "w is missing"),
        ('"h": 480,', '"h": [480],', "."),
        ('"fl_x": 790.0, ', "", r"frames\[1\]: fl_x is missing"),
        ('"cx": 311.0, ', "", r"frames\[1\]: cx is missing"),
        (
            '"file_path": "images/right.png"',
            '"file": "images/right.png"',
            "file_path is missing",
        ),
        (
            '"file_path": "images/right.png"',
            '"file_path": "images/left.png"',
            "is there twice",
        ),
        ('"file_path": "images/right.png"', '"file_path": null', "file_path is missing"),
        (
            "[-0.6, 0.0, -0.8, -0.144], [0.0, 0.0, 0.0, 1.0]",
            "[0, 0, 0, 1]",
            r"shape|rotation",
        ),
        ("-0.144], [0.0, 0.0, 0.0, 1.0]", "-0.144], [0.0, 0.0, 0.0, 2.0]", "last row"),
        ("[0.8, 0.0, -0.6, 0.142]", "[0.8, 0.0, -0.6]", "equal rows"),
        ("[0.8, 0.0, -0.6, 0.142]", "[0.8, 0.0, 0.6, 0.142]", "not a rotation"),
        ('"frames": [', '"frames": [7, ', "named values"),
        ("[0, 0, 1, 0]]", "[0, 0, 1, 0]", "no JSON"),
    ],
    "multical": [
        ('"model": "standard"', '"model": "kannala_brandt"', "kannala_brandt"),
        ('"model": "standard"', '"model": []', "text"),
        ('"cameras": {', '"kameras": {', "no known format"),
        ('"K": [[790', '"k": [[790', "K is missing"),
        ('"dist": [[-0.28', '"distort": [[-0.28', "dist is missing"),
        ("0.0015, -0.02]]", "0.0015]]", "pass lens="),
        ("0.0015, -0.02]]", "0.0015, -0.02, 0, 0, 0, 0.1, 0, 0, 0]]", "thin prism"),
        ("0.0015, -0.02]]", "0.0015, -0.02, 0, 0, 0, 0, 0, 0, 0, 0.1, 0]]", "tilted"),
        ("0.0015, -0.02]]", "0.0015, -0.02]", "no JSON"),
        ('"right_to_left"', '"right_to_middle"', "not among the cameras"),
        ('"right_to_left"', '"left"', "left is there twice"),
        ('    "left": {"R"', '    "left_to_right": {"R"', "lead to"),
        ('"right": {\n      "model"', '"left": {\n      "model"', "left is there twice"),
        ('"T": [-0.2, 0.01, 0.03]', '"t": [-0.2, 0.01, 0.03]', "T is missing"),
        ('"R": [[0.8', '"r": [[0.8', "R is missing"),
        ("[-0.2, 0.01, 0.03]", "[-0.2, 0.01]", r"T: shape \(3,\)"),
        ("[[0.8, 0.0, -0.6], ", "[", r"shape \(3, 3\)"),
        (
            "[0, 0, 0]},",
            '[0, 0, 0]}, "right": {"R": [1,0,0,0,1,0,0,0,1], "T": [1,2,3]},',
            "contra",
        ),
        ('"image_size": [640, 480]', '"image_size": [640, 480, 3]', "image_size"),
        ('"camera_poses": {', '"camera_poses": [', "no JSON"),
    ],
    "bop": [
        ('"1": {', '"0": {', "0 is there twice"),
        ('"1": {"cam_K"', '"1": {"cam_k"', "1: cam_K is missing"),
        ('"1": {', '"1": 7, "2": {', "named values"),
        ('"cam_R_w2c": [0.8,', '"cam_R": [0.8,', "one of cam_R_w2c and cam_t_w2c"),
        ('"cam_t_w2c": [-200.0,', '"cam_t": [-200.0,', "one of cam_R_w2c and cam_t_w2c"),
        ('"cam_R_w2c": [0.8,', '"cam_R_w2c": [', r"shape \(3, 3\)"),
        ('"cam_t_w2c": [-200.0,', '"cam_t_w2c": [', r"shape \(3,\)"),
        ('"cam_K": [790.0, 0.0,', '"cam_K": [790.0,', r"shape \(3, 3\)"),
        ('"cam_K": [790.0, 0.0,', '"cam_K": [790.0, 2.0,', "skew"),
        (
            '0.0, 0.0, 1.0],\n        "depth_scale": 0.1,\n        "cam_R_w2c": [0.8',
            "9]",
            "JSON",
        ),
        ('"0": {', '"0": {"name": {},', "text"),
        ('"0": {', '"0": {"name": "1",', "1 is there twice"),
    ],
    "rigcal": [
        ("right,640", "left,640", "line 3: camera left is there twice"),
        ("right,640", ",640", "text"),
        ("right,640", "my cam,640", "no blanks"),
        ("right,640", '"right",640', "quotes"),
        ("right,640", "right;640", "fields where the header"),
        ("-0.003,brown", "-0.003", "fields where the header"),
        ("-0.003,brown", "-0.003,brown,", "fields where the header"),
        ("-0.003,brown", "-0.003,fisheye", "p1, p2, k5 and k6"),
        ("-0.003,brown", "-0.003,omni", "omni"),
        ("camera,width", "camera,breadth", "width is missing"),
        ("camera,width", "camera,height", "column is there twice"),
        ("width,height,fx", "width,height,f", "no known format"),
        ("camera,width", "cam,width", "no known format"),
        (",k5,k6,lens", ",k5,k5,lens", "column is there twice"),
    ],
}


def broken(name):
    """For a sample, (what was done, the file, its text, what the message must match)."""
    for what, file, text in spoilt(name):
        yield what, file, text, "."
    file = PLACES[name][0]
    good = SAMPLES[name].files[file]
    for old, new, match in EDITS[name]:
        assert old in good, (name, old)
        yield f"{old!r} to {new!r}", file, good.replace(old, new, 1), match


def complaint(path, folder, options):
    """The result of load_cameras for a file. Only a FileError of one line is right."""
    try:
        load_cameras(path, **options)
    except FileError as error:
        text = str(error)
        places = re.findall(r"[^ ]*: ", text)
        is_told_once = len(set(places)) == len(places) > 0
        if text.startswith(str(folder)) and "\n" not in text and is_told_once:
            return text
        return f"WRONG FORM {text!r}"
    except Exception as error:  # any is a failure
        return f"WRONG {type(error).__name__}: {error}"
    return "WRONG: no error"


@pytest.mark.parametrize("name", PLACES)
def test_a_broken_file_says_what_is_wrong(name, tmp_path):
    sample = SAMPLES[name]
    path = sample.put(tmp_path)
    wrong, count = [], 0
    for what, file, text, match in broken(name):
        (tmp_path / file).write_text(text)
        said = complaint(path, tmp_path, sample.options)
        if said.startswith("WRONG") or not re.search(match, said):
            wrong.append(f"{what}: {said} does not match {match}")
        count += 1
    assert wrong == []
    assert count + len(CONTENTS) >= 20


# ==== files beside ============================================================

BESIDE = [
    ("images.txt", "2 0.9486832980505138", "2 x", "line 6: "),
    (
        "images.txt",
        "2 0.9486832980505138 0 -0.31622776601683794 0",
        "2 0 0 0 0",
        "length is 0",
    ),
    ("images.txt", "2 0.9486832980505138", "2 nan", "line 6: a number is NaN"),
    ("images.txt", "2 right", "2", "line 6: IMAGE_ID"),
    ("images.txt", "2 right", "3 right", "line 6: camera 3 is not in cameras.txt"),
    ("images.txt", "2 right", "2 left", "line 6: image left is there twice"),
    ("images.txt", "-0.2 0.01", "1e31 0.01", "line 6: .*1e30"),
    ("images.txt", "# Image", "\0", "zero byte"),
    ("rigs.txt", "CAMERA 2 1 ", "CAMERA 2 ", "line 3: SENSOR_TYPE"),
    ("rigs.txt", "CAMERA 2 1 ", "CAMERA 3 1 ", "line 3: camera 3 is not in"),
    ("rigs.txt", " 0.03\n", "\n", "line 3: shape"),
    ("rigs.txt", " 0.03\n", " 0.03 7\n", "line 3: SENSOR_TYPE"),
    ("rigs.txt", "1 2 CAMERA 1", "1 2 CAMERA 1\n1 2", "line 4: SENSOR_TYPE"),
    (
        "rigs.txt",
        " 0.03\n",
        " 0.03\n2 2 CAMERA 1 CAMERA 2 0\n",
        "2 rigs have several cameras",
    ),
    ("rigs.txt", "CAMERA 2 1 ", "CAMERA 1 1 ", "camera 1 is there twice"),
]


@pytest.mark.parametrize(("file", "old", "new", "match"), BESIDE)
def test_broken_neighbours_of_colmap(file, old, new, match, tmp_path):
    files = {**SAMPLES["colmap"].files}
    if file == "rigs.txt":
        files[file] = COLMAP_RIGS
    assert old in files[file]
    path = Sample("colmap", {**files, file: files[file].replace(old, new, 1)}, {}).put(
        tmp_path
    )
    with pytest.raises(FileError, match=match):
        load_cameras(path)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("right,0.8", "left,0.8", "camera left is there twice"),
        ("0.6,0,0.8", "0.6,0,0.9", "line 3: the matrix is not a rotation"),
        ("0.6,0,0.8", "0.6,0,-0.8", "line 3: the matrix is not a rotation"),
        ("-0.2,0.01", "nan,0.01", "line 3.tx: a number is NaN"),
        ("-0.2,0.01", "1e31,0.01", "1e30"),
        ("-0.2,0.01", "x,0.01", "line 3.tx"),
        ("-0.2,0.01", "0.01", "fields"),
        (",R33,", ",R99,", "R33 is missing"),
    ],
)
def test_a_broken_rig_csv(old, new, match, tmp_path):
    text = SAMPLES["rigcal"].files["rig.csv"]
    assert old in text
    files = {**SAMPLES["rigcal"].files, "rig.csv": text.replace(old, new, 1)}
    with pytest.raises(FileError, match=match) as caught:
        load_cameras(Sample("rigcal", files, {}).put(tmp_path))
    assert caught.value.path.endswith("rig.csv")


# ==== no file of cameras at all ===============================================

CONTENTS = {
    "empty": b"",
    "blank": b" \n\t\n",
    "a mark alone": b"\xef\xbb\xbf",
    "zeros": bytes(100),
    "Latin-1": "Kamera für links".encode("latin-1"),
    "UTF-16": "cam0:\n  a: 1\n".encode("utf-16"),
    "a picture": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
    "an archive": b"PK\3\4\x14\0\0\0",
    "prose": b"The left camera was moved on Saturday.\n",
    "a list": b"[1, 2, 3]",
    "one number": b"42",
    "HTML": b"<!DOCTYPE html>\n<html><body>404</body></html>",
    "foreign JSON": b'{"a": 1}',
    "foreign YAML": b"a: 1\nb: [2]\n",
    "foreign TOML": b"[tool]\na = 1\n",
    "foreign XML": b'<?xml version="1.0"?><svg/>',
    "foreign CSV": b"frame,camera,u,v\n1,left,2,3\n",
    "header alone": b"camera,width,height,fx,fy,cx,cy\n",
    "old CAHVOR": b"Dimensions = 640 480\nModel = CAHVOR = perspective, distortion\n",
    "deep JSON": b'{"a":' * 100000,
    "deep lists": b'{"cam_K":' + b"[" * 100000,
    "deep YAML": b"a: " + b"[" * 20000,
    "deep list of YAML": b"- " * 3000,
    "deep TOML": b"[a]\nb = " + b"[" * 100000,
    "deep Python": b"{'lens_model': 'LENSMODEL_X', 'a': " + b"(" * 100000,
    "deep signs": b"{'lens_model': 'LENSMODEL_X', 'a': " + b"-" * 100000 + b"1}",
    "deep XML": b"<?xml version='1.0'?><opencv_storage>" + b"<a>" * 50000,
    "closed XML": b"<opencv_storage>"
    + b"<a>" * 9000
    + b"</a>" * 9000
    + b"</opencv_storage>",
    "long number in JSON": b'{"0": {"cam_K": ' + b"1" * 10000 + b"}}",
    "long number in YAML": b"cam0: {camera_model: pinhole, a: " + b"1" * 10000 + b"}",
    "long number in TOML": b"[cam]\nmatrix = " + b"1" * 10000,
    "many numbers": b'{"0": {"cam_K": [' + b"1," * 50000 + b"1]}}",
    "many levels": b'{"0": {"cam_K": ' + b"[" * 200 + b"1" + b"]" * 200 + b"}}",
    "laughs": b"a: &a [1, 2]\n"
    + b"".join(
        b"%c: &%c [*%c, *%c]\n" % (98 + i, 98 + i, 97 + i, 97 + i) for i in range(24)
    )
    + b"M: *y\n",
    "MATLAB 7.3": b"MATLAB 7.3 MAT-file" + bytes(500),
    "MATLAB cut": b"MATLAB 5.0 MAT-file" + bytes(500),
    "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(500),
    "stored": b"RIGCxxxx",
    "no cameras in JSON": b'{"cameras": {}}',
    "no frames": b'{"frames": []}',
}


@pytest.mark.parametrize("what", CONTENTS)
def test_what_is_no_file_of_cameras(what, tmp_path, monkeypatch):
    from rigcal.formats import stored

    monkeypatch.setattr(stored, "load_bytes", None)
    (tmp_path / "file").write_bytes(CONTENTS[what])
    formats = (None, *{sample.format for sample in SAMPLES.values()}, "stored")
    for format in sorted(formats, key=str):
        with pytest.raises(FileError) as caught:
            load_cameras(tmp_path / "file", format)
        assert str(caught.value).startswith(f"{tmp_path / 'file'}: ")
        assert len(str(caught.value)) < 600


def test_paths_that_cannot_be_read(tmp_path):
    (tmp_path / "folder").mkdir()
    for path in ("gone.yaml", "gone/a.yaml", "folder", "a\0b"):
        with pytest.raises(FileError):
            load_cameras(f"{tmp_path}/{path}")
        with pytest.raises(FileError):
            load_target(f"{tmp_path}/{path}")


def test_a_file_that_is_too_large(tmp_path, monkeypatch):
    from rigcal.formats import _common

    monkeypatch.setattr(_common, "FILE_MAX", 100)
    (tmp_path / "file").write_bytes(b"#" * 101)
    with pytest.raises(FileError, match="no camera file"):
        load_cameras(tmp_path / "file")


def test_yaml_that_is_too_large(tmp_path, monkeypatch):
    from rigcal.formats import _text

    monkeypatch.setattr(_text, "YAML_MAX", 100)
    (tmp_path / "file").write_text("a: 1\n" * 21)
    with pytest.raises(FileError, match="no camera file"):
        load_cameras(tmp_path / "file")


EMPTY = {
    "kalibr": "{}",
    "multical": '{"cameras": {}}',
    "bop": "{}",
    "nerfstudio": '{"frames": []}',
    "anipose": "[metadata]\nerror = 1\n",
    "matlab": "{}",
    "colmap": "# none\n",
    "mrcal": "{}",
}


@pytest.mark.parametrize("format", EMPTY)
def test_a_format_without_a_camera(format, tmp_path):
    (tmp_path / "file").write_text(EMPTY[format])
    with pytest.raises(FileError):
        load_cameras(tmp_path / "file", format)


# ==== .mat files ==============================================================


def matlab_struct():
    return json.loads(SAMPLES["matlab-json"].files["rig.json"])


def test_a_mat_file_is_read_and_broken_ones_are_named(tmp_path):
    io = pytest.importorskip("scipy.io")
    struct = {
        key: {k: np.array(v) if isinstance(v, list) else v for k, v in part.items()}
        if isinstance(part, dict)
        else np.array(part)
        for key, part in matlab_struct().items()
    }
    io.savemat(tmp_path / "rig.mat", {"stereo": struct})
    assert len(load_cameras(tmp_path / "rig.mat")) == 2
    io.savemat(tmp_path / "flat.mat", struct)
    assert len(load_cameras(tmp_path / "flat.mat")) == 2
    data = (tmp_path / "rig.mat").read_bytes()
    for length in [128, 130, 136, 150, 200, 300, 500, 700, 900, len(data) - 8]:
        (tmp_path / "cut.mat").write_bytes(data[:length])
        with pytest.raises(FileError):
            load_cameras(tmp_path / "cut.mat")
    for key, value in [
        ("RotationOfCamera2", np.eye(2)),
        ("RotationOfCamera2", "text"),
        ("RotationOfCamera2", np.eye(3) * 2),
        ("RotationOfCamera2", np.full((3, 3), np.nan)),
        ("RotationOfCamera2", np.eye(3) * 1j),
        ("TranslationOfCamera2", [1, 2]),
        ("TranslationOfCamera2", []),
        ("CameraParameters2", 5),
        ("CameraParameters2", {"RadialDistortion": 1}),
        ("CameraParameters1", np.array([], dtype=object)),
        ("WorldUnits", "ells"),
    ]:
        io.savemat(tmp_path / "bad.mat", {"s": {**struct, key: value}})
        with pytest.raises(FileError):
            load_cameras(tmp_path / "bad.mat")
    io.savemat(tmp_path / "other.mat", {"x": [1, 2, 3]})
    with pytest.raises(FileError, match="no struct"):
        load_cameras(tmp_path / "other.mat")
    with pytest.raises(FileError, match="no struct"):
        load_cameras(tmp_path / "other.mat", "matlab")


def test_an_object_of_matlab_is_named(tmp_path, monkeypatch):
    from rigcal.formats import matlab

    monkeypatch.setattr(matlab, "load_mat", lambda data: {"__function_workspace__": 1})
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file")
    with pytest.raises(FileError, match="toStruct"):
        load_cameras(tmp_path / "a.mat")


def test_without_scipy(tmp_path, monkeypatch):
    import sys

    from rigcal import save_cameras

    monkeypatch.setitem(sys.modules, "scipy.io", None)
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file")
    with pytest.raises(FileError, match="need scipy"):
        load_cameras(tmp_path / "a.mat")
    with pytest.raises(FileError, match="need scipy"):
        save_cameras(tmp_path / "b.mat", SAMPLES["anipose"].truth)


# ==== chance ==================================================================


@pytest.mark.parametrize("name", PLACES)
def test_cut_files_and_changed_bytes_never_do_anything_else(name, tmp_path):
    """Some are still valid files. The others must give a FileError."""
    sample = SAMPLES[name]
    path = sample.put(tmp_path)
    file = PLACES[name][0]
    data = sample.files[file].encode()
    dice = random.Random(name)
    refused = 0
    cases = [data[: len(data) * i // 20] for i in range(20)]
    for _ in range(30):
        changed = bytearray(data)
        for _ in range(dice.choice([1, 1, 3])):
            at = dice.randrange(len(changed))
            changed[at] = dice.choice(
                b"0123456789.-+eE[]{}()<>,:;#'\"\\ \n\t\0\xffaZ&*!%@|"
            )
        cases.append(bytes(changed))
    for case in cases:
        (tmp_path / file).write_bytes(case)
        try:
            load_cameras(path, **sample.options)
        except FileError:
            refused += 1
    assert refused >= 8


def test_a_rotation_whose_squares_overflow(tmp_path):
    sample = SAMPLES["kalibr"]
    path = sample.put(tmp_path)
    path.write_text(sample.files[path.name].replace("0.6, 0.0, 0.8", "1e300, 0.0, 0.8"))
    with pytest.raises(FileError, match="not a rotation"):
        load_cameras(path)


# ==== targets =================================================================

TARGET = "target_type: aprilgrid\ntagCols: 6\ntagRows: 4\ntagSize: 0.1\ntagSpacing: 0.3\n"


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("aprilgrid", "charuco", "one of aprilgrid, checkerboard, circlegrid"),
        ("aprilgrid", "[a]", "text"),
        ("aprilgrid", "checkerboard", "targetCols is missing"),
        ("aprilgrid", "circlegrid", "targetCols is missing"),
        ("target_type", "type", "target_type is missing"),
        ("tagCols: 6", "tagCols: 0", "1 to 1000"),
        ("tagCols: 6", "tagCols: 6.5", "whole number"),
        ("tagCols: 6", "tagCols: -6", "whole number"),
        ("tagCols: 6", "tagCols: 100000", "1 to 1000"),
        ("tagCols: 6", "tagCols: many", "numbers"),
        ("tagCols: 6", "tagCols:", "tagCols is missing"),
        ("tagCols: 6", "tagRows: 6", "tagRows is there twice"),
        ("tagSize: 0.1", "tagSize: 0", "above 0"),
        ("tagSize: 0.1", "tagSize: -1", "above 0"),
        ("tagSize: 0.1", "tagSize: .nan", "NaN"),
        ("tagSize: 0.1", "tagSize: [0.1, 0.2]", "one number"),
        ("tagSpacing: 0.3", "tagSpacing: 0", "above 0"),
        ("tagSpacing: 0.3", "tagSpacing: .inf", "infinite"),
        ("tagSpacing: 0.3", "tagSpacing: 0.3\nasymmetricGrid: maybe", "true or false"),
        ("target_type", "{", "no YAML"),
        (TARGET, "", "empty"),
        (TARGET, "[1]", "named values"),
    ],
)
def test_a_broken_target(old, new, match, tmp_path):
    (tmp_path / "t.yaml").write_text(TARGET.replace(old, new, 1))
    with pytest.raises(FileError, match=match):
        load_target(tmp_path / "t.yaml")


def test_targets_that_there_cannot_be(tmp_path):
    from rigcal import Target

    for arguments in [
        ("x", 1, 1, 1.0),
        ("aprilgrid", 1.5, 1, 1.0),
        ("circlegrid", 1, 1, np.inf),
    ]:
        with pytest.raises(Error):
            Target(*arguments)
    with pytest.raises(Error, match="tag 4 is not on this target"):
        Target("aprilgrid", 2, 2, 0.1, 0.3).corners(4)
