"""Sphinx: build.sh runs it in a copy of this folder, with the package installed."""

from __future__ import annotations

import enum
import inspect
import re
from typing import Any

import rigcal

project = "rigcal"
version = release = rigcal.__version__
copyright = "the authors of rigcal, MIT licence"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["README.md"]
myst_enable_extensions = ["attrs_inline"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

html_theme = "furo"
html_title = f"rigcal {release}"
html_static_path = ["_static"]
html_css_files = ["rigcal.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "friendly", "github-dark"

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True}

# Docstrings are plain text in columns: "name  what it is". Here they become lists.
ROW = re.compile(r"^(\S.*?)\s{2,}(\S.*)$")


def escaped(text: str) -> str:
    """Plain text as reStructuredText: `names` as code, nothing else is markup."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(
        f"``{part[1:-1]}``" if part.startswith("`") else re.sub(r"([\\*_|])", r"\\\1", part)
        for part in parts
    )


def as_rows(lines: list[str]) -> list[tuple[str, str]] | None:
    """The rows (name, what it is) of a paragraph in columns; None: it is not such a
    paragraph."""
    rows: list[tuple[str, str]] = []
    column = 0
    for line in lines:
        found = ROW.match(line)
        if found:
            column = found.start(2)
            rows.append((found[1], found[2]))
        elif rows and line.startswith(" "):
            rows[-1] = (rows[-1][0], f"{rows[-1][1]} {line.strip()}")
        elif rows and line[column - 1 : column] == " " and line[:column].strip(" ,"):
            rows.append((line[:column].strip(), line[column:]))  # a name of full length
        elif rows:
            rows.append(("", line))
        else:
            return None
    return rows


def paragraphs(lines: list[str]) -> list[list[str]]:
    """Cuts the text at empty lines, and where columns begin."""
    found: list[list[str]] = [[]]
    for line in lines:
        if not line.strip():
            found.append([])
        else:
            found[-1].append(line.rstrip())
    return [part for part in found if part]


def tidy(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """autodoc-process-docstring"""
    made: list[str] = []
    for part in paragraphs(lines):
        rows = as_rows(part)
        if all(line.startswith("    ") for line in part):
            made += ["::", "", *part, ""]
        elif rows is None:
            made += [escaped(" ".join(line.strip() for line in part)), ""]
        else:
            for head, text in rows:
                made += (
                    [f"``{head}``", f"    {escaped(text)}"]
                    if head
                    else ["", escaped(text), ""]
                )
            made.append("")
    lines[:] = made


def skip(
    app: Any, what: str, name: str, obj: Any, is_skipped: bool, options: Any
) -> bool | None:
    """Fields of named tuples and of data classes are in the docstring of their class."""
    text = inspect.getdoc(obj) or ""
    if text.startswith("Alias for field number") or isinstance(obj, enum.Enum):
        return True
    return None


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", tidy)
    app.connect("autodoc-skip-member", skip)
