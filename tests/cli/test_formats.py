"""Files of other programs: each is named, with what to do and where to read on."""
import io
import os
import re
import unittest
import zipfile

from cli_support import ROOT, STEREO, CliTest, content, rigcal, write

FORMAT = content(os.path.join(ROOT, "examples", "data"), "FORMAT.md")
HEADINGS = re.findall(r"(?m)^##+ (.*)$", FORMAT)

OPENCV_YAML = """%YAML:1.0
---
image_width: 1280
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 900.5, 0., 640., 0., 905.25, 470., 0., 0., 1. ]
"""
OPENCV_XML = """<?xml version="1.0"?>
<opencv_storage>
<image_width>1280</image_width>
</opencv_storage>
"""
OPENCV_JSON = """{
    "image_width": 1280,
    "camera_matrix": {
        "type_id": "opencv-matrix",
        "rows": 3
    }
}
"""
KALIBR = """cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.27, 0.06, 0.0008, 0.0001]
  distortion_model: radtan
  intrinsics: [461.6, 460.1, 362.6, 246.0]
  resolution: [752, 480]
"""
ROS = """image_width: 640
image_height: 480
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [532.8, 0, 342.4, 0, 532.9, 233.8, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.02, 0.001, -0.0001, 0.16]
"""
ROS_MESSAGE = """header:
  frame_id: left
height: 480
width: 640
distortion_model: plumb_bob
d:
- -0.28
"""
ROS_INI = """# oST version 5.0 parameters


[image]

width
640
"""
COLMAP_CAMERAS = """# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 1
1 SIMPLE_RADIAL 3072 2304 2559.69 1536 1152 -0.0218531
"""
COLMAP_IMAGES = """# Image list with two lines of data per image:
#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
#   POINTS2D[] as (X, Y, POINT3D_ID)
1 0.85 0.01 0.50 -0.14 -0.73 1.02 3.74 1 P1180141.JPG
2362.39 248.498 58396 1784.7 268.254 59027
"""
TOML = """[metadata]
adjusted = false

[cam_00]
name = "cam_00"
size = [ 1088, 1920,]
matrix = [ [ 1681.0, 0.0, 540.0,], [ 0.0, 1681.0, 960.0,], [ 0.0, 0.0, 1.0,],]
"""
MATLAB_TEXT = """% Intrinsic and Extrinsic Camera Parameters

%-- Focal length:
fc = [ 657.395 ; 657.763 ];
"""
MRCAL = """{
    'lensmodel':  'LENSMODEL_OPENCV5',
    'intrinsics': [ 532.8, 532.9, 342.4, 233.8, 0, 0, 0, 0, 0,],
}
"""
LFS = """version https://git-lfs.github.com/spec/v1
oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393
size 12345
"""


def spreadsheet():
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")
    return data.getvalue()


def separated(by):
    return content(STEREO, "observations.csv").replace(",", by)


# For each file: its name, what the message says that it looks like, and the section, if
# any.
FILES = {
    "OpenCV YAML": (OPENCV_YAML, "OpenCV's YAML", "OpenCV"),
    "OpenCV YAML without matrices": ("%YAML:1.0\n---\nmodel_type: PINHOLE\n",
                                     "OpenCV's YAML", "OpenCV"),
    "OpenCV YAML without its head": (OPENCV_YAML.split("---\n")[1], "OpenCV's YAML",
                                     "OpenCV"),
    "OpenCV XML": (OPENCV_XML, "OpenCV's XML", "OpenCV"),
    "OpenCV JSON": (OPENCV_JSON, "OpenCV's JSON", "OpenCV"),
    "Kalibr": (KALIBR, "Kalibr's camchain YAML", "Kalibr"),
    "ROS": (ROS, "ROS's camera_info YAML", "ROS"),
    "ROS, a message": (ROS_MESSAGE, "ROS's camera_info YAML", "ROS"),
    "ROS, INI": (ROS_INI, "ROS's camera calibration in INI form", "ROS"),
    "COLMAP's cameras": (COLMAP_CAMERAS, "COLMAP's text", "COLMAP, Bundler"),
    "COLMAP's cameras without head": (COLMAP_CAMERAS.split("\n")[3] + "\n",
                                      "COLMAP's text", "COLMAP, Bundler"),
    "COLMAP's images": (COLMAP_IMAGES, "COLMAP's text", "COLMAP, Bundler"),
    "Bundler": ("# Bundle file v0.3\n1 2\n500 0 0\n", "a Bundler file",
                "COLMAP, Bundler"),
    "VisualSFM": ("NVM_V3\n\n2\na.jpg\t500 1 0 0 0 0 0 0 0 0\n",
                  "a VisualSFM .nvm file", "COLMAP, Bundler"),
    "MATLAB 5": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(90),
                 "a MATLAB .mat file", "MATLAB"),
    "MATLAB 7.3": (b"\x89HDF\r\n\x1a\n" + bytes(90), "an HDF5 file", "MATLAB"),
    "MATLAB text": (MATLAB_TEXT, "Calib_Results.m", "MATLAB"),
    "mrcal": (MRCAL, "an mrcal camera model", "JSON, TOML and others"),
    "JSON": ('{"cameras": [1, 2]}\n', "JSON", "JSON, TOML and others"),
    "JSON, a list": ("[\n  {\"fx\": 1}\n]\n", "JSON", "JSON, TOML and others"),
    "TOML": (TOML, "TOML or INI", "JSON, TOML and others"),
    "YAML": ("# rig\nleft:\n  focal: 500\n", "YAML", "JSON, TOML and others"),
    "XML": ("<?xml version='1.0'?>\n<rig/>\n", "XML", "JSON, TOML and others"),
    "web page": ("\n<!DOCTYPE html>\n<html></html>\n", "a web page", None),
    "Git LFS": (LFS, "a pointer of Git LFS", None),
    "spreadsheet": (spreadsheet(), "a spreadsheet", "Tables of other forms"),
    "old spreadsheet": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an old spreadsheet",
                        "Tables of other forms"),
    "UTF-16": (content(STEREO, "observations.csv").encode("utf-16"),
               "text in UTF-16", "Tables of other forms"),
    "UTF-16, the other end first": (
        "\ufeffcamera,fx\n".encode("utf-16-be"), "text in UTF-16",
        "Tables of other forms"),
    "UTF-16 without a mark": ("camera,fx\n1,2\n".encode("utf-16-le"),
                              "text in UTF-16", "Tables of other forms"),
    "semicolons": (separated(";"), "a table separated by semicolons",
                   "Tables of other forms"),
    "semicolons and decimal commas": (
        separated(";").replace(".", ","), "a table separated by semicolons",
        "Tables of other forms"),
    "tabs": (separated("\t"), "a table separated by tabs",
             "Tables of other forms"),
    "blanks": (separated(" "), "a table separated by blanks",
               "Tables of other forms"),
    "quotes": ('"camera","fx"\n"left",500\n', "CSV with its names in quotes",
               "Tables of other forms"),
    "line ends of old Macs": (
        content(STEREO, "observations.csv").replace("\n", "\r"),
        "text with the line ends of old Macs", "Tables of other forms"),
    "PDF": (b"%PDF-1.4\n%\xe2\xe3\n", "a PDF document", "What you give"),
    "PNG": (b"\x89PNG\r\n\x1a\n\0\0", "a picture", "What you give"),
    "JPEG": (b"\xff\xd8\xff\xe0\0\x10JFIF", "a picture", "What you give"),
    "GIF": (b"GIF89a", "a picture", "What you give"),
    "TIFF": (b"II*\0\x08", "a picture", "What you give"),
    "TIFF, the other end first": (b"MM\0*\0", "a picture", "What you give"),
    "WebP": (b"RIFF\x10\0\0\0WEBPVP8 ", "a picture", "What you give"),
    "SQLite": (b"SQLite format 3\0", "an SQLite database", "What you give"),
    "ROS bag": (b"#ROSBAG V2.0\n", "a ROS bag", "What you give"),
    "MCAP": (b"\x89MCAP0\r\n", "an MCAP recording", "What you give"),
    "bzip2": (b"BZh91AY", "a bzip2 archive", None),
    "xz": (b"\xfd7zXZ\0", "an xz archive", None),
    "7z": (b"7z\xbc\xaf\x27\x1c", "a 7z archive", None),
    "UTF-32": ("\ufeffcamera\n".encode("utf-32-le"), "text in UTF-32",
               "Tables of other forms"),
    "UTF-32, the other end first": ("\ufeffcamera\n".encode("utf-32-be"),
                                    "text in UTF-32", "Tables of other forms"),
    "NumPy": (b"\x93NUMPY\x01\0", "a NumPy .npy file", "What you give"),
    "gzip": (b"\x1f\x8b\x08\0\0", "a gzip archive", None),
    "stored calibration": (b"RIGC\x01\0\x08\0", "a calibration stored by rigcal_store_save",
                           "What you give"),
}


class TestFormats(CliTest):
    def test_each_is_named_as_cameras_and_as_observations(self):
        for name, (data, what, section) in FILES.items():
            path = write(self.folder, "given", data)
            for cameras, observations in ((path, STEREO + "/observations.csv"),
                                          (STEREO + "/cameras.csv", path)):
                with self.subTest(file=name, observations=observations):
                    run = self.calibrate(cameras, observations)
                    self.assertEqual((run.returncode, run.stdout), (2, ""))
                    told = re.fullmatch(
                        rf"{re.escape(path)}:1: this looks like {re.escape(what)}"
                        r"[^:]*: [^:]+?(?:; see \"(.*)\" in "
                        r"examples/data/FORMAT\.md)?\n", run.stderr)
                    self.assertTrue(told, run.stderr)
                    self.assertEqual(told[1], section)
                    self.assertFalse(os.path.exists(self.out))

    def test_the_sections_are_those_of_the_document(self):
        for _, _, section in FILES.values():
            if section is not None:
                self.assertIn(section, HEADINGS)

    def test_our_own_files_are_none_of_these(self):
        """In columns that are ignored, or in names, any text is allowed."""
        for column in ("a: b", "[cam0]", "{", "fc = [", "'lensmodel': 'x'",
                       "\"type_id\": \"opencv-matrix\"", "a;b", "<opencv_storage>"):
            with self.subTest(column=column):
                head, *lines = content(STEREO, "cameras.csv").splitlines()
                table = [head + "," + column] + [line + "," + column
                                                 for line in lines]
                run = self.calibrate(write(self.folder, "c.csv", "\n".join(table)),
                                     STEREO + "/observations.csv")
                self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_a_table_that_is_none_of_ours_is_told_what_it_lacks(self):
        path = write(self.folder, "c.csv", "cam,w,h\nleft,640,480\n")
        run = self.calibrate(path, STEREO + "/observations.csv")
        self.assertEqual(run.stderr, f"{path}:1: there is no column camera: examples/"
                                     "data/FORMAT.md lists those of cameras.csv\n")

    def test_our_files_given_for_others_are_named(self):
        self.calibrate_well(STEREO)
        ours = {name: self.result(name) for name in
                ("poses.csv", "rig.csv", "targets.csv", "pairs.csv", "residuals.csv")}
        ours["cameras.csv"] = STEREO + "/cameras.csv"
        ours["observations.csv"] = STEREO + "/observations.csv"
        for given, path in ours.items():
            for wanted in ("cameras.csv", "observations.csv"):
                if given == wanted:
                    continue
                files = {**ours, wanted: path}
                run = rigcal("calibrate", "--cameras", files["cameras.csv"],
                             "--observations", files["observations.csv"])
                self.assertEqual(run.returncode, 2)
                self.assertRegex(run.stderr, rf"\A{path}:1: there is no column \w+: this "
                                             f"looks like {given}, where {wanted} is "
                                             r"wanted\n\Z")


class TestFormatTables(unittest.TestCase):
    """The tables in the section "From other programs" of FORMAT.md."""

    def rows(self, first):
        table = re.search(rf"(?m)^\| {first} \|.*\n\| ---.*\n((?:\|.*\n)+)",
                          FORMAT[FORMAT.index("## From other programs"):])[1]
        return [[cell.strip() for cell in line.strip("| ").split("|")]
                for line in table.splitlines()]

    def test_columns_are_those_of_cameras_csv_in_the_order_of_the_list(self):
        ours = re.search(r"\*\*`cameras.csv`\*\*: `(.*)`", FORMAT)[1].split(",")
        rows = self.rows("program \\| model \\| its list \\| columns \\| `lens`")
        self.assertGreater(len(rows), 15)
        for program, model, names, columns, lens in rows:
            with self.subTest(program=program, model=model):
                self.assertIn(lens, ("`brown`", "`fisheye`"))
                theirs = names.split(",")[0].split()
                mine = [c.strip("` ") for c in columns.replace(" and ", ",").split(",")]
                self.assertLessEqual(set(mine), set(ours))
                same = {"f": "fx fy", "t1": "p1", "t2": "p2",
                        "k": "k1"}
                self.assertEqual(mine, " ".join(same.get(n, n) for n in theirs).split())


if __name__ == "__main__":
    unittest.main()
