"""Read a well-formed XML tree: bounded, without entities, network or DOCTYPE; the only module that uses lxml."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError, did_you_mean

MAX_URDF_BYTES = 5_000_000
"""Largest size of a URDF [bytes]: usual ones have about 100 kB; meshes are in files of their own."""

MAX_ATTRIBUTES = 1000
"""Largest number of attributes of an element; a URDF has no more than six."""

_ENCODING = re.compile(rb"""^\s*<\?xml[^>]*?encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_DOCTYPE = re.compile(r"(?:\s|<\?.*?\?>|<!--.*?-->)*+<!(?!--)", re.DOTALL)
"""A DOCTYPE can be only before the root; blanks, comments and instructions may precede it."""
_OTHER_ROOTS = {"sdf": "an SDF file", "mujoco": "a MuJoCo file", "COLLADA": "a mesh", "gazebo": "a Gazebo file"}


def read_xml(path: Path) -> Any:
    """The root element of a URDF file.

    Args:
        path: the file.

    Returns:
        The lxml element ``<robot>``.

    Raises:
        InputError: the file is missing, a folder, empty, over 5 MB, binary, not XML, not URDF, or an unexpanded xacro.
    """
    text = _decoded(_bytes_of(path))
    if not text.strip():
        raise InputError("the file is empty", remedy="give a URDF file")
    if not text.lstrip().startswith("<"):
        raise InputError("not an XML file", remedy="give a URDF file, which begins with <robot name=...>")
    if _DOCTYPE.match(text):
        remedy = "delete the <!DOCTYPE ...> lines"
        raise InputError("a DOCTYPE is not read, it could pull in other files", remedy=remedy)
    root = _parsed(text)
    _refuse_xacro(root, path)
    namespace = root.tag.rpartition("}")[0]
    if namespace:
        for element in root.iter():
            if isinstance(element.tag, str) and element.tag.startswith(namespace):
                element.tag = element.tag.rpartition("}")[2]
    if root.tag != "robot":
        what = _OTHER_ROOTS.get(root.tag, "no URDF")
        raise InputError(f"this is {what}: its root is <{root.tag}>", remedy="the root of a URDF is <robot name=...>")
    return root


def _bytes_of(path: Path) -> bytes:
    """The content of a file, not more than a URDF may have; else an error that says what the path is."""
    try:
        if path.is_dir():
            inside = sorted(entry.name for entry in path.iterdir() if entry.suffix == ".urdf")
            remedy = "give the URDF file in it" + (f": {', '.join(inside[:5])}" if inside else "")
            raise InputError("this is a folder", remedy=remedy)
        if not path.exists():
            near = sorted(entry.name for entry in path.parent.glob("*.urdf")) if path.parent.is_dir() else []
            raise InputError("no such file", remedy=did_you_mean(path.name, near) if near else "check the path")
        if not path.is_file():
            raise InputError("not a regular file", remedy="give a URDF file")
        with path.open("rb") as stream:
            data = stream.read(MAX_URDF_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", remedy="check the path and its permissions") from None
    if len(data) > MAX_URDF_BYTES:
        remedy = "a URDF is text; keep meshes in their own files"
        raise InputError(f"larger than {MAX_URDF_BYTES // 10**6} MB", remedy=remedy)
    return data


def _decoded(data: bytes) -> str:
    """The text of a file in UTF-8, or in the encoding that its declaration names."""
    if b"\0" in data:
        raise InputError("a binary file, or text in UTF-16", remedy="give a URDF file saved as UTF-8")
    declared = _ENCODING.match(data.removeprefix(b"\xef\xbb\xbf"))
    name = declared.group(1).decode().lower() if declared else "utf-8"
    codec = "latin-1" if name in {"iso-8859-1", "latin-1", "latin1", "windows-1252"} else "utf-8-sig"
    try:
        return data.decode(codec)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(f"not UTF-8 text (line {line})", remedy="give a URDF file saved as UTF-8", line=line) from None


def _parsed(text: str) -> Any:
    """The root element; nothing outside the text is loaded, and lines are counted as in the file."""
    from lxml import etree

    # The declaration may name another encoding, but the bytes are UTF-8 now.
    body = re.sub(r"^\s*<\?xml.*?\?>", "", text, count=1, flags=re.DOTALL).encode()
    skipped = text.count("\n") - body.count(b"\n")
    body = b"\n" * skipped + body
    closed = dict.fromkeys(("resolve_entities", "huge_tree", "load_dtd"), False)
    options = {"encoding": "utf-8", "no_network": True, **closed}
    parser = etree.XMLParser(**options)
    try:
        return etree.fromstring(body, parser)
    except etree.XMLSyntaxError as error:
        # Old simulator tags have undeclared prefixes (<sensor:camera>); URDF readers accept them.
        if {entry.type_name for entry in parser.error_log} == {"NS_ERR_UNDEFINED_NAMESPACE"}:
            return etree.fromstring(body, etree.XMLParser(recover=True, **options))
        reason, line = re.sub(r", line \d+, column \d+.*$", "", error.msg or "not XML", flags=re.DOTALL), error.lineno
    raise InputError(f"not well-formed XML (line {line}): {reason}", remedy="correct the XML there", line=line)


def _refuse_xacro(root: Any, path: Path) -> None:
    """Refuse a file whose macros have not been expanded."""
    for element in root.iter():
        if not isinstance(element.tag, str):
            continue
        if len(element.attrib) > MAX_ATTRIBUTES:
            problem = f"{len(element.attrib)} attributes, more than {MAX_ATTRIBUTES} (line {element.sourceline})"
            raise InputError(problem, key=element.tag, remedy="a URDF has a few for each element")
        macro = "xacro" in element.tag.rpartition("}")[0] or element.tag.startswith("xacro:")
        holes = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if macro or holes:
            plain = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
            line, value = element.sourceline, holes[0] if holes else None
            problem, remedy = f"this is xacro, not expanded to URDF (line {line})", f"xacro {path.name} > {plain}"
            raise InputError(problem, value=value, remedy=f"expand it first: {remedy}", line=line)


def xml_text(root: Any) -> str:
    """Text of a tree from `read_xml`, to be saved as UTF-8."""
    from lxml import etree

    return f'<?xml version="1.0" encoding="utf-8"?>\n{etree.tostring(root, encoding="unicode")}\n'
