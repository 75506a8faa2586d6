"""The base of every effect: a named law with parameters, units, bounds and a neutral value.

The law itself is written once, in the compiled core. A class here gives its name, its place in the equations of motion
and its parameters. A user's own effect is a subclass that overrides `torque` in Python: it runs in every solver, more
slowly.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar, Literal, Self, dataclass_transform

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.checks import Array, check_known
from flexdyn.effects.extent import MotionExtent
from flexdyn.effects.law_table import LAWS
from flexdyn.effects.parameters import USUAL_SIZES, checked_number, parameter
from flexdyn.effects.traits import Traits
from flexdyn.errors import InputError

Side = Literal["link", "motor", "transmission", "sensor"]
Stage = Literal["actuator", "deflection", "spring", "friction", "dry", "link", "inertia", "sensor", "model"]
Scale = Literal["given", "speed", "deflection", "seconds", "one"]
Prevalence = Literal["everywhere", "often", "seldom"]

_registry: dict[str, type[Effect]] = {}


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(parameter, dataclasses.field))
class Effect(Traits):
    """Base of all effects; every subclass becomes a frozen dataclass automatically.

    Class attributes:
        name: the effect's name in files and reports: the class name in snake_case.
        sides: where it may act.
        stage: its place in the equations: ``actuator`` (tau_applied = law(tau)), ``deflection`` (delta before
            every spring law), ``spring`` (adds to tau_s), ``friction`` and ``dry`` (left side, f_link or f_motor),
            ``link`` (right side, on the link), ``inertia`` (changes M and h), ``sensor`` (what is measured),
            ``model`` (a number of the model).
        law: its formula as the catalogue shows it, in x, u (position, velocity of its side), tau, delta.
        neutral: the parameter values at which it changes nothing; a neutral effect is left out of the plant. Default:
            0 for what it is `linear` in.
        no_torque: if the law is no torque over position and velocity: what to use instead.
        shown: parameter values with which the documentation shows it.
        takes_load: its torque depends on what the transmission carries, so that it needs an elastic joint.
        has_state: its law remembers, by an internal state of its own.
        order: place among the effects on the motor's torque, or on the deflection; the least acts first, users' own
            last.

    A built-in law has stage, `takes_load`, `has_state` and `conservative` from the core's table.

    A diagnosis proposes every class that names `linear`, `linear_bounds` or `axes`.

    Class attributes for a diagnosis:
        linear: parameters in which the torque is linear, all together; the torque is 0 if all of them are 0.
        linear_bounds: lower bounds of what it is linear in, where that is something else than its parameters: see
            `numbers_of`.
        axes: the other parameters, of which a grid of values is tried, see `tried`.
        grids: that grid, in units of what the joint does: the greatest torque that its motor must have ``given``, its
            greatest ``speed`` or ``deflection``, the ``seconds`` of the recording, or ``one`` of the parameter's own
            unit.
        contains: names of effects that it becomes for some limit of its parameters; never proposed together with it.
        plainer: names of laws that it refines by further parameters: only what these explain beyond such a law counts.
        sum_of: names of effects that together, at one joint, are the same law as this one.
        natural_size: prior standard deviation of its size, if that does not depend on the drive's torque.
        prevalence: how many drives have it. It is weighed against something unknown that looks like it.
        of_velocity: friction or damping that the velocity alone decides.
        of_recorded_torque: it bends the torque on its way, so that what it does is a matter of the recorded torque;
            what others do is taken of the torque that the model needs, whose noise is less.
        cycles: of a law that is periodic over the position, the parameter with its number of cycles in a turn.
        position_error: of an effect on positions, the parameter that is its size [rad or m].
        damps_spring: of a damping across the spring of a joint, the parameter that is its coefficient.
        bends_spring: with it, the transmission is no linear spring.
        makes_elastic: where a joint that the model takes for rigid becomes elastic, the parameter with its stiffness.
        is_constant: neither the motion nor the command changes what it adds; a force sensor may have such a torque too.
        small_size: size of what it is linear in at which a diagnosis computes what it does; `small` may depend on more.
        unproposed: parameters that keep their default where a diagnosis proposes the effect.
        late_by: the parameter by which it shifts a signal in time [s]; empty: it shifts none.

    Example:
        >>> friction = fd.effects.CoulombFriction("elbow", side="motor", level=0.2)
        >>> friction.torque(x=0.0, u=[-1.0, 0.0, 1.0])
        array([-0.2,  0. ,  0.2])
    """

    name: ClassVar[str]
    sides: ClassVar[tuple[Side, ...]] = ()
    stage: ClassVar[Stage] = "friction"
    law: ClassVar[str] = ""
    neutral: ClassVar[Mapping[str, float]] = {}
    no_torque: ClassVar[str] = ""
    shown: ClassVar[Mapping[str, float]] = {}
    takes_load: ClassVar[bool] = False
    has_state: ClassVar[bool] = False
    order: ClassVar[int] = 100
    linear: ClassVar[tuple[str, ...]] = ()
    linear_bounds: ClassVar[tuple[float, ...]] = ()
    unproposed: ClassVar[tuple[str, ...]] = ()
    axes: ClassVar[tuple[str, ...]] = ()
    grids: ClassVar[Mapping[str, tuple[Scale, tuple[float, ...]]]] = {}
    contains: ClassVar[tuple[str, ...]] = ()
    plainer: ClassVar[tuple[str, ...]] = ()
    sum_of: ClassVar[tuple[str, ...]] = ()
    natural_size: ClassVar[float] = math.inf
    small_size: ClassVar[float] = 1.0
    late_by: ClassVar[str] = ""
    prevalence: ClassVar[Prevalence] = "seldom"
    of_velocity: ClassVar[bool] = False
    of_recorded_torque: ClassVar[bool] = False
    cycles: ClassVar[str] = ""
    position_error: ClassVar[str] = ""
    damps_spring: ClassVar[str] = ""
    bends_spring: ClassVar[bool] = False
    makes_elastic: ClassVar[str] = ""
    is_constant: ClassVar[bool] = False

    def __init_subclass__(cls, abstract: bool = False) -> None:
        """Make the subclass a frozen dataclass and register it in the catalogue under its name."""
        dataclasses.dataclass(frozen=True, kw_only=True)(cls)
        if cls.grids:
            cls.axes = tuple(cls.grids)
        cls.neutral = cls.neutral or dict.fromkeys(cls.linear, 0.0)
        if not abstract:
            cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        row = None if cls.torque is not Effect.torque else LAWS.get(cls.__dict__.get("name", ""))
        if row is not None:
            cls.stage, cls.takes_load, cls.has_state = row.stage, row.of_load, row.has_state
            cls.conservative = row.conservative
        if abstract:
            return
        known = _registry.get(cls.name)
        if known is not None and known.__module__ != cls.__module__:
            raise TypeError(f"an effect named {cls.name} exists already, in {known.__module__}")
        _registry[cls.name] = cls

    def __post_init__(self) -> None:
        """Check every number against its bounds and store it as a float."""
        for field in self.parameters():
            neutral = self.neutral.get(field.name, math.nan)
            number = checked_number(self.name, field, getattr(self, field.name), neutral)
            object.__setattr__(self, field.name, number)

    @classmethod
    @functools.cache
    def parameters(cls) -> tuple[dataclasses.Field[Any], ...]:
        """The parameters of the effect, in the order in which the core takes them."""
        return tuple(f for f in dataclasses.fields(cls) if "unit" in f.metadata)  # type: ignore[arg-type]

    @classmethod
    def declared(cls, name: str) -> Mapping[str, Any]:
        """What a parameter declares, see `parameter`."""
        return next(field.metadata for field in cls.parameters() if field.name == name)

    @classmethod
    def units(cls, *, prismatic: bool) -> dict[str, str]:
        """The units of its parameters on a prismatic or a revolute joint."""
        key = "prismatic_unit" if prismatic else "unit"
        return {field.name: field.metadata[key] for field in cls.parameters()}

    @classmethod
    def summary(cls) -> str:
        """The first sentence of the docstring."""
        return inspect.cleandoc(cls.__doc__ or "").split("\n")[0]

    @property
    def values(self) -> tuple[float, ...]:
        """The parameter values, in the order of `parameters`."""
        return tuple(getattr(self, f.name) for f in self.parameters())

    @property
    def is_neutral(self) -> bool:
        """Whether it changes nothing: every parameter named in `neutral` has its neutral value."""
        return bool(self.neutral) and all(getattr(self, key) == value for key, value in self.neutral.items())

    @classmethod
    def unknowable(cls) -> tuple[str, ...]:
        """Parameters that a model file may call unknown: those that a diagnosis would find if the effect were missing.

        A number in which the torque is linear starts near 0, of another one the values of `axes` are compared. None
        of what scales or bends the recorded torque, in which all else is measured: there a wide prior makes the fit
        wrong, see docs/diagnosis_equations.md.
        """
        if cls.scales_torque or cls.of_recorded_torque:
            return ()
        shaped = () if not cls.axes else tuple(name for name in cls.uncertain() if not cls.is_kept(name))
        return tuple(name for name in cls.uncertain() if name in (*cls.linear, *shaped))

    @classmethod
    def is_kept(cls, name: str) -> bool:
        """Whether no fit moves a parameter of a missing effect: it keeps its default or is one of a few values."""
        return name in cls.unproposed or bool(cls.declared(name)["chosen"])

    @classmethod
    def moved_axes(cls) -> tuple[str, ...]:
        """Those of its `axes` whose values a fit moves, where others are one of a few values."""
        return tuple(name for name in cls.axes if not cls.is_kept(name))

    def parts(self) -> tuple[Effect, ...]:
        """What it is in the plant: one effect for each law of the core that it has."""
        return (self,)

    def in_usual_range(self) -> Self:
        """The same law with its numbers in their usual range: most laws have one form only."""
        return self

    @property
    def lateness(self) -> float:
        """Time by which it shifts a signal [s]; 0: it shifts none."""
        return float(getattr(self, self.late_by)) if self.late_by else 0.0

    @property
    def in_numbers(self) -> bool:
        """Whether a resolved model has it in its numbers and no more as an effect."""
        return self.stage == "model" or bool(self.makes_elastic)

    @property
    def is_python(self) -> bool:
        """Whether its law is written in Python: a subclass overrides `torque`."""
        return type(self).torque is not Effect.torque

    def torque(self, x: ArrayLike, u: ArrayLike, *, t: ArrayLike = 0.0, tau: ArrayLike = 0.0) -> Array:
        """Evaluate the law over whole recordings, with the sign that it has in the equations of motion.

        Args:
            x: position of the effect's side [rad or m]; the deflection delta in a transmission.
            u: velocity of the effect's side [rad/s or m/s]; delta' in a transmission, omega of the other joint in a
                coupling.
            t: time since the start of the run [s].
            tau: torque before the law, for the stage ``actuator``; tau_s for laws that take the load [N m or N].

        Returns:
            the torque [N m or N], of the broadcast shape of the arguments. A dry law gives the end of its set in the
            direction of u, and 0 at u = 0.

        Raises:
            InputError: the law is no torque over position and velocity.
        """
        if self.no_torque:
            problem = "the effect has no torque over position and velocity"
            raise InputError(problem, key="effect", value=self.name, remedy=self.no_torque)
        columns = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (t, x, u, tau)))
        return self._evaluate(*(np.asarray(column, order="C") for column in columns))

    def to_dict(self) -> dict[str, Any]:
        """As a model file writes it: ``{effect: name, joint: ..., parameters}``; None is left out."""
        fields = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}  # type: ignore[arg-type]
        return {"effect": self.name} | {key: value for key, value in fields.items() if value is not None}

    def replace(self, **changes: Any) -> Self:
        """A copy of the effect with some fields changed; the new values are checked."""
        return dataclasses.replace(self, **changes)  # type: ignore[type-var]

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Make the effect from a model file's entry without its ``effect`` key.

        Raises:
            InputError: a key that the effect does not have, or a required key is missing.
        """
        fields = {f.name: f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
        for key in entry:
            check_known(key, fields, f"{cls.name} has no such parameter", key=str(key))
        for key, field in fields.items():
            if field.default is dataclasses.MISSING and key not in entry:
                unit = field.metadata.get("unit")
                raise InputError(f"{cls.name} needs it", key=key, remedy=f"give it in {unit}" if unit else "name it")
        return cls(**entry)

    @classmethod
    def tried(cls, extent: MotionExtent) -> Iterable[Sequence[float]]:
        """Values of its `axes` that a diagnosis tries (points, axes); none where the joint cannot show the effect.

        Args:
            extent: what the joint does in the recordings.
        """
        sizes = [[share * extent.size(scale) for share in shares] for scale, shares in cls.grids.values()]
        return itertools.product(*sizes)

    @classmethod
    def numbers_of(cls, point: Sequence[float], x: Sequence[float]) -> dict[str, float] | None:
        """Its parameters from values of its `axes` and of what it is linear in; None: there is no such effect.

        Args:
            point: of the grid, from `tried`.
            x: numbers that a fit gave, in the order of `linear`.
        """
        return dict(zip(cls.axes, point, strict=True)) | dict(zip(cls.linear, x, strict=True))

    @classmethod
    def small(cls, extent: MotionExtent) -> float:
        """Size of what it is linear in at which a diagnosis computes what it does."""
        return cls.small_size

    def largest(self, name: str) -> float:
        """Largest value that a fit gives a parameter."""
        return math.inf

    @classmethod
    def example(cls, joint: str = "joint", other: str = "other_joint") -> Self:
        """An effect with typical parameters, for documentation and drawings.

        Args:
            joint: the joint that it acts on, if it acts on one.
            other: a second joint, if it needs one.
        """
        numbers = {
            field.name: cls.shown.get(field.name, USUAL_SIZES.get(field.metadata["unit"], 1.0))
            for field in cls.parameters()
            if field.default is dataclasses.MISSING or field.name in cls.shown
        }
        return cls(**cls._example_place(joint, other), **numbers)

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        """Names of its fields that are not numbers."""
        return {}

    def _evaluate(self, t: Array, x: Array, u: Array, tau: Array, z: Array | None = None) -> Array:
        """The core's law of this name over contiguous columns; z is its state, if it has one."""
        out = np.empty(x.shape)
        _core.evaluate_law(self.name, self.values, t, x, u, tau, np.zeros(x.shape) if z is None else z, out)
        return out


def registered() -> Mapping[str, type[Effect]]:
    """Every effect class defined so far, users' own included, by name.

    Example:
        >>> fd.effects.registered()["payload"]
        <class 'flexdyn.effects.link.Payload'>
    """
    return dict(_registry)
