"""The site that build.sh made: it has every public name, and every page has text."""

from __future__ import annotations

import enum
import html.parser
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import zlib
from typing import Any

import conftest
import pytest
import scenes
from sybil import Sybil

import rigcal

HTML = pathlib.Path(os.environ.get("RIGCAL_DOCS", "nowhere"))
PAGES = sorted(HTML.glob("**/*.html"))
NAMES = sorted(set(rigcal.__all__) - {"__version__"})


def test_the_site_is_built() -> None:
    names = {page.relative_to(HTML).as_posix() for page in PAGES}
    assert {"index.html", "quickstart.html", "conventions.html", "command.html"} <= names
    assert len(names) >= 17


@pytest.mark.filterwarnings("ignore::rigcal.Caveat")
@pytest.mark.parametrize("name", ["README.md", "DETECT.md", "FORMATS.md"])
def test_the_snippets_of_a_page_beside_run(name: str) -> None:
    path = pathlib.Path(__file__).resolve().parents[1] / name
    document = Sybil(conftest.PARSERS).parse(path)
    conftest.setup(document.namespace)
    try:
        scenes.everything()
        ran = [example.evaluate() for example in document.examples()]
    finally:
        conftest.teardown(document.namespace)
    assert ran


# ---- the reference -----------------------------------------------------------------


def inventory() -> set[str]:
    """The names in Sphinx's objects.inv, which the site describes."""
    data = (HTML / "objects.inv").read_bytes()
    lines = zlib.decompress(data.split(b"\n", 4)[4]).decode().splitlines()
    return {line.split(" ", 1)[0] for line in lines if " py:" in line}


def own_members(owner: Any) -> list[str]:
    """Public methods and properties that a class of rigcal defines."""
    return [
        name
        for name, member in vars(owner).items()
        if not name.startswith("_")
        and (
            inspect.isroutine(member)
            or isinstance(member, (property, classmethod, staticmethod))
        )
        and not isinstance(member, type(min))
    ]


def is_own(name: str) -> bool:
    return inspect.isclass(getattr(rigcal, name)) and not issubclass(
        getattr(rigcal, name), enum.Enum
    )


CLASSES = [name for name in NAMES if is_own(name)]


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_has_a_docstring(name: str) -> None:
    obj = getattr(rigcal, name)
    text = vars(obj).get("__doc__") if inspect.isclass(obj) else inspect.getdoc(obj)
    assert text
    assert len(text.split()) >= 3
    assert not text.startswith(f"{name}("), "made by dataclass or NamedTuple"


@pytest.mark.parametrize("name", CLASSES)
def test_its_methods_have_docstrings(name: str) -> None:
    owner = getattr(rigcal, name)
    bare = [
        m
        for m in own_members(owner)
        if not inspect.getdoc(inspect.getattr_static(owner, m))
    ]
    assert bare == []


def test_the_reference_has_every_public_name() -> None:
    there = inventory()
    assert [name for name in NAMES if f"rigcal.{name}" not in there] == []
    members = [
        f"rigcal.{name}.{m}" for name in CLASSES for m in own_members(getattr(rigcal, name))
    ]
    assert [name for name in members if name not in there] == []


def test_it_has_no_name_that_is_not_public() -> None:
    heads = {name.split(".")[1] for name in inventory() if "." in name}
    modules = {name for name in heads if inspect.ismodule(getattr(rigcal, name))}
    assert sorted(heads - modules - set(NAMES)) == []


# ---- the pages ---------------------------------------------------------------------


class Page(html.parser.HTMLParser):
    """The words of a page's article, its links and pictures."""

    def __init__(self, path: pathlib.Path) -> None:
        super().__init__()
        self.words: list[str] = []
        self.links: list[str] = []
        self.ids: set[str] = set()
        self.depth = 0
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.depth += tag == "article"
        self.ids.add(values.get("id") or "")
        self.links += [values[k] or "" for k in ("href", "src") if k in values]

    def handle_endtag(self, tag: str) -> None:
        self.depth -= tag == "article"

    def handle_data(self, data: str) -> None:
        if self.depth:
            self.words += data.split()


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_page_says_something_and_its_links_lead_somewhere(path: pathlib.Path) -> None:
    page = Page(path)
    if path.stem not in ("search", "genindex", "py-modindex", "index"):
        assert len(page.words) > 60
    for link in page.links:
        place, _, anchor = link.partition("#")
        place = place.partition("?")[0]
        if re.match(r"[a-z]+:", link):
            continue
        target = (path.parent / place) if place else path
        assert target.exists(), link
        if anchor and target.suffix == ".html":
            assert anchor in Page(target).ids, link


def test_the_page_of_the_command_is_its_help() -> None:
    assert "--estimate-intrinsics" in Page(HTML / "command.html").words[-2000:]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["conventions", "quickstart"])
def test_a_page_is_drawn(name: str, scheme: str, tmp_path: pathlib.Path) -> None:
    """In Chromium a page must show several colours, and be dark in the dark theme."""
    import matplotlib.image

    known = ("chromium-headless-shell", "chromium", "google-chrome")
    program = next(filter(None, map(shutil.which, known)), None)
    assert program, "no Chromium: apt-get install chromium-headless-shell"
    picture = tmp_path / "page.png"
    subprocess.run(
        [
            program, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
            "--window-size=1000,1400", f"--user-data-dir={tmp_path}/profile",
            f"--blink-settings=preferredColorScheme={int(scheme == 'light')}",
            f"--screenshot={picture}", (HTML / f"{name}.html").as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )  # fmt: skip
    image = matplotlib.image.imread(picture)[..., :3]
    assert (image.mean() > 0.8) if scheme == "light" else (image.mean() < 0.3)
    rows = image.reshape(len(image), -1)
    assert (rows.std(axis=1) > 0.01).mean() > 0.5  # text or drawing in most rows
    colours = len({tuple(c) for c in (image[::4, ::4].reshape(-1, 3) * 31).astype(int)})
    assert colours > 20
