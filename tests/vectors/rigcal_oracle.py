# The independent reference of the tests. It shares no code with the library.
"""An independent reference (NumPy, float64) of the mathematics in EQUATIONS.md.

It is written for clarity, not speed, and shares no code with the C library: use it to
make golden vectors for tests and to settle arguments about signs and frames.

Conventions
-----------
Camera frame: x right, y down, z along the optical axis.   X_cam = R @ X_world + t.
`u` is a normalised image point (x/z, y/z), shape (n, 2).  `X` is (n, 3), any length unit;
t has the same unit.  Angles are radians.  R = Rz(yaw) @ Ry(pitch) @ Rx(roll).
"""
import numpy as np


# ---- rotations -----------------------------------------------------------------------
def rot_x(a):
    c, s = np.cos(a), np.sin(a)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def rot_y(a):
    c, s = np.cos(a), np.sin(a)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def rot_z(a):
    c, s = np.cos(a), np.sin(a)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def euler_to_matrix(yaw, pitch, roll):
    """Eq. (8)."""
    return rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)


def matrix_to_euler(R):
    """Inverse of eq. (8), pitch in [-pi/2, pi/2]; at gimbal lock roll is set to 0."""
    sp = -R[2, 0]
    if abs(sp) > 1 - 1e-15:
        return np.arctan2(-R[0, 1], R[1, 1]), np.sign(sp) * np.pi / 2, 0.0
    return np.arctan2(R[1, 0], R[0, 0]), np.arcsin(sp), np.arctan2(R[2, 1], R[2, 2])


def rotation_angle(Ra, Rb):
    """Angle between two rotations, stable near 0: 2 asin(|Ra-Rb|_F / sqrt 8)."""
    return 2 * np.arcsin(min(1.0, np.linalg.norm(Ra - Rb) / np.sqrt(8)))


# ---- the paper's calibration equations -------------------------------------------------
def pair_terms(X, u, pairs):
    """For each pair (i, j): unit normal n of the interpretation plane, unit offset d.
    The pair equation is n . R d = 0 (eqs. 11, after t_z is eliminated from 10a, 10b)."""
    m = np.column_stack([u, np.ones(len(u))])
    out = []
    for i, j in pairs:
        n, d = np.cross(m[i], m[j]), X[i] - X[j]
        out.append((n / np.linalg.norm(n), d / np.linalg.norm(d)))
    return out


def eliminate_coefficients(n, d, which, a1, a2):
    """n . R d = p cos(w) + q sin(w) + k, linear in the eliminated angle w.
    which='yaw': (a1, a2) = (pitch, roll); 'pitch': (yaw, roll); 'roll': (yaw, pitch)."""
    if which == "yaw":
        v = rot_y(a1) @ rot_x(a2) @ d
        return n[0] * v[0] + n[1] * v[1], n[1] * v[0] - n[0] * v[1], n[2] * v[2]
    if which == "pitch":
        m, v = rot_z(a1).T @ n, rot_x(a2) @ d
        return m[0] * v[0] + m[2] * v[2], m[0] * v[2] - m[2] * v[0], m[1] * v[1]
    m = (rot_z(a1) @ rot_y(a2)).T @ n
    return m[1] * d[1] + m[2] * d[2], m[2] * d[1] - m[1] * d[2], m[0] * d[0]


def two_angle_residual(terms, which, a1, a2):
    """The paper's objective: |eq. 15| + sum |eq. 13c and its extra-pair siblings|.
    Returns (residual, eliminated angle, condition number of the 2x2 matrix A)."""
    P = [eliminate_coefficients(n, d, which, a1, a2) for n, d in terms]
    A = np.array([[P[0][0], P[0][1]], [P[1][0], P[1][1]]])
    b = -np.array([P[0][2], P[1][2]])
    c, s = np.linalg.solve(A, b)
    w = np.arctan2(s, c)
    r = abs(c * c + s * s - 1)
    r += sum(abs(p * np.cos(w) + q * np.sin(w) + k) for p, q, k in P[2:])
    return r, w, np.linalg.cond(A)


def translation_from_pairs(R, X, u, pairs):
    """Eqs. (10a), (10b), averaged as in eq. (16)."""
    q = X @ R.T
    tz = []
    for i, j in pairs:
        for k in range(2):
            du = u[i, k] - u[j, k]
            if abs(du) > 1e-9:
                tz.append(((q[i, k] - q[j, k]) - (u[i, k] * q[i, 2] - u[j, k] * q[j, 2])) / du)
    tz = np.mean(tz)
    txy = np.mean(u * (q[:, 2:] + tz) - q[:, :2], axis=0)
    return np.array([txy[0], txy[1], tz])


def translation_least_squares(R, X, u):
    """Least squares over all 2n equations  t_xy - u t_z = u q_z - q_xy,  q = R X."""
    q = X @ R.T
    n = len(X)
    A = np.zeros((2 * n, 3))
    A[0::2, 0] = 1
    A[1::2, 1] = 1
    A[:, 2] = -u.reshape(-1)
    b = (u * q[:, 2:] - q[:, :2]).reshape(-1)
    return np.linalg.lstsq(A, b, rcond=None)[0]


# ---- optical-axis search: yaw AND translation eliminated, O(1) per evaluation ----------
class Moments:
    """One pass over the points; afterwards every evaluation costs the same whatever n is."""

    def __init__(self, X, u):
        n = len(X)
        self.X_mean, uc = X.mean(0), u[:, 0] + 1j * u[:, 1]
        x = X - self.X_mean
        self.u_mean = uc.mean()
        du = uc - self.u_mean
        V = uc[:, None] * x
        self.V_mean = V.mean(0)
        V = V - self.V_mean
        self.S = np.sum(np.abs(du) ** 2)
        self.C = x.T @ x
        self.K = np.real(V.conj().T @ V)
        self.g = du.conj() @ x
        self.h = np.real(V.conj().T @ du)
        self.G = V.conj().T @ x
        self.n = n

    def harmonics(self, M):
        """Given rows M = [m1; m2; m3] of Ry(pitch)Rx(roll), the cost over yaw is
        const - Re(a z) - Re(b z^2), z = exp(i yaw); t_z(mean depth) = (Re(U z) - B)/S > 0."""
        p = M[0] + 1j * M[1]
        W, U, B = M[2] @ self.G @ p, self.g @ p, self.h @ M[2]
        a, b = 2 * (W - B * U / self.S), U * U / (2 * self.S)
        const = (M[2] @ self.K @ M[2] + np.trace(self.C) - M[2] @ self.C @ M[2]
                 - abs(U) ** 2 / (2 * self.S) - B * B / self.S)
        return const, a, b, U, B

    def cost(self, M, samples=3600):
        """Object-space cost minimised over yaw (brute force here) on the arc where the mean
        depth is positive. Returns (cost, yaw)."""
        const, a, b, U, B = self.harmonics(M)
        w = np.linspace(-np.pi, np.pi, samples, endpoint=False)
        for _ in range(6):
            z = np.exp(1j * w)
            f = np.where(np.real(U * z) > B, np.real(a * z) + np.real(b * z * z), -np.inf)
            k = int(np.argmax(f))
            step = (w[1] - w[0]) * 2
            w = np.linspace(w[k] - step, w[k] + step, 41)
        z = np.exp(1j * w[20])
        return const - np.real(a * z) - np.real(b * z * z), w[20]

    def pose(self, M, yaw):
        _, _, _, U, B = self.harmonics(M)
        depth = (np.real(U * np.exp(1j * yaw)) - B) / self.S
        txy = self.V_mean @ M[2] + depth * self.u_mean
        R = rot_z(yaw) @ M
        return R, np.array([txy.real, txy.imag, depth]) - R @ self.X_mean


# ---- transforms, measurement, matching line --------------------------------------------
def relative_pose(Ra, ta, Rb, tb):
    """Eqs. (17), (18): b_from_a."""
    R = Rb @ Ra.T
    return R, tb - R @ ta


def depth_least_squares(R, t, ua, ub):
    """Eqs. (22)-(24): least squares over both depths (Z_a, Z_b), 3 equations 2 unknowns:
    Z_b [u_b; 1] - Z_a R [u_a; 1] = t."""
    A = np.column_stack([-R @ np.append(ua, 1.0), np.append(ub, 1.0)])
    return np.linalg.lstsq(A, t, rcond=None)[0]


def matching_line(R, t, ua):
    """Eqs. (25), (26): (alpha, beta, gamma) with alpha x_b + beta y_b + gamma = 0."""
    return np.cross(t, R @ np.append(ua, 1.0))


def rotation_difference_norm(Ra, Rb):
    """Section VI-C: largest |eigenvalue| (spectral norm) of Ra - Rb = 2 sin(angle / 2)."""
    return np.linalg.norm(Ra - Rb, 2)


# ---- maximum-likelihood refinement and its covariance ----------------------------------
def project(R, t, X):
    p = X @ R.T + t
    return p[:, :2] / p[:, 2:]


def reprojection_jacobian(R, t, X):
    """d(projected u)/d(w, dt), left perturbation R <- exp([w]x) R, t <- t + dt. (2n, 6)."""
    q = X @ R.T
    p = q + t
    iz = 1 / p[:, 2]
    x, y = p[:, 0] * iz, p[:, 1] * iz
    J = np.zeros((2 * len(X), 6))
    J[0::2, 0], J[0::2, 1], J[0::2, 2] = -iz * x * q[:, 1], iz * (q[:, 2] + x * q[:, 0]), -iz * q[:, 1]
    J[0::2, 3], J[0::2, 5] = iz, -iz * x
    J[1::2, 0], J[1::2, 1], J[1::2, 2] = -iz * (q[:, 2] + y * q[:, 1]), iz * y * q[:, 0], iz * q[:, 0]
    J[1::2, 4], J[1::2, 5] = iz, -iz * y
    return J


def exp_so3(w):
    th = np.linalg.norm(w)
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if th < 1e-9:
        return np.eye(3) + K + K @ K / 2
    return np.eye(3) + np.sin(th) / th * K + (1 - np.cos(th)) / th**2 * K @ K


def refine(R, t, X, u, iterations=50):
    """Levenberg-Marquardt on the reprojection error (the maximum-likelihood pose for equal
    isotropic image noise). Returns R, t, sum of squared errors."""
    lam, e = 1e-4, np.sum((u - project(R, t, X)) ** 2)
    for _ in range(iterations):
        J = reprojection_jacobian(R, t, X)
        r = (u - project(R, t, X)).reshape(-1)
        H, g = J.T @ J, J.T @ r
        for _ in range(10):
            d = np.linalg.solve(H + lam * np.diag(np.diag(H)), g)
            R2, t2 = exp_so3(d[:3]) @ R, t + d[3:]
            e2 = np.sum((u - project(R2, t2, X)) ** 2)
            if e2 <= e:
                break
            lam *= 10
        else:
            return R, t, e
        done = e - e2 <= 1e-15 * e
        R, t, e, lam = R2, t2, e2, lam * 0.1
        if done:
            break
    return R, t, e


def pose_covariance(R, t, X, sigma):
    """6x6 covariance of (w, dt) for image noise sigma in normalised units; also the
    Cramer-Rao bound when evaluated at the truth."""
    J = reprojection_jacobian(R, t, X)
    return sigma**2 * np.linalg.inv(J.T @ J)


# ---- the whole rig: cameras and placements together --------------------------------------
# A pose is (R, t). Small turns and shifts (w, dt) of each camera, then of each placement,
# stand in one vector; the equations are dense and nothing is eliminated.
def compose(c_from_b, b_from_a):
    return c_from_b[0] @ b_from_a[0], c_from_b[0] @ b_from_a[1] + c_from_b[1]


def moved(pose, d):
    """R <- exp([w]x) R, t <- t + dt."""
    return exp_so3(d[:3]) @ pose[0], pose[1] + d[3:]


def log_so3(R):
    """The rotation vector, for angles below pi."""
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    s = np.linalg.norm(v)
    return v if s == 0 else v * np.arctan2(s, (np.trace(R) - 1) / 2) / s


def difference(pose, origin):
    """d with moved(origin, d) = pose."""
    return np.concatenate([log_so3(pose[0] @ origin[0].T), pose[1] - origin[1]])


def rig_residuals(project_px, views, cams, places, priors, sigma):
    """(G1), (G7): all errors, over sigma of each point; then those of the priors, whitened.
    views: (camera, placement, X, uv, sigmas). priors: {camera: (pose, covariance)}."""
    out = []
    for c, f, X, uv, spreads in views:
        R, t = compose(cams[c], places[f])
        for x, p, s in zip(X, uv, spreads):
            out.append((p - project_px(c, R @ x + t)) / s)
    for c, (pose, covariance) in priors.items():
        whiten = np.linalg.inv(np.linalg.cholesky(covariance))
        out.append(sigma * whiten @ difference(pose, cams[c]))
    return np.concatenate(out)


def rig_adjust(project_px, views, cams, places, held=(0,), priors=(), sigma=1.0, rounds=8):
    """Gauss-Newton over all poses, its derivatives by central differences.
    Returns cams, places, sum of squares, (J^T J)^-1 of free cameras and then placements,
    where the unknowns of each camera begin (None: it is held), the errors, and of each error
    what it loses of its freedom to the unknowns: the diagonal of J (J^T J)^-1 J^T."""
    cams, places, priors = list(cams), list(places), dict(priors)
    free = [c for c in range(len(cams)) if c not in held]
    begin = {c: 6 * i for i, c in enumerate(free)}
    n = 6 * (len(free) + len(places))

    def at(d):
        K, P = list(cams), list(places)
        for c in free:
            K[c] = moved(K[c], d[begin[c]:begin[c] + 6])
        for f in range(len(P)):
            i = 6 * (len(free) + f)
            P[f] = moved(P[f], d[i:i + 6])
        return K, P

    def errors(d):
        return rig_residuals(project_px, views, *at(d), priors, sigma)

    for k in range(rounds + 1):
        J, step = [], 2e-4
        for i in range(n):
            e = np.zeros(n)
            e[i] = step
            # the fourth order: the step may be large, and rounding small
            J.append((8 * (errors(e) - errors(-e)) - errors(2 * e) + errors(-2 * e)) / (12 * step))
        J, r = np.array(J).T, errors(np.zeros(n))
        if k < rounds:
            cams, places = at(-np.linalg.lstsq(J, r, rcond=None)[0])
    covariance = np.linalg.inv(J.T @ J)
    lost = np.sum(J @ covariance * J, axis=1)
    return cams, places, r @ r, covariance, [begin.get(c) for c in range(len(cams))], r, lost


def rig_pair(cams, covariance, begin, a, b):
    """(G9): b_from_a, and its covariance by the differences of b_from_a itself."""
    def pair(d_a, d_b):
        A, B = moved(cams[a], d_a), moved(cams[b], d_b)
        R = B[0] @ A[0].T
        return R, B[1] - R @ A[1]
    origin, n = pair(np.zeros(6), np.zeros(6)), len(covariance)
    J = np.zeros((6, n))
    for side, c in enumerate((a, b)):
        for i in range(6):
            if begin[c] is not None:
                e = np.zeros((2, 6))
                e[side, i] = 1e-4
                J[:, begin[c] + i] = (difference(pair(*e), origin)
                                      - difference(pair(*-e), origin)) / 2e-4
    return origin, J @ covariance @ J.T


def loop_closure(total, own, n_views, n_cameras, n_places, n_points):
    """(G14): F and its two degrees of freedom."""
    between = 6 * (n_views - n_cameras - n_places + 1)
    within = 2 * n_points - 6 * n_views
    return (total - own) / between / (own / within), between, within


# ---- self-check ------------------------------------------------------------------------
# ---- the choice between two poses of each view (CHOICE in EQUATIONS.md) -----------------
CHOICE_LIMIT = 30.
CHOICE_LADDER = (1., 4., 16., 64., 256., 1024.)


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def inverse(pose):
    return pose[0].T, -pose[0].T @ pose[1]


def hypothesis(b, a):
    """b_from_a of poses b_from_x and a_from_x; its error as a function of a point: the
    derivative by the errors of b and then of a of the turn and of the image of that point."""
    pose = compose(b, inverse(a))
    R, O, I = pose[0], np.zeros((3, 3)), np.eye(3)

    def derivative(point):
        arm = point - a[1]
        return np.block([[I, O, -R, O],
                         [-cross_matrix(R @ arm), I, R @ cross_matrix(arm), -R]])
    return pose, derivative


def squared_distance(one, other, point):
    """Of two claims (pose, derivative, joint covariance) about one transform."""
    S = sum(h[1](point) @ h[2] @ h[1](point).T for h in (one, other))
    d = np.r_[log_so3(other[0][0] @ one[0][0].T),
              other[0][0] @ point + other[0][1] - one[0][0] @ point - one[0][1]]
    return d @ np.linalg.solve(S, d)


def joint(*blocks):
    n = len(blocks[0])
    out = np.zeros((n * len(blocks),) * 2)
    for i, block in enumerate(blocks):
        out[n * i:n * i + n, n * i:n * i + n] = block
    return out


def pair_claims(views, f, a, b):
    """All hypotheses of b_from_a by placement f: views[c, f] is a list of (pose, information,
    sse). Of each: pose, derivative, covariance, where the target is, what it costs more."""
    out = []
    for A, H_a, sse_a in views[a, f]:
        for B, H_b, sse_b in views[b, f]:
            out.append((*hypothesis(B, A), joint(np.linalg.inv(H_b), np.linalg.inv(H_a)), A[1],
                        sse_a - views[a, f][0][2] + sse_b - views[b, f][0][2]))
    return out


def costs_of(claims, which, sigma):
    """What claim `which` = (placement, number) costs in every placement, in sigma^2."""
    f, k = which
    it, out = claims[f][k], {}
    for g, others in claims.items():
        out[g] = min(squared_distance(it, o, it[3]) + o[4] for o in others)
        if g == f:
            out[g] = it[4]
        out[g] /= sigma**2
    return out


def best_claim(claims, sigma, limit):
    """(how many agree, -cost), and which claim that is."""
    best = None
    for f in claims:
        for k in range(len(claims[f])):
            m = np.array(list(costs_of(claims, (f, k), sigma).values()))
            score = ((m < limit).sum(), -np.minimum(m, limit).sum())
            if best is None or score > best[0]:
                best = (score, f, k)
    return best


def place(views, cams, known, f, sigma, limit):
    """Placement f by the joined cameras: pose, covariance by the view alone, how many views
    agree, how many there are, which candidate each takes."""
    options, best = [], None
    seen = [c for c in sorted(cams) if (c, f) in views]
    for c in seen:
        for i, (T, H, sse) in enumerate(views[c, f]):
            # rig_from_placement = cam^-1 T; the error of the camera is known at a point
            R = cams[c][0].T
            P = compose(inverse(cams[c]), T)
            turn = joint(R, R)
            cov, at = known[c]
            own = turn @ np.linalg.inv(H) @ turn.T
            arm = np.block([[np.eye(3), np.zeros((3, 3))],
                            [-cross_matrix(cams[c][0] @ (P[1] - at)), np.eye(3)]])
            whole = own + turn @ arm @ cov @ arm.T @ turn.T
            options.append((c, i, P, own, whole, sse - views[c, f][0][2]))
    for c, i, P, own, whole, extra in options:
        cost, takes = 0., {}
        for other in seen:
            found = []
            for d, j, Q, _, cov, more in options:
                if d == other and (d != c or j == i):
                    x = difference(Q, P)
                    far = x @ np.linalg.solve(whole + cov, x) if d != c else 0.
                    found.append(((far + more) / sigma**2, j))
            least = min(found)
            cost += min(least[0], limit)
            takes[other] = least[1] if least[0] < limit else 2
        agree = sum(t < 2 for t in takes.values())
        score = (agree, -cost, -np.trace(whole[:3, :3]))
        if best is None or score > best[0]:
            best = (score, P, own, agree, len(seen), takes)
    return best[1:]


def choose(views, n_cams, n_places, sigma):
    """The candidate of every view, tau^2, the share that agrees, and cameras and placements
    in the frame of the first camera of the seed. As RIG.md has (G15), (G16)."""
    counts, most, seeds = np.zeros(len(CHOICE_LADDER)), 0, [None] * len(CHOICE_LADDER)
    for a in range(n_cams):
        for b in range(a + 1, n_cams):
            shared = [f for f in range(n_places) if (a, f) in views and (b, f) in views]
            if not shared:
                continue
            claims = {f: pair_claims(views, f, a, b) for f in shared}
            for k, tau2 in enumerate(CHOICE_LADDER):
                score, f, i = best_claim(claims, sigma, CHOICE_LIMIT * tau2)
                if len(shared) > 1:
                    counts[k] += score[0] - 1
                if seeds[k] is None or score > seeds[k][0]:
                    seeds[k] = (score, a, b, claims[f][i])
            most += len(shared) - 1
    rung = 0
    while rung < 4 and not (counts[rung] > 0 and counts[rung] >= .8 * counts[rung + 1]):
        rung += 1
    limit = CHOICE_LIMIT * CHOICE_LADDER[rung]

    def known_of(claim):
        J = claim[1](claim[3])
        return J @ claim[2] @ J.T, claim[3]

    _, a, b, claim = seeds[rung]
    cams = {a: (np.eye(3), np.zeros(3)), b: claim[0]}
    known = {a: (np.zeros((6, 6)), np.zeros(3)), b: known_of(claim)}
    while True:
        places = {f: place(views, cams, known, f, sigma, limit) for f in range(n_places)
                  if any((c, f) in views for c in cams)}
        best = None
        for c in range(n_cams):
            claims = {}
            for f, (P, cov, agree, n, _) in places.items():
                if c not in cams and (c, f) in views and (agree > 1 or n == 1):
                    claims[f] = [(*hypothesis(T, P), joint(np.linalg.inv(H), cov), P[1],
                                  sse - views[c, f][0][2]) for T, H, sse in views[c, f]]
            if claims:
                score, f, k = best_claim(claims, sigma, limit)
                if best is None or score > best[0]:
                    best = (score, c, claims[f][k])
        if best is None:
            break
        cams[best[1]], known[best[1]] = best[2][0], known_of(best[2])
    takes = {(c, f): t for f, p in places.items() for c, t in p[4].items()}
    return takes, CHOICE_LADDER[rung], counts[rung] / most, cams, {
        f: p[0] for f, p in places.items()}


def _self_check():
    rng = np.random.default_rng(1)
    for trial in range(200):
        X = rng.uniform(-1, 1, (6, 3)) + rng.uniform(-5, 5, 3)
        R = euler_to_matrix(*rng.uniform([-np.pi, -1.5, -np.pi], [np.pi, 1.5, np.pi]))
        t = np.array([0.3, -0.2, 6.0]) - R @ X.mean(0)
        u = project(R, t, X)
        ypr = matrix_to_euler(R)
        assert np.allclose(euler_to_matrix(*ypr), R, atol=1e-12)
        prs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
        terms = pair_terms(X, u, prs)
        for n, d in terms:
            assert abs(n @ R @ d) < 1e-12
        y, p, r = ypr
        for which, a1, a2, w in (("yaw", p, r, y), ("pitch", y, r, p), ("roll", y, p, r)):
            for n, d in terms:
                P, Q, k = eliminate_coefficients(n, d, which, a1, a2)
                assert abs(P * np.cos(w) + Q * np.sin(w) + k - n @ R @ d) < 1e-12
            res, w2, cond = two_angle_residual(terms, which, a1, a2)
            assert res < 1e-13 * max(1.0, cond) ** 2 * 1e3, (which, res, cond)
        assert np.allclose(translation_from_pairs(R, X, u, prs), t, atol=1e-7)
        assert np.allclose(translation_least_squares(R, X, u), t, atol=1e-9)
        M = rot_y(p) @ rot_x(r)
        vm = Moments(X, u)
        cost, yaw = vm.cost(M)
        assert cost < 1e-9 and abs(np.angle(np.exp(1j * (yaw - y)))) < 1e-5
        R2, t2 = vm.pose(M, y)
        assert np.allclose(R2, R, atol=1e-9) and np.allclose(t2, t, atol=1e-7)
        # the O(1) cost equals the O(n) sum it stands for, at a wrong direction too
        M = euler_to_matrix(0.0, p + 0.3, r - 0.2)
        cost, yaw = vm.cost(M)
        Rw = rot_z(yaw) @ M
        tw = translation_least_squares(Rw, X, u)
        q = X @ Rw.T + tw
        direct = np.sum((u * q[:, 2:] - q[:, :2]) ** 2)
        assert abs(cost - direct) < 1e-8 * max(1.0, direct), (cost, direct)
        # Jacobian against differences
        J = reprojection_jacobian(R, t, X)
        for k in range(6):
            e = np.zeros(6)
            e[k] = 1e-6
            num = (project(exp_so3(e[:3]) @ R, t + e[3:], X) - project(exp_so3(-e[:3]) @ R, t - e[3:], X)) / 2e-6
            assert np.allclose(num.reshape(-1), J[:, k], atol=1e-6)
        # second camera
        Rb = exp_so3(rng.normal(0, 0.2, 3)) @ R
        tb = t + rng.normal(0, 0.5, 3)
        ub = project(Rb, tb, X)
        Rba, tba = relative_pose(R, t, Rb, tb)
        for i in range(6):
            za, zb = depth_least_squares(Rba, tba, u[i], ub[i])
            assert abs(za - (R @ X[i] + t)[2]) < 1e-6 and abs(zb - (Rb @ X[i] + tb)[2]) < 1e-6
            l = matching_line(Rba, tba, u[i])
            assert abs(l @ np.append(ub[i], 1.0)) < 1e-10
        assert abs(rotation_difference_norm(R, Rb) - 2 * np.sin(rotation_angle(R, Rb) / 2)) < 1e-9
    print("oracle self-check: 200 scenes agree")


if __name__ == "__main__":
    _self_check()
