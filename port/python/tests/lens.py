"""The lens models of rigcal.h, section camera, in NumPy, for comparison with other
programs."""

import numpy as np


def project(camera, X_rig):
    """Pixels (n, 2) of points (n, 3) in the rig's frame."""
    k = camera.coefficients
    X = X_rig if camera.cam_from_rig is None else camera.cam_from_rig.apply(X_rig)
    x, y = X[:, 0] / X[:, 2], X[:, 1] / X[:, 2]
    r2 = x * x + y * y
    if camera.lens == "fisheye":
        r = np.sqrt(r2)
        a = np.arctan(r)
        grown = a * (1 + k["k1"] * a**2 + k["k2"] * a**4 + k["k3"] * a**6 + k["k4"] * a**8)
        xd, yd = x / r * grown, y / r * grown
    else:
        d = (1 + k["k1"] * r2 + k["k2"] * r2**2 + k["k3"] * r2**3) / (
            1 + k["k4"] * r2 + k["k5"] * r2**2 + k["k6"] * r2**3
        )
        xd = x * d + 2 * k["p1"] * x * y + k["p2"] * (r2 + 2 * x * x)
        yd = y * d + k["p1"] * (r2 + 2 * y * y) + 2 * k["p2"] * x * y
    return np.column_stack([camera.fx * xd + camera.cx, camera.fy * yd + camera.cy])


def points(seed=1, n=50):
    """Points (n, 3) in front of both cameras of format_samples.py."""
    rng = np.random.default_rng(seed)
    return rng.uniform([-0.8, -0.8, 2.0], [0.2, 0.8, 4.0], (n, 3))
