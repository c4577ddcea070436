"""Statuses and constants of the C headers. Made by make_names.py: do not edit."""

from __future__ import annotations

import enum
from typing import Final

RIGCAL_POSES_MAX: Final = 4
RIGCAL_BLAME_TRIES: Final = 64
RIGCAL_STORE_CAMERAS_MAX: Final = 65535
RIGCAL_STORE_HEADER_BYTES: Final = 32
RIGCAL_CHOOSE_PLACEMENTS: Final = 20
RIGCAL_MOTION_MOST: Final = 4
RIGCAL_FAULT_DEVIATIONS: Final = 5
RIGCAL_FAULT_VALUES: Final = 6
RIGCAL_SPANS_ROW: Final = 8
RIGCAL_SPANS_UNITS: Final = 2000
RIGCAL_MONITOR_CAMERAS_MAX: Final = 64
RIGCAL_MONITOR_TARGETS_MAX: Final = 16
RIGCAL_MONITOR_HEAD: Final = 48
RIGCAL_MONITOR_BODY: Final = 179
RIGCAL_MONITOR_LENS: Final = 15
RIGCAL_SIGHTINGS_MAX: Final = 1000
RIGCAL_SIGHTING_PAIRS: Final = 120


class Status(enum.IntEnum):
    """What a function says: 0 done, above 0 done with a caveat, below 0 failed."""

    RIGCAL_OK = 0
    RIGCAL_RUNNING = 1
    RIGCAL_BUDGET_SPENT = 2
    RIGCAL_DISCONNECTED = 3
    RIGCAL_AMBIGUOUS = 4
    RIGCAL_POOR_FIT = 5
    RIGCAL_FEW_AGREE = 6
    RIGCAL_VAGUE = 7
    RIGCAL_UNSEEN_POINT = 8
    RIGCAL_MOST_DISAGREE = 9
    RIGCAL_VIEWS_LEFT_OUT = 10
    RIGCAL_ERR_NULL = -1
    RIGCAL_ERR_NOT_FINITE = -2
    RIGCAL_ERR_RANGE = -3
    RIGCAL_ERR_CAMERA = -4
    RIGCAL_ERR_ROTATION = -5
    RIGCAL_ERR_CAPACITY = -6
    RIGCAL_ERR_STATE = -7
    RIGCAL_ERR_TOO_FEW = -8
    RIGCAL_ERR_COINCIDENT = -9
    RIGCAL_ERR_COLLINEAR = -10
    RIGCAL_ERR_EDGE_ON = -11
    RIGCAL_ERR_PRECISION = -12
    RIGCAL_ERR_NO_RAY = -13
    RIGCAL_ERR_BEHIND = -14
    RIGCAL_ERR_WIDE_RAY = -15
    RIGCAL_ERR_PARALLEL = -16
    RIGCAL_ERR_EPIPOLE = -17
    RIGCAL_ERR_OUTSIDE = -18
    RIGCAL_ERR_DEGENERATE = -19
    RIGCAL_ERR_NO_POSE = -20
    RIGCAL_ERR_DAMAGED = -21
    RIGCAL_ERR_FOREIGN = -22
    RIGCAL_ERR_VERSION = -23
    RIGCAL_ERR_NO_CONSENSUS = -24
    RIGCAL_ERR_MIRRORED = -25
    RIGCAL_ERR_TWICE = -26
    RIGCAL_ERR_UNSORTED = -27
    RIGCAL_ERR_CONTRADICTION = -28

    @property
    def text(self) -> str:
        """What is wrong, and what to do."""
        return TEXTS[self]


class Lenses(enum.IntEnum):
    """enum rigcal_lenses of rigcal.h."""

    RIGCAL_LENS_BROWN = 0
    RIGCAL_LENS_FISHEYE = 1


class BlameVerdicts(enum.IntEnum):
    """enum rigcal_blame_verdicts of rigcal.h."""

    RIGCAL_BLAME_NONE = 0
    RIGCAL_BLAME_LIKELY = 1
    RIGCAL_BLAME_SURE = 2


class DiagnosisVerdicts(enum.IntEnum):
    """enum rigcal_diagnosis_verdicts of rigcal.h."""

    RIGCAL_DIAGNOSIS_CONSISTENT = 0
    RIGCAL_DIAGNOSIS_UNITS = 1
    RIGCAL_DIAGNOSIS_ONE_POINT = 2
    RIGCAL_DIAGNOSIS_MIRRORED = 3
    RIGCAL_DIAGNOSIS_UNEXPLAINED = 4


class Takes(enum.IntEnum):
    """enum rigcal_takes of rigcal_choose.h."""

    RIGCAL_TAKES_FIRST = 0
    RIGCAL_TAKES_SECOND = 1
    RIGCAL_TAKES_NONE = 2


class ClockStates(enum.IntEnum):
    """enum rigcal_clock_states of rigcal_clocks.h."""

    RIGCAL_CLOCK_HELD = 0
    RIGCAL_CLOCK_FREE = 1
    RIGCAL_CLOCK_ALONE = 2
    RIGCAL_CLOCK_STILL = 3


class FaultKinds(enum.IntEnum):
    """enum rigcal_fault_kinds of rigcal_faults.h."""

    RIGCAL_FAULT_CLOCK = 0
    RIGCAL_FAULT_DRIFT = 1
    RIGCAL_FAULT_CLOCKS = 2
    RIGCAL_FAULT_SHUTTER = 3
    RIGCAL_FAULT_FOCAL = 4
    RIGCAL_FAULT_ASPECT = 5
    RIGCAL_FAULT_CENTRE = 6
    RIGCAL_FAULT_DISTORTION = 7
    RIGCAL_FAULT_MOVED = 8
    RIGCAL_FAULT_BENT = 9
    RIGCAL_FAULT_STRETCHED = 10
    RIGCAL_FAULT_KINDS = 11


class FaultsVerdicts(enum.IntEnum):
    """enum rigcal_faults_verdicts of rigcal_faults.h."""

    RIGCAL_RIG_AGREES = 0
    RIGCAL_RIG_EXPLAINED = 1
    RIGCAL_RIG_FOUND = 2
    RIGCAL_RIG_UNEXPLAINED = 3


class FaultsBits(enum.IntEnum):
    """enum rigcal_faults_bits of rigcal_faults.h."""

    RIGCAL_FAULTS_NAMED = 1
    RIGCAL_FAULTS_PATTERN = 2
    RIGCAL_FAULTS_ALONG_MOTION = 4
    RIGCAL_FAULTS_ALIKE = 8
    RIGCAL_FAULTS_NO_TIMES = 16
    RIGCAL_FAULTS_NO_NEIGHBOUR = 32
    RIGCAL_FAULTS_NO_MOTION = 64
    RIGCAL_FAULTS_TWO_CAMERAS = 128
    RIGCAL_FAULTS_NO_LOOP = 256


class ViewVerdicts(enum.IntEnum):
    """enum rigcal_view_verdicts of rigcal_judge.h."""

    RIGCAL_VIEW_FITS = 0
    RIGCAL_VIEW_CONTRADICTS = 1
    RIGCAL_VIEW_ONE_OF_TWO = 2
    RIGCAL_VIEW_UNCHECKED = 3


class Causes(enum.IntEnum):
    """enum rigcal_causes of rigcal_judge.h."""

    RIGCAL_CAUSE_UNKNOWN = 0
    RIGCAL_CAUSE_TURNED = 1
    RIGCAL_CAUSE_SHIFTED = 2
    RIGCAL_CAUSE_SWAPPED = 3


class MatchPurposes(enum.IntEnum):
    """enum rigcal_match_purposes of rigcal_match.h."""

    RIGCAL_MATCH_SEARCH = 1
    RIGCAL_MATCH_DRAW = 2


class CameraRoles(enum.IntEnum):
    """enum rigcal_camera_roles of rigcal_rig.h."""

    RIGCAL_CAMERA_FREE = 0
    RIGCAL_CAMERA_HELD = 1
    RIGCAL_CAMERA_PRIOR = 2


class Losses(enum.IntEnum):
    """enum rigcal_losses of rigcal_rig.h."""

    RIGCAL_LOSS_HUBER = 1
    RIGCAL_LOSS_TRUNCATED = 2


TEXTS: Final = {
    Status.RIGCAL_OK: (
        "done"
    ),
    Status.RIGCAL_RUNNING: (
        "the solver is not finished: call its step function again"
    ),
    Status.RIGCAL_BUDGET_SPENT: (
        "the evaluations ran out before the tolerance was met: the best found so far "
        "was returned; allow more, or check the data"
    ),
    Status.RIGCAL_DISCONNECTED: (
        "some cameras share no placement of the target with the first one: place the "
        "target where both sides see it"
    ),
    Status.RIGCAL_AMBIGUOUS: (
        "another pose fits nearly as well: see the probabilities; tilt the target or "
        "use another camera to tell"
    ),
    Status.RIGCAL_POOR_FIT: (
        "the error is too large for noise: check the correspondences, the target and "
        "the intrinsics"
    ),
    Status.RIGCAL_FEW_AGREE: (
        "so few observations agree that chance may do it: check the correspondences, "
        "or give more"
    ),
    Status.RIGCAL_VAGUE: (
        "the data hardly fix the pose: move nearer, or observe points that are "
        "farther apart"
    ),
    Status.RIGCAL_UNSEEN_POINT: (
        "the lens model images no ray at one of the pixels: the pose is that of the "
        "other points; check that pixel and the lens"
    ),
    Status.RIGCAL_MOST_DISAGREE: (
        "most observations disagree with this pose: check the correspondences and the "
        "target's coordinates"
    ),
    Status.RIGCAL_VIEWS_LEFT_OUT: (
        "some views contradict the others and were left out: see which, and why"
    ),
    Status.RIGCAL_ERR_NULL: (
        "a pointer that must not be NULL is NULL"
    ),
    Status.RIGCAL_ERR_NOT_FINITE: (
        "an input is NaN or infinite"
    ),
    Status.RIGCAL_ERR_RANGE: (
        "a count, an option or a number is outside its documented range"
    ),
    Status.RIGCAL_ERR_CAMERA: (
        "the intrinsics cannot be used: focal lengths and image size must be "
        "positive, the lens known, coefficients within 1e9, and those that the lens "
        "does not use 0"
    ),
    Status.RIGCAL_ERR_ROTATION: (
        "a matrix is not a rotation to 1e-6 (float 1e-3), a quaternion has length 0, "
        "or rotations cancel when averaged"
    ),
    Status.RIGCAL_ERR_CAPACITY: (
        "a buffer is too small: the manual says what it takes"
    ),
    Status.RIGCAL_ERR_STATE: (
        "the solver was not begun, or is not finished"
    ),
    Status.RIGCAL_ERR_TOO_FEW: (
        "too few points, views or pairs for the unknowns: observe more"
    ),
    Status.RIGCAL_ERR_COINCIDENT: (
        "fewer than three distinct points or rays: check for points entered twice"
    ),
    Status.RIGCAL_ERR_COLLINEAR: (
        "all the points lie on one line, about which the camera may turn freely: add "
        "a point off the line"
    ),
    Status.RIGCAL_ERR_EDGE_ON: (
        "all the rays lie in one plane: the target is seen edge-on, tilt it"
    ),
    Status.RIGCAL_ERR_PRECISION: (
        "the points are so far from the origin that their shape is lost in rounding: "
        "subtract a common offset"
    ),
    Status.RIGCAL_ERR_NO_RAY: (
        "the lens model images no ray there: the pixel or point is outside its usable "
        "field"
    ),
    Status.RIGCAL_ERR_BEHIND: (
        "a point is not in front of the camera"
    ),
    Status.RIGCAL_ERR_WIDE_RAY: (
        "a ray is 90 degrees or more off the optical axis (80, for a pose in a build "
        "without three points), which this function cannot use"
    ),
    Status.RIGCAL_ERR_PARALLEL: (
        "the rays are parallel or nearly so, so the depth is unknown: move the "
        "cameras apart"
    ),
    Status.RIGCAL_ERR_EPIPOLE: (
        "the point is the image of the other camera's centre: every line through it "
        "matches"
    ),
    Status.RIGCAL_ERR_OUTSIDE: (
        "the line does not cross the image"
    ),
    Status.RIGCAL_ERR_DEGENERATE: (
        "the equations are singular: this geometry has no unique answer"
    ),
    Status.RIGCAL_ERR_NO_POSE: (
        "no start led to a pose with every point in front: check the correspondences, "
        "and that the coordinates are right-handed"
    ),
    Status.RIGCAL_ERR_DAMAGED: (
        "the stored bytes are incomplete or were altered: use another copy, or "
        "calibrate again"
    ),
    Status.RIGCAL_ERR_FOREIGN: (
        "these bytes are not a stored calibration"
    ),
    Status.RIGCAL_ERR_VERSION: (
        "the calibration was stored in a form that this version of the library does "
        "not know: use the one that stored it"
    ),
    Status.RIGCAL_ERR_NO_CONSENSUS: (
        "no more observations agree on a pose than chance makes agree: check the "
        "correspondences, the target and the camera"
    ),
    Status.RIGCAL_ERR_MIRRORED: (
        "only a mirror shows this: the corners run the wrong way round, the tag is "
        "seen from behind or the image is flipped"
    ),
    Status.RIGCAL_ERR_TWICE: (
        "two views are of the same camera and placement: make one view of them"
    ),
    Status.RIGCAL_ERR_UNSORTED: (
        "the views are not in the order of their placements: sort them"
    ),
    Status.RIGCAL_ERR_CONTRADICTION: (
        "the views contradict each other, most of them: check which image is of which "
        "camera and placement, the target's coordinates and the intrinsics"
    ),
}
