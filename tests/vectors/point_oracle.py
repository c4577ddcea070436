"""Points from several views, with the covariance of their error, by dense algebra: all
pixels of all views in one vector, all cameras' turns and shifts in another. Derivatives are
by complex steps, the minimum is SciPy's, and chi square is taken in what the point cannot
change, without the point."""
import math
import random

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import least_squares

import rigcal_oracle as oracle

VIEWS = 5
STEP = 1e-30


def turn(w):
    """exp([w]x) to first order, of a complex step as exact as any."""
    return np.eye(3) + np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def derivative(f, n):
    return np.column_stack([np.imag(f(STEP * 1j * e)) / STEP for e in np.eye(n)])


def joint_covariance(n_free, seed):
    """A covariance of 6 n_free numbers that C makes, too: L L^T, L from small integers."""
    n = 6 * n_free
    L = np.zeros((n, n))
    for i in range(n):
        scale = 4e-4 if i % 6 < 3 else 2e-3
        for j in range(i):
            L[i, j] = scale * ((7 * i + 11 * j + 3 * seed) % 13 - 6) / 13
        L[i, i] = scale
    return L @ L.T


def measure(project, poses, uv, sigmas, covariance, start):
    """X; its covariance, that of the noise, chi square, rms, and the gains (3, 6 n)."""
    n = len(uv)

    def pixels(P, d):
        return np.concatenate([
            project(k, turn(d[6 * k:6 * k + 3]) @ R @ P + t + d[6 * k + 3:6 * k + 6])
            for k, (R, t) in enumerate(poses)])

    zero, seen = np.zeros(6 * n), np.concatenate(uv)
    noise = np.repeat(np.asarray(sigmas) ** 2, 2)
    X = least_squares(lambda P: (pixels(P, zero) - seen) / np.sqrt(noise), start,
                      x_scale=0.01, xtol=1e-12, ftol=1e-12).x
    for _ in range(20):  # to the last digit
        A = derivative(lambda d: pixels(X + d, zero), 3)
        W = A.T / noise
        X = X + np.linalg.solve(W @ A, W @ (seen - pixels(X, zero)))
    A, B = derivative(lambda d: pixels(X + d, zero), 3), derivative(lambda d: pixels(X, d), 6 * n)
    G = np.linalg.solve((A.T / noise) @ A, A.T / noise)
    V = np.diag(noise) + B @ covariance @ B.T
    e = seen - pixels(X, zero)
    N = null_space(A.T)
    chi2 = (N.T @ e) @ np.linalg.solve(N.T @ V @ N, N.T @ e)
    return X, G @ V @ G.T, (G * noise) @ G.T, chi2, math.sqrt(e @ e / n), -G @ B


def widest(rays):
    return max(math.atan2(np.linalg.norm(np.cross(a, b)), abs(a @ b))
               for i, a in enumerate(rays) for b in rays[:i])


def vectors(cameras, project_px, decimals, row):
    """Views of cameras of all lenses, about a point before them; every third rig has its
    first camera held."""
    rng, points, lengths = random.Random(23), [], []
    last = None
    while len(points) < 30:
        n, seed = 2 + len(points) // 2 % 4, len(points)
        if seed % 2 == 0:  # two points a rig
            which = [rng.randrange(5) for _ in range(n)]
            yprs = [decimals(rng, -0.25, 0.25, 4, (3,)) for _ in range(n)]
            ts = [decimals(rng, -1.2, 1.2, 3, (3,)) for _ in range(n)]
            sigmas = [decimals(rng, 0.2, 0.8, 2) for _ in range(n)]
            held = seed % 6 == 0
            first = seed
        else:
            n = len(which)
        poses = [(oracle.euler_to_matrix(*y), t) for y, t in zip(yprs, ts)]
        X = decimals(rng, -0.5, 0.5, 3, (3,)) + [0, 0, 5]
        inside = [R @ X + t for R, t in poses]
        rays = [R.T @ p / np.linalg.norm(p) for (R, _), p in zip(poses, inside)]
        if (any(p[2] < 3 or np.hypot(p[0], p[1]) > 0.55 * p[2] for p in inside) or
                widest(rays) < 0.1):
            continue
        uv = [np.round(project_px(cameras[k], p) + [rng.gauss(0, s), rng.gauss(0, s)], 2)
              for k, p, s in zip(which, inside, sigmas)]
        Sigma = np.zeros((6 * n, 6 * n))
        Sigma[6 * held:, 6 * held:] = joint_covariance(n - held, first)
        found = measure(lambda k, p: project_px(cameras[which[k]], p), poses, uv, sigmas,
                        Sigma, X)
        views = [row(k, y, t, p, s) for k, y, t, p, s in zip(which, yprs, ts, uv, sigmas)]
        views += [np.zeros(10)] * (VIEWS - n)
        points.append(row(n, int(held), first, *views, *found[:5]))
        if seed % 2 == 1:
            d = last[0] - found[0]
            unit = d / np.linalg.norm(d)
            lever = unit @ (last[5] - found[5])
            lengths.append(row(np.linalg.norm(d), math.sqrt(
                unit @ (last[2] + found[2]) @ unit + lever @ Sigma @ lever)))
        last = found
    return {
        "POINT": ("views n; 1: the first camera is held; the seed of the joint covariance; five "
                  "times (those beyond n are 0) index of the camera, yaw, pitch, roll and t of "
                  "its pose, noisy pixel, sigma; X, its covariance, that of the noise alone, "
                  "chi square, rms [px]", points),
        "POINT_LENGTH": ("of each two points of one rig: their distance, its standard deviation",
                         lengths),
    }
