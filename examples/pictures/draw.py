#!/usr/bin/env python3
"""Draws the pictures of the documents: draw.py NUMBERS PICTURES.

NUMBERS is the folder that run.sh fills, from the library and the command line. Writes one
SVG a picture into the folder PICTURES.

    draw.py --check NUMBERS PICTURES

compares instead: the pictures must be as they are drawn from the numbers, word for word;
what is drawn may be half a pixel off, because of another math library.
"""
import csv
import math
import pathlib
import re
import sys

from svg import Picture, Side, below, draw_axes, draw_camera, mul

ROOT = pathlib.Path(__file__).resolve().parents[2]
STEREO = ROOT / "examples/data/opencv_stereo"
PIXELS_OFF, BYTES_MOST = 0.5, 60000
WIDTH = 820


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def numbers(row, names):
    return [float(row[name]) for name in names]


def pose(row, prefix=""):
    R = numbers(row, [f"{prefix}R{i}{j}" for i in "123" for j in "123"])
    return R, numbers(row, [f"{prefix}t{k}" for k in "xyz"])


def compose(a, b):
    """The transform a after b; each is (R, t)."""
    R = [sum(a[0][3 * i + k] * b[0][3 * k + j] for k in range(3))
         for i in range(3) for j in range(3)]
    return R, [x + t for x, t in zip(mul(a[0], b[1]), a[1])]


def apply(T, X):
    return [x + t for x, t in zip(mul(T[0], X), T[1])]


class Plot:
    """The axes of a curve: a frame with ticks, and the position of a value in it."""

    def __init__(self, picture, box, xs, ys):
        self.picture, self.box, self.xs, self.ys = picture, box, xs, ys

    def __call__(self, x, y):
        left, top, width, height = self.box
        return (left + width * (x - self.xs[0]) / (self.xs[1] - self.xs[0]),
                top + height * (1 - (y - self.ys[0]) / (self.ys[1] - self.ys[0])))

    def ticks(self, at_x, at_y, names=True, form="{:g}"):
        left, top, width, height = self.box
        for x in at_x:
            u = self(x, 0)[0]
            self.picture.line((u, top), (u, top + height), "line", 0.7)
            if names:
                self.picture.text((u, top + height + 16), form.format(x), "soft", 12, "middle")
        for y in at_y:
            v = self(0, y)[1]
            self.picture.line((left, v), (left + width, v), "line", 0.7)
            self.picture.text((left - 7, v + 4), form.format(y), "soft", 12, "end")

    def curve(self, xs, ys, stroke, width=1.6, dash=None):
        self.picture.path([self(x, min(max(y, self.ys[0]), self.ys[1]))
                           for x, y in zip(xs, ys)], stroke=stroke, width=width, dash=dash)


# ---- a real rig ------------------------------------------------------------------------

def board_corners(data):
    """The corners of the board: X, Y, Z by point."""
    return {int(row["point"]): numbers(row, "XYZ")
            for row in read(data / "observations.csv") if row["frame"] == "01"}


def draw_rig(folder):
    cameras = {row["camera"]: row for row in read(folder / "stereo/rig.csv")}
    targets = read(folder / "stereo/targets.csv")
    pair, = read(folder / "stereo/pairs.csv")
    views = read(folder / "stereo/poses.csv")
    residuals = [float(row["error_px"]) for row in read(folder / "stereo/residuals.csv")]
    corners = board_corners(STEREO)
    picture = Picture(WIDTH, 372, "Two real cameras and seven places of a chessboard, "
                      "calibrated by rigcal")
    side = Side(-40, 24, 720, (0.035, 0.0, 0.2), (262, 200))
    far_first = sorted(targets, key=lambda row: -float(row["tz"]))
    for k, row in enumerate(far_first):
        T = pose(row)
        outline = [apply(T, x) for x in ((-.0125, -.0125, 0), (.2125, -.0125, 0),
                                         (.2125, .1375, 0), (-.0125, .1375, 0))]
        picture.path([side(x) for x in outline], fill="fill", stroke="soft", close=True,
                     opacity=0.85)
        picture.dots([side(apply(T, x)) for x in corners.values()], 1.1, "soft")
    for name, colour in (("right", "red"), ("left", "blue")):
        R, t = pose(cameras[name])
        o = draw_camera(picture, side, R, t, 0.055, colour, 0.16)
        x, y = side(o)
        picture.text((x - 4, y + 24) if name == "left" else (x + 8, y + 6), name, colour, 15,
                     "end" if name == "left" else "start", bold=True, halo=True)
    turn = angle_deg(pose(pair)[0], [1, 0, 0, 0, 1, 0, 0, 0, 1])
    x, rms = 520, math.sqrt(sum(e * e for e in residuals) / len(residuals))
    lines = [("You give", [f"{len(corners)} corners of a board, and their pixels",
                           f"in {len(views)} views: 2 cameras, {len(targets)} places;",
                           "the intrinsics of both cameras;", "no guess of any pose"]),
             ("You get", ["where right is, seen from left:",
                          f"{1000 * math.hypot(*numbers(pair, ('tx', 'ty', 'tz'))):.1f} mm away, "
                          f"± {1000 * float(cameras['right']['sigma_pos']):.2f} mm,",
                          f"turned by {turn:.2f}°, ± {float(pair['sigma_rot_deg']):.3f}°;",
                          f"corners {rms:.2f} px rms from their pixels;",
                          "why not all of that is noise"])]
    y = 44
    for head, text in lines:
        picture.text((x, y), head, "ink", 16, bold=True)
        for line in text:
            y += 23
            picture.text((x, y), line, "ink", 14.5)
        y += 40
    picture.text((x, 352), "drawn from what rigcal calibrate wrote", "soft", 12.5)
    return picture


# ---- frames ----------------------------------------------------------------------------

def turned(yaw, pitch):
    """The axes, as rows, of a camera that looks `yaw` degrees to the right and `pitch`
    down."""
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    d, e = math.cos(math.radians(pitch)), math.sin(math.radians(pitch))
    return [c, 0, -s, -s * e, d, -c * e, s * d, e, c * d]


def curved(picture, a, b, bend, stroke):
    """An arrow along an arc that is `bend` pixels off the straight line."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    d = math.hypot(dx, dy)
    middle = ((a[0] + b[0]) / 2 - 2 * bend * dy / d, (a[1] + b[1]) / 2 + 2 * bend * dx / d)
    points = [tuple((1 - f) ** 2 * p + 2 * f * (1 - f) * m + f * f * q
                    for p, m, q in zip(a, middle, b)) for f in [k / 24 for k in range(25)]]
    picture.path(points[:-1], stroke=stroke, width=1.6, dash="5 4")
    picture.arrow(points[-3], points[-1], stroke, 1.6, 9)
    return points[12]


def draw_frames(folder):
    picture = Picture(WIDTH, 390, "The frames of two cameras and a target, and the transforms "
                      "between them")
    side = Side(-24, 24, 128, (0.0, 0.25, 1.0), (268, 206))
    board = [1, 0, 0, 0, 1, 0, 0, 0, 1], [0.35, -0.35, 2.5]
    board = (turned(-22, 12), board[1])
    R_board = [board[0][3 * j + i] for i in range(3) for j in range(3)]  # rig from target
    quad = [apply((R_board, board[1]), x)
            for x in ((0, 0, 0), (1.15, 0, 0), (1.15, .8, 0), (0, .8, 0))]
    picture.path([side(x) for x in quad], fill="fill", stroke="soft", close=True)
    picture.dots([side(apply((R_board, board[1]), (0.23 * i, 0.2 * j, 0)))
                  for i in range(6) for j in range(5)], 2.2, "soft")
    point = apply((R_board, board[1]), (0.92, 0.6, 0))
    places = {"a": (-0.95, 0.35, 0.0), "b": (0.95, 0.6, 0.1)}
    axes = {"a": turned(18, -6), "b": turned(-14, -10)}
    for name in "ab":
        R, o = axes[name], places[name]
        t = [-x for x in mul(R, o)]
        picture.line(side(o), side(point), "gold", 1.1, "2 4")
        draw_camera(picture, side, R, t, 0.34, "soft")
        draw_axes(picture, side, R, o, 0.52)
    draw_axes(picture, side, board[0], board[1], 0.5)
    picture.circle(side(point), 5, fill="gold")
    x, y = side(point)
    picture.text((x + 9, y + 4), "X", "gold", 15, bold=True, halo=True)
    a, b, w = side(places["a"]), side(places["b"]), side(board[1])
    u, v = curved(picture, (a[0] + 16, a[1] + 22), (b[0] - 16, b[1] + 22), 22, "ink")
    picture.text((u, v + 20), "b_from_a", "ink", 14, "middle", mono=True, halo=True)
    u, v = curved(picture, (w[0] - 14, w[1] - 6), (a[0] - 26, a[1] - 42), 16, "ink")
    picture.text((u - 6, v - 8), "a_from_target", "ink", 14, "end", mono=True, halo=True)
    picture.text((a[0] - 14, a[1] + 30), "camera a", "ink", 15, "end", bold=True)
    picture.text((b[0] + 22, b[1] + 34), "camera b", "ink", 15, bold=True)
    u, v = side(quad[1])
    picture.text((u + 8, v - 2), "target", "ink", 15, bold=True)
    x, y = 566, 62
    for text, colour, gap in (
            ("Every frame is right-handed.", "ink", 22), ("In a camera:", "ink", 22),
            ("x to the right of the image", "red", 20), ("y downwards", "green", 20),
            ("z forwards, the optical axis", "blue", 30),
            ("b_from_a = (R, t) takes points", "ink", 20),
            ("of frame a to frame b:", "ink", 26)):
        picture.text((x, y), text, colour, 14.5)
        y += gap
    picture.text((x + 12, y), "X_b = R X_a + t", "ink", 14.5, mono=True)
    y += 32
    picture.text((x, y), "Names chain from right to left:", "ink", 14.5)
    y += 26
    picture.text((x + 12, y), "b_from_target =\n  b_from_a a_from_target", "ink", 14, mono=True)
    return picture


# ---- the sphere of directions --------------------------------------------------------------

SPHERE_LEVELS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)


def draw_sphere(folder):
    rows, optima = read(folder / "sphere.csv"), read(folder / "optima.csv")
    seeds = read(folder / "seeds.csv")
    best = sorted(seeds, key=lambda row: float(row["cost"]))[:3]
    n = 1 + max(int(row["row"]) for row in rows)
    picture = Picture(WIDTH, 432, "The cost of every direction of the optical axis, the "
                      "directions where the search looks, and the two poses found")
    radius, top = 148, 196
    for half, (left, head) in enumerate(((590, "The camera behind the target"),
                                         (190, "The camera in front of the target"))):
        grid = [[0.0] * n for _ in range(n)]
        for row in rows:
            if int(row["half"]) == half:
                grid[int(row["row"])][int(row["column"])] = math.log(float(row["cost"]))

        def at(x, y, left=left):
            return left + radius * x, top + radius * y
        picture.begin_clip(f'<circle cx="{left}" cy="{top}" r="{radius}"/>')
        picture.circle((left, top), radius, fill=f"step{len(SPHERE_LEVELS)}")
        for k in reversed(range(len(SPHERE_LEVELS))):
            curves = below(grid, math.log(SPHERE_LEVELS[k]))
            picture.paths([[at(2.1 * u / (n - 1) - 1.05, 2.1 * v / (n - 1) - 1.05)
                            for u, v in curve] for curve in curves], fill=f"step{k}")
        picture.end_clip()
        picture.circle((left, top), radius, stroke="soft", width=1.2)
        for row in seeds:
            x, y, z = numbers(row, "xyz")
            if (z > 0) == (half == 1):
                picture.circle(at(x, y), 4.2, fill="page" if row not in best else "sun",
                               stroke="ink", width=1.2)
        for row in optima:
            x, y, z = numbers(row, ("m_x", "m_y", "m_z"))
            if row["corner"] == "0" and (z > 0) == (half == 1):
                colour, name = (("red", "best pose") if row["pose"] == "0"
                                else ("pink", "second pose"))
                picture.circle(at(x, y), 7.5, stroke="page", width=5)
                picture.circle(at(x, y), 7.5, stroke=colour, width=3)
                u, v = at(x, y)
                picture.text((u, v + 26), name, colour, 14, "middle", bold=True, halo=True)
        picture.text((left, 32), head, "ink", 15, "middle", bold=True)
    x, y = 32, 376
    picture.circle((x, y - 4), 4.2, fill="page", stroke="ink", width=1.2)
    picture.text((x + 12, y), f"the {len(seeds)} directions evaluated first", "ink", 13.5)
    x += 252
    picture.circle((x, y - 4), 4.2, fill="sun", stroke="ink", width=1.2)
    picture.text((x + 12, y), "the three that are followed downhill", "ink", 13.5)
    x += 274
    picture.text((x, y), "low", "ink", 13.5)
    x += 30
    for k in range(len(SPHERE_LEVELS) + 1):
        picture.rect(x + 20 * k, y - 12, 20, 14, fill=f"step{k}")
    picture.text((x + 20 * len(SPHERE_LEVELS) + 28, y), "high cost", "ink", 13.5)
    picture.text((32, y + 26), "Centre: the camera looks straight at the target. Rim: it looks "
                 "along the plane of the target.\nA step of blue is three times the cost of "
                 "the one before.", "soft", 12.5)
    return picture


# ---- two poses of a flat target ----------------------------------------------------------

def draw_two_poses(folder):
    optima = read(folder / "optima.csv")
    picture = Picture(WIDTH, 350, "Two poses of a square tag that have nearly the same image")
    poses = [[row for row in optima if row["pose"] == p] for p in "01"]
    depth = sum(float(row["Z"]) for row in poses[0]) / 4
    side = Side(-58, 22, 118, (0, 0, depth), (300, 160))
    near = Side(-58, 22, 118, (0, 0, depth - 2.1), (110, 232))
    colours, names = ("red", "pink"), ("best pose", "second pose")
    eye = [1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, -(depth - 2.1)]
    o = near((0, 0, depth - 2.1))
    for row in poses[0]:
        end = side(numbers(row, "XYZ"))
        picture.line(o, end, "gold", 1, "2 4")
    for k in (1, 0):
        quad = [side(numbers(row, "XYZ")) for row in poses[k]]
        picture.path(quad, fill=colours[k], close=True, opacity=0.14)
        picture.path(quad, stroke=colours[k], width=2.4, close=True)
        centre = [sum(float(row[c]) for row in poses[k]) / 4 for c in "XYZ"]
        edge = [[float(poses[k][i][c]) - float(poses[k][0][c]) for c in "XYZ"] for i in (1, 3)]
        normal = [edge[1][1] * edge[0][2] - edge[1][2] * edge[0][1],
                  edge[1][2] * edge[0][0] - edge[1][0] * edge[0][2],
                  edge[1][0] * edge[0][1] - edge[1][1] * edge[0][0]]
        tip = [c + 0.8 * w for c, w in zip(centre, normal)]
        picture.arrow(side(centre), side(tip), colours[k], 2)
        u, v = side(tip)
        picture.text((u + (-6 if k else 6), v + (-26 if k else 14)), names[k], colours[k], 14.5,
                     "middle" if k else "start", bold=True, halo=True)
    draw_camera(picture, near, *eye, 0.5, "blue")
    picture.text((o[0], o[1] + 58), "camera", "blue", 15, "middle", bold=True)
    picture.text((24, 334), "In space: the tag leans one way or the other.", "soft", 13)

    left, top, size = 470, 28, 280
    seen = [numbers(row, ("u_seen", "v_seen")) for row in poses[0]]
    middle = [sum(p[k] for p in seen) / 4 for k in (0, 1)]
    reach = 1.25 * max(abs(p[k] - middle[k]) for p in seen for k in (0, 1))

    def at(uv):
        return (left + size / 2 * (1 + (uv[0] - middle[0]) / reach),
                top + size / 2 * (1 + (uv[1] - middle[1]) / reach))
    picture.rect(left, top, size, size, fill="fill", stroke="line")
    for k in (1, 0):
        picture.path([at(numbers(row, "uv")) for row in poses[k]], stroke=colours[k],
                     width=1.8, close=True, dash=None if k == 0 else "6 4")
    for p in seen:
        picture.cross(at(p), 8, "ink", 1.6)
    for k, v in ((0, 0), (1, 1)):
        row = poses[k][0]
        picture.text((left + size / 2, top + size / 2 - 24 + 44 * v),
                     f"{names[k]}\n{float(row['rms_px']):.2f} px rms", colours[k], 12.5,
                     "middle", bold=True)
    picture.text((left, 334), f"In the image, {2 * reach:.0f} px of it: crosses are the "
                 "corners.", "soft", 12.5)
    return picture


# ---- a matching line and its band ----------------------------------------------------------

BAND_CORNERS, BAND_REACH = (45, 38, 31, 17), 8
BAND_COLOURS = ("red", "blue", "green", "pink")


def band_of(bands, corner):
    mine = [row for row in bands if int(row["corner"]) == corner]
    sides = ([], [])
    for row in mine:
        u, v, across_u, across_v, half = numbers(
            row, ("u", "v", "across_u", "across_v", "half_width"))
        for k, sign in enumerate((-1, 1)):
            sides[k].append((u + sign * half * across_u, v + sign * half * across_v))
    return [(float(row["u"]), float(row["v"])) for row in mine], sides[0] + sides[1][::-1]


def draw_band(folder):
    place = "3"
    corners = [row for row in read(folder / "matching/corners.csv") if row["place"] == place]
    bands = read(folder / "matching/bands.csv")
    chosen = BAND_CORNERS
    picture = Picture(WIDTH, 330, "Corners in the left image, and in the right image the band "
                      "in which each is looked for")
    scale, top = 0.47, 44

    def box(left, head, w=640 * scale, h=480 * scale):
        picture.rect(left, top, w, h, fill="fill", stroke="line")
        picture.text((left, top - 12), head, "ink", 14.5, bold=True)
    box(20, "left image")
    picture.dots([(20 + scale * float(row["u"]), top + scale * float(row["v"]))
                  for row in corners], 1.6, "soft")
    for colour, corner in zip(BAND_COLOURS, chosen):
        row, = [row for row in corners if int(row["corner"]) == corner]
        picture.circle((20 + scale * float(row["u"]), top + scale * float(row["v"])), 5.5,
                       stroke=colour, width=2.4)
    left = 342
    box(left, "right image: a band for each")

    def at(p):
        return left + scale * p[0], top + scale * p[1]
    picture.begin_clip(f'<rect x="{left}" y="{top}" width="{640 * scale}" '
                       f'height="{480 * scale}"/>')
    for colour, corner in zip(BAND_COLOURS, chosen):
        middle, outline = band_of(bands, corner)
        picture.path([at(p) for p in outline], fill=colour, close=True, opacity=0.3)
        picture.path([at(p) for p in middle], stroke=colour, width=1.4)
    picture.end_clip()
    picture.dots([at(numbers(row, ("u_true", "v_true"))) for row in corners], 1.6, "soft")
    for colour, corner in zip(BAND_COLOURS, chosen):
        row, = [row for row in corners if int(row["corner"]) == corner]
        picture.circle(at(numbers(row, ("u_true", "v_true"))), 5.5, stroke=colour, width=1.6)

    shown, left2, size = 1, 664, 136
    row, = [row for row in corners if int(row["corner"]) == chosen[shown]]
    u0, v0 = numbers(row, ("u_true", "v_true"))
    x, y = at((u0, v0))
    r = scale * BAND_REACH
    picture.rect(x - r, y - r, 2 * r, 2 * r, stroke="ink", width=1.2)
    picture.line((x + r, y - r), (left2, top + 30), "ink", 0.8)
    picture.line((x + r, y + r), (left2, top + 30 + size), "ink", 0.8)
    picture.rect(left2, top + 30, size, size, fill="fill", stroke="ink", width=1.2)

    def zoom(p):
        return (left2 + size / 2 * (1 + (p[0] - u0) / BAND_REACH),
                top + 30 + size / 2 * (1 + (p[1] - v0) / BAND_REACH))
    picture.begin_clip(f'<rect x="{left2}" y="{top + 30}" width="{size}" height="{size}"/>')
    middle, outline = band_of(bands, chosen[shown])
    width = 2 * min((abs(float(row["u"]) - u0), float(row["half_width"])) for row in bands
                    if int(row["corner"]) == chosen[shown])[1]
    picture.path([zoom(p) for p in outline if abs(p[0] - u0) < 60], fill=BAND_COLOURS[shown],
                 close=True, opacity=0.3)
    picture.path([zoom(p) for p in middle if abs(p[0] - u0) < 60],
                 stroke=BAND_COLOURS[shown], width=1.4)
    picture.cross(zoom((u0, v0)), 8, "ink", 1.6)
    picture.end_clip()
    picture.text((left2, top + 48 + size), f"{2 * BAND_REACH} x {2 * BAND_REACH} pixels:",
                 "ink", 13)
    picture.text((left2, top + 66 + size), f"the match, a cross,\nis in the band,\nwhich is "
                 f"{width:.1f} px wide", "ink", 13)
    share = sum(int(row["in_range"]) for row in corners)
    picture.text((20, 300), "A chessboard seen by a real stereo pair, which is calibrated by "
                 "other places of it.\n"
                 f"Of {len(corners)} corners {share / len(corners):.1f} are in a band on "
                 "average. Bands hold the match with 99 %, from 0.2 to 0.8 m.", "soft", 12.5)
    return picture


# ---- the graph of a rig ----------------------------------------------------------------------

def draw_graph(folder):
    links, views = read(folder / "links.csv"), read(folder / "views.csv")
    picture = Picture(WIDTH, 330, "Which camera saw which placement, and which cameras that "
                      "joins")
    cameras = 1 + max(int(row["camera"]) for row in views)
    places = 1 + max(int(row["placement"]) for row in views)
    group = {int(row["a"]): int(row["b"]) for row in links if row["kind"] == "group"}
    colours = ("blue", "red", "green")

    def seen_at(k, n, y):
        return 60 + (k + 0.5) * 320 / n, y
    picture.text((40, 34), "Views join cameras and placements", "ink", 15, bold=True)
    for row in views:
        c, p = int(row["camera"]), int(row["placement"])
        picture.line(seen_at(c, cameras, 96), seen_at(p, places, 232), colours[group[c]], 1.8)
    for c in range(cameras):
        x, y = seen_at(c, cameras, 96)
        picture.circle((x, y), 17, fill="page", stroke=colours[group[c]], width=2.4)
        picture.text((x, y + 5), f"c{c}", "ink", 14, "middle", bold=True)
    for p in range(places):
        x, y = seen_at(p, places, 232)
        picture.rect(x - 16, y - 16, 32, 32, fill="fill", stroke="soft", width=1.6, r=3)
        picture.text((x, y + 5), f"p{p}", "ink", 14, "middle")
    picture.text((40, 282), "A line is a view: one camera at one placement.\nc4 saw only p5, "
                 "which no other camera saw.", "soft", 12.5)

    picture.text((450, 34), "What every two cameras share", "ink", 15, bold=True)
    at = [(478, 190), (566, 78), (654, 190), (780, 190), (780, 78)]
    weak, = [row for row in links if row["kind"] == "weakest"]
    for row in links:
        a, b = int(row["a"]), int(row["b"]) if row["b"] else 0
        if row["kind"] == "link":
            n = int(row["shared"])
            picture.line(at[a], at[b], "blue", 1.5 + 1.5 * n)
            x, y = (at[a][0] + at[b][0]) / 2, (at[a][1] + at[b][1]) / 2
            lines = f"{n} shared", f"{float(row['sigma_deg']):.2f}°"
            if at[a][1] == at[b][1]:  # text above and below the line, or else beside it
                picture.text((x, y - 8), lines[0], "ink", 12.5, "middle")
                picture.text((x, y + 17), lines[1], "ink", 12.5, "middle")
            else:
                is_left = x < at[1][0]
                picture.text((x - 12 if is_left else x + 12, y - 6), "\n".join(lines), "ink",
                             12.5, "end" if is_left else "start")
        if row["kind"] == "advice":
            curved(picture, (at[a][0] + 18, at[a][1]), (at[b][0] - 18, at[b][1]), 0, "red")
            picture.text((673, 68), "missing", "red", 13, "middle", bold=True, halo=True)
    for c in range(cameras):
        picture.circle(at[c], 17, fill="page", stroke=colours[group[c]], width=2.4)
        picture.text((at[c][0], at[c][1] + 5), f"c{c}", "ink", 14, "middle", bold=True)
    advice, = [row for row in links if row["kind"] == "advice"]
    picture.text((450, 250), f"The standard deviation of the turn between two\ncameras, by the placements "
                 f"that they share. Weakest\nafter the adjustment: c{weak['a']} to "
                 f"c{weak['b']}, {float(weak['sigma_deg']):.2f}°. Advice: show\nthe target to "
                 f"c{advice['a']} and c{advice['b']} together, once.", "soft", 12.5)
    return picture


# ---- what a monitor sees ----------------------------------------------------------------------

def angle_deg(R, S):
    trace = sum(a * b for a, b in zip(R, S))
    return math.degrees(math.acos(min(1, max(-1, (trace - 1) / 2))))


def draw_monitor(folder):
    frames = read(folder / "frames.csv")
    time = [float(row["time_s"]) for row in frames]
    alarm = [t for t, row in zip(time, frames) if row["alarm"] == "1"]
    answer = [row for row in frames if row["alarm"] == "1"][-1]
    picture = Picture(WIDTH, 418, "Evidence that a camera moved, and the turn of each camera, "
                      "over time; camera b is bumped after 10 s")
    box = (78, 34, 560, 130)
    ends, step = (time[0], math.ceil(time[-1])), 4
    evidence = Plot(picture, box, ends, (-10, 3))
    turn = Plot(picture, (78, 206, 560, 130), ends, (0, 0.5))
    for plot in (evidence, turn):
        left, right = plot(alarm[0], 0)[0], plot(alarm[-1], 0)[0]
        picture.rect(left, plot.box[1], max(right - left, 3), plot.box[3], fill="red",
                     opacity=0.2)
    evidence.ticks(range(0, int(ends[1]) + 1, step), (-8, -4, 0), names=False)
    turn.ticks(range(0, int(ends[1]) + 1, step), (0, 0.2, 0.4))
    picture.line(evidence(ends[0], 0), evidence(ends[1], 0), "red", 1.4, "6 4")
    evidence.curve(time, [float(row["evidence"]) for row in frames], "ink")
    names = ("a", "b", "c")
    poses = {name: [pose(row, f"{name}.") for row in frames] for name in names}
    for name, colour in zip(names, ("soft", "red", "blue")):
        R0 = poses[name][60][0]
        turn.curve(time[60:], [angle_deg(R, R0) for R, _ in poses[name][60:]], colour, 2)
    picture.text((78, 22), "evidence of a move (logarithm, over its limit)", "ink", 13.5, bold=True)
    picture.text((78, 196), "turn since 4 s [degrees]", "ink", 13.5, bold=True)
    picture.text((358, 372), "time [s]", "soft", 13, "middle")
    x, y = evidence(ends[0], 0)
    picture.text((x + 6, y - 6), "limit", "red", 12.5)
    x = 656
    picture.text((x, 56), f"alarm at {alarm[0]:.1f} s", "red", 14.5, bold=True)
    picture.text((x, 78), f"{len(alarm)} frames later:\ncamera {answer['camera']} moved, "
                 f"with\nprobability {float(answer['probability']):.3f}", "ink", 13.5)
    for k, (name, colour) in enumerate((("b, solved anew", "red"), ("c", "blue"),
                                        ("a, the frame", "soft"))):
        picture.line((x, 240 + 24 * k), (x + 24, 240 + 24 * k), colour, 2.4)
        picture.text((x + 32, 244 + 24 * k), name, "ink", 13.5)
    last = angle_deg(poses["b"][-1][0], poses["b"][60][0])
    picture.text((x, 320), f"truth: 0.2°, found {last:.2f}°", "ink", 13.5)
    picture.text((78, 392), "Simulated: three cameras, 20 matches a frame, 0.3 px of noise, one "
                 "match in twenty wrong.\nCamera b is turned by 0.2° at 10 s.", "soft", 12.5)
    return picture


PICTURES = {"rig": draw_rig, "frames": draw_frames, "sphere": draw_sphere,
            "two_poses": draw_two_poses, "band": draw_band, "graph": draw_graph,
            "monitor": draw_monitor}
WORDS = re.compile(r">([^<]*)</text>")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def differs(kept, made):
    """Says what is different, or nothing."""
    if NUMBER.sub("0", kept) != NUMBER.sub("0", made):
        return "other shapes or words"
    for a, b in zip(WORDS.findall(kept), WORDS.findall(made)):
        if a != b:
            return f"'{a}' is '{b}' now"
    for a, b in zip(NUMBER.findall(kept), NUMBER.findall(made)):
        if abs(float(a) - float(b)) > PIXELS_OFF:
            return f"{a} is {b} now"
    return None


def main():
    check = sys.argv[1:2] == ["--check"]
    if len(sys.argv) != 3 + check:
        sys.exit(__doc__.strip())
    folder, out = map(pathlib.Path, sys.argv[1 + check:])
    wrong = []
    for name, draw in PICTURES.items():
        text = draw(folder).text_of()
        path = out / f"{name}.svg"
        if len(text) > BYTES_MOST:
            wrong.append(f"{path.name} has {len(text)} bytes, more than {BYTES_MOST}")
        if not check:
            path.write_text(text)
        elif not path.exists():
            wrong.append(f"{path.name} is missing")
        elif difference := differs(path.read_text(), text):
            wrong.append(f"{path.name}: {difference}")
    extra = {path.stem for path in out.glob("*.svg")} - set(PICTURES)
    wrong += [f"{name}.svg: nothing draws it" for name in sorted(extra)]
    if wrong:
        print("\n".join(wrong))
        sys.exit("draw.py: the pictures are not as kept. When they ought to be so: "
                 "sh examples/pictures/run.sh")
    print(f"{len(PICTURES)} pictures", "as kept" if check else f"in {out}")


if __name__ == "__main__":
    main()
