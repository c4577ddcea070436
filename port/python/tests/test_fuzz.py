"""Short forms of fuzz.py and fuzz_files.py, and what they have found."""

from __future__ import annotations

import fuzz
import fuzz_files
import numpy as np
import pytest

import rigcal

HUGE = np.broadcast_to(np.float64(1), (2**40, 3))


def test_any_call_is_an_answer_or_an_error():
    counts = fuzz.run(8000, 2)
    assert counts["answers"] > 1500
    assert counts["errors"] > 2000
    assert set(fuzz.NAMES) <= set(counts)


def test_a_changed_file_is_read_or_refused():
    assert 40 < fuzz_files.run(600, 2) < 400


@pytest.mark.parametrize("data", [None, 3, "text", [1, 2], {}, HUGE])
def test_bytes_that_are_none(data):
    with pytest.raises(rigcal.Error, match="data: bytes are expected"):
        rigcal.CalibratedRig.from_bytes(data)


def test_a_huge_array_is_refused_before_it_is_copied():
    with pytest.raises(rigcal.Error, match=r"R: shape \(3, 3\) is expected"):
        rigcal.Transform(HUGE, np.zeros(3))
    with pytest.raises(rigcal.Error, match=r"X: .* more than 2\^31"):
        rigcal.Transform.identity().apply(HUGE)
    with pytest.raises(rigcal.Error, match="fx"):
        rigcal.Camera(HUGE, 1, 0, 0)


@pytest.mark.parametrize("value", [np.ones((6, 2)), np.zeros(0), "text", None, [1]])
def test_a_switch_is_true_or_false(value):
    X, uv = np.random.default_rng(1).random((6, 3)), np.zeros((6, 2))
    camera = rigcal.Camera(800, 800, 320, 240)
    for call in (
        lambda: rigcal.solve_pose(camera, X, uv, robust=value),
        lambda: rigcal.solve_poses(camera, X, uv[None], robust=value),
        lambda: rigcal.solve_poses(camera, X, uv[None], covariance=value),
    ):
        with pytest.raises(rigcal.Error, match="True or False"):
            call()


def test_a_lens_that_is_no_text():
    for lens in (np.ones((2, 2)), np.zeros(3, [("x", "f8")]), None):
        with pytest.raises(rigcal.Error, match="lens"):
            rigcal.Camera(800, 800, 320, 240, lens=lens)
