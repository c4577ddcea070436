#!/usr/bin/env python3
"""Lays out every package of port/package.sh and reads its manifest.

The version is the header's, the sources are those of RIGCAL_PARTS in CMakeLists.txt,
each once, the headers are those of include/, every file named is there, and the fields
are what the format demands: restated here from the formats' own descriptions, because not every
one of them has a tool that can be had everywhere (tests/ways/run.sh runs those
that can).
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
URL = "https://example.org/rigcal"

ARDUINO_CATEGORIES = {
    "Display", "Communication", "Signal Input/Output", "Sensors", "Device Control",
    "Timing", "Data Storage", "Data Processing", "Other"}
# The children of <package> that the schema has; the required ones first.
PDSC_DEMANDED = ["name", "vendor", "description", "url", "releases"]
PDSC_ALLOWED = set(PDSC_DEMANDED) | {
    "license", "licenseSets", "keywords", "taxonomy", "components", "conditions",
    "requirements", "repository", "changelogs", "apis", "examples"}
PDSC_COMPONENT = {"deprecated", "description", "RTE_Components_h", "Pre_Include_Global_h",
                  "Pre_Include_Local_Component_h", "files"}


def version():
    text = (ROOT / "include/rigcal.h").read_text()
    return ".".join(re.search(rf"#define RIGCAL_VERSION_{part} +(\d+)", text)[1]
                    for part in ("MAJOR", "MINOR", "PATCH"))


def sources():
    text = (ROOT / "CMakeLists.txt").read_text()
    layers, parts = (re.search(rf"set\({name}\s+([^)]*)\)", text)[1]
                     for name in ("RIGCAL_LAYERS", "RIGCAL_PARTS"))
    return [f"src/rigcal_{part}.c"
            for part in parts.replace("${RIGCAL_LAYERS}", layers).split()]


def headers():
    return sorted(f"include/{path.name}" for path in (ROOT / "include").glob("*.h"))


def fields(text, separator):
    """Reads lines "name: value" or "name=value" without nesting."""
    found = {}
    for line in text.splitlines():
        m = re.match(rf"(\w+)\s*{separator}\s*(.*?)\s*$", line)
        if m:
            found[m[1]] = m[2].strip('"')
    return found


def missing(found, names, where):
    for name in names:
        if not found.get(name):
            yield f"{where} has no {name}"


def arduino(folder):
    p = fields((folder / "library.properties").read_text(), "=")
    yield p.get("version")
    yield from missing(p, ["name", "version", "author", "maintainer", "sentence", "paragraph",
                           "category", "url", "architectures"], "library.properties")
    if not re.fullmatch(r"[A-Za-z0-9][\w .-]{0,62}", p.get("name", "")):
        yield "library.properties: name"
    if p.get("category") not in ARDUINO_CATEGORIES:
        yield f"library.properties: there is no category {p.get('category')}"
    if p.get("url") != URL:
        yield "library.properties: url is not the one asked for"
    for header in p.get("includes", "").split(","):
        if not (folder / "src" / header).is_file():
            yield f"library.properties includes {header}"
    for sketch in (folder / "examples").iterdir():
        if not (sketch / (sketch.name + ".ino")).is_file():
            yield f"examples/{sketch.name} has no {sketch.name}.ino"


def cmsis_pack(folder):
    path, = folder.glob("*.pdsc")
    package = ElementTree.parse(path).getroot()
    yield package.find("releases/release").get("version")
    for tag in PDSC_DEMANDED:
        if package.find(tag) is None:
            yield f"{path.name} has no {tag}"
    if not re.fullmatch(r"\d+\.\d+(\.\d+)?", package.get("schemaVersion", "")):
        yield f"{path.name} has no schemaVersion"
    tags = [child.tag for child in package]
    if len(tags) != len(set(tags)) or set(tags) - PDSC_ALLOWED:
        yield f"{path.name}: a child of package is unknown or there twice"
    if not package.findtext("description", "").strip():
        yield f"{path.name}: the description is empty"
    vendor, name = package.findtext("vendor"), package.findtext("name")
    if path.name != f"{vendor}.{name}.pdsc" or not re.fullmatch(r"[\w-]+\.[\w-]+", f"{vendor}.{name}"):
        yield f"{path.name} is of {vendor}, {name}"
    if package.findtext("url") != URL:
        yield f"{path.name}: url is not the one asked for"
    classes = {d.get("Cclass") for d in package.findall("taxonomy/description")}
    for component in package.findall("components/component"):
        variant = component.get("Cvariant")
        yield from missing(component.attrib, ["Cclass", "Cgroup", "Cversion"], f"component {variant}")
        if component.get("Cclass") not in classes:
            yield f"component {variant}: its Cclass is not in the taxonomy"
        if component.get("Cversion") != version():
            yield f"component {variant} is of version {component.get('Cversion')}"
        if {child.tag for child in component} - PDSC_COMPONENT or not component.findtext("description"):
            yield f"component {variant}: an element that the schema does not know, or no description"
        files = [(f.get("category"), f.get("name")) for f in component.findall("files/file")]
        for category, file in files:
            if not (folder / file).is_file():
                yield f"component {variant} names {file}, which is not there"
        if sorted(f for c, f in files if c == "sourceC") != sorted(sources()):
            yield f"component {variant} does not list each source once"
        if sorted(f for c, f in files if c == "header") != headers():
            yield f"component {variant} does not list each header once"


def conan(folder):
    recipe = (folder / "conanfile.py").read_text()
    yield re.search(r'^    version = "(.*)"', recipe, re.M)[1]
    for pattern in re.search(r"exports_sources = (.*)", recipe)[1].split(", "):
        if not list(folder.glob(pattern.strip('"'))):
            yield f"conanfile.py exports {pattern}, which is not there"


def esp_idf(folder):
    manifest = fields((folder / "idf_component.yml").read_text(), ":")
    yield manifest.get("version")
    yield from missing(manifest, ["version", "description", "license"], "idf_component.yml")


def meson(folder):
    text = (folder / "meson.build").read_text()
    yield re.search(r"\bversion: '(.*)'", text)[1]
    if sorted(re.findall(r"'(src/.*)'", text)) != sorted(sources()):
        yield "meson.build does not list each source once"
    if sorted(re.findall(r"'(include/.*)'", text)) != headers():
        yield "meson.build does not install each header once"


def platformio(folder):
    manifest = json.loads((folder / "library.json").read_text())
    yield manifest.get("version")
    yield from missing(manifest, ["name", "version", "description", "keywords", "license"], "library.json")
    for key in ("srcDir", "includeDir"):
        if not (folder / manifest["build"][key]).is_dir():
            yield f"library.json: {key} is not there"
    for header in manifest["headers"]:
        if not (folder / manifest["build"]["includeDir"] / header).is_file():
            yield f"library.json: {header} is not there"


def zephyr(folder):
    yield None
    module = (folder / "zephyr/module.yml").read_text()
    for key, inside in (("cmake", "CMakeLists.txt"), ("kconfig", "")):
        named = re.search(rf"^  {key}: (\S+)$", module, re.M)
        if not named or not (folder / named[1] / inside).is_file():
            yield f"module.yml: {key}"


WAYS = {"arduino": arduino, "cmsis-pack": cmsis_pack, "conan": conan, "esp-idf": esp_idf,
        "meson": meson, "platformio": platformio, "zephyr": zephyr}


def check(way, folder):
    done = subprocess.run(["sh", ROOT / "port/package.sh", way, folder, URL],
                          capture_output=True, text=True)
    if done.returncode:
        yield done.stderr
        return
    findings = WAYS[way](folder)
    stated = next(findings)
    if stated not in (version(), None):
        yield f"its version is {stated}, the header's {version()}"
    yield from findings

    for path in folder.rglob("*"):
        if path.is_file() and re.search(r"@[A-Z]+@", path.read_text()):
            yield f"{path.name} holds a place that was not filled"
    laid = {p.name for p in (folder / "src").iterdir()}
    kept = {p.name for p in (ROOT / "src").iterdir()}
    if kept - laid or {pathlib.Path(s).name for s in sources()} - laid:
        yield "a file of src/ or a layer's is not there"
    public = folder / ("src" if way == "arduino" else "include")
    if {pathlib.Path(h).name for h in headers()} - {p.name for p in public.glob("*.h")}:
        yield "a header of include/ is not there"
    if not (folder / "LICENSE").is_file() or not (folder / "README.md").is_file():
        yield "no LICENSE or no README.md"


def main():
    bad = []
    for way in WAYS:
        with tempfile.TemporaryDirectory() as work:
            bad += [f"{way}: {text}" for text in check(way, pathlib.Path(work, "rigcal"))]
    others = {p.parent.name for p in (ROOT / "port").glob("*/README.md")}
    bad += [f"{way}: port/{way} has no README.md" for way in WAYS if way not in others]
    for text in bad:
        print(text)
    if bad:
        sys.exit(f"check_manifests: {len(bad)} faults")
    print(f"{len(WAYS)} manifests of version {version()}, {len(headers())} headers, "
          f"{len(sources())} sources")


if __name__ == "__main__":
    main()
