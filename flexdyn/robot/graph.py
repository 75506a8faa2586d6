"""Check that links and joints form one tree: unique names, known links, one parent each, one root, no loop."""

from __future__ import annotations

from collections.abc import Sequence

from flexdyn.errors import InputError, did_you_mean

LinkLine = tuple[str, int | None]
JointLine = tuple[str, str, str, int | None]


def check_graph(links: Sequence[LinkLine], joints: Sequence[JointLine]) -> None:
    """Refuse links and joints that are not one tree.

    Args:
        links: name and line of every link.
        joints: name, parent link, child link and line of every joint.

    Raises:
        InputError: naming the links or joints at fault.
    """
    _refuse_repeats("link", links)
    _refuse_repeats("joint", [(name, line) for name, _, _, line in joints])
    declared = {name for name, _ in links}
    parent_joint: dict[str, JointLine] = {}
    for joint in joints:
        name, parent, child, line = joint
        for end, link in (("parent", parent), ("child", child)):
            if link not in declared:
                raise _error(f"joint '{name}'/{end}", f"link '{link}' is not declared", line, _declare(link, declared))
        if parent == child:
            raise _error(f"joint '{name}'", f"joins link '{child}' to itself", line, "give it another parent")
        if child in parent_joint:
            other = parent_joint[child][0]
            remedy = "flexdyn models trees; remove one of the two joints"
            raise _error(f"link '{child}'", f"has two parents, by joints '{other}' and '{name}'", line, remedy)
        parent_joint[child] = joint
    _refuse_loops(links, parent_joint)
    roots = [name for name, _ in links if name not in parent_joint]
    if len(roots) > 1:
        shown = ", ".join(f"'{name}'" for name in roots[:5]) + (", ..." if len(roots) > 5 else "")
        remedy = "join them to one tree by fixed joints, or remove the links that hang on nothing"
        raise InputError(f"{len(roots)} root links: {shown}", key="link", remedy=remedy)


def _refuse_repeats(what: str, named: Sequence[LinkLine]) -> None:
    first: dict[str, int | None] = {}
    for name, line in named:
        if name in first:
            raise _error(f"{what} '{name}'", f"the name is used twice, first in line {first[name]}", line, "rename one")
        first[name] = line


def _refuse_loops(links: Sequence[LinkLine], parent_joint: dict[str, JointLine]) -> None:
    """Find loops: the path from a link to its parents must end at a root; a link met twice is in a loop."""
    sound: set[str] = set()
    for start, _ in links:
        path: list[str] = []
        link = start
        while link not in sound and link in parent_joint:
            if link in path:
                loop = [*path[path.index(link) :], link]
                # Ring order is child to parent; the reader expects parent to child.
                round_trip = " -> ".join(reversed(loop[-6:]))
                remedy = "flexdyn models trees; cut the loop at one joint"
                raise _error(f"link '{link}'", f"the links form a loop: {round_trip}", parent_joint[link][3], remedy)
            path.append(link)
            link = parent_joint[link][1]
        sound.update(path)


def _declare(link: str, declared: set[str]) -> str:
    near = did_you_mean(link, declared)
    return near if near.startswith("did you mean") else f'add <link name="{link}"/>'


def _error(key: str, problem: str, line: int | None, remedy: str) -> InputError:
    return InputError(problem + f" (line {line})" if line else "", key=key, remedy=remedy, line=line)
