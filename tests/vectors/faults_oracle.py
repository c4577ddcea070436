"""What disturbs a rig, as dense least squares (EQUATIONS.md FAULTS).

All unknowns stand in one vector: the poses of the cameras but the first, those of the
placements. Every derivative is one by a complex step, through the projection with the fault
in it. Nothing is eliminated but by a dense solve. A fault is (kind, camera), by the numbers
of RIGCAL_FAULT_; of MOVED (kind, camera, placement).
"""
import numpy as np
from scipy.stats import f as f_distribution

CLOCK, DRIFT, CLOCKS, SHUTTER, FOCAL, ASPECT, CENTRE, DISTORTION, MOVED, BENT, STRETCHED = range(11)
PARAMETERS = {CLOCK: 1, DRIFT: 1, SHUTTER: 1, FOCAL: 1, ASPECT: 1, CENTRE: 2, DISTORTION: 2,
              MOVED: 6, BENT: 2, STRETCHED: 1}


def cross(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def turned(w):
    """exp([w]x); to third order where w is tiny, so that a complex step goes through."""
    a2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    K = cross(w)
    if abs(a2) < 1e-12:
        return np.eye(3) + K + K @ K / 2
    a = np.sqrt(a2)
    return np.eye(3) + np.sin(a) / a * K + (1 - np.cos(a)) / a2 * K @ K


def moved(pose, d):
    return turned(d[:3]) @ pose[0], pose[1] + d[3:]


def between(pose, other):
    """d with moved(pose, d) == other."""
    R = other[0] @ pose[0].T
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = np.sqrt(v @ v)
    angle = np.arctan2(sine, (np.trace(R) - 1) / 2)
    return np.concatenate([v * (angle / sine if sine > 1e-12 else 1), other[1] - pose[1]])


class Rig:
    """cameras: rows width, height, fx, fy, cx, cy, k1, k2. views: (camera, placement, uv (n, 2)),
    all of the points X. times, and `runs`: the placements that follow one another."""

    def __init__(self, cameras, X, views, times, runs):
        self.cameras, self.X, self.views, self.times = np.asarray(cameras), X, views, times
        self.runs = runs
        self.middle = (min(times) + max(times)) / 2
        low, high = X.min(0), X.max(0)
        self.board = (X[:, :2] - (low + high)[:2] / 2) / ((high - low)[:2] / 2)

    def curve(self, places, f):
        """The polynomial through all placements of a run, from placement f: coefficients of
        t, t^2, ... of (w, dt). Kept, as it is asked for point by point."""
        if getattr(self, "of", None) is not places:
            self.of, self.curves = places, {}
        if f in self.curves:
            return self.curves[f]
        run = next(r for r in self.runs if f in r)
        others = [m for m in run if m != f]
        t = np.array([self.times[m] - self.times[f] for m in others])
        d = np.array([between(places[f], places[m]) for m in others])
        powers = t[:, None] ** np.arange(1, len(t) + 1)
        self.curves[f] = np.linalg.solve(powers, d) if others else np.zeros((0, 6))
        return self.curves[f]

    def project(self, view, cams, places, fault=None, theta=()):
        c, f, uv = view
        w, h, fx, fy, cx, cy, k1, k2 = self.cameras[c]
        X = self.X.astype(complex)
        cam = cams[c]
        late = np.zeros(len(X), complex)
        kind = fault[0] if fault else None
        if kind == CLOCKS:
            late += theta[c - 1] if c > 0 else 0
        elif kind is not None and (kind >= BENT or fault[1] == c):
            if kind == CLOCK:
                late += theta[0]
            elif kind == DRIFT:
                late += theta[0] * (self.times[f] - self.middle)
            elif kind == SHUTTER:
                late += theta[0] * (uv[:, 1] - (h - 1) / 2) / h
            elif kind == FOCAL:
                fx, fy = fx * (1 + theta[0]), fy * (1 + theta[0])
            elif kind == ASPECT:
                fx, fy = fx * (1 + theta[0] / 2), fy * (1 - theta[0] / 2)
            elif kind == CENTRE:
                cx, cy = cx + theta[0], cy + theta[1]
            elif kind == DISTORTION:
                k1, k2 = k1 + theta[0], k2 + theta[1]
            elif kind == MOVED and f >= fault[2]:
                cam = moved(cam, theta)
            elif kind == BENT:
                X[:, 2] += (1 - self.board ** 2) @ theta
            elif kind == STRETCHED:
                X[:, 0] *= 1 + theta[0] / 2
                X[:, 1] *= 1 - theta[0] / 2
        if (late == late[0]).all():
            p = cam[0] @ self.seen(places[f], f, late[0], X) + cam[1][..., None]
        else:
            p = np.stack([(cam[0] @ self.seen(places[f], f, one, x[None]))[..., 0] + cam[1]
                          for one, x in zip(late, X)], -1)
        x, y = p[..., 0, :] / p[..., 2, :], p[..., 1, :] / p[..., 2, :]
        s = x * x + y * y
        g = 1 + s * (k1 + s * k2)
        return np.stack([fx * g * x + cx, fy * g * y + cy], -1)

    def seen(self, place, f, late, X):
        """The board's points in the rig's frame, so long after the placement."""
        if late != 0:
            curve = self.curve(self.at, f)
            place = moved(place, sum(a * late ** (k + 1) for k, a in enumerate(curve)))
        return place[0] @ X.T + place[1][..., None]

    def errors(self, cams, places, fault=None, theta=()):
        """Observed less projected, (measured, )."""
        return np.concatenate([(v[2] - self.project(v, cams, places, fault, theta)).ravel()
                               for v in self.views])

    def poses(self, cams, places, x):
        C = len(cams)
        return ([cams[0]] + [moved(cams[c], x[6 * c - 6:6 * c]) for c in range(1, C)],
                [moved(p, x[6 * (C - 1 + f):6 * (C + f)]) for f, p in enumerate(places)])

    def jacobian(self, cams, places, fault=None, theta=()):
        """d(projection) by all unknowns, and by theta. The motion is that of `at`."""
        C, n, k, h = len(cams), 6 * (len(cams) - 1 + len(places)), len(theta), 1e-30
        blocks = []
        turns = np.array([np.eye(3) + cross(1j * h * w) for w in np.eye(12, 3)])
        shifts = 1j * h * np.eye(12, 3, -3)
        for c, f, uv in self.views:
            block = np.zeros((2 * len(uv), n + k))
            cam = turns @ cams[c][0], cams[c][1] + shifts
            place = np.roll(turns, 6, 0) @ places[f][0], places[f][1] + np.roll(shifts, 6, 0)
            poses = self.project((c, f, uv), {c: cam}, {f: place}, fault, theta).imag / h
            poses = poses.reshape(12, -1).T
            if c > 0:
                block[:, 6 * (c - 1):6 * c] = poses[:, :6]
            block[:, 6 * (C - 1 + f):6 * (C + f)] = poses[:, 6:]
            for i in range(k):
                y = theta + 1j * h * np.eye(k)[i]
                block[:, n + i] = self.project((c, f, uv), cams, places, fault, y).imag.ravel() / h
            blocks.append(block)
        J = np.vstack(blocks)
        return J[:, :n], J[:, n:]

    def fit(self, cams, places, fault=None, k=0, rounds=10):
        """Gauss and Newton, the motion taken from where the placements stand. A few derivatives
        are enough: the other rounds converge by the second."""
        theta = np.zeros(k)
        for r in range(rounds):
            self.at = places
            if r < (4 if fault else 7):
                J, D = self.jacobian(cams, places, fault, theta)
                inverse = np.linalg.pinv(np.hstack([J, D]))
            step = inverse @ self.errors(cams, places, fault, theta).real
            cams, places = self.poses(cams, places, step[:J.shape[1]])
            theta = theta + step[J.shape[1]:]
        self.at = places
        e = self.errors(cams, places, fault, theta).real
        return cams, places, theta, e @ e

    def freedom(self):
        measured = sum(2 * len(v[2]) for v in self.views)
        unknown = 6 * (len(self.cameras) - 1 + len(self.times))
        return measured, measured - unknown, measured - 6 * len(self.views)

    def own_projector(self, J, cams, places):
        """An orthonormal basis of what the poses of the views, each by itself, can do."""
        h, columns, at = 1e-30, [], 0
        total = len(J)
        for c, f, uv in self.views:
            rows = slice(at, at + 2 * len(uv))
            for i in range(6):
                d = np.zeros(6, complex)
                d[i] = 1j * h
                column = np.zeros(total)
                column[rows] = self.project((c, f, uv), {c: moved(cams[c], d)}, places).imag.ravel() / h
                columns.append(column)
            at += 2 * len(uv)
        return np.linalg.qr(np.array(columns).T)[0]

    def optimum(self, cams, places):
        """Errors, derivatives, and bases of what the poses can do: of the rig, of the views."""
        if not hasattr(self, "kept"):
            self.at = places
            J = self.jacobian(cams, places)[0]
            self.kept = (self.errors(cams, places).real, J, np.linalg.qr(J)[0],
                         self.own_projector(J, cams, places))
        return self.kept

    def columns(self, cams, places, fault, k):
        """d(projection) by the parameters of a fault."""
        return np.array([-self.errors(cams, places, fault, 1e-30j * np.eye(k)[i]).imag / 1e-30
                         for i in range(k)]).T

    def test(self, cams, places, fault):
        """One step: theta, sigma, gain, own gain, F afterwards, p, turn, shift at 5 sigma."""
        k = len(cams) - 1 if fault[0] == CLOCKS else PARAMETERS[fault[0]]
        e, J, Q, own = self.optimum(cams, places)
        D = self.columns(cams, places, fault, k)
        left = D - Q @ (Q.T @ D)
        I = left.T @ left
        theta = np.linalg.solve(I, left.T @ e)
        gain = theta @ I @ theta
        alone = D - own @ (own.T @ D)
        own_gain = 2 * (alone.T @ e) @ theta - theta @ (alone.T @ alone) @ theta
        measured, dof, within = self.freedom()
        cost, own_cost = e @ e, e @ e - (own.T @ e) @ (own.T @ e)
        s2 = (cost - gain) / (dof - k)
        sigma = np.sqrt(np.diag(np.linalg.inv(I)) * s2)
        F_after = (((cost - gain) - (own_cost - own_gain)) / (dof - within - k) /
                   ((own_cost - own_gain) / within))
        effect = np.linalg.lstsq(J, D, rcond=None)[0][:6 * (len(cams) - 1)].reshape(-1, 6, k)
        most = [max(5 * sigma[j] * np.linalg.norm(effect[c, half:half + 3, j])
                    for c in range(len(effect)) for j in range(k)) for half in (0, 3)]
        return theta, sigma, gain, F_after, f_distribution.sf(gain / k / s2, k, dof - k), most

    def closure(self, cams, places):
        """F, and the part of the disagreement along the motion."""
        e, J, _, own = self.optimum(cams, places)
        measured, dof, within = self.freedom()
        disagreement = (own.T @ e) @ (own.T @ e)
        F = disagreement / (dof - within) / ((e @ e - disagreement) / within)
        along = 0.
        at = 0
        for v in self.views:
            rows = slice(at, at + 2 * len(v[2]))
            h = 1e-30
            speed = self.project(v, cams, places, (CLOCK, v[0]), np.array([1j * h])).imag.ravel() / h
            along += (speed @ (own @ (own.T @ e))[rows]) ** 2 / (speed @ speed)
            at += 2 * len(v[2])
        return F, along / disagreement

    def pattern(self, cams, places, row_length):
        """Correlation of neighbouring residuals along the board's rows, and their number."""
        e, J, _, own = self.optimum(cams, places)
        left = np.eye(len(e)) - own @ own.T
        r = left @ e
        s2 = r @ r / self.freedom()[2]
        n = len(self.X)
        pairs = [2 * (n * v + i) + k for v in range(len(self.views)) for i in range(n - 1)
                 if (i + 1) % row_length for k in range(2)]
        pairs = np.array(pairs)
        product = (r[pairs] * r[pairs + 2]).sum() / s2 - left[pairs, pairs + 2].sum()
        return product / len(pairs), len(pairs)
