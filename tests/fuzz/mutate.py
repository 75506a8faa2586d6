"""Damage, drawn from a seeded generator: to bytes, to text, and to what lies in an archive."""

from __future__ import annotations

import contextlib
import io
import json
import random
import re
import struct
import zipfile
from collections.abc import Callable, Sequence

EDGES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 2**31 - 1, 2**31, 2**32 - 1, 2**53, 2**62, 2**63 - 1, 2**64 - 1)
NUMBERS = (
    *("nan", "-nan", ".nan", "inf", "-inf", ".inf", "1e308", "-1e308", "1e309", "1e-320", "-0.0", "0", "-1", "1e15"),
    *("1e-15", "1e300", "9" * 40, "9" * 5000, "0x10", "1_000", "1,5", "0b1", "1e", "--1", "true", "null", "~", ""),
)
WORDS = (
    *("", " ", "\t", "\n", "\r", "\r\n", "\x00", "\x1b[31m", "\u202e", "\ufeff", "\u2028", "\x85", "\ud7ff", "é", "💥"),
    *("<script>alert(1)</script>", "&amp;", "&x;", "<!--", "-->", "]]>", "<![CDATA[", "../" * 20, "{", "}", "[", "]"),
    *("*", "&a", "*a", "!!python/object:os.system", "!!int ''", "!!binary |", "? ", "- ", ": ", "#", "|", ">", "%"),
    *("'", '"', "`", "\\", "@", "x" * 300, "x" * 10_000, "[" * 500, "{" * 500, "- " * 300, "a: " * 40, "%s%n", "${x}"),
)
_NUMBER = re.compile(r"[-+]?\d[\d.eE+-]*")
_WORD = re.compile(r"[A-Za-z_][\w.]*")

Mutator = Callable[[random.Random, Sequence[bytes]], bytes]


def any_bytes(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """One of the seeds with up to eight kinds of damage to its bytes."""
    data = bytearray(rng.choice(seeds))
    for _ in range(1 + min(int(rng.expovariate(0.8)), 8)):
        if not data:
            break
        rng.choice(_BYTES)(rng, data, seeds)
    return bytes(data[:200_000])


def _flip(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _byte(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    data[rng.randrange(len(data))] = rng.choice((0, 255, 127, 128, rng.randrange(256)))


def _integer(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    size = rng.choice((2, 4, 8))
    at = rng.randrange(len(data))
    if rng.random() < 0.7:
        at -= at % size
    value = (rng.choice(EDGES) + rng.randint(-1, 1)) % 2 ** (8 * size)
    data[at : at + size] = value.to_bytes(size, rng.choice(("little", "big")))


def _double(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at = rng.randrange(len(data)) // 8 * 8
    data[at : at + 8] = struct.pack("<d", rng.choice((0.0, -1.0, 1e308, -1e308, 5e-324, float("nan"), float("inf"))))


def _cut(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    del data[rng.randrange(len(data)) :]


def _remove(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at = rng.randrange(len(data))
    del data[at : at + rng.choice((1, 2, 4, 8, 64, 512))]


def _repeat(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at, size = rng.randrange(len(data)), rng.choice((1, 4, 8, 64, 512))
    data[at:at] = data[at : at + size] * rng.choice((1, 2, 16))


def _splice(rng: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    other = rng.choice(seeds)
    at, start, size = rng.randrange(len(data)), rng.randrange(len(other) or 1), rng.choice((8, 64, 512, 4096))
    data[at : at + size] = other[start : start + size]


_BYTES = (_flip, _byte, _byte, _integer, _integer, _double, _cut, _remove, _repeat, _splice)


def any_text(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """One of the seeds with numbers, words and lines exchanged, or with damage to its bytes."""
    if rng.random() < 0.1:
        return any_bytes(rng, seeds)
    text = rng.choice(seeds).decode()
    for _ in range(1 + min(int(rng.expovariate(1.0)), 8)):
        text = rng.choice(_TEXTS)(rng, text)
    return text.encode("utf-8", "surrogatepass")[:200_000]


def _other_number(rng: random.Random, text: str) -> str:
    return _exchanged(rng, text, _NUMBER, rng.choice((*NUMBERS, repr(rng.uniform(-10, 10)), str(rng.randint(-9, 99)))))


def _other_word(rng: random.Random, text: str) -> str:
    words = _WORD.findall(text)
    return _exchanged(rng, text, _WORD, rng.choice((*WORDS, *NUMBERS, *words[:200], *words[:200])))


def _exchanged(rng: random.Random, text: str, pattern: re.Pattern[str], by: str) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text + by
    match = rng.choice(found)
    return text[: match.start()] + by + text[match.end() :]


def _inserted(rng: random.Random, text: str) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice((*WORDS, *NUMBERS)) + text[at:]


def _without(rng: random.Random, text: str) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + text[at + rng.choice((1, 1, 2, 5, 40)) :]


def _lines(rng: random.Random, text: str) -> str:
    lines = text.splitlines(keepends=True) or [""]
    at, to = rng.randrange(len(lines)), rng.randrange(len(lines))
    line = lines[at]
    if rng.random() < 0.5:
        del lines[at]
    lines[to:to] = [line] * rng.choice((0, 1, 1, 2, 30))
    return "".join(lines)


_TEXTS = (_other_number, _other_number, _other_word, _other_word, _inserted, _without, _lines)


def any_archive(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """An archive damaged, or one that is sound and holds damaged members."""
    if rng.random() < 0.4:
        return any_bytes(rng, seeds)
    with zipfile.ZipFile(io.BytesIO(rng.choice(seeds))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    damaged, made = rng.choice(list(members)), io.BytesIO()
    members[damaged] = any_bytes(rng, [members[damaged]])
    with zipfile.ZipFile(made, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for name, data in members.items():
            archive.writestr(rng.choice(("t.npy", "x", "../q.npy")) if rng.random() < 0.05 else name, data)
    return made.getvalue()


def any_store(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """An archive of a Zarr store with damage to one file, most often to the metadata, which hold the study."""
    with zipfile.ZipFile(io.BytesIO(rng.choice(seeds))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = "zarr.json" if rng.random() < 0.8 else rng.choice(list(members))
    members[name] = _other_metadata(rng, members[name]) if name == "zarr.json" else any_bytes(rng, [members[name]])
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return made.getvalue()


def _other_metadata(rng: random.Random, data: bytes) -> bytes:
    """Other text anywhere, in the study that stands in it, or in what it says of one array."""
    kind, content = rng.choice(("text", "study", "study", "array")), json.loads(data)
    if kind == "text":
        return any_text(rng, [data])
    if kind == "study":
        content["attributes"]["study"] = any_text(rng, [content["attributes"]["study"].encode()]).decode(
            errors="replace"
        )
    else:
        arrays = content["consolidated_metadata"]["metadata"]
        chosen = rng.choice(list(arrays))
        with contextlib.suppress(ValueError):  # JSON no more: it stays as it was
            arrays[chosen] = json.loads(any_text(rng, [json.dumps(arrays[chosen]).encode()]))
    return json.dumps(content).encode()


def a_number(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """What a case is drawn from, where there are no bytes to damage."""
    return str(rng.getrandbits(63)).encode()
