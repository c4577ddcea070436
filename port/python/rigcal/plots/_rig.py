"""The rig in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..transform import Array
from ._scene import Scene, make_scene
from ._style import Theme, count, new_figure, number, plain, round_125, themed

if TYPE_CHECKING:
    from ..rig import Rig

SIZE = (7.4, 5.2)
VIEW = {"elev": 22, "azim": -62}  # from behind the cameras, on their right
LINE_HEIGHT = 0.17  # inches of a line of the title
MARGIN = 0.9  # of the room, that is filled
AWAY = 9.0  # points of the screen that a name is moved at a time, away from others


def plot_rig(
    rig: Rig,
    *,
    ax: Any = None,
    dark: bool = False,
    k: float = 3.0,
    exaggeration: float | None = None,
    boards: bool = True,
    figure: Any = None,
) -> Any:
    """See Rig.plot."""
    scene = make_scene(rig, k, exaggeration, boards)
    lines = title_lines(scene, rig, k)
    with themed(dark) as theme:
        if ax is None:
            figure = figure or new_figure(SIZE)
            figure.set_layout_engine("none")
            height = LINE_HEIGHT * (len(lines) + 0.7) / figure.get_figheight()
            ax = figure.add_axes((0, 0, 1, 1 - height), projection="3d")
            figure.text(
                0.02, 1 - 0.3 * LINE_HEIGHT / figure.get_figheight(), "\n".join(lines),
                va="top", linespacing=1.3,
            )  # fmt: skip
            box = figure.transFigure.transform([[0, 0], [1, 1 - height]])
        else:
            ax.set_title("\n".join(lines), loc="left")
            box = None
        _draw(ax, scene, theme, box)
    return ax.figure


def caption(scene: Scene, k: float) -> str:
    """Says what the ellipsoids are."""
    if not scene.ellipsoids:
        return ""
    large = (
        "true size"
        if scene.exaggeration == 1
        else f"drawn {number(scene.exaggeration)} times as large"
    )
    return f"ellipsoids: {number(k)} sigma of the centre, {large}"


def title_lines(scene: Scene, rig: Rig, k: float) -> list[str]:
    things = count(len(rig), "camera")
    if scene.n_boards:
        things += f", {count(scene.n_boards, 'board')}"
    lines = [things, caption(scene, k), *scene.notes]
    return [plain(line, 110) for line in lines if line]


def _draw(ax: Any, scene: Scene, theme: Theme, box: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    A = scene.turn
    ax.set_axis_off()
    ax.set_proj_type("persp", focal_length=1.4)
    ax.view_init(**VIEW)

    def lines(what: list[Array], colour: str, label: str, **how: Any) -> None:
        if what:
            drawn = Line3DCollection(what, colors=colour, label=label, clip_on=False, **how)
            ax.add_collection3d(drawn, autolim=False)

    grid, square = _grid(scene.points @ A.T)
    lines(grid, theme.line, "grid", linewidths=0.5)
    lines([X @ A.T for X in scene.boards.values()], theme.faint, "boards", linewidths=0.6)
    for n, (name, frustum) in enumerate(scene.frustums.items()):
        for label, what in (
            ("frustum", frustum),
            ("ellipsoid", scene.ellipsoids.get(name, [])),
        ):
            lines([X @ A.T for X in what], theme.of(n), f"{label} {name}", linewidths=1.1)
    edge = next(iter(scene.frustums.values()))[1]
    length = 0.5 * float(np.linalg.norm(edge[1] - edge[0]))
    near = np.linalg.norm(scene.points, axis=1).min() < scene.size
    for name, end in zip("xyz" if near else "", length * A.T):
        lines([np.array([0 * end, end])], theme.ink, f"axis {name}", linewidths=1)
        ax.text(*(1.25 * end), name, color=theme.faint, fontsize=7, ha="center",
                va="center", clip_on=False)  # fmt: skip
    drawn = [scene.points @ A.T, *grid, *([length * A.T] if near else [])]
    drawn += [X @ A.T for of in scene.ellipsoids.values() for X in of]
    _fit(ax, np.vstack(drawn), box)
    _names(ax, scene, theme)
    ax.text2D(
        1.0, 0.0, f"a square of the floor: {number(square)} of your unit", ha="right",
        va="bottom", transform=ax.transAxes if box is None else _corner(ax.figure),
        color=theme.faint, fontsize=8,
    )  # fmt: skip


def _corner(figure: Any) -> Any:
    """The right bottom corner of the figure, slightly inside."""
    from matplotlib.transforms import ScaledTranslation

    return figure.transFigure + ScaledTranslation(-0.08, 0.06, figure.dpi_scale_trans)


def _on_screen(ax: Any, points: Array) -> Array:
    """(n, 2) pixels of the figure."""
    from mpl_toolkits.mplot3d import proj3d

    p, q, _ = proj3d.proj_transform(*points.T, ax.get_proj())
    screen: Array = ax.transData.transform(np.column_stack([p, q]))
    return screen


def _fit(ax: Any, points: Array, box: Any) -> None:
    """Limits and zoom so that the points fill the box (2, 2) of the screen; None: that of
    the axes. The scales of the three axes are equal."""
    low, high = points.min(0), points.max(0)
    half = float((high - low).max()) / 2 or 1.0
    middle, zoom = (low + high) / 2, 1.0
    elev, azim = np.radians([VIEW["elev"], VIEW["azim"]])
    right = np.array([-np.sin(azim), np.cos(azim), 0])
    up = np.array(
        [-np.sin(elev) * np.cos(azim), -np.sin(elev) * np.sin(azim), np.cos(elev)]
    )
    for _ in range(4):
        ax.set(**{f"{x}lim": (m - half, m + half) for x, m in zip("xyz", middle)})
        ax.set_box_aspect((1, 1, 1), zoom=zoom)
        ax.apply_aspect()
        room = np.array(ax.bbox.get_points() if box is None else box)
        steps = middle + half * np.array([0 * right, right, up])
        zero, one, two = _on_screen(ax, steps)
        scale = np.array([one[0] - zero[0], two[1] - zero[1]]) / half
        screen = _on_screen(ax, points)
        least, most = screen.min(0), screen.max(0)
        off = ((least + most) / 2 - room.mean(0)) / scale
        middle = middle + off[0] * right + off[1] * up
        zoom *= MARGIN * float(((room[1] - room[0]) / np.maximum(most - least, 1e-9)).min())


def _grid(points: Array) -> tuple[list[Array], float]:
    """Lines of a floor under the points, and the side of a square."""
    low, high = points.min(0), points.max(0)
    side = float((high - low).max()) or 1.0
    square = round_125(side / 6)
    first = np.floor(low[:2] / square - 0.1)
    last = np.ceil(high[:2] / square + 0.1)
    x, y = (np.arange(a, b + 1) * square for a, b in zip(first, last))
    z = low[2] - 0.04 * side
    return [
        *(np.array([[a, y[0], z], [a, y[-1], z]]) for a in x),
        *(np.array([[x[0], b, z], [x[-1], b, z]]) for b in y),
    ], square


def _names(ax: Any, scene: Scene, theme: Theme) -> None:
    """Writes each name above its frustum. If two would overlap, one is moved up."""
    A, points = scene.turn, 72 / ax.figure.dpi
    taken: list[tuple[float, float, float]] = []
    tops = {}
    for name, frustum in scene.frustums.items():
        X, C = frustum[0] @ A.T, A @ scene.centres[name]
        side = 0.5 if X[:, 2].max() > C[2] + 0.01 * scene.size else 0
        tops[name] = np.array([*(C + side * (X.mean(0) - C))[:2], max(C[2], X[:, 2].max())])
    order = np.argsort(_on_screen(ax, np.array(list(tops.values())))[:, 1])
    names = list(tops)
    for k in order.tolist():
        text = plain(names[k], 24)
        width, up = 6.2 * len(text) + 4, 2.0
        x, y = _on_screen(ax, tops[names[k]][None])[0] * points
        for _ in range(20):
            if all(
                abs(x - a) > (width + w) / 2 or abs(y + up - b) > 11 for a, b, w in taken
            ):
                break
            up += AWAY
        taken.append((x, y + up, width))
        X = tops[names[k]]
        rise = _on_screen(ax, np.array([X, X + [0, 0, 0.01 * scene.size]]))[:, 1]
        per_point = 0.01 * scene.size / max(float(np.ptp(rise)) * points, 1e-9)
        ax.text(
            *(X + [0, 0, min(up * per_point, scene.size)]), text, ha="center", va="bottom",
            fontsize=9, weight="bold", color=theme.ink, clip_on=False,
        )  # fmt: skip
