"""Transforms, compared with cases by hand and with identities."""

import pickle

import numpy as np
import pytest

from rigcal import Error, Transform

QUARTER_Z = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # x goes to y
ANGLES = [0, 1e-300, 1e-12, 1e-6, 0.1, 1, 3, np.pi - 1e-6, np.pi - 1e-12]


def turned(seed, angle, **frames):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return Transform.from_rvec(
        angle * axis / np.linalg.norm(axis), rng.normal(size=3), **frames
    )


def rodrigues(w):
    """Rodrigues' formula, as it stands in books."""
    angle = np.linalg.norm(w)
    x, y, z = w / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def test_a_quarter_turn_about_z_in_every_notation():
    t = [1, 2, 3]
    same = [
        Transform(QUARTER_Z, t),
        Transform.from_rvec([0, 0, np.pi / 2], t),
        Transform.from_quat_wxyz([1, 0, 0, 1], t),
        Transform.from_matrix([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]),
    ]
    for T in same:
        np.testing.assert_allclose(T.apply([1, 0, 0]), [1, 3, 3], atol=1e-15)
        np.testing.assert_allclose(T.rvec, [0, 0, np.pi / 2], atol=1e-15)
        np.testing.assert_allclose(T.quat_wxyz, [0.5**0.5, 0, 0, 0.5**0.5], atol=1e-15)
        np.testing.assert_allclose(T.center, [-2, 1, -3], atol=1e-15)
        assert (T.to, T.frm) == ("cam0", "rig")


@pytest.mark.parametrize("angle", ANGLES)
def test_vectors_and_quaternions_keep_their_digits(angle):
    for seed in range(20):
        T = turned(seed, angle)
        rng = np.random.default_rng(seed)
        axis = rng.normal(size=3)
        w = angle * axis / np.linalg.norm(axis)
        np.testing.assert_allclose(T.rvec, w, rtol=1e-15, atol=4e-15)
        np.testing.assert_allclose(T.R @ T.R.T, np.eye(3), atol=1e-15)
        assert np.linalg.norm(T.quat_wxyz) == pytest.approx(1, abs=1e-15)
        assert T.quat_wxyz[0] >= 0
        if angle > 1e-6:
            np.testing.assert_allclose(T.R, rodrigues(w), atol=2e-15)
        again = Transform.from_quat_wxyz(-3 * T.quat_wxyz, T.t)
        np.testing.assert_allclose(again.R, T.R, atol=1e-15)


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_turns(axis):
    T = Transform(2 * np.outer(axis, axis) - np.eye(3), [0, 0, 0])
    np.testing.assert_allclose(np.abs(T.rvec), np.pi * axis, atol=1e-15)


def test_chains_and_inverses_do_what_their_parts_do():
    a, b = turned(1, 2.0, to="c", frm="b"), turned(2, 1.0, to="b", frm="a")
    X = np.random.default_rng(3).normal(size=(4, 5, 3))
    np.testing.assert_allclose((a @ b).apply(X), a.apply(b.apply(X)), atol=1e-14)
    np.testing.assert_allclose(a.inv().apply(a.apply(X)), X, atol=1e-14)
    np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-14)
    np.testing.assert_allclose(a.apply(a.center), 0, atol=1e-14)
    assert ((a @ b).to, (a @ b).frm) == ("c", "a")
    assert (a.inv().to, a.inv().frm) == ("b", "c")
    assert (a @ a.inv()).to == "c"


def test_frames_must_meet():
    a = Transform.identity("right", "rig")
    with pytest.raises(
        Error, match=r"right_from_rig @ right_from_rig: .* rig is not right"
    ):
        a @ a
    with pytest.raises(TypeError):
        a @ np.eye(4)


@pytest.mark.parametrize(
    ("R", "t", "what"),
    [
        (np.eye(2), [0, 0, 0], r"R: shape \(3, 3\) is expected, not \(2, 2\)"),
        (np.eye(3) * 1.01, [0, 0, 0], "R: the matrix is not a rotation"),
        (np.diag([1, 1, -1]), [0, 0, 0], "R: the matrix is not a rotation"),
        (np.full((3, 3), 1e300), [0, 0, 0], "R: the matrix is not a rotation"),
        (np.full((3, 3), np.nan), [0, 0, 0], "R: an element is NaN or infinite"),
        ("R", [0, 0, 0], "R: numbers of shape"),
        (np.eye(3) * 1j, [0, 0, 0], "R: numbers of shape"),
        ([[1], [1, 2]], [0, 0, 0], "R: numbers of shape"),
        (np.eye(3), [0, 0], r"t: shape \(3,\) is expected, not \(2,\)"),
        (np.eye(3), [0, 0, np.inf], "t: an element"),
        (np.eye(3), [0, 0, 1e31], "t: a coordinate is beyond 1e30"),
        (np.eye(3), None, "t: "),
        (np.eye(3), [10**400, 0, 0], "t: numbers of shape"),
    ],
)
def test_what_is_no_transform(R, t, what):
    with pytest.raises(Error, match=what):
        Transform(R, t)


def test_other_inputs_that_cannot_be_used():
    with pytest.raises(Error, match="name must be text"):
        Transform(np.eye(3), [0, 0, 0], 1)
    with pytest.raises(Error, match="length is 0"):
        Transform.from_quat_wxyz([0, 0, 0, 0], [0, 0, 0])
    with pytest.raises(Error, match="longer than 1e6"):
        Transform.from_rvec([1e7, 0, 0], [0, 0, 0])
    with pytest.raises(Error, match="last row"):
        Transform.from_matrix(np.eye(4) * 2)
    for X in (1.0, [1, 2], [[1, 2]], "abc", [[1, 2, 3], [1]]):
        with pytest.raises(Error, match="X: "):
            Transform.identity().apply(X)


def test_a_transform_is_a_value():
    source = np.eye(3)
    T = Transform(source, [1, 2, 3])
    source[0, 0] = 5
    assert T.R[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        T.R[0, 0] = 2
    with pytest.raises(AttributeError):
        T.t = np.zeros(3)
    same = Transform(np.eye(3), [1, 2, 3])
    assert same == T
    assert hash(T) == hash(same)
    assert pickle.loads(pickle.dumps(T)) == T
    assert Transform(np.eye(3), [1, 2, 4]) != T
    assert Transform(np.eye(3), [1, 2, 3], "a") != T
    assert T != 1
    assert repr(T) == "Transform(cam0_from_rig: rvec (0, 0, 0), t (1, 2, 3))"
