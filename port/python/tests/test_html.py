"""The page of a rig: what it says, that it is complete, and how a browser shows it."""

from __future__ import annotations

import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cli_scenes import STEREO, Recording, rows_of
from plot_scenes import ink, ring, stored

import rigcal
from rigcal import html as page_of
from rigcal.command import main
from rigcal.plots import _style

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def stereo_rig() -> rigcal.Rig:
    return rigcal.calibrate(STEREO / "cameras.csv", STEREO / "observations.csv")


@pytest.fixture(scope="module")
def stereo_page(stereo_rig: rigcal.Rig) -> str:
    return page_of.make_page(stereo_rig)


class Reader(html.parser.HTMLParser):
    """Tags with their attributes, and the text that is read."""

    VOID = ("meta", "br", "img", "circle", "path", "image", "use", "rect", "line")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, Any]]] = []
        self.text = ""
        self.open: list[str] = []
        self.cells: list[list[str]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: Any) -> None:
        self.tags.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "tr":
            self.cells.append([])
        if tag in ("td", "th"):
            self.cells[-1].append("")

    def handle_startendtag(self, tag: str, attributes: Any) -> None:
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag  # all is closed in its order

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("script", "style"):
            self.text += data
            if "td" in self.open or "th" in self.open:
                self.cells[-1][-1] += data


def read(page: str) -> Reader:
    reader = Reader(page)
    assert not reader.open
    return reader


# ---- what it says -------------------------------------------------------------------


def test_the_page_has_it_all(stereo_rig: rigcal.Rig, tmp_path: pathlib.Path) -> None:
    path = tmp_path / "rig.html"
    stereo_rig.html(path, "Stereo")
    reader = read(path.read_text("utf-8"))
    said = reader.text
    assert said.index("The views disagree") < said.index("What to do next")
    for part in stereo_rig.cause.partition("Next:")[0].split(". "):
        assert part.strip(" .") in said
    for part in stereo_rig.advice:
        assert part in said
    for head in ("The rig", "Cameras", "Residuals", "How well each view fits",
                 "Who saw the target together", "What may be wrong", "The program's report",
                 "How it was made"):  # fmt: skip
        assert head in said
    assert f"rigcal {rigcal.__version__}" in said
    assert "detections: observations.csv" in said
    assert stereo_rig.report.splitlines()[3] in said
    for name, sigma in stereo_rig.sigmas.items():
        (cells,) = [row for row in reader.cells if row[:1] == [name]]
        assert cells[7:9] == [f"{sigma.position:.3g}", f"{sigma.rotation_deg:.3g}"]
        centre = stereo_rig.cam_from_rig(name).center
        assert [float(x) for x in cells[4:7]] == pytest.approx(centre, rel=1e-4, abs=1e-12)
    faults = [row for row in reader.cells if row and row[0] == "board is bent"]
    assert len(faults) == 1
    assert len([tag for tag, _ in reader.tags if tag == "svg"]) == 4
    data = json.loads(re.search(r'id="lines">(.*?)</script>', path.read_text())[1])  # type: ignore[index]
    colours = [line[0] for line in data["lines"]]
    assert colours.count("c0") == 5  # a border and four edges
    assert colours.count("c1") == 8  # and three ellipses
    assert colours.count("faint") == 7
    assert [name for name, _ in data["names"]] == ["left", "right"]


def test_nothing_is_fetched_and_no_folder_is_named(
    stereo_rig: rigcal.Rig, tmp_path: pathlib.Path
) -> None:
    known = tmp_path / "my folder"
    known.mkdir()
    rig = replace(stereo_rig, warnings=[f"{tmp_path}/x/residuals.csv lists all of them"])
    rig.report = f"see {tmp_path}/y/rig.csv, and C:\\people\\me\\a.csv"
    rig.made = {"file": f"{tmp_path}/rig.bin", "camera": "/left/image"}
    page = page_of.make_page(rig)
    for folder in (
        str(tmp_path),
        os.fspath(pathlib.Path.home()) + "/",
        "people",
        os.getcwd(),
    ):
        assert folder not in page
    for name in ("residuals.csv", "rig.csv", "rig.bin", "a.csv", "/left/image"):
        assert name in page
    for tag, attributes in read(page).tags:
        assert tag not in ("link", "iframe", "object", "base")
        for key in ("src", "href", "action", "srcset"):
            value = attributes.get(key) or "#"
            assert value.startswith(("#", "data:image/jpeg;base64,"))
    assert not re.search(r"url\((?!#)|@import|@font-face|fetch\(|XMLHttp", page)
    assert "default-src 'none'" in page


def test_colours_are_variables(stereo_page: str) -> None:
    page = stereo_page
    for drawn in re.findall(r"<svg.*?</svg>", page, re.S):
        assert not re.search(r"#[0-9a-fA-F]{6}|rgb\(", drawn)
        assert "var(--" in drawn
    used = set(re.findall(r"var\(--([\w]+)\)", page)) - {"mark"}
    style = re.search(r"<style>(.*?)</style>", page, re.S)
    assert style
    light, dark = style[1].split("prefers-color-scheme:dark", 1)
    for name in used:
        assert f"--{name}:" in light
        assert f"--{name}:" in dark
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    for reference in re.findall(r'(?:url\(|href=")#([^")]*)', page):
        assert reference in ids


NASTY = ["<img src=x onerror=alert(1)>", "\"&'", "</script><b>", "$x_1$", "кам\N{CAMERA}",
         "\u202ex\x00\ud800", "/left/image", "_" * 200]  # fmt: skip


def test_names_are_text(tmp_path: pathlib.Path) -> None:
    rig = ring(len(NASTY), 3, names=NASTY, left_out=2)
    rig.made = {"<b>": "</ul>"}
    rig.html(tmp_path / "x.html", '<script>alert("t")</script>')
    page = (tmp_path / "x.html").read_bytes().decode("utf-8")
    reader = read(page)
    tags = [tag for tag, _ in reader.tags]
    assert tags.count("script") == 2  # the lines, and what turns them
    assert "img" not in tags
    assert "b" not in tags[tags.index("section") :]
    assert not any(key.startswith("on") for _, a in reader.tags for key in a)
    for name in NASTY[:5]:
        assert name in reader.text
    assert "\x00" not in page
    assert "\u202e" not in page
    data = json.loads(re.search(r'id="lines">(.*?)</script>', page)[1])  # type: ignore[index]
    assert data["names"][2][0] == NASTY[2]


def verdicts() -> dict[str, tuple[rigcal.Rig, str, str]]:
    good = ring(2, 3)
    parted = ring(2, 3)
    parted.calibrated._group[1] = 1
    return {
        "good": (good, "good", "The rig is good"),
        "out": (ring(3, 3, left_out=1), "warn", "after 1 view of 8 had to be left out"),
        "told": (replace(good, warnings=["odd; do this"]), "warn", "reservations below"),
        "none": (stored(), "none", "no recording"),
        "parted": (parted, "bad-one", "2 groups that have no frame in common"),
        "unknown": (replace(good, verdict=None, sqrt_f=None), "warn", "nothing could"),
        "joined": (
            replace(good, verdict=None, warnings=["the rig is joined but not adjusted"]),
            "bad-one",
            "could not be adjusted together",
        ),
        "little": (replace(good, verdict="found", sqrt_f=2.0), "warn", "2 times more"),
        "explained": (
            replace(good, verdict="explained", sqrt_f=9.0),
            "bad-one",
            "is found",
        ),
        "why": (replace(good, verdict="unexplained", sqrt_f=9.0), "bad-one", "none of the"),
    }


@pytest.mark.parametrize("case", verdicts())
def test_the_verdict_is_a_sentence(case: str) -> None:
    rig, kind, words = verdicts()[case]
    found, sentence = page_of.headline(rig)
    assert found == kind
    assert words in sentence
    assert max(map(len, (s.split() for s in re.split(r"[.:] ", sentence)))) <= 25
    told = page_of.advice(rig)
    assert told == {"good": ["nothing: save the rig, and use it"], "told": ["do this"],
                    "out": ["look at it"]}.get(case, told)  # fmt: skip


def test_clocks_and_left_out_views() -> None:
    recording = Recording(late={"c": 0.012})
    rig = rigcal.calibrate(
        recording.cameras, recording.rows, times=recording.times, clocks=True
    )
    reader = read(page_of._clocks(rig))
    (clock,) = [r for r in reader.cells if r[0] == "c"]
    assert float(clock[1]) == pytest.approx(1e3 * rig.clocks["c"].offset, abs=0.01)
    assert rig.made["options"] == "--clocks --times=times.csv"
    recording = Recording()
    recording.spoil("100", "b")
    with pytest.warns(rigcal.Caveat):
        rig = rigcal.calibrate(recording.cameras, recording.rows)
    assert [(v.camera, v.frame) for v in rig.left_out] == [("b", "100")]
    reader = read(page_of.make_page(rig))
    (lost,) = [r for r in reader.cells if r[:2] == ["b", "100"]]
    assert lost[2:] == [rig.left_out[0].why, rig.left_out[0].advice]
    assert rig.warnings[0] in reader.text


def test_thumbnails_have_the_residuals(tmp_path: pathlib.Path) -> None:
    from matplotlib.image import imsave

    rig = ring(3, 5, left_out=1)
    image = np.random.default_rng(0).integers(0, 255, (720, 1280), dtype=np.uint8)
    imsave(tmp_path / "a.png", image, cmap="gray")
    (tmp_path / "b.png").write_bytes(b"no image")
    keys = [(str(v["camera"]), str(v["frame"])) for v in rig.views]
    rig.images = {key: image for key in keys}
    page = page_of.make_page(rig)
    reader = read(page)
    assert page.count("data:image/jpeg;base64,") == page_of.THUMBS_MOST
    assert reader.text.count("left out") >= 1
    (lost,) = rig.left_out
    assert f"{lost.camera} in {lost.frame}: left out" in reader.text
    assert page.count("<circle") == 2 * 12 * page_of.THUMBS_MOST
    rig.images = {keys[k]: tmp_path / name for k, name in enumerate(["a.png", "b.png"] * 7)}
    body = read(page_of._thumbs(rig)).text
    assert "b.png" not in body.partition("No image of")[0]
    assert ": this is no image" in body
    assert str(tmp_path) not in body
    rig.images = {("cam0", "99"): image}
    assert "No image of" in read(page_of._thumbs(rig)).text


# ---- the file -----------------------------------------------------------------------


def test_the_size_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = ring(8, 125, points=30)
    assert len(rig.views) == 999
    rig.report = "x" * 300_000
    page = page_of.make_page(rig)
    assert len(page.encode()) < 1_500_000 < page_of.BYTES_MOST
    assert "characters are left out" in page
    assert "too large" not in page
    small = ring(2, 2)
    small.report = "x" * 90_000
    monkeypatch.setattr(page_of, "BYTES_MOST", 85_000)
    less = page_of.make_page(small)
    assert len(less.encode()) < 85_000
    assert "the page would be too large" in less
    monkeypatch.setattr(page_of, "BYTES_MOST", 1000)
    with pytest.raises(rigcal.Error, match="too large for a page of 1000 bytes"):
        page_of.make_page(small)


def test_it_is_there_whole_or_not_at_all(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, path = ring(2, 2), tmp_path / "rig.html"
    path.write_text("before")

    def fails(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fails)
        with pytest.raises(rigcal.FileError, match=r"rig\.html: No space left"):
            rig.html(path)
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["rig.html"]
    rig.html(path)
    assert path.read_text("utf-8").endswith("</html>\n")
    assert [p.name for p in tmp_path.iterdir()] == ["rig.html"]
    umask = os.umask(0)
    os.umask(umask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~umask
    for bad, words in (
        (tmp_path, "this is a folder"),
        (tmp_path / "no" / "x", "no folder"),
    ):
        with pytest.raises(rigcal.FileError, match=words):
            rig.html(bad)


def test_two_pages_of_one_rig_are_the_same(
    stereo_rig: rigcal.Rig, stereo_page: str
) -> None:
    assert page_of.make_page(stereo_rig) == stereo_page


# ---- the command --------------------------------------------------------------------


def test_report_and_html_of_the_command(tmp_path: pathlib.Path, capfd: Any) -> None:
    out, page = tmp_path / "out", tmp_path / "a.html"
    files = [
        f"--cameras={STEREO}/cameras.csv",
        "--observations",
        f"{STEREO}/observations.csv",
    ]
    arguments = ["calibrate", *files, "--out", str(out), "--sigma", "0.2"]
    assert main(arguments) == 0
    plain = capfd.readouterr().out
    assert main([*arguments, "--html", str(page), "--title", "A & B"]) == 0
    said = capfd.readouterr()
    assert said.out == plain
    assert str(page) in said.err
    reader = read(page.read_text())
    assert "A & B" in reader.text
    assert "options: --sigma=0.2" in reader.text
    assert plain.splitlines()[5] in reader.text
    assert main(["report", str(out), f"--out={tmp_path}/b.html", "--title=B"]) == 0
    assert capfd.readouterr().out == f"{tmp_path}/b.html\n"
    rows = [r for r in read((tmp_path / "b.html").read_text()).cells if r[:1] == ["right"]]
    assert rows[0] == next(r for r in reader.cells if r[:1] == ["right"])
    assert main(["report", str(out / "rig.bin"), "--out", str(tmp_path / "c.html")]) == 0
    assert "no recording" in (tmp_path / "c.html").read_text()
    capfd.readouterr()
    for words, what in (
        (["report"], "required: FOLDER|FILE"),
        (["report", "a", "b"], "one folder of calibrate --out"),
        (["report", f"{tmp_path}/no"], "no"),
        (["report", str(out), "--out", "/no/x.html"], "there is no folder"),
        (["calibrate", *files, "--html", "/no/x.html"], "there is no folder"),
        (["calibrate", *files, "--html"], "--html: expected one argument"),
        (["calibrate", files[0], f"--html={page}"], "--observations"),
        (["calibrate", *files, f"--html={page}", "--wrong"], "wrong"),
    ):
        assert main(words) == 2
        assert what in capfd.readouterr().err
    bad = rows_of(STEREO / "observations.csv")[:0]
    assert bad == []
    (tmp_path / "o.csv").write_text("frame,camera,point,X,Y,Z,u,v\n")
    assert main(["calibrate", files[0], f"--observations={tmp_path}/o.csv",
                 f"--html={tmp_path}/d.html"]) != 0  # fmt: skip
    assert not (tmp_path / "d.html").exists()
    assert main(["--help"]) == 0
    assert "the C program by itself has no --html" in capfd.readouterr().out


# ---- a browser ----------------------------------------------------------------------


def browser() -> str:
    for name in ("chromium-headless-shell", "chromium", "google-chrome"):
        if shutil.which(name):
            return name
    pytest.fail("no Chromium: apt-get install chromium-headless-shell")


# A script that reports where the pictures of a page are, and what they show.
PROBE = """<script>addEventListener("load",function(){setTimeout(function(){
var found=[];document.querySelectorAll("svg,canvas").forEach(function(e){
var b=e.getBoundingClientRect();
if(b.width)found.push([e.tagName.toLowerCase(),b.left,b.top,b.right,b.bottom])});
document.body.dataset.found=JSON.stringify({boxes:found,wide:innerWidth,
over:document.documentElement.scrollWidth,high:document.querySelector('main').offsetHeight,
paper:getComputedStyle(document.body).backgroundColor});},300)})</script>"""
LIGHT, DARK = (
    "--blink-settings=preferredColorScheme=1",
    "--blink-settings=preferredColorScheme=0",
)
WIDE, HIGH = 1000, 6000


def opened(page: pathlib.Path, *flags: str, width: int = WIDE) -> tuple[str, str]:
    """Runs the browser on a page. Returns its document and its messages."""
    run = subprocess.run(
        [browser(), "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         f"--window-size={width},{HIGH}", "--enable-logging=stderr", "--v=0",
         "--virtual-time-budget=1500", *flags, page.as_uri()],
        capture_output=True, text=True, timeout=120, errors="replace",
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    console = [line for line in run.stderr.splitlines() if "CONSOLE" in line]
    return run.stdout, "\n".join(console)


def look(
    page: pathlib.Path, folder: pathlib.Path, scheme: str, *flags: str, **how: Any
) -> Any:
    """Boxes of the pictures of a page, and its screenshot."""
    from matplotlib.image import imread

    probed = folder / f"probe-{page.name}"
    probed.write_text(
        page.read_text("utf-8").replace("</body>", PROBE + "</body>"), "utf-8"
    )
    document, console = opened(probed, scheme, "--dump-dom", **how)
    assert console == ""
    found = re.search(r'data-found="([^"]*)"', document)
    assert found
    shot = folder / "shot.png"
    _, console = opened(page, scheme, f"--screenshot={shot}", *flags, **how)
    assert console == ""
    image = (imread(shot)[..., :3] * 255).round().astype(int)
    return json.loads(found[1].replace("&quot;", '"')), image, document


def inks(found: Any, image: Any) -> list[float]:
    h, w = image.shape[:2]
    return [
        ink(image, (left / w, top / h, min(right, w) / w, min(bottom, h) / h))
        for _, left, top, right, bottom in found["boxes"]
        if bottom < h and left < w
    ]


@pytest.mark.parametrize("scheme", [LIGHT, DARK])
def test_a_browser_shows_every_picture(
    stereo_page: str, tmp_path: pathlib.Path, scheme: str
) -> None:
    page = tmp_path / "rig.html"
    page.write_text(stereo_page, "utf-8")
    found, image, document = look(page, tmp_path, scheme)
    paper = (_style.LIGHT if scheme == LIGHT else _style.DARK)["paper"]
    expected = [int(paper[k : k + 2], 16) for k in (1, 3, 5)]
    assert found["paper"] == f"rgb({', '.join(map(str, expected))})"
    assert image[5, 5].tolist() == expected
    assert [kind for kind, *_ in found["boxes"]] == ["canvas", "svg", "svg", "svg"]
    assert found["high"] < HIGH
    assert found["over"] <= found["wide"]
    assert min(inks(found, image)) > 0.01
    for text in ("Who saw the target together", "left", "right"):
        assert text in document
    # Each picture must have the theme's paper, light or dark, as its most frequent pixel.
    for _, left, top, right, bottom in found["boxes"]:
        part = image[int(top) + 2 : int(bottom) - 2, int(left) + 2 : int(right) - 2]
        assert (part == expected).all(-1).mean() > 0.3


def test_a_browser_without_scripts_and_a_narrow_one(
    stereo_page: str, tmp_path: pathlib.Path
) -> None:
    page = tmp_path / "rig.html"
    names = ring(5, 3, names=NASTY[:5], left_out=1)
    names.html(page)
    found, image, document = look(page, tmp_path, LIGHT, width=420)
    assert found["over"] <= found["wide"]  # tables and pictures scroll by themselves
    assert min(inks(found, image)) > 0.005
    assert "alert(1)&gt;" in document
    from matplotlib.image import imread

    shot = tmp_path / "still.png"
    still = stereo_page.replace("script-src 'unsafe-inline'", "script-src 'none'")
    page.write_text(still, "utf-8")
    opened(page, LIGHT, f"--screenshot={shot}")
    image = (imread(shot)[..., :3] * 255).round().astype(int)
    top = 0.06  # the still picture stands where the canvas would
    assert ink(image, (0.05, top, 0.95, 0.18)) > 0.01


def test_an_error_of_a_page_would_be_seen(tmp_path: pathlib.Path) -> None:
    page = tmp_path / "bad.html"
    page.write_text("<!DOCTYPE html><script>undefinedFunction()</script>")
    assert "undefinedFunction" in opened(page, "--dump-dom")[1]
