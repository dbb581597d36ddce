"""What callers hand over, checked for its type: one clear error in place of one from deep inside."""

from __future__ import annotations

import reprlib
from numbers import Integral
from types import UnionType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.support.arrays import Complexes, Floats


def as_number(name: str, value: Any) -> float:
    """One real number as Python's own, an int where it is whole: numpy's narrow ones overflow in what they enter.

    NaN and infinity pass: their rules are the caller's.

    Raises:
        ValueError: a text, None, a truth value, an array; the message gives name and value.

    >>> as_number("steps", np.int16(710)) ** 2, as_number("speed_m_s", np.float32(0.5))
    (504100, 0.5)
    """
    if type(value) is float:
        return value
    try:
        number = np.asarray(value)
    except ValueError:  # rows of unequal length
        number = np.empty(0)
    if number.ndim > 0 or number.dtype.kind not in "iuf" or value is np.ma.masked:
        raise ValueError(f"{name} must be a number, got {reprlib.repr(value)}")
    return int(number) if number.dtype.kind in "iu" else float(number)


def as_numbers(**values: Any) -> tuple[float, ...]:
    """The same of several, by name."""
    return tuple(as_number(name, value) for name, value in values.items())


def hold_numbers(held: Any, *names: str) -> None:
    """Have a frozen dataclass hold these of its fields as `as_number` gives them.

    Raises:
        ValueError: a field that is not one real number.
    """
    for name in names:
        object.__setattr__(held, name, as_number(name, getattr(held, name)))


def as_floats(name: str, value: Any) -> Floats:
    """A copy of real numbers as an array; its shape, NaN and infinity are the caller's to judge.

    Raises:
        ValueError: a text, None, a truth value, complex numbers, rows of unequal length; the message gives name and
            value.
    """
    return as_reals(name, value).astype(np.float64)


def as_reals(name: str, value: Any) -> NDArray[Any]:
    """The same as they are, not copied."""
    return _as_array(name, value, "iuf")


def as_finite(name: str, value: Any) -> Floats:
    """The same of numbers that must be finite."""
    array = as_floats(name, value)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {reprlib.repr(array.tolist())}")
    return array


def as_points(name: str, value: Any) -> Floats:
    """The same of points or vectors, (..., 3)."""
    array = as_finite(name, value)
    if array.shape[-1:] != (3,):
        raise ValueError(f"{name} must have shape (..., 3), got {array.shape}")
    return array


def as_complexes(name: str, value: Any) -> Complexes:
    """The same of numbers that may be complex."""
    return _as_array(name, value, "iufc").astype(np.complex128)


def _as_array(name: str, value: Any, kinds: str) -> NDArray[Any]:
    try:
        array = np.asarray(value)
    except ValueError:  # rows of unequal length
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in kinds:
        raise ValueError(f"{name} must be numbers, got {reprlib.repr(value)}")
    return array


def check_broadcast(**values: ArrayLike) -> None:
    """Refuse arrays whose shapes do not broadcast together.

    Raises:
        ValueError: the message gives names and shapes.
    """
    shapes = [np.shape(value) for value in values.values()]
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        *names, last = values
        raise ValueError(f"{', '.join(names)} and {last} must broadcast, got shapes {shapes}") from None


TURN_RAD = 2.0 * np.pi


def check_angles(most_turns: float = 1.0, **values: ArrayLike) -> None:
    """Refuse angles that are not finite or wind further than anyone means in radians: they are degrees.

    Args:
        most_turns: greatest angle either way, in full turns.
        values: angles by name, rad, of any shape.

    Raises:
        ValueError: the message gives name, rule and value.
    """
    for name, value in values.items():
        angle = as_floats(name, value)
        if not (np.abs(angle) <= most_turns * TURN_RAD).all():  # NaN fails too
            limit = f"{most_turns * TURN_RAD:.1f}"
            raise ValueError(f"{name} must be in radians, finite and within +-{limit}, got {reprlib.repr(value)}")


def check_seed(**values: Any) -> None:
    """Refuse what seeds no reproducible stream: anything but a whole number, 0 or more.

    Raises:
        ValueError: the message gives name and value.
    """
    check_counts(0, **values)


def check_counts(least: int, /, **values: Any) -> None:
    """Refuse anything but a whole number, `least` or more.

    Raises:
        ValueError: the message gives name, rule and value.
    """
    for name, value in values.items():
        if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
            raise ValueError(f"{name} must be a whole number, {least} or more, got {reprlib.repr(value)}")


def as_several(name: str, value: Any) -> tuple[Any, ...]:
    """All of an iterable.

    Raises:
        ValueError: what cannot be gone through, an array without an axis included; the message gives name and value.
    """
    try:
        return tuple(value)
    except TypeError:
        raise ValueError(f"{name} must be of type Iterable, got {reprlib.repr(value)}") from None


def check_types(**values: tuple[Any, type | UnionType]) -> None:
    """Refuse what is not of its type; each value comes with the type that it must have.

    Raises:
        ValueError: the message gives name, type and value.
    """
    for name, (value, kind) in values.items():
        if not isinstance(value, kind):
            kinds = kind.__args__ if isinstance(kind, UnionType) else (kind,)
            words = " or ".join(each.__name__ for each in kinds)
            raise ValueError(f"{name} must be of type {words}, got {reprlib.repr(value)}")
