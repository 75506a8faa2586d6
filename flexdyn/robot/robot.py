"""A fixed-base arm: named joints, limits, frames, and the kinematic tree for the core."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.checks import Array
from flexdyn.errors import InputError, did_you_mean, listed, visible
from flexdyn.io.locked import Locked, locked_copy
from flexdyn.io.notebook import Public
from flexdyn.robot.axes import Axes, with_axes
from flexdyn.robot.frames import find_frame, last_frame
from flexdyn.robot.joints import RobotJoint
from flexdyn.robot.link_numbers import size_of, with_inertial
from flexdyn.robot.links import Inertial, Link
from flexdyn.robot.meshes import visual_model
from flexdyn.robot.mimic import Mimic
from flexdyn.robot.summary import as_card, limit_rows
from flexdyn.robot.tree import FramePlacement, Tree

_ARRAYS = ("lower", "upper", "velocity_limit", "effort_limit", "damping", "friction")


@dataclass(frozen=True, eq=False, repr=False)
class Robot(Locked, Public):
    """An arm of n independent joints, each one number: an unwrapped angle [rad] or a displacement [m].

    Made by load_robot. It is immutable, its arrays are read-only, and it can be pickled.

    Attributes:
        name: the robot's name.
        source: what it was loaded from: a known name or the absolute path of a URDF; None for a pin.Model.
        package_dirs: folders of its package:// meshes, as given.
        lock: positions [rad or m] of the joints locked by the user, as given.
        joint_names: the independent joints in Pinocchio's order.
        kinds: "revolute" or "prismatic" for each.
        continuous: whether each can turn without limit.
        lower: least position, shape (n,) [rad or m]; -inf where unlimited.
        upper: largest position, shape (n,) [rad or m]; inf where unlimited.
        velocity_limit: shape (n,) [rad/s or m/s]; inf where unlimited.
        effort_limit: shape (n,) [N m or N]; inf where unlimited.
        damping: viscous coefficient of the URDF's <dynamics>, shape (n,) [N m s/rad or N s/m], followers' included.
        friction: Coulomb level of the URDF's <dynamics>, shape (n,) [N m or N], followers' included.
        axes: of coupled drives, in the place of the joints that they name: axis -> {joint: coefficient}.
        coupled_limits: least and largest position of joints that axes replace, where the URDF limits them.
        followers: mimic joints: (leader, multiplier, offset), q_follower = multiplier q_leader + offset.
        tree: the arrays of the kinematic tree, followers included.

    Example:
        >>> robot = fd.load_robot("ur5")
        >>> robot.n, robot.joint_names[0]
        (6, 'shoulder_pan_joint')
    """

    name: str
    source: str | Path | None
    package_dirs: tuple[Path, ...]
    lock: Mapping[str, float]
    joint_names: tuple[str, ...]
    kinds: tuple[str, ...]
    continuous: tuple[bool, ...]
    lower: Array
    upper: Array
    velocity_limit: Array
    effort_limit: Array
    damping: Array
    friction: Array
    followers: Mapping[str, Mimic]
    tree: Tree
    _model: pin.Model
    _links: tuple[Link, ...] = field(default=())
    _joints: tuple[RobotJoint, ...] = field(default=())
    axes: Axes = field(default_factory=dict)
    coupled_limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Copy arrays and tables and make them read-only."""
        for name in _ARRAYS:
            object.__setattr__(self, name, locked_copy(getattr(self, name)))
        for name in ("lock", "followers", "coupled_limits"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __repr__(self) -> str:
        """Name and joints."""
        return visible(f"<Robot {self.name}: {self.n} joints {', '.join(self.joint_names)}>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: joints and their limits."""
        return as_card(self)

    def limit_rows(self) -> list[tuple[str, str, str, str, str]]:
        """Name, type, range, speed and effort of every joint, as texts with units."""
        return limit_rows(self)

    @property
    def n(self) -> int:
        """Number of independent joints."""
        return len(self.joint_names)

    @property
    def pin_model(self) -> pin.Model:
        """A copy of the Pinocchio model of the tree, followers included: nq = nv = m, every joint one number."""
        return self._model.copy()

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names that frame() knows, in Pinocchio's order."""
        return tuple(dict.fromkeys(entry.name for entry in self._model.frames))

    @cached_property
    def tip(self) -> str:
        """Name of the default end frame: the last link on the last joint of a serial chain.

        Raises:
            InputError: the arm is branched, so that there is no one end.
        """
        m = self.tree.m
        if np.array_equal(self.tree.parent, np.arange(m) - 1):
            return self.last_frame
        leaves = [j for j in range(m) if j not in self.tree.parent]
        ends = listed((f"'{last_frame(self._model, j)}'" for j in leaves), 6)
        remedy = f"name the frame, for example one of {ends}"
        raise InputError(f"robot {self.name} is branched and has several ends", key="frame", remedy=remedy)

    def joint_index(self, joint: str | int) -> int:
        """Index of an independent joint in q.

        Args:
            joint: its name, or its index already.

        Returns:
            An index from 0 to n - 1.

        Raises:
            InputError: no such joint, or a follower.
        """
        if isinstance(joint, int):
            if 0 <= joint < self.n:
                return joint
            raise InputError("no such joint", key="joint", value=joint, remedy=f"joints count from 0 to {self.n - 1}")
        if joint in self.joint_names:
            return self.joint_names.index(joint)
        if joint in self.followers:
            remedy = f"name its leader '{self.followers[joint][0]}'"
            raise InputError("the joint mimics another", key="joint", value=joint, remedy=remedy)
        moved_by = [axis for axis, entry in self.axes.items() if joint in entry]
        remedy = f"it is moved by {' and '.join(moved_by)}" if moved_by else did_you_mean(joint, self.joint_names)
        raise InputError("no such joint", key="joint", value=joint, remedy=remedy)

    def angle_unit(self, joint: str | int) -> str:
        """Unit of a joint's position, also of one that axes move: "rad" or "m"."""
        return "m" if self._slides(joint) else "rad"

    def torque_unit(self, joint: str | int) -> str:
        """Unit of a joint's torque or force: "N m" or "N"."""
        return "N" if self._slides(joint) else "N m"

    def _slides(self, joint: str | int) -> bool:
        """Whether a joint is prismatic; an axis that moves one is, where all of its joints are."""
        moved_by: list[str | int] = [
            x for x, entry in self.axes.items() if joint in entry and joint not in self.joint_names
        ]
        return any(self.kinds[self.joint_index(each)] == "prismatic" for each in moved_by or [joint])

    def frame(self, name: str) -> FramePlacement:
        """The joint and placement of a frame; if a link and a joint have the same name, it is the link.

        Args:
            name: a link, joint or other frame of the robot.

        Returns:
            The joint that carries it (-1: the base) and its placement there.

        Raises:
            InputError: no such frame.
        """
        if isinstance(name, str) and name in self._placements:
            return self._placements[name]
        place = find_frame(self._model, name)
        self._placements[name] = place
        return place

    @cached_property
    def _placements(self) -> dict[str, FramePlacement]:
        """Frames that were computed before."""
        return {}

    def expand(self, q: Any) -> Array:
        """Positions of all joints of the tree, followers included: q_tree = G q + g0.

        Args:
            q: positions of the independent joints, shape (n,) or (samples, n) [rad or m].

        Returns:
            Shape (m,) or (samples, m).

        Raises:
            InputError: another number of joints.
        """
        positions = np.asarray(q, dtype=np.float64)
        if positions.ndim not in (1, 2) or positions.shape[-1] != self.n:
            remedy = f"one number for each of {', '.join(self.joint_names)}"
            raise InputError("wrong shape", key="q", value=positions.shape, remedy=remedy)
        return np.asarray(positions @ self.tree.gain.T + self.tree.offset)

    def with_axes(self, axes: Axes, *, ignore_dynamics: bool = False) -> Robot:
        """The robot in the coordinates of drives that move several joints together.

        Every axis replaces a joint: ``p = A q``, and the torques of the joints are ``A^T tau``. Gears, rotors, springs,
        friction and ripple of a drive act on its axis. `expand` converts back to positions of the joints.

        Args:
            axes: axis -> {joint: coefficient}, as many axes as joints in them; coefficients of mixed kinds are in
                rad/m or m/rad.
            ignore_dynamics: ignore <dynamics> of the replaced joints, which is refused otherwise.

        Raises:
            InputError: axes that are not invertible or do not fit.

        Example:
            >>> arm = fd.load_robot("scara_two_link")
            >>> belt = arm.with_axes({"shoulder": {"shoulder": 1.0}, "motor": {"shoulder": 1.0, "elbow": 1.0}})
            >>> belt.joint_names, belt.expand([0.5, 0.7])  # the second motor stands on the base
            (('shoulder', 'motor'), array([0.5, 0.2]))
        """
        return with_axes(self, axes, ignore_dynamics=ignore_dynamics)

    def with_link_scaled(self, link: str, *, mass: float = 1.0, com: float = 1.0, inertia: float = 1.0) -> Robot:
        """The robot with numbers of one link's <inertial> multiplied.

        Args:
            link: its name.
            mass: factor of the mass [1].
            com: factor of the position of the centre of mass in the link's frame [1].
            inertia: factor of the inertia about the centre of mass [1].

        Returns:
            A new robot; only the link's inertia differs, and its source is None: no file describes it.

        Raises:
            InputError: no such link, one without mass, or one that does not move.
        """
        return self._with_inertial(link, lambda given: given.scaled(mass, com, inertia))

    def with_link_inertia(self, link: str, moment: float) -> Robot:
        """The robot with another inertia of one link: the same about every axis through its centre of mass.

        Args:
            link: its name.
            moment: replaces the inertia of its <inertial> [kg m^2].

        Returns:
            A new robot; only the link's inertia differs, and its source is None: no file describes it.

        Raises:
            InputError: no such link, one without mass, or one that does not move.
        """
        return self._with_inertial(link, lambda given: given.round(moment))

    def link_size(self, link: str) -> tuple[float, float]:
        """Mass of a link [kg], and its length: to its centre of mass or its farthest joint, whichever is larger [m].

        Args:
            link: its name.

        Raises:
            InputError: no such link, one without mass, or one that does not move.
        """
        self._with_inertial(link, lambda given: given)  # refuses a link without size
        return size_of(link, self._links, self._joints)

    def visual_model(self) -> pin.GeometryModel:
        """The shapes of the robot on the joints of pin_model; this reads the meshes. Empty for a pin.Model source."""
        return visual_model(self._model, self._links, self._joints)

    def _with_inertial(self, link: str, change: Callable[[Inertial], Inertial]) -> Robot:
        """The robot with the mass, centre of mass and inertia of one link changed."""
        changed = with_inertial(link, change, self._links, self.frame, self.tree, self.pin_model)
        return replace(self, source=None, **changed)

    @property
    def last_frame(self) -> str:
        """The last link, or other frame, that the last joint carries; `tip` where the arm is not branched."""
        return last_frame(self._model, self.tree.m - 1)
