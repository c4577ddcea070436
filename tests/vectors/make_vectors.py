#!/usr/bin/env python3
"""Makes the golden vectors of the tests from an independent reference.

    python3 tests/vectors/make_vectors.py           writes vectors_<topic>.h here
    python3 tests/vectors/make_vectors.py --check   compares the numbers with those
                                                    files, to 1e-10; writes nothing

A comment above each array says what the numbers are. Inputs are decimal numbers of a few
digits, drawn with Python's own generator, whose numbers are the same in every version;
outputs come from rigcal_oracle.py, NumPy and SciPy and have all digits.
"""
import math
import os
import random
import re
import struct
import sys
import zlib

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, norm

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import point_oracle  # noqa: E402
import faults_oracle as oracle_faults  # noqa: E402
import rigcal_oracle as oracle  # noqa: E402

CHECK_TOLERANCE = 1e-10  # of the number, or of 1 where the number is smaller


def decimals(rng, low, high, digits, shape=()):
    """Uniform numbers with this many decimals."""
    n = int(np.prod(shape)) if shape != () else 1
    values = [round(rng.uniform(low, high), digits) for _ in range(n)]
    return np.array(values).reshape(shape) if shape != () else values[0]


def any_ypr(rng, pitch=1.5):
    return np.array([decimals(rng, -3.14, 3.14, 4), decimals(rng, -pitch, pitch, 4),
                     decimals(rng, -3.14, 3.14, 4)])


def row(*parts):
    return np.concatenate([np.atleast_1d(np.asarray(p, float)).ravel() for p in parts])


# ---- rotations -------------------------------------------------------------------------
def rotations():
    rng = random.Random(1)
    euler, vectors, quaternions, nearest = [], [], [], []
    for i in range(60):
        ypr = any_ypr(rng, 1.57)
        if i < 8:  # axes, where signs show
            ypr = np.array([(i & 1) * 1.5, (i >> 1 & 1) * -0.7, (i >> 2) * 2.5])
        euler.append(row(ypr, oracle.euler_to_matrix(*ypr)))
    for i in range(60):
        w = decimals(rng, -1.8, 1.8, 4, (3,))
        if i < 20:  # small: the series, not the formula
            w = np.array([float("%.4e" % (x * 10.0 ** -(i % 10))) for x in w])
        vectors.append(row(w, Rotation.from_rotvec(w).as_matrix()))
    for _ in range(40):
        q = decimals(rng, -2, 2, 3, (4,))
        if q[0] < 0:
            q = -q
        quaternions.append(row(q, Rotation.from_quat(q[[1, 2, 3, 0]]).as_matrix()))
    while len(nearest) < 40:
        # from a hundredth of noise to nearly any matrix
        noise = 10.0 ** -(2 - len(nearest) / 20)
        M = oracle.euler_to_matrix(*any_ypr(rng)) * rng.uniform(0.3, 3)
        M = np.round(M + decimals(rng, -noise, noise, 4, (3, 3)), 4)
        U, s, Vt = np.linalg.svd(M)
        if np.linalg.det(M) > 0 and s[2] > 0.05 * s[0]:
            nearest.append(row(M, U @ Vt))
    lock = []
    for i in range(10):
        yaw, up = decimals(rng, -3.14, 3.14, 4), (1 if i % 2 else -1)
        # pitch exactly +-pi/2: sin 1, cos 0
        R = oracle.rot_z(yaw) @ np.array([[0, 0, up], [0, 1, 0], [-up, 0, 0]])
        lock.append(row(yaw, up * math.pi / 2, 0, R))
    return {
        "ROTATION_YPR": ("yaw, pitch, roll; R = Rz Ry Rx (8)", euler),
        "ROTATION_LOCK": ("gimbal lock: yaw, pitch, roll = 0; R", lock),
        "ROTATION_VECTOR": ("rotation vector w; R (SciPy's Rotation)", vectors),
        "ROTATION_QUATERNION": ("quaternion w, x, y, z of any length, w >= 0; R (SciPy's "
                                "Rotation)", quaternions),
        "ROTATION_NEAREST": ("M; the rotation nearest to it (NumPy's SVD: U V^T)", nearest),
    }


# ---- transforms and rigs ---------------------------------------------------------------
def karcher_mean(Rs, weights):
    R = Rs[0]
    for _ in range(200):
        w = sum(k * Rotation.from_matrix(R.T @ Q).as_rotvec() for k, Q in zip(weights, Rs))
        w /= sum(weights)
        R = R @ Rotation.from_rotvec(w).as_matrix()
    return Rotation.from_matrix(R).as_matrix()


def transforms():
    rng = random.Random(2)
    relative, bound, mean = [], [], []
    for _ in range(50):
        ya, yb = any_ypr(rng), any_ypr(rng)
        ta, tb = decimals(rng, -5, 5, 3, (3,)), decimals(rng, -5, 5, 3, (3,))
        R, t = oracle.relative_pose(oracle.euler_to_matrix(*ya), ta,
                                    oracle.euler_to_matrix(*yb), tb)
        relative.append(row(ya, ta, yb, tb, R, t))
    for i in range(40):
        y, size = any_ypr(rng), 10.0 ** -(i % 5)
        # not too small: the norm is of a difference of matrices
        y2 = np.round(y + decimals(rng, -1, 1, 4, (3,)) * size, 6)
        t, X = decimals(rng, -5, 5, 3, (3,)), decimals(rng, -5, 5, 3, (3,))
        t2 = np.round(t + decimals(rng, -1, 1, 4, (3,)) * size, 6)
        norm = oracle.rotation_difference_norm(oracle.euler_to_matrix(*y),
                                               oracle.euler_to_matrix(*y2))
        bound.append(row(y, t, y2, t2, X,
                         norm * np.linalg.norm(X) + np.linalg.norm(t - t2)))
    for i in range(40):
        spread = 0.02 if i % 2 else 0.8
        base = any_ypr(rng)
        yprs = [np.round(base + decimals(rng, -spread, spread, 4, (3,)), 4) for _ in range(5)]
        ts = [decimals(rng, -3, 3, 3, (3,)) for _ in range(5)]
        weights = [decimals(rng, 0.1, 4, 2) for _ in range(5)]
        if i % 5 == 0:
            weights[i % 4] = 0.0
        Rs = [oracle.euler_to_matrix(*y) for y in yprs]
        R = karcher_mean(Rs, weights)
        t = sum(k * x for k, x in zip(weights, ts)) / sum(weights)
        angles = [np.linalg.norm(Rotation.from_matrix(R.T @ Q).as_rotvec()) for Q in Rs]
        sr = math.sqrt(sum(k * a * a for k, a in zip(weights, angles)) / sum(weights))
        st = math.sqrt(sum(k * np.sum((x - t) ** 2) for k, x in zip(weights, ts))
                       / sum(weights))
        mean.append(row(*[row(k, y, x) for k, y, x in zip(weights, yprs, ts)], R, t, sr, st))
    return {
        "TRANSFORM_RELATIVE": ("a_from_world as yaw, pitch, roll and t; b_from_world "
                               "likewise; R and t of b_from_a (17), (18)", relative),
        "TRANSFORM_BOUND": ("b_from_a as yaw, pitch, roll and t; the true one; X_a; "
                            "|R - R'|_2 |X_a| + |t - t'| with NumPy's spectral norm", bound),
        "TRANSFORM_MEAN": ("five times weight, yaw, pitch, roll, t; R of the Karcher mean, "
                           "mean of t, weighted rms of the angles and of the distances "
                           "from it", mean),
    }


# ---- scenes and the calibration equations ----------------------------------------------
PAIRS = [(i, j) for j in range(6) for i in range(j)]  # those of n points: n(n-1)/2 first


def scene_list():
    """Six points, an image rounded to 1e-4 (that is its noise), angles off the truth."""
    rng, scenes = random.Random(3), []
    while len(scenes) < 80:
        X = decimals(rng, -0.5, 0.5, 3, (6, 3)) + np.round(decimals(rng, -2, 2, 1, (3,)), 1)
        X = np.round(X, 3)
        ypr = any_ypr(rng, 1.4)
        R = oracle.euler_to_matrix(*ypr)
        view = np.array([rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(3, 6)])
        t = np.round(view - R @ X.mean(0), 3)
        u = np.round(oracle.project(R, t, X), 4)
        # the first four points differ well in both image coordinates, as the average
        # over pairs (16) leaves out those that hardly do
        du = np.array([np.abs(u[i] - u[j]) for i, j in PAIRS[:6]])
        apart = min(np.linalg.norm(u[i] - u[j]) for i, j in PAIRS)
        if np.all(du > 0.15 * du.max(0)) and apart > 0.004:
            wrong = np.round(ypr + decimals(rng, -0.3, 0.3, 4, (3,)), 4)
            scenes.append((X, u, ypr, t, wrong))
    return scenes


def scenes():
    return {"SCENE": ("six points: X, Y, Z each; their noisy normalised image points: x, y "
                      "each; yaw, pitch, roll and t they were taken from; yaw, pitch, roll "
                      "nearby",
                      [row(X, u, ypr, t, wrong) for X, u, ypr, t, wrong in scene_list()])}


WHICH = (("yaw", (1, 2)), ("pitch", (0, 2)), ("roll", (0, 1)))


def points_of(k):
    return 3 + k % 4  # points used of scene k: 3, 4, 5, 6


def pairs():
    terms, coefficients = [], []
    for k, (X, u, _, _, wrong) in enumerate(scene_list()):
        i, j = PAIRS[k % 15]
        n, d = oracle.pair_terms(X, u, [(i, j)])[0]
        terms.append(row(i, j, n, d, n @ oracle.euler_to_matrix(*wrong) @ d))
        coefficients.append(row(*[oracle.eliminate_coefficients(n, d, which, *wrong[list(ab)])
                                  for which, ab in WHICH]))
    return {
        "PAIR_TERMS": ("of each scene one pair: i, j, normal, offset (11), and the residual "
                       "at the angles nearby (13)", terms),
        "PAIR_COEFFICIENTS": ("of the same pairs p, q, k (14) at the angles nearby when yaw, "
                              "pitch, roll is eliminated", coefficients),
    }


def eliminate_all(terms, which, a1, a2):
    """A of every pair, by least squares."""
    P = np.array([oracle.eliminate_coefficients(n, d, which, a1, a2) for n, d in terms])
    (c, s), _, _, sv = np.linalg.lstsq(P[:, :2], -P[:, 2], rcond=None)
    w = np.arctan2(s, c)
    r = abs(c * c + s * s - 1)
    r += np.sum(np.abs(P[:, 0] * np.cos(w) + P[:, 1] * np.sin(w) + P[:, 2]))
    return w, c, s, sv[0] / sv[1], c * c + s * s - 1, r


def eliminate_two(terms, which, a1, a2):
    """The oracle's, with what it does not return."""
    P = [oracle.eliminate_coefficients(n, d, which, a1, a2) for n, d in terms[:2]]
    c, s = np.linalg.solve([P[0][:2], P[1][:2]], [-P[0][2], -P[1][2]])
    r, w, cond = oracle.two_angle_residual(terms, which, a1, a2)
    return w, c, s, cond, c * c + s * s - 1, r


def elimination(form):
    out = []
    for k, (X, u, _, _, wrong) in enumerate(scene_list()):
        n = points_of(k)
        terms = oracle.pair_terms(X, u, PAIRS[:n * (n - 1) // 2])
        out.append(row(*[form(terms, which, *wrong[list(ab)]) for which, ab in WHICH]))
    return out


ELIMINATION = ("of scene k, with all pairs of its first 3 + k % 4 points, (0,1), (0,2), (1,2), "
               "(0,3) .., at the angles nearby, when yaw, pitch, roll is eliminated: angle, "
               "cosine, sine, cond, c^2 + s^2 - 1, residual. ")


def elimination_two():
    return {"ELIMINATION_TWO": (ELIMINATION + "A of the first two pairs.",
                                elimination(eliminate_two))}


def elimination_all():
    return {"ELIMINATION_ALL": (ELIMINATION + "A of all pairs, by NumPy's lstsq.",
                                elimination(eliminate_all))}


def translation():
    out = []
    for X, u, ypr, _, wrong in scene_list():
        R, R2 = oracle.euler_to_matrix(*ypr), oracle.euler_to_matrix(*wrong)
        out.append(row(oracle.translation_from_pairs(R, X[:4], u[:4], PAIRS[:6]),
                       oracle.translation_from_pairs(R2, X[:4], u[:4], PAIRS[:6]),
                       oracle.translation_least_squares(R, X, u),
                       oracle.translation_least_squares(R2, X, u),
                       np.sum([abs(n @ R2 @ d) for n, d in oracle.pair_terms(X, u, PAIRS)])))
    return {"TRANSLATION": ("of each scene t by the average over the pairs of its first four "
                            "points (16) at the angles they were taken from, and at those "
                            "nearby; t by least squares over six points at both; the "
                            "three-angle residual (5) of all 15 pairs at those nearby", out)}


# ---- two views -------------------------------------------------------------------------
def two_views():
    rng, out = random.Random(5), []
    while len(out) < 80:
        ypr = decimals(rng, -0.8, 0.8, 4, (3,))
        t = decimals(rng, -2, 2, 3, (3,))
        R = oracle.euler_to_matrix(*ypr)
        Xa = np.array([rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(2, 8)])
        Xb = R @ Xa + t
        if Xb[2] < 1:
            continue
        ua = np.round(Xa[:2] / Xa[2], 4)
        ub = np.round(Xb[:2] / Xb[2] + [rng.gauss(0, 0.003), rng.gauss(0, 0.003)], 4)
        a, b = R @ np.append(ua, 1), np.append(ub, 1)
        sine = np.linalg.norm(np.cross(a, b)) / np.linalg.norm(a) / np.linalg.norm(b)
        za, zb = oracle.depth_least_squares(R, t, ua, ub)
        if sine > 0.02 and za > 0 and zb > 0:
            line = oracle.matching_line(R, t, ua)
            out.append(row(ypr, t, ua, ub, za, zb, np.linalg.norm(zb * b - za * a - t),
                           line / np.hypot(line[0], line[1]), sine))
    return {"TWO_VIEWS": ("b_from_a as yaw, pitch, roll and t; x, y in a; x, y in b, noisy; "
                          "depths in a and b by lstsq (22)..(24) and the distance of the rays "
                          "there; matching line (25), (26); sine of the angle between the "
                          "rays", out)}


# ---- cameras ---------------------------------------------------------------------------
# lens (0 Brown, 1 fisheye), width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6
CAMERAS = [
    [0, 640, 480, 800, 800, 319.5, 239.5, 0, 0, 0, 0, 0, 0, 0, 0],
    [0, 1280, 1024, 1100, 1090, 650.25, 500.5, -0.28, 0.09, 0.0011, -0.0007, -0.012, 0, 0, 0],
    [0, 1920, 1080, 950, 955, 940, 560, 5.1, 2.2, 0.0003, 0.0002, 0.11, 5.4, 4.1, 0.62],
    [0, 800, 600, 700, 700, -90, 720, -0.05, 0.002, 0, 0, 0, 0, 0, 0],
    [1, 1280, 960, 380, 381, 640.5, 470, -0.02, 0.006, 0, 0, -0.003, 0.0004, 0, 0],
]


def project_px(camera, X):
    """The formulas of rigcal.h. Complex X will do, so that derivatives can be exact."""
    lens, _, _, fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 = camera
    if lens == 0:
        x, y = X[0] / X[2], X[1] / X[2]
        q = x * x + y * y
        d = (1 + k1 * q + k2 * q**2 + k3 * q**3) / (1 + k4 * q + k5 * q**2 + k6 * q**3)
        xd = x * d + 2 * p1 * x * y + p2 * (q + 2 * x * x)
        yd = y * d + p1 * (q + 2 * y * y) + 2 * p2 * x * y
    else:
        r = np.sqrt(X[0] ** 2 + X[1] ** 2)
        th = np.arctan(r / X[2]) if np.real(X[2]) > 0 else np.pi / 2 - np.arctan(X[2] / r)
        bent = th * (1 + k1 * th**2 + k2 * th**4 + k3 * th**6 + k4 * th**8)
        xd, yd = X[0] / r * bent, X[1] / r * bent
    return np.array([fx * xd + cx, fy * yd + cy])


def cameras():
    rng, out = random.Random(6), []
    for k, camera in enumerate(CAMERAS):
        reach = [0.4, 0.6, 0.9, 1.0, 2.5][k]
        for _ in range(30):
            X = decimals(rng, -reach, reach, 4, (3,))
            X[2] = 1.0
            if camera[0] == 1:  # up to 120 degrees off the axis
                X = decimals(rng, -1, 1, 4, (3,))
                X[2] = decimals(rng, -0.4, 1.0, 4)
            X = np.round(X * decimals(rng, 0.5, 20, 1), 4)
            if np.linalg.norm(X[:2]) > 0.01:
                out.append(row(k, X, project_px(camera, X)))
    return {
        "CAMERA": ("lens (0 Brown, 1 fisheye), width, height, fx, fy, cx, cy, k1, k2, p1, p2, "
                   "k3, k4, k5, k6", CAMERAS),
        "CAMERA_PROJECTION": ("index of the camera; point in its frame; its pixel", out),
    }


# ---- triangulation ---------------------------------------------------------------------
def exact_jacobian(f, X):
    """By complex steps: as accurate as f itself."""
    h = 1e-30
    return np.column_stack([np.imag(f(X + 1j * h * e)) / h for e in np.eye(3)])


def triangulation():
    rng, out = random.Random(7), []
    while len(out) < 40:
        n = 2 + len(out) % 4
        X = decimals(rng, -0.5, 0.5, 3, (3,)) + [0, 0, 5]
        which, yprs, ts, uvs = [], [], [], []
        while len(which) < n:
            k = rng.randrange(5)
            ypr, t = decimals(rng, -0.25, 0.25, 4, (3,)), decimals(rng, -1.2, 1.2, 3, (3,))
            p = oracle.euler_to_matrix(*ypr) @ X + t
            if p[2] < 3 or np.hypot(p[0], p[1]) > 0.55 * p[2]:
                continue
            uv = project_px(CAMERAS[k], p) + [rng.gauss(0, 0.5), rng.gauss(0, 0.5)]
            which, yprs, ts = which + [k], yprs + [ypr], ts + [t]
            uvs.append(np.round(uv, 2))
        Rs = [oracle.euler_to_matrix(*y) for y in yprs]
        rays = [R.T @ (R @ X + t) / np.linalg.norm(R @ X + t) for R, t in zip(Rs, ts)]
        if max(np.linalg.norm(np.cross(a, b)) for a in rays for b in rays) < 0.1:
            continue

        def residual(P):
            return np.concatenate([project_px(CAMERAS[k], R @ P + t) - uv
                                   for k, R, t, uv in zip(which, Rs, ts, uvs)])

        P = least_squares(residual, X, x_scale=0.01, xtol=1e-12, ftol=1e-12).x
        for _ in range(20):  # to the last digit
            J = exact_jacobian(residual, P)
            P = P - np.linalg.solve(J.T @ J, J.T @ residual(P))
        J, r = exact_jacobian(residual, P), residual(P)
        views = [row(k, y, t, uv) for k, y, t, uv in zip(which, yprs, ts, uvs)]
        views += [np.zeros(9)] * (5 - n)
        out.append(row(n, *views, P, math.sqrt(np.sum(r**2) / n), np.linalg.inv(J.T @ J)))
    return {"TRIANGULATION": ("views n; five times (those beyond n are 0) index of the camera, "
                              "yaw, pitch, roll and t of its pose, noisy pixel; X by SciPy's "
                              "least_squares and exact derivatives, rms [px], covariance at "
                              "sigma_px = 1: (J^T J)^-1", out)}


# ---- the direction of the optical axis -------------------------------------------------
def least_over_yaw(moments, M):
    """The oracle's harmonics, minimised exactly: the stationary points are roots of a
    quartic in exp(i yaw), and the arc of positive depth has two ends. None: no arc."""
    const, a, b, U, B = moments.harmonics(M)
    if abs(U) <= B:
        return None
    # d/dyaw Re(a z + b z^2) = 0:  2 b z^4 + a z^3 - conj(a) z - 2 conj(b) = 0 on |z| = 1
    z = np.roots([2 * b, a, 0, -np.conj(a), -2 * np.conj(b)])
    z = z[np.abs(np.abs(z) - 1) < 1e-4]
    z = z / np.abs(z)
    for _ in range(3):  # to the last digit
        slope, bend = np.imag(a * z + 2 * b * z * z), np.real(a * z + 4 * b * z * z)
        safe = np.where(np.abs(bend) > 1e-6 * abs(a), bend, np.inf)
        z = z * np.exp(-1j * slope / safe)
    z = z[np.real(U * z) > B]
    if abs(B) < abs(U):
        ends = np.exp(1j * np.arccos(B / abs(U)) * np.array([1, -1])) * np.conj(U) / abs(U)
        z = np.concatenate([z, ends])
    cost = np.min(const - np.real(a * z) - np.real(b * z * z))
    brute, _ = moments.cost(M)
    assert abs(cost - brute) < 1e-6 * np.trace(moments.C)
    return cost


def direction():
    rng, out = random.Random(8), []
    for k, (X, u, ypr, t, wrong) in enumerate(scene_list()[:40]):
        n = 4 + k % 3
        moments = oracle.Moments(X[:n], u[:n])
        directions = [oracle.euler_to_matrix(*y)[2] for y in (ypr, wrong)]
        directions += [np.array([rng.gauss(0, 1) for _ in range(3)]) for _ in range(4)]
        for m3 in directions:
            m3 = np.round(m3 / np.linalg.norm(m3), 6)
            unit = m3 / np.linalg.norm(m3)
            M = oracle.rot_y(np.arcsin(-unit[0])) @ oracle.rot_x(np.arctan2(unit[1], unit[2]))
            cost = least_over_yaw(moments, M)
            out.append(row(k, n, m3, np.trace(moments.C), -1 if cost is None else cost))
    return {"DIRECTION_COST": ("scene and how many of its points, not rotated to the axis; "
                          "direction m3, to be made of unit length; sum |X - mean|^2; cost by "
                          "the oracle's Moments, least over yaw on the closed arc of "
                          "positive depth: -1 when there is none", out)}


# ---- maximum likelihood ----------------------------------------------------------------
def lower(A):
    return A[np.tril_indices(6)]


def refine_pinhole():
    equations, minimum = [], []
    for k, (X, u, ypr, t, wrong) in enumerate(scene_list()[:40]):
        n = 4 + k % 3
        X, u = X[:n], u[:n]
        R = oracle.euler_to_matrix(*wrong)
        if np.min((X @ R.T + t)[:, 2]) > 0.5:
            J, r = oracle.reprojection_jacobian(R, t, X), (u - oracle.project(R, t, X)).ravel()
            equations.append(row(k, n, r @ r, J.T @ r, lower(J.T @ J)))
        R, t, _ = oracle.refine(oracle.euler_to_matrix(*ypr), t, X, u)
        for _ in range(30):  # to the last digit
            J, r = oracle.reprojection_jacobian(R, t, X), (u - oracle.project(R, t, X)).ravel()
            d = np.linalg.solve(J.T @ J, J.T @ r)
            R, t = oracle.exp_so3(d[:3]) @ R, t + d[3:]
        sse = np.sum((u - oracle.project(R, t, X)) ** 2)
        # not those that a little noise would tip over
        spread = np.sqrt(np.diag(oracle.pose_covariance(R, t, X, 1e-4)))
        if np.max(spread[:3]) < 0.02:
            minimum.append(row(k, n, R, t, sse, lower(oracle.pose_covariance(R, t, X, 1))))
    return equations, minimum


def lens_equations(camera, R, t, X, uv, sigma):
    """Residuals over sigma and their exact derivatives by (w, dt)."""
    r, J = [], []
    for x, p, s in zip(X, uv, sigma):
        q = R @ x
        Jc = exact_jacobian(lambda P: project_px(camera, P), q + t)
        cross = np.array([[0, -q[2], q[1]], [q[2], 0, -q[0]], [-q[1], q[0], 0]])
        r.append((p - project_px(camera, q + t)) / s)
        J.append(np.hstack([-Jc @ cross, Jc]) / s)
    return np.concatenate(r), np.vstack(J)


def refine_lens():
    rng, out = random.Random(9), []
    while len(out) < 30:
        k, n = len(out) % 5, 5 + len(out) % 4
        weighted = len(out) % 2
        X = decimals(rng, -0.5, 0.5, 3, (n, 3)) + decimals(rng, -2, 2, 1, (3,))
        X = np.round(X, 3)
        R = oracle.euler_to_matrix(*any_ypr(rng, 1.4))
        off = rng.uniform(0, 1.7 if k == 4 else 0.35)
        way, far = rng.uniform(-3.1, 3.1), rng.uniform(3, 6)
        centre = far * np.array([np.sin(off) * np.cos(way), np.sin(off) * np.sin(way),
                                 np.cos(off)])
        t = centre - R @ X.mean(0)
        P = X @ R.T + t
        if k < 4 and np.max(np.hypot(P[:, 0], P[:, 1]) / P[:, 2]) > 0.6:
            continue
        sigma = np.array([[0.5, 1, 2][i % 3] if weighted else 1.0 for i in range(n)])
        uv = np.array([project_px(CAMERAS[k], p) for p in P])
        uv = np.round(uv + [[s * rng.gauss(0, 0.5), s * rng.gauss(0, 0.5)] for s in sigma], 2)
        # two to five degrees and a few percent of the distance off
        axis = np.array([rng.gauss(0, 1) for _ in range(3)])
        axis *= math.radians(rng.uniform(2, 5)) / np.linalg.norm(axis)
        R0 = oracle.exp_so3(axis) @ R
        start = np.round(oracle.matrix_to_euler(R0), 4)
        R0 = oracle.euler_to_matrix(*start)
        t0 = centre * rng.uniform(0.95, 1.05) - R0 @ X.mean(0)
        t0 = np.round(t0, 3)

        def residual(v):
            Rv = oracle.exp_so3(v[:3]) @ R
            return np.concatenate([(project_px(CAMERAS[k], Rv @ x + t + v[3:]) - p) / s
                                   for x, p, s in zip(X, uv, sigma)])

        best = least_squares(residual, np.zeros(6), x_scale=[0.01] * 6, xtol=1e-14, ftol=1e-14)
        R, t = oracle.exp_so3(best.x[:3]) @ R, t + best.x[3:]
        for _ in range(30):  # to the last digit
            r, J = lens_equations(CAMERAS[k], R, t, X, uv, sigma)
            d = np.linalg.solve(J.T @ J, J.T @ r)
            R, t = oracle.exp_so3(d[:3]) @ R, t + d[3:]
        r, J = lens_equations(CAMERAS[k], R, t, X, uv, sigma)
        if abs(r @ r - 2 * best.cost) > 1e-6 * (r @ r):
            continue
        points = [row(x, p, s) for x, p, s in zip(X, uv, sigma)] + [np.zeros(6)] * (8 - n)
        out.append(row(k, n, *points, start, t0, R, t, r @ r, lower(np.linalg.inv(J.T @ J))))
    return out


def refine():
    equations, minimum = refine_pinhole()
    return {
        "REFINE_EQUATIONS": ("scene and how many of its points, at the angles nearby and t, "
                             "in normalised coordinates: sum of squares, J^T e (w, dt), lower "
                             "triangle of J^T J, by the oracle's reprojection_jacobian",
                             equations),
        "REFINE_PINHOLE": ("scene and how many of its points: R and t of the minimum that "
                           "the oracle's refine comes to from the angles and t they were "
                           "taken from, sum of squares, lower triangle of its "
                           "pose_covariance at sigma = 1, all in normalised coordinates",
                           minimum),
        "REFINE_LENS": ("index of the camera, points n, eight times (those beyond n are 0) "
                        "X, noisy pixel, sigma; start: yaw, pitch, roll, t; minimum by "
                        "SciPy's least_squares and exact derivatives: R, t, sum of squared "
                        "errors over sigma, lower triangle of (J^T J)^-1", refine_lens()),
    }


# ---- Nelder-Mead -----------------------------------------------------------------------
# Only sums and products, written out, so that C can do the same operations in the same order.
def rosenbrock(x):
    a, b = x[1] - x[0] * x[0], 1 - x[0]
    return 100 * a * a + b * b


def powell(x):  # Powell's (1962) singular quartic in four variables, the last held at 0
    a, b = x[0] + 10 * x[1], x[1] - 2 * x[2]
    bb, xx = b * b, x[0] * x[0]
    return a * a + 5 * x[2] * x[2] + bb * bb + 10 * xx * xx


def himmelblau(x):
    a, b = x[0] * x[0] + x[1] - 11, x[0] + x[1] * x[1] - 7
    return a * a + b * b


def quartic(x):  # one variable, minimum at 2
    a = x[0] - 2
    return a * a * a * a + a * a


FUNCTIONS = [(rosenbrock, 2), (powell, 3), (himmelblau, 2), (quartic, 1)]
STARTS = [
    [(-1.2, 1), (0, 0), (2, -2), (1, 1), (-3, 7)],
    [(3, -1, 0), (1, 1, 1), (0, 0, 0), (-2, 3, 5)],
    [(0, 0), (1, 1), (-4, 4), (5, -3), (-1, -2), (3, 2)],
    [(0,), (10,), (-3.5,), (2,)],
]


def fminsearch_simplex(x0):
    rows = [np.array(x0, float)]
    for i in range(len(x0)):
        v = np.array(x0, float)
        v[i] = v[i] * 1.05 if v[i] != 0 else 0.00025
        rows.append(v)
    return np.array(rows)


def run_neldermead(f, x0, tol, max_evals, trace=None):
    def g(x):
        if trace is not None:
            trace.append(np.array(x))
        return f([float(v) for v in x])
    return minimize(g, x0, method="Nelder-Mead",
                    options={"initial_simplex": fminsearch_simplex(x0), "xatol": tol,
                             "fatol": tol, "maxfev": max_evals, "maxiter": 10**9})


def pad(x):
    return row(x, np.zeros(3 - len(x)))


def neldermead():
    runs, trace = [], []
    for which, (f, k) in enumerate(FUNCTIONS):
        for x0 in STARTS[which]:
            for tol, most in ((1e-4, 100000), (1e-8, 100000), (1e-8, 20), (1e-8, 31),
                              (1e-8, 50)):
                r = run_neldermead(f, x0, tol, most)
                if most < 100000 and r.status == 0:
                    continue
                runs.append(row(which, k, pad(x0), tol, most, r.nfev, pad(r.x), r.fun,
                                r.status))
    points = []
    run_neldermead(rosenbrock, (-1.2, 1), 1e-4, 100000, points)
    trace = [row(p, rosenbrock(p)) for p in points]
    return {
        "NELDERMEAD_RUN": (
            "scipy.optimize.minimize(method='Nelder-Mead') from fminsearch's simplex: "
            "function, k, x0 (three), xatol = fatol, maxfev; evaluations, x (three), f(x), "
            "0 converged or 1 evaluations spent. Functions 0 Rosenbrock, 1 Powell's "
            "singular quartic with its fourth variable at 0, 2 Himmelblau, 3 (x - 2)^4 + "
            "(x - 2)^2; the order of the operations is that of make_vectors.py", runs),
        "NELDERMEAD_TRACE": ("every point that the first of those runs evaluates, in order: "
                             "x, y, f", trace),
    }


# ---- stored calibrations ---------------------------------------------------------------
SEQUENCE, TAG = 0xFFFFFFFE, 0x12345678


def stored_cameras():
    """lens, width, height, whether Sigma is known; the other numbers of the camera; R; t;
    Sigma."""
    rng, out = random.Random(10), []
    for k, known in ((0, 0), (1, 1), (4, 1)):
        A = decimals(rng, -1e-3, 1e-3, 6, (6, 6))
        Sigma = np.array([float("%.6e" % x) for x in (A @ A.T).ravel()]) * known
        # not all digits: the last one may differ between machines, and bytes would show it
        R = np.round(oracle.euler_to_matrix(*any_ypr(rng)), 12) if k else np.eye(3)
        t = decimals(rng, -5, 5, 4, (3,)) if k else np.zeros(3)
        out.append(row(CAMERAS[k][:3], known, CAMERAS[k][3:], R, t, Sigma) + 0.0)  # no -0
    return out


def stored(rows, letter):
    """The byte form of FORMAT.md; letter d or f, struct's for the two precisions."""
    body = b""
    for r in rows:
        body += struct.pack("<4i", *[int(x) for x in r[:4]])
        numbers = row(r[4:28], lower(r[28:].reshape(6, 6)))
        body += struct.pack("<%d%s" % (len(numbers), letter), *numbers)
    head = struct.pack("<4sHHIIII", b"RIGC", 1, struct.calcsize("<" + letter), len(rows),
                       SEQUENCE, TAG, 32 + len(body)) + struct.pack("<I", zlib.crc32(body))
    return head + struct.pack("<I", zlib.crc32(head)) + body


HELD, GROUP = (1, 0, 0), (0, 0, 1)


def stored_joint():
    """sigma_px, F, its degrees of freedom; the joint covariance of the cameras that are not
    held, lower triangle."""
    A = decimals(random.Random(12), -1e-3, 1e-3, 6, (12, 12))
    Sigma = [float("%.6e" % x) for x in (A @ A.T)[np.tril_indices(12)]]
    return row(0.3125, 1.75, 42, 1234), row(Sigma)


def stored_rig(rows, letter):
    """The byte form of a calibrated rig."""
    numbers, Sigma = stored_joint()
    body = struct.pack("<4%s" % letter, *numbers)
    for r, held, group in zip(rows, HELD, GROUP):
        body += struct.pack("<5i", *[int(x) for x in r[:3]], held, group)
        body += struct.pack("<24%s" % letter, *r[4:28])
    body += struct.pack("<%d%s" % (len(Sigma), letter), *Sigma)
    head = struct.pack("<4sHHIIII", b"RIGC", 2, struct.calcsize("<" + letter), len(rows),
                       SEQUENCE, TAG, 32 + len(body)) + struct.pack("<I", zlib.crc32(body))
    return head + struct.pack("<I", zlib.crc32(head)) + body


def store():
    rng, crcs = random.Random(11), []
    for text in [b"", b"123456789", b"\0", b"\xff" * 32, b"\0" * 40] + [
            bytes(rng.randrange(256) for _ in range(n)) for n in range(1, 40)]:
        crcs.append(row(len(text), list(text) + [0] * (40 - len(text)), zlib.crc32(text)))
    rows = stored_cameras()
    return {
        "STORE_CRC": ("number of bytes; the bytes, and zeros up to 40; zlib.crc32 of them",
                      crcs),
        "STORE_CAMERA": ("a calibration: of each camera lens, width, height, whether Sigma is "
                         "known; fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6; R; t; Sigma",
                         rows),
        "STORE_NUMBERS": ("its sequence number and tag", [row(SEQUENCE, TAG)]),
        "STORE_DOUBLE": ("its bytes as a double build stores them, by Python's struct and "
                         "zlib", [row(list(stored(rows, "d")))]),
        "STORE_FLOAT": ("and as a float build does", [row(list(stored(rows, "f")))]),
        "STORE_JOINT": ("a calibrated rig of the same cameras: sigma_px, F, its two degrees of "
                        "freedom; whether each camera is held; its group; the joint "
                        "covariance, lower triangle",
                        [row(stored_joint()[0], HELD, GROUP, stored_joint()[1])]),
        "STORE_RIG_DOUBLE": ("its bytes as a double build stores them",
                             [row(list(stored_rig(rows, "d")))]),
        "STORE_RIG_FLOAT": ("and as a float build does",
                            [row(list(stored_rig(rows, "f")))]),
    }


# ---- chance ----------------------------------------------------------------------------
def chance():
    rows = []
    for freedom in (1, 2, 4, 6, 10, 20, 40, 100, 640):
        for deviations in (0, 1, 2, 3.1, 4.75):
            rows.append(row(freedom, deviations,
                            chi2.isf(norm.sf(deviations), freedom)))
    return {"CHANCE_CHI2": ("degrees of freedom, standard deviations of a normal variable; "
                            "the chi squared that is exceeded as seldom", rows)}


# ---- the whole rig ---------------------------------------------------------------------
RIG_CAMERAS = [0, 1, 4]  # of CAMERAS: a pinhole, a Brown lens, a fisheye
RIG_PLACES = 5
RIG_POINTS = 8
RIG_UNSEEN = (2, 3)  # camera and placement


def rig_problem():
    """Poses as yaw, pitch, roll, t; points; pixels, all of a few digits."""
    rng = random.Random(12)
    cams = [np.zeros(6), np.array([0.31, -0.42, 0.05, 2.1, -0.2, 0.4]),
            np.array([-0.2, 0.37, -0.1, -1.9, 0.3, 0.5])]
    places = [row(decimals(rng, -0.6, 0.6, 3, (3,)), decimals(rng, -0.5, 0.5, 3, (2,)),
                  decimals(rng, 4.5, 5.5, 3)) for _ in range(RIG_PLACES)]
    X = np.array([[(0.5 if i >> k & 1 else -0.5) + decimals(rng, -0.2, 0.2, 3)
                   for k in range(3)] for i in range(RIG_POINTS)])
    X = np.round(X, 3)
    views = []
    for f in range(RIG_PLACES):
        for c, k in enumerate(RIG_CAMERAS):
            if (c, f) == RIG_UNSEEN:
                continue
            R, t = oracle.compose(rig_pose(cams[c]), rig_pose(places[f]))
            spreads = np.array([[1, 0.5, 2][(i + c) % 3] for i in range(RIG_POINTS)])
            uv = np.array([project_px(CAMERAS[k], R @ x + t) for x in X])
            noise = np.array([[rng.gauss(0, 0.4) * s for _ in range(2)] for s in spreads])
            views.append((c, f, X, np.round(uv + noise, 2), spreads))
    return cams, places, X, views


def rig_pose(six):
    return oracle.euler_to_matrix(*six[:3]), np.array(six[3:], float)


def rig():
    cams, places, X, views = rig_problem()
    K, P = [rig_pose(c) for c in cams], [rig_pose(f) for f in places]

    def px(c, point):
        return project_px(CAMERAS[RIG_CAMERAS[c]], point)

    # sigma of 0.4 px; camera 1 and camera 2 known beforehand, a little beside the truth
    off = [np.array([0.002, -0.001, 0.0015, 0.004, -0.003, 0.002]) * s for s in (1, -1)]
    covariances = [np.diag(s * np.array([1e-6, 2e-6, 1e-6, 4e-6, 5e-6, 9e-6])) for s in (1, 4)]
    before = {c: (oracle.moved(K[c], off[c - 1]), covariances[c - 1]) for c in (1, 2)}
    answers, noise, own = [], [], 0
    bumped = list(K)
    bumped[1] = oracle.moved(K[1], [0.001, 0.002, -0.001, 0.003, 0.002, -0.004])
    for kind, (start, held, priors) in enumerate((
            (K, (0,), {}), (bumped, (0, 1), {}), (K, (), before))):
        C, F, total, covariance, begin, errors, lost = oracle.rig_adjust(
            px, views, start, P, held, priors, 0.4)
        by = np.repeat([c for c, *_ in views], 2 * RIG_POINTS)
        for c in range(3):
            mine = np.flatnonzero(by == c)
            noise.append(row(kind, c, errors[mine] @ errors[mine], np.sum(1 - lost[mine])))
        for c in range(3):
            block = np.zeros((6, 6))
            if begin[c] is not None:
                block = covariance[begin[c]:begin[c] + 6, begin[c]:begin[c] + 6]
            answers.append(row(kind, 0, c, *C[c], total, block))
        for f in range(RIG_PLACES):
            i = len(covariance) - 6 * (RIG_PLACES - f)
            answers.append(row(kind, 1, f, *F[f], total, covariance[i:i + 6, i:i + 6]))
        for a, b in ((0, 1), (1, 2), (2, 1)):
            pose, Sigma = oracle.rig_pair(C, covariance, begin, a, b)
            answers.append(row(kind, 2, 3 * a + b, *pose, total, Sigma))
    for c, f, *seen in views:  # the camera's own frame, in which the target is placed
        alone = [K[0]] * 3
        own += oracle.rig_adjust(px, [(c, 0, *seen)], alone, [oracle.compose(K[c], P[f])],
                                 (0, 1, 2))[2]
    total = answers[0][15]
    closure = oracle.loop_closure(total, own, len(views), 3, RIG_PLACES,
                                  RIG_POINTS * len(views))
    known = {0: (K[0], np.zeros((6, 6))), **before}
    return {
        "RIG_CAMERA": ("a camera: the numbers of rigcal_camera; yaw, pitch, roll, t of the "
                       "pose from which the pixels come; the same, as R and t, of the bumped "
                       "start; of the pose that is known beforehand, R, t; its covariance",
                       [row(CAMERAS[k], cams[c], *bumped[c], *known[c][0], known[c][1])
                        for c, k in enumerate(RIG_CAMERAS)]),
        "RIG_PLACE": ("a placement: yaw, pitch, roll, t", places),
        "RIG_POINT": ("a point of the target", X),
        "RIG_VIEW": ("a view: camera, placement; of each point the pixel and its sigma",
                     [row(c, f, *[row(p, s) for p, s in zip(uv, spreads)])
                      for c, f, _, uv, spreads in views]),
        "RIG_ANSWER": ("what least squares over all poses come to. 0 camera 0 is held, 1 "
                       "cameras 0 and 1 are, camera 1 bumped, 2 cameras 1 and 2 have what is "
                       "known beforehand at sigma 0.4 px and camera 0 is free; 0 a camera, 1 "
                       "a placement, 2 camera b from camera a; its number, or 3 a + b; R, t, "
                       "sum of squares, covariance for noise of 1 px", answers),
        "RIG_NOISE": ("of each kind of RIG_ANSWER and each camera: its sum of squares, and its "
                      "degrees of freedom: those of the errors less what they lose to the "
                      "unknowns", noise),
        "RIG_CLOSURE": ("sum of squares of the views by themselves, F, its degrees of freedom "
                        "between and within", [row(own, *closure)]),
    }


# ---- two poses of each view ------------------------------------------------------------
CHOICE_CAMS, CHOICE_PLACES, CHOICE_SIGMA = 4, 6, 0.3


def choice_information(rng, T):
    """Of a tag's pose, roughly: the tilt is known least, then the distance."""
    J = np.diag([9, 8, 40, 80, 80, 9.]) + decimals(rng, -2, 2, 1, (6, 6))
    return J.T @ J


def choice_views():
    """Poses as R and t of a few digits, information, sum of squares. Of each view two; one
    view in four has the wrong one first, and one view is of another placement."""
    rng = random.Random(31)
    cams = [np.zeros(6)] + [np.array([decimals(rng, -.2, .2, 2), .3 * c, decimals(rng, -.2, .2, 2),
                                      -3.1 * c, decimals(rng, -.5, .5, 2), .6 * c * c])
                            for c in range(1, CHOICE_CAMS)]
    places = [row(decimals(rng, -.5, .5, 2, (3,)), decimals(rng, -.6, .6, 2, (2,)),
                  decimals(rng, 9.5, 10.5, 2)) for _ in range(CHOICE_PLACES)]
    views, rows = {}, []
    for f in range(CHOICE_PLACES):
        for c in range(CHOICE_CAMS):
            if (c, f) in ((2, 1), (0, 4), (1, 4)):
                continue
            T = oracle.compose(rig_pose(cams[c]), rig_pose(places[(f + 1) % 6 if (c, f) == (3, 3)
                                                                  else f]))
            H = choice_information(rng, T)
            noise = np.linalg.solve(np.linalg.cholesky(H).T,
                                    [rng.gauss(0, CHOICE_SIGMA) for _ in range(6)])
            T = oracle.moved(T, noise)
            sight = T[1] / np.linalg.norm(T[1])
            n = T[0][:, 2]
            mirrored = T[0].copy()  # tilted to the other side of the line of sight
            axis = np.cross(n, sight)
            angle = 2 * math.atan2(np.linalg.norm(axis), n @ sight)
            mirrored = oracle.exp_so3(axis / np.linalg.norm(axis) * angle) @ mirrored
            sums = sorted(decimals(rng, .05, .6, 3, (2,)))
            if rng.random() < .25:
                sums = sums[::-1]
            found = [(T, H, sums[0]), ((mirrored, T[1]), choice_information(rng, T), sums[1])]
            if (c, f) == (1, 2):
                found = found[:1]
            views[c, f] = sorted(found, key=lambda x: x[2])
            for i, (pose, information, sse) in enumerate(views[c, f]):
                ypr = np.round(oracle.matrix_to_euler(pose[0]), 5)
                t = np.round(pose[1], 5)
                information = np.round(np.round(information, 8), 1)  # ties, whatever rounds J.T @ J
                views[c, f][i] = ((oracle.euler_to_matrix(*ypr), t), information, sse)
                rows.append(row(c, f, i, ypr, t, information[np.triu_indices(6)], sse))
    return views, rows


def choice():
    views, rows = choice_views()
    takes, tau2, share, cams, places = oracle.choose(views, CHOICE_CAMS, CHOICE_PLACES,
                                                     CHOICE_SIGMA)
    apart = []
    for f, g in ((0, 2), (2, 0), (3, 5), (1, 0)):
        one, other = (oracle.pair_claims(views, at, 0, 1) for at in (f, g))
        for i in range(len(one)):
            for j in range(len(other)):
                # the number of a hypothesis: 2 (candidate of camera 0) + candidate of camera 1
                step = [2 if len(views[1, at]) == 2 else 1 for at in (f, g)]
                k, m = (2 * (x // s) + x % s for x, s in zip((i, j), step))
                apart.append(row(f, k, g, m, oracle.squared_distance(one[i], other[j],
                                                                     one[i][3])))
    back = oracle.inverse(cams[0])
    return {
        "CHOICE_POSE": ("a pose of a view: camera, placement, 0 the better or 1 the other; yaw, "
                        "pitch, roll, t; information, the upper triangle row by row; sum of "
                        "squares [px^2]", rows),
        "CHOICE_APART": ("camera 1 from camera 0 by placement, with 2 (pose of camera 0) + pose "
                         "of camera 1; and by another; their squared distance for noise of 1 px",
                         apart),
        "CHOICE_ANSWER": ("noise 0.3 px: tau^2, the share that agrees", [row(tau2, share)]),
        "CHOICE_TAKES": ("camera, placement, the pose that it takes; 2: none",
                         [row(c, f, t) for (c, f), t in sorted(takes.items(),
                                                               key=lambda x: x[0][::-1])]),
        "CHOICE_CAMERA": ("a camera from camera 0: R, t",
                          [row(*oracle.compose(cams[c], back)) for c in range(CHOICE_CAMS)]),
        "CHOICE_PLACE": ("a placement from camera 0: R, t",
                         [row(*oracle.compose(cams[0], places[f]))
                          for f in range(CHOICE_PLACES)]),
    }


# ---- files -----------------------------------------------------------------------------
# ---- faults ----------------------------------------------------------------------------
def faults_rig(seed, fault, size):
    """Three cameras, two runs of three placements, a board of 3 x 3 points that moves; 0.3 px of
    noise, and a fault in what was seen."""
    rng = random.Random(seed)
    cameras = [[1280, 960, 800 + 10 * c, 805, 640 - 3 * c, 480, -0.1 + 0.02 * c, 0.03] for c in range(3)]
    X = np.array([[0.11 * i - 0.11, 0.09 * j - 0.09, 0] for j in range(3) for i in range(3)])
    times = [10 * run + (i - 1) / 30 for run in range(2) for i in range(3)]
    cams = [(np.eye(3), np.zeros(3))]
    for angle, shift in ((0.5, (-0.48, 0.05, 0.12)), (-0.6, (0.55, -0.03, 0.17))):
        cams.append((oracle_faults.turned(np.array([0.03, angle, 0.02])), np.array(shift)))
    places = []
    for run in range(2):
        tilt = decimals(rng, -0.5, 0.5, 3, (3,))
        start = (oracle_faults.turned(tilt), np.array([0.1 * run - 0.05, 0.04 - 0.1 * run, 1]))
        speed, bend = decimals(rng, -0.5, 0.5, 3, (6,)), decimals(rng, -2, 2, 3, (6,))
        places += [oracle_faults.moved(start, speed * (t - 10 * run) + bend * (t - 10 * run) ** 2)
                   for t in times[3 * run:3 * run + 3]]
    exact = oracle_faults.Rig(cameras, X, [], times, [(0, 1, 2), (3, 4, 5)])
    exact.at = places
    views = []
    for f in range(6):
        for c in range(3):
            uv = exact.project((c, f, np.zeros((9, 2))), cams, places).real
            if fault:
                uv = exact.project((c, f, uv), cams, places, fault, np.array(size)).real
            noise = np.array([round(rng.gauss(0, 0.3), 3) for _ in range(18)]).reshape(9, 2)
            views.append((c, f, np.round(uv + noise, 3)))
    rig = oracle_faults.Rig(cameras, X, views, times, [(0, 1, 2), (3, 4, 5)])
    return (rig,) + rig.fit(cams, places)


def faults():
    """Faults of 5 to 30 sigma, and each test at the optimum without them."""
    kinds = [((0, 1), [0.004]), ((2, -1), [0.003, -0.004]), ((3, 2), [0.03]), ((5, 0), [0.01]),
             ((8, 2, 3), [0.01, 0, -0.01, 0, 0.004, 0]), ((9, -1), [0.0015, -0.001]), ((10, -1), [0.01])]
    every = ([(kind, c) for kind in (0, 1, 3, 4, 5, 6, 7) for c in range(3)] + [(2, -1), (9, -1), (10, -1)] +
             [(8, c, 3) for c in range(3)])
    pixels, poses, tests, whole, refits = [], [], [], [], []
    for scene, (fault, size) in enumerate([(None, None)] + kinds):
        rig, cams, places, _, cost = faults_rig(60 + scene, fault, size)
        pixels.append(row(*[v[2] for v in rig.views]))
        poses.append(row(*[np.concatenate([p[0].ravel(), p[1]]) for p in list(cams) + list(places)]))
        F, along = rig.closure(cams, places)
        pattern, pairs = rig.pattern(cams, places, 3)
        whole.append(row(cost, F, along, pattern, pairs))
        for one in every if scene < 2 else [fault]:
            theta, sigma, gain, F_after, p, most = rig.test(cams, places, one)
            padded = np.zeros((2, 6))
            padded[0, :len(theta)], padded[1, :len(theta)] = theta, sigma
            tests.append(row(scene, one[0], one[1], one[2] if len(one) > 2 else -1, padded, gain, F_after, p, most))
        if fault:
            _, _, theta, freed = rig.fit(cams, places, fault, len(size))
            padded = np.zeros(6)
            padded[:len(theta)] = theta
            refits.append(row(scene, fault[0], fault[1], padded, cost - freed))
    return {"FAULTS_PIXELS": ("of each scene, the pixels of all views; camera by camera of each placement", pixels),
            "FAULTS_POSES": ("of each scene R, t of the cameras, and of the placements, at the optimum", poses),
            "FAULTS_WHOLE": ("of each scene the sum of squares, F, the part along the motion, the pattern and its pairs", whole),
            "FAULTS_TESTS": ("scene, kind, camera, placement; theta, its sigma, gain, F afterwards, p, turn, shift", tests),
            "FAULTS_REFITS": ("scene, kind, camera; theta of an adjustment with that fault free, and its gain", refits)}


TOPICS = {
    "neldermead": neldermead, "rotation": rotations, "transform": transforms,
    "scenes": scenes, "pairs": pairs, "elimination_two": elimination_two,
    "elimination_all": elimination_all, "translation": translation,
    "two_views": two_views, "camera": cameras, "triangulation": triangulation,
    "direction": direction, "refine": refine, "store": store, "chance": chance,
    "rig": rig, "choice": choice, "faults": faults,
    "point": lambda: point_oracle.vectors(CAMERAS, project_px, decimals, row),
}


def number(x):
    """The shortest decimal that reads back as the same double."""
    x = float(x) + 0.0  # no -0
    return repr(int(x)) if x == int(x) and abs(x) < 1e9 else repr(x)


def wrapped(words, first, indent, end):
    lines, line = [], first
    for word in words:
        if len(line) + len(word) + 1 > 79 and line.strip():
            lines.append(line.rstrip())
            line = indent
        line += word + " "
    return "\n".join(lines + [line.rstrip() + end])


def header(topic, arrays):
    guard = "VECTORS_%s_H" % topic.upper()
    out = ["/* Made by tests/vectors/make_vectors.py; to make it again run",
           " *     python3 tests/vectors/make_vectors.py */",
           "#ifndef " + guard, "#define " + guard, ""]
    for name, (comment, rows) in arrays.items():
        rows = np.array(rows, float)
        out += [wrapped(comment.split(), "/* ", " * ", " */"),
                "enum { %s_ROWS = %d };" % (name, len(rows)),
                "static const double %s[%d][%d] = {" % ((name,) + rows.shape)]
        for r in rows:
            words = [number(x) + "," for x in r]
            words[-1] = words[-1][:-1]
            out.append(wrapped(words, "{", " ", "},"))
        out += ["};", ""]
    return "\n".join(out + ["#endif /* %s */" % guard, ""])


def read_header(path):
    with open(path) as f:
        text = f.read()
    arrays = {}
    for name, _, cols, body in re.findall(
            r"static const double (\w+)\[(\d+)\]\[(\d+)\] = \{(.*?)\n\};", text, re.S):
        numbers = [float(x) for x in re.findall(r"[-+.\deE]+", body)]
        arrays[name] = np.array(numbers).reshape(-1, int(cols))
    return arrays


def main(args):
    if args not in ([], ["--check"]):
        print(__doc__)
        return 2
    wrong, count = [], 0
    for topic, make in TOPICS.items():
        path = os.path.join(HERE, "vectors_%s.h" % topic)
        arrays = make()
        if not args:
            with open(path, "w") as f:
                f.write(header(topic, arrays))
            continue
        committed = read_header(path) if os.path.exists(path) else {}
        if set(committed) != set(arrays):
            wrong.append("%s: has other arrays" % os.path.basename(path))
            continue
        for name, (_, rows) in arrays.items():
            rows, old = np.array(rows, float), committed[name]
            if rows.shape != old.shape:
                wrong.append("%s: has another size" % name)
                continue
            off = np.abs(rows - old) / np.maximum(1, np.abs(old))
            count += off.size
            if not np.all(off <= CHECK_TOLERANCE):
                k = np.unravel_index(np.argmax(np.nan_to_num(off, nan=np.inf)), off.shape)
                wrong.append("%s[%d][%d]: is %r, now %r" % (name, *k, old[k], rows[k]))
    for line in wrong:
        print(line)
    if args and not wrong:
        print("%d numbers in %d files agree" % (count, len(TOPICS)))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
