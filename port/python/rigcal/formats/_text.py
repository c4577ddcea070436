"""From bytes to named values, and back: YAML, JSON, TOML, XML, Python's literals.

Every parser refuses a name that occurs twice in one place. Errors of other parsers become
an Error with their line."""

from __future__ import annotations

import ast
import json
import re
import sys
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any, Callable

import yaml

from ..errors import Error
from ..transform import Array

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

YAML_MAX = 4 << 20  # bytes: PyYAML reads about 0.3 MB a second
DEPTH_MAX = 100  # brackets: PyYAML takes a time that grows with their square
TOO_DEEP = "nested too deeply"


def decode(data: bytes) -> str:
    """Text in UTF-8, with or without a byte-order mark."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        raise Error(f"byte {e.start} is not text in UTF-8") from None
    if "\0" in text:
        raise Error("there is a zero byte: the file is no text")
    if not text.strip():
        raise Error("the file is empty")
    return text


def _unique(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    names: dict[Any, Any] = {}
    for name, value in pairs:
        if name in names:
            raise Error(f"{name} is there twice")
        names[name] = value
    return names


# ==== JSON, Python's literals, TOML ===========================================


def parse_json(text: str) -> Any:
    try:
        return json.loads(text, object_pairs_hook=_unique)
    except json.JSONDecodeError as e:
        raise Error(f"line {e.lineno}: no JSON: {e.msg}") from None
    except RecursionError:
        raise Error(f"no JSON: {TOO_DEEP}") from None
    except Error:
        raise
    except ValueError as e:  # a whole number of thousands of digits
        raise Error(f"no JSON: {e}") from None


def dump_json(value: Any) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def parse_literal(text: str) -> Any:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(text.strip(), mode="eval")
        for node in ast.walk(tree):
            if isinstance(node, ast.Dict):
                _unique([(getattr(k, "value", k), None) for k in node.keys])
        return ast.literal_eval(tree)
    except SyntaxError as e:
        raise Error(f"line {e.lineno}: no Python dictionary: {e.msg}") from None
    except Error:
        raise
    except (RecursionError, MemoryError):
        raise Error(f"no Python dictionary: {TOO_DEEP}") from None
    except (ValueError, TypeError):
        raise Error("no Python dictionary: only names and values are expected") from None


def parse_toml(text: str) -> Any:
    try:
        return tomllib.loads(text)
    except ValueError as e:
        raise Error(f"no TOML: {e}") from None
    except RecursionError:
        raise Error(f"no TOML: {TOO_DEEP}") from None


def dump_toml(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """Tables by their dotted names. JSON's lists, numbers and texts are TOML's too."""
    lines = []
    for name, table in tables.items():
        lines.append(f"[{name}]")
        lines += [f"{key} = {json.dumps(value)}" for key, value in table.items()]
        lines.append("")
    return "\n".join(lines)


def toml_key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)


# ==== YAML, OpenCV's among it =================================================

MATRIX_TAG = "tag:yaml.org,2002:opencv-matrix"


class _Loader(yaml.SafeLoader):
    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        if isinstance(node, yaml.MappingNode):
            names = [key.value for key, _ in node.value if isinstance(key.value, str)]
            for name in names:
                if names.count(name) > 1:
                    raise Error(f"line {node.start_mark.line + 1}: {name} is there twice")
        return super().construct_mapping(node, deep=deep)


def _matrix(loader: Any, node: Any) -> Any:
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor(MATRIX_TAG, _matrix)


class Matrix(dict[str, Any]):
    """To be written as a matrix of OpenCV: rows, cols, dt, data."""

    def __init__(self, array: Array) -> None:
        rows, cols = array.shape
        super().__init__(rows=rows, cols=cols, dt="d", data=array.ravel().tolist())


class _Dumper(yaml.SafeDumper):
    pass


def _represent(dumper: Any, matrix: Matrix) -> Any:
    return dumper.represent_mapping(MATRIX_TAG, dict(matrix), flow_style=False)


_Dumper.add_representer(Matrix, _represent)


def _depth(text: str) -> int:
    """The deepest nesting of brackets, wherever they are."""
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", text):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    return deepest


def parse_yaml(text: str) -> Any:
    """The first document. OpenCV's "%YAML:1.0" is no YAML and left out."""
    if len(text) > YAML_MAX:
        raise Error(f"more than {YAML_MAX >> 20} MB of YAML: that is no camera file")
    if _depth(text) > DEPTH_MAX:
        raise Error(f"no YAML: {TOO_DEEP}")
    text = re.sub(r"\A%YAML:[^\n]*", "", text.lstrip())
    try:
        return next(yaml.load_all(text, Loader=_Loader), None)
    except yaml.MarkedYAMLError as e:
        line = f"line {e.problem_mark.line + 1}: " if e.problem_mark else ""
        raise Error(f"{line}no YAML: {e.problem}") from None
    except yaml.YAMLError as e:
        raise Error(f"no YAML: {' '.join(str(e).split())}") from None
    except RecursionError:
        raise Error(f"no YAML: {TOO_DEEP}") from None
    except Error:
        raise
    except (ValueError, TypeError) as e:  # PyYAML's own of dates and unusual names
        raise Error(f"no YAML: {e}") from None


def dump_yaml(value: Any) -> str:
    text: str = yaml.dump(
        value, Dumper=_Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True
    )
    return text


# ==== XML of OpenCV ===========================================================


def parse_xml(text: str) -> Any:
    if "<!" in re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL):
        raise Error("declarations (<!...) are not expected in XML of OpenCV")
    try:
        root = ET.fromstring(text)
    except ET.ParseError as e:
        raise Error(f"line {e.position[0]}: no XML: {e}") from None
    if root.tag != "opencv_storage":
        raise Error(f"opencv_storage is expected in XML, not {root.tag}")
    try:
        return _xml_value(root)
    except RecursionError:
        raise Error(f"no XML: {TOO_DEEP}") from None


def _xml_value(element: ET.Element) -> Any:
    children = list(element)
    if children and all(child.tag == "_" for child in children):
        return [_xml_value(child) for child in children]
    if children or element.tag == "opencv_storage":
        return _unique([(child.tag, _xml_value(child)) for child in children])
    text = (element.text or "").strip()
    if text.startswith('"') and text.endswith('"') and len(text) > 1:
        return text[1:-1]
    words = text.split()
    return words[0] if len(words) == 1 and element.tag != "data" else words


def dump_xml(values: Mapping[str, Any]) -> str:
    root = ET.Element("opencv_storage")
    for name, value in values.items():
        element = ET.SubElement(root, name)
        if isinstance(value, Matrix):
            element.set("type_id", "opencv-matrix")
            for part in ("rows", "cols", "dt"):
                ET.SubElement(element, part).text = str(value[part])
            words = [repr(v) for v in value["data"]]
            ET.SubElement(element, "data").text = " ".join(words)
        elif isinstance(value, str):
            element.text = f'"{value}"'
        else:
            element.text = str(value)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


Parser = Callable[[str], Any]
PARSERS: dict[str, Parser] = {
    "json": parse_json,
    "python": parse_literal,
    "toml": parse_toml,
    "yaml": parse_yaml,
    "xml": parse_xml,
}
