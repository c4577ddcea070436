"""Drawings as SVG that can be read on light and on dark pages.

Colours have names; the style sheet in each file gives them a value for light pages and
another for dark ones. Coordinates are in pixels at the size at which a picture is shown,
rounded to a tenth, so that the same numbers make the same file.
"""
import math

# name: (on light pages, on dark pages). The last five tell things apart; they are Okabe
# and Ito's, lighter on dark pages, which the colour-blind can tell apart too.
COLOURS = {
    "page": ("#ffffff", "#0d1117"),
    "ink": ("#1f2328", "#e6edf3"),
    "soft": ("#59636e", "#9198a1"),
    "line": ("#c4ccd4", "#3d444d"),
    "fill": ("#eef1f4", "#1c222a"),
    "blue": ("#0072b2", "#56b4e9"),
    "red": ("#c94f00", "#ff8c42"),
    "green": ("#00805d", "#2dd4a4"),
    "pink": ("#b3528c", "#e59cc6"),
    "gold": ("#a86f00", "#f0b429"),
    "sun": ("#ffc53d", "#ffc53d"),
}
# Colours from the lowest to the highest value of a map.
STEPS = [("#08519c", "#9ecae1"), ("#2b7bba", "#6baed6"), ("#5aa2cf", "#4292c6"),
         ("#8cc0dd", "#2f75a8"), ("#b7d4ea", "#235b86"), ("#d6e5f4", "#1a4163"),
         ("#ebf2fa", "#142c43")]
COLOURS.update({f"step{i}": pair for i, pair in enumerate(STEPS)})
FONT = "font-family:system-ui,-apple-system,'Segoe UI',Helvetica,Arial,sans-serif"


def short(x):
    text = f"{x:.1f}"
    return text[:-2] if text.endswith(".0") else text


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class Picture:
    def __init__(self, width, height, title):
        self.size, self.title = (width, height), title
        self.parts, self.used, self.clips = [], {("f", "page")}, 0

    def look(self, fill, stroke, width, dash, opacity):
        """The attributes of a shape. If no colour is named, it has none."""
        classes = []
        for kind, name in (("f", fill), ("s", stroke)):
            if name:
                self.used.add((kind, name))
            classes.append(f"{kind}-{name or 'none'}")
        text = f' class="{" ".join(classes)}"'
        if stroke and width != 1:
            text += f' stroke-width="{short(width)}"'
        if dash:
            text += f' stroke-dasharray="{dash}"'
        if opacity != 1:
            text += f' opacity="{opacity:g}"'
        return text

    def path(self, points, fill=None, stroke=None, width=1, close=False, dash=None, opacity=1):
        d = "M" + "L".join(f"{short(x)},{short(y)}" for x, y in points) + ("z" if close else "")
        self.parts.append(f'<path d="{d}"{self.look(fill, stroke, width, dash, opacity)}/>')

    def paths(self, lists, fill=None, stroke=None, width=1, opacity=1):
        """Closed curves as one shape. A place is inside if it is inside an odd number of
        them."""
        d = "".join("M" + "L".join(f"{short(x)},{short(y)}" for x, y in points) + "z"
                    for points in lists)
        if d:
            self.parts.append(f'<path fill-rule="evenodd" d="{d}"'
                              f'{self.look(fill, stroke, width, None, opacity)}/>')

    def line(self, a, b, stroke="ink", width=1, dash=None, opacity=1):
        self.path([a, b], stroke=stroke, width=width, dash=dash, opacity=opacity)

    def circle(self, at, r, fill=None, stroke=None, width=1, dash=None, opacity=1):
        self.parts.append(f'<circle cx="{short(at[0])}" cy="{short(at[1])}" r="{short(r)}"'
                          f'{self.look(fill, stroke, width, dash, opacity)}/>')

    def cross(self, at, r, stroke="ink", width=1.2):
        x, y = at
        self.line((x - r, y), (x + r, y), stroke, width)
        self.line((x, y - r), (x, y + r), stroke, width)

    def dots(self, points, r, colour="ink", opacity=1):
        d = "".join(f"M{short(x)},{short(y)}h0" for x, y in points)
        self.parts.append(f'<path d="{d}"{self.look(None, colour, 2 * r, None, opacity)}/>')

    def rect(self, x, y, w, h, fill=None, stroke=None, width=1, r=0, opacity=1):
        self.parts.append(
            f'<rect x="{short(x)}" y="{short(y)}" width="{short(w)}" height="{short(h)}"'
            f'{f" rx=" + chr(34) + short(r) + chr(34) if r else ""}'
            f'{self.look(fill, stroke, width, None, opacity)}/>')

    def arrow(self, a, b, stroke="ink", width=1.6, head=7):
        d = math.hypot(b[0] - a[0], b[1] - a[1])
        if d < 1e-9:
            return
        x, y = (b[0] - a[0]) / d, (b[1] - a[1]) / d
        h = min(head, d)
        foot = (b[0] - 0.8 * h * x, b[1] - 0.8 * h * y)
        self.line(a, foot, stroke, width)
        self.path([b, (b[0] - h * x - 0.42 * h * y, b[1] - h * y + 0.42 * h * x),
                   (b[0] - h * x + 0.42 * h * y, b[1] - h * y - 0.42 * h * x)],
                  fill=stroke, close=True)

    def text(self, at, text, fill="ink", size=14, anchor="start", bold=False, mono=False,
             halo=False):
        """A text; line ends make several lines. halo: makes it readable on a drawing."""
        self.used.add(("f", fill))
        for k, line in enumerate(text.split("\n")):
            if halo:
                self.used.add(("h", "page"))
            name = f"f-{fill}" + (" halo" if halo else "") + (" mono" if mono else "")
            self.parts.append(
                f'<text x="{short(at[0])}" y="{short(at[1] + 1.25 * size * k)}" '
                f'class="{name}" font-size="{short(size)}"'
                + ("" if anchor == "start" else f' text-anchor="{anchor}"')
                + (' font-weight="600"' if bold else "") + f">{escaped(line)}</text>")

    def begin_clip(self, shape):
        """What follows, until end_clip, is drawn only inside the shape, which is an SVG
        element."""
        self.clips += 1
        self.parts.append(f'<clipPath id="c{self.clips}">{shape}</clipPath>'
                          f'<g clip-path="url(#c{self.clips})">')

    def end_clip(self):
        self.parts.append("</g>")

    def style(self, dark):
        kinds = {"f": "fill", "s": "stroke"}
        return "".join(f".{kind}-{name}{{{kinds[kind]}:{COLOURS[name][dark]}}}"
                       for kind, name in sorted(self.used) if kind in kinds) + (
            f".halo{{stroke:{COLOURS['page'][dark]}}}" if ("h", "page") in self.used else "")

    def text_of(self):
        w, h = self.size
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w} {h}" width="{w}" '
                f'height="{h}" role="img" stroke-linejoin="round" stroke-linecap="round">\n'
                f"<title>{escaped(self.title)}</title>\n"
                f"<style>text{{{FONT}}}.mono{{font-family:ui-monospace,Menlo,Consolas,"
                f"monospace}}.f-none{{fill:none}}.s-none{{stroke:none}}"
                f".halo{{paint-order:stroke;stroke-width:4px}}\n{self.style(0)}\n"
                f"@media (prefers-color-scheme:dark){{{self.style(1)}}}</style>\n"
                f'<rect width="{w}" height="{h}" rx="8" class="f-page"/>\n'
                + "\n".join(self.parts) + "\n</svg>\n")


# ---- what stands ahead of a camera, from the side ---------------------------------------

def mul(R, x):
    return [sum(R[3 * i + k] * x[k] for k in range(3)) for i in range(3)]


def mul_t(R, x):
    return [sum(R[3 * k + i] * x[k] for k in range(3)) for i in range(3)]


class Side:
    """Points (x right, y down, z forward) seen from far away. They are turned about y by
    `turn` degrees, then tipped about x by `tip`. The scale is `scale` pixels a unit, and
    the point `middle` is at `at`."""

    def __init__(self, turn, tip, scale, middle, at):
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        d, e = math.cos(math.radians(tip)), math.sin(math.radians(tip))
        self.R = [c, 0, s, e * s, d, -e * c, -d * s, e, d * c]
        self.scale, self.middle, self.at = scale, middle, at

    def __call__(self, X):
        q = mul(self.R, [x - m for x, m in zip(X, self.middle)])
        return self.at[0] + self.scale * q[0], self.at[1] + self.scale * q[1]


def camera_center(R, t):
    return [-x for x in mul_t(R, t)]


def draw_camera(picture, side, R, t, size, colour, axis=0.0, half=(0.62, 0.46)):
    """The pyramid of a camera with cam_from_frame (R, t); its optical axis as an arrow."""
    o = camera_center(R, t)
    corners = [[o_i + size * w for o_i, w in zip(o, mul_t(R, (x, y, 1)))]
               for x, y in ((-half[0], -half[1]), (half[0], -half[1]), (half[0], half[1]),
                            (-half[0], half[1]))]
    picture.path([side(x) for x in corners], fill="page", stroke=colour, width=1.6, close=True,
                 opacity=0.9)
    for x in corners:
        picture.line(side(o), side(x), colour, 1.6)
    up = [o_i + size * w for o_i, w in zip(o, mul_t(R, (0, -1.5 * half[1], 1)))]
    picture.path([side(corners[0]), side(up), side(corners[1])], fill=colour, stroke=colour,
                 width=1, close=True)
    if axis:
        picture.arrow(side(o), side([o_i + axis * w for o_i, w in zip(o, mul_t(R, (0, 0, 1)))]),
                      colour)
    return o


def draw_axes(picture, side, R, o, size, names=("x", "y", "z"), font=14, away=1.17):
    """Axes of a frame at o; row i of R is its axis i. x red, y green, z blue."""
    for i, colour in enumerate(("red", "green", "blue")):
        end = [o_k + size * R[3 * i + k] for k, o_k in enumerate(o)]
        picture.arrow(side(o), side(end), colour, 2.2, 8)
        if names:
            name = [o_k + away * size * R[3 * i + k] for k, o_k in enumerate(o)]
            x, y = side(name)
            picture.text((x, y + 0.35 * font), names[i], colour, font, "middle", bold=True,
                         halo=True)


# ---- maps: the parts of a grid below a level ---------------------------------------------

def below(grid, level):
    """Closed curves around the area below the level, as (column, row), by marching squares.
    Everything outside the grid counts as above."""
    rows, columns = len(grid), len(grid[0])

    def value(i, j):
        return grid[i][j] if 0 <= i < rows and 0 <= j < columns else math.inf

    def cut(a, b, va, vb):
        f = 0.5 if math.inf in (va, vb) else (level - va) / (vb - va)
        return (a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]))

    follow = {}
    for i in range(-1, rows):
        for j in range(-1, columns):
            at = [(j, i), (j + 1, i), (j + 1, i + 1), (j, i + 1)]
            v = [value(y, x) for x, y in at]
            inside = [x < level for x in v]
            # The edges where the curve enters and leaves, with the area below on its right.
            enter = [k for k in range(4) if not inside[k] and inside[(k + 1) % 4]]
            leave = [k for k in range(4) if inside[k] and not inside[(k + 1) % 4]]
            for e in enter:
                out = min(leave, key=lambda k: (k - e) % 4)

                def place(k):
                    return cut(at[k], at[(k + 1) % 4], v[k], v[(k + 1) % 4])
                follow[key(at[e], at[(e + 1) % 4])] = (
                    key(at[out], at[(out + 1) % 4]), place(e))
    curves = []
    while follow:
        start = k = min(follow)
        curve = []
        while k in follow:
            k, point = follow.pop(k)
            curve.append(point)
        assert k == start, "a curve is not closed"
        curves.append(curve)
    return curves


def key(a, b):
    return (min(a, b), max(a, b))
