"""Small files of each format, written by hand in the form that the format documents, and
what they say: two cameras, "left" at the rig and "right" turned by -36.87 degrees about y.

The right camera's rotation is exact in every notation: 0.8 and 0.6 in a matrix, 3 and 1
over the root of 10 in a quaternion, -0.6435 = -atan(3/4) as a vector."""

from dataclasses import dataclass, field, replace

import numpy as np

from rigcal import Camera, Transform

R = np.array([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])
T = np.array([-0.2, 0.01, 0.03])  # metres
RVEC = [0.0, -0.6435011087932844, 0.0]
QUAT = [0.9486832980505138, 0.0, -0.31622776601683794, 0.0]
SIZE = (640, 480)
K_LEFT, K_RIGHT = (800.0, 810.0, 320.5, 240.25), (790.0, 795.0, 310.5, 250.75)
BROWN = ((-0.3, 0.1, 0.001, -0.002, 0.05), (-0.28, 0.08, -0.0005, 0.0015, -0.02))
BROWN4 = (BROWN[0][:4], BROWN[1][:4])
FISHEYE = ((-0.02, 0.09, -0.11, 0.05), (-0.03, 0.08, -0.1, 0.04))
RATIONAL = (
    (*BROWN[0], 0.01, -0.02, 0.003),
    (*BROWN[1], -0.01, 0.02, -0.003),
)
NONE = ((), ())


def truth(
    dist=BROWN, lens="brown", names=("left", "right"), size=SIZE, pose=True, scale=1.0
):
    """The contents of a file of two cameras."""
    poses = (np.eye(3), np.zeros(3)), (R, T * scale)
    return {
        name: Camera(
            *K,
            size=size,
            dist=d,
            lens=lens,
            name=name,
            cam_from_rig=Transform(*p, name, "rig") if pose else None,
        )
        for name, K, d, p in zip(names, (K_LEFT, K_RIGHT), dist, poses)
    }


OPENCV_YAML = """%YAML:1.0
---
calibration_time: "Sat Nov 28 12:00:00 2026"
imageSize: [ 640, 480 ]
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 800., 0., 320.5, 0., 810., 240.25, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -3.0000000000000000e-01, 0.1, 1.0e-03, -2.0e-03, 0.05 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 790., 0., 310.5, 0., 795., 250.75, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.28, 0.08, -0.0005, 0.0015, -0.02 ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.8, 0., -0.6, 0., 1., 0.,
       0.6, 0., 0.8 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.2, 0.01, 0.03 ]
"""

OPENCV_XML = """<?xml version="1.0"?>
<opencv_storage>
<imageSize>
  640 480</imageSize>
<cameraMatrix1 type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    800. 0. 320.5 0. 810. 240.25 0. 0. 1.</data></cameraMatrix1>
<distCoeffs1 type_id="opencv-matrix">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -0.3 0.1 0.001 -0.002 0.05</data></distCoeffs1>
<cameraMatrix2 type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    790. 0. 310.5 0. 795. 250.75 0. 0. 1.</data></cameraMatrix2>
<distCoeffs2 type_id="opencv-matrix">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -0.28 0.08 -0.0005 0.0015 -0.02</data></distCoeffs2>
<R type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    0.8 0. -0.6 0. 1. 0. 0.6 0. 0.8</data></R>
<T type_id="opencv-matrix">
  <rows>3</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -0.2 0.01 0.03</data></T>
</opencv_storage>
"""

OPENCV_CAMERA = """%YAML:1.0
---
nr_of_frames: 20
image_width: 640
image_height: 480
flags: 0
fisheye_model: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 800., 0., 320.5, 0., 810., 240.25, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -0.3, 0.1, 0.001, -0.002, 0.05 ]
avg_reprojection_error: 0.21
"""

ROS = """image_width: 640
image_height: 480
camera_name: right
camera_matrix:
  rows: 3
  cols: 3
  data: [790.0, 0.0, 310.5, 0.0, 795.0, 250.75, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.08, -0.0005, 0.0015, -0.02]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.8, 0.0, 0.6, 0.0, 1.0, 0.0, -0.6, 0.0, 0.8]
projection_matrix:
  rows: 3
  cols: 4
  data: [700.0, 0.0, 300.0, -140.0, 0.0, 700.0, 260.0, 0.0, 0.0, 0.0, 1.0, 0.0]
"""

ROS_MESSAGE = """header:
  seq: 7
  stamp:
    secs: 1700000000
    nsecs: 5
  frame_id: "cam_optical"
height: 480
width: 640
distortion_model: "rational_polynomial"
D: [-0.3, 0.1, 0.001, -0.002, 0.05, 0.01, -0.02, 0.003]
K: [800.0, 0.0, 320.5, 0.0, 810.0, 240.25, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [800.0, 0.0, 320.5, 0.0, 0.0, 810.0, 240.25, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: False
---
"""

KALIBR = """cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.02, 0.09, -0.11, 0.05]
  distortion_model: equidistant
  intrinsics: [800.0, 810.0, 320.5, 240.25]
  resolution: [640, 480]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: -0.005
cam1:
  T_cn_cnm1:
  - [0.8, 0.0, -0.6, -0.2]
  - [0.0, 1.0, 0.0, 0.01]
  - [0.6, 0.0, 0.8, 0.03]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.03, 0.08, -0.1, 0.04]
  distortion_model: equidistant
  intrinsics: [790.0, 795.0, 310.5, 250.75]
  resolution: [640, 480]
  rostopic: /cam1/image_raw
"""

ANIPOSE = """[cam_0]
name = "left"
size = [ 640, 480,]
matrix = [ [ 800.0, 0.0, 320.5,], [ 0.0, 810.0, 240.25,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.3, 0.1, 0.001, -0.002, 0.05,]
rotation = [ 0.0, 0.0, 0.0,]
translation = [ 0.0, 0.0, 0.0,]

[cam_1]
name = "right"
size = [ 640, 480,]
matrix = [ [ 790.0, 0.0, 310.5,], [ 0.0, 795.0, 250.75,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.28, 0.08, -0.0005, 0.0015, -0.02,]
rotation = [ 0.0, -0.6435011087932844, 0.0,]
translation = [ -0.2, 0.01, 0.03,]

[metadata]
adjusted = false
error = 0.42
"""

POSE2SIM = """[left]
name = "left"
size = [ 640.0, 480.0]
matrix = [ [ 800.0, 0.0, 320.5], [ 0.0, 810.0, 240.25], [ 0.0, 0.0, 1.0]]
distortions = [ -0.3, 0.1, 0.001, -0.002]
rotation = [ 0.0, 0.0, 0.0]
translation = [ 0.0, 0.0, 0.0]
fisheye = false

[right]
name = "right"
size = [ 640.0, 480.0]
matrix = [ [ 790.0, 0.0, 310.5], [ 0.0, 795.0, 250.75], [ 0.0, 0.0, 1.0]]
distortions = [ -0.28, 0.08, -0.0005, 0.0015]
rotation = [ 0.0, -0.6435011087932844, 0.0]
translation = [ -0.2, 0.01, 0.03]
fisheye = false

[metadata]
adjusted = false
error = 0.0
"""

CALISCOPE = """[cameras.0]
cam_id = 0
rotation_count = 0
error = 0.5
exposure = -8
grid_count = 39
ignore = false
size = [640, 480]
matrix = [[800.0, 0.0, 320.5], [0.0, 810.0, 240.25], [0.0, 0.0, 1.0]]
distortions = [-0.3, 0.1, 0.001, -0.002, 0.05]
translation = [0.0, 0.0, 0.0]
rotation = [0.0, 0.0, 0.0]

[cameras.1]
cam_id = 1
rotation_count = 1
error = 0.4
exposure = -7
grid_count = 33
ignore = false
size = [640, 480]
matrix = [[790.0, 0.0, 310.5], [0.0, 795.0, 250.75], [0.0, 0.0, 1.0]]
distortions = [-0.28, 0.08, -0.0005, 0.0015, -0.02]
translation = [-0.2, 0.01, 0.03]
rotation = [0.0, -0.6435011087932844, 0.0]
"""

CALISCOPE_OLD = """CreationDate = 2023-03-31T09:56:43.193358

[cam_0]
port = 0
size = [ 640, 480,]
rotation_count = 0
matrix = [ [ 800.0, 0.0, 320.5,], [ 0.0, 810.0, 240.25,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.3, 0.1, 0.001, -0.002, 0.05,]
ignore = false
translation = [ 0.0, 0.0, 0.0,]
rotation = [ [ 1.0, 0.0, 0.0,], [ 0.0, 1.0, 0.0,], [ 0.0, 0.0, 1.0,],]

[cam_1]
port = 1
size = [ 640, 480,]
rotation_count = -1
matrix = [ [ 790.0, 0.0, 310.5,], [ 0.0, 795.0, 250.75,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.28, 0.08, -0.0005, 0.0015, -0.02,]
ignore = false
translation = [ -0.2, 0.01, 0.03,]
rotation = [ [ 0.8, 0.0, -0.6,], [ 0.0, 1.0, 0.0,], [ 0.6, 0.0, 0.8,],]

[cam_2]
port = 2
ignore = true

[capture_volume]
stage = 2

[charuco]
columns = 4
rows = 5
"""

MRCAL = """# recorded on a Saturday
{
    'lens_model':  'LENSMODEL_OPENCV8',

    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....
    'intrinsics': [ 790.0, 795.0, 310.5, 250.75, -0.28, 0.08, -0.0005, 0.0015, -0.02, -0.01,
                    0.02, -0.003,],

    # extrinsics are rt_fromref
    'extrinsics': [ 0.0, -0.6435011087932844, 0.0, -0.2, 0.01, 0.03, ],

    'imagersize': [ 640, 480,],
    'icam_intrinsics': 1,
    'optimization_inputs': b'0Z9lw',
}
"""

COLMAP = {
    "cameras.txt": """# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 2
1 OPENCV 640 480 800 810 321 240.75 -0.3 0.1 0.001 -0.002
2 OPENCV 640 480 790 795 311 251.25 -0.28 0.08 -0.0005 0.0015
""",
    "images.txt": """# Image list with two lines of data per image:
#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
#   POINTS2D[] as (X, Y, POINT3D_ID)
1 1 0 0 0 0 0 0 1 left
12.5 13.5 -1 100.25 7.75 3
2 0.9486832980505138 0 -0.31622776601683794 0 -0.2 0.01 0.03 2 right

""",
}

COLMAP_RIGS = """# Rig calib list with one line of data per calib:
#   RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as (SENSOR_TYPE, ...)
1 2 CAMERA 1 CAMERA 2 1 0.9486832980505138 0 -0.31622776601683794 0 -0.2 0.01 0.03
"""

MATLAB_JSON = """{
  "CameraParameters1": {
    "RadialDistortion": [-0.3, 0.1, 0.05],
    "TangentialDistortion": [0.001, -0.002],
    "ImageSize": [480, 640],
    "WorldUnits": "millimeters",
    "IntrinsicMatrix": [[800, 0, 0], [0, 810, 0], [321.5, 241.25, 1]]
  },
  "CameraParameters2": {
    "RadialDistortion": [-0.28, 0.08, -0.02],
    "TangentialDistortion": [-0.0005, 0.0015],
    "ImageSize": [480, 640],
    "WorldUnits": "millimeters",
    "IntrinsicMatrix": [[790, 0, 0], [0, 795, 0], [311.5, 251.75, 1]]
  },
  "RotationOfCamera2": [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]],
  "TranslationOfCamera2": [-200, 10, 30]
}
"""

# World from camera with y up and z backwards: columns right, up, back, and the centre.
NERFSTUDIO = """{
  "camera_model": "OPENCV",
  "w": 640,
  "h": 480,
  "frames": [
    {
      "file_path": "images/left.png",
      "fl_x": 800.0, "fl_y": 810.0, "cx": 321.0, "cy": 240.75,
      "k1": -0.3, "k2": 0.1, "p1": 0.001, "p2": -0.002, "k3": 0.05,
      "transform_matrix": [
        [1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0]
      ]
    },
    {
      "file_path": "images/right.png",
      "fl_x": 790.0, "fl_y": 795.0, "cx": 311.0, "cy": 251.25,
      "k1": -0.28, "k2": 0.08, "p1": -0.0005, "p2": 0.0015, "k3": -0.02,
      "transform_matrix": [
        [0.8, 0.0, -0.6, 0.142], [0.0, -1.0, 0.0, -0.01],
        [-0.6, 0.0, -0.8, -0.144], [0.0, 0.0, 0.0, 1.0]
      ]
    }
  ],
  "applied_transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]
}
"""

MULTICAL = """{
  "cameras": {
    "left": {
      "model": "standard",
      "image_size": [640, 480],
      "K": [[800.0, 0.0, 320.5], [0.0, 810.0, 240.25], [0.0, 0.0, 1.0]],
      "dist": [[-0.3, 0.1, 0.001, -0.002, 0.05]]
    },
    "right": {
      "model": "standard",
      "image_size": [640, 480],
      "K": [[790.0, 0.0, 310.5], [0.0, 795.0, 250.75], [0.0, 0.0, 1.0]],
      "dist": [[-0.28, 0.08, -0.0005, 0.0015, -0.02]]
    }
  },
  "camera_poses": {
    "left": {"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "T": [0, 0, 0]},
    "right_to_left": {
      "R": [[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]],
      "T": [-0.2, 0.01, 0.03]
    }
  },
  "image_sets": {"rgb": []}
}
"""

BOP = """{
  "0": {"cam_K": [800.0, 0.0, 320.5, 0.0, 810.0, 240.25, 0.0, 0.0, 1.0],
        "depth_scale": 0.1,
        "cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_w2c": [0, 0, 0]},
  "1": {"cam_K": [790.0, 0.0, 310.5, 0.0, 795.0, 250.75, 0.0, 0.0, 1.0],
        "depth_scale": 0.1,
        "cam_R_w2c": [0.8, 0.0, -0.6, 0.0, 1.0, 0.0, 0.6, 0.0, 0.8],
        "cam_t_w2c": [-200.0, 10.0, 30.0]}
}
"""

CSV = {
    "cameras.csv": """camera,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3,k4,k5,k6,lens
left,640,480,800,810,320.5,240.25,-0.3,0.1,0.001,-0.002,0.05,0.01,-0.02,0.003,brown
right,640,480,790,795,310.5,250.75,-0.28,0.08,-0.0005,0.0015,-0.02,-0.01,0.02,-0.003,brown
""",
    "rig.csv": """camera,R11,R12,R13,R21,R22,R23,R31,R32,R33,tx,ty,tz,sigma_rot_deg
left,1,0,0,0,1,0,0,0,1,0,0,0,0
right,0.8,0,-0.6,0,1,0,0.6,0,0.8,-0.2,0.01,0.03,0.02
""",
}

# A rectified pair: the rig is turned as the right camera's image, and 0.2 m to its left.
ROS_RIGHT = replace(
    truth()["right"], cam_from_rig=Transform(R, R @ [-0.2, 0.0, 0.0], "right", "rig")
)
FISHEYE_PAIR = OPENCV_YAML.replace("cols: 5", "cols: 4")
FISHEYE_PAIR = FISHEYE_PAIR.replace(", 0.05 ]", " ]").replace(", -0.02 ]", " ]")


@dataclass
class Sample:
    """The files of one format by name, and what they contain."""

    format: str
    files: dict
    truth: dict
    options: dict = field(default_factory=dict)

    def put(self, folder):
        """Writes the files. Returns the path to load."""
        for name, text in self.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        return folder if len(self.files) > 1 else folder / next(iter(self.files))


def only(name, cameras):
    return {name: cameras[name]}


SAMPLES = {
    "opencv-yaml": Sample("opencv", {"stereo.yml": OPENCV_YAML}, truth()),
    "opencv-xml": Sample("opencv", {"stereo.xml": OPENCV_XML}, truth()),
    "opencv-camera": Sample(
        "opencv", {"left.yml": OPENCV_CAMERA}, only("left", truth(pose=False))
    ),
    "opencv-fisheye": Sample(
        "opencv",
        {"pair.yml": FISHEYE_PAIR},
        truth(BROWN4, "fisheye"),
        {"lens": "fisheye"},
    ),
    "ros": Sample("ros", {"right.yaml": ROS}, {"right": ROS_RIGHT}),
    "ros-message": Sample(
        "ros",
        {"info.yaml": ROS_MESSAGE},
        only("cam_optical", truth(RATIONAL, names=("cam_optical", "b"), pose=False)),
    ),
    "kalibr": Sample(
        "kalibr", {"camchain.yaml": KALIBR}, truth(FISHEYE, "fisheye", ("cam0", "cam1"))
    ),
    "anipose": Sample("anipose", {"calibration.toml": ANIPOSE}, truth()),
    "pose2sim": Sample("anipose", {"Calib.toml": POSE2SIM}, truth(BROWN4)),
    "caliscope": Sample(
        "caliscope", {"camera_array.toml": CALISCOPE}, truth(names=("0", "1"))
    ),
    "caliscope-old": Sample(
        "caliscope", {"config.toml": CALISCOPE_OLD}, truth(names=("cam_0", "cam_1"))
    ),
    "mrcal": Sample("mrcal", {"right.cameramodel": MRCAL}, only("right", truth(RATIONAL))),
    "colmap": Sample("colmap", COLMAP, truth(BROWN4)),
    "colmap-rigs": Sample(
        "colmap", {**COLMAP, "rigs.txt": COLMAP_RIGS}, truth(BROWN4, names=("1", "2"))
    ),
    "matlab-json": Sample(
        "matlab", {"rig.json": MATLAB_JSON}, truth(names=("cam1", "cam2"))
    ),
    "nerfstudio": Sample("nerfstudio", {"transforms.json": NERFSTUDIO}, truth()),
    "multical": Sample("multical", {"calibration.json": MULTICAL}, truth()),
    "bop": Sample(
        "bop", {"scene_camera.json": BOP}, truth(NONE, names=("0", "1"), size=None)
    ),
    "rigcal": Sample("rigcal", CSV, truth(RATIONAL)),
}
