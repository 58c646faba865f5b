"""Points into a camera's picture, by the model of OpenCV."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from ._errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ._types import Array, Doubles

_COEFFICIENTS = (0, 4, 5, 8)


class Projection(NamedTuple):
    """Where points are in a picture, one row a point."""

    pixels: Doubles
    """u, to the right, and v, downwards: (n, 2) float64. The centre of the first pixel is at 0, 0. NaN for points that are
    not in front of the camera."""
    depth: Doubles
    """Metres in front of the camera, along its axis: (n,) float64; behind it below 0."""
    visible: NDArray[np.bool_]
    """Whether a point is in the picture: (n,) bool. What may hide it is not considered."""


def _numbers(name: str, given: Any) -> Array:
    try:
        return np.asarray(given, "f8")
    except (TypeError, ValueError):
        raise OptionError(f"{name} is {given!r}; use numbers") from None


def _matrix(name: str, given: Any, shapes: tuple[tuple[int, int], ...]) -> Array:
    made = _numbers(name, given)
    if made.shape not in shapes or not np.isfinite(made).all():
        raise OptionError(f"{name} has the shape {made.shape}; use finite numbers of the shape "
                          + " or ".join(map(str, shapes)))
    return made


def _camera(given: Any) -> Array:
    made = _matrix("K", given, ((3, 3),))
    if made[0, 0] <= 0 or made[1, 1] <= 0 or made[1, 0] or (made[2] != (0, 0, 1)).any():
        raise OptionError("K is not the matrix of a camera; use [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels, fx and fy "
                          "above 0")
    return made


def _pose(given: Any) -> Array:
    made = _matrix("T", given, ((4, 4), (3, 4)))
    turn = made[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3 or np.linalg.det(turn) < 0:
        raise OptionError("the first three columns of T are not a rotation; T takes points from the sensor's "
                          "frame (x forward, y left, z up) to the camera's (x right, y down, z forward)")
    if len(made) == 4 and (made[3] != (0, 0, 0, 1)).any():
        raise OptionError(f"the last row of T is {made[3].tolist()}; use [0, 0, 0, 1]")
    return made


def _coefficients(given: Any) -> Array:
    made = np.zeros(0) if given is None else _numbers("distortion", given).reshape(-1)
    if len(made) not in _COEFFICIENTS or not np.isfinite(made).all():
        raise OptionError(f"distortion has {len(made)} numbers; use k1 k2 p1 p2 [k3 [k4 k5 k6]], as OpenCV has them")
    return np.concatenate([made, np.zeros(8 - len(made))])


def _size(given: Any) -> Optional[Array]:
    made = None if given is None else _numbers("size, (width, height) in pixels,", given)
    if made is not None and (made.shape != (2,) or not (made > 0).all() or not np.isfinite(made).all()):
        raise OptionError(f"size is {given!r}; use (width, height) in pixels")
    return made


def _limit(k: Array) -> float:
    """The square of the radius from which on the distorted radius does not grow any more: what lies outside of it would
    come back into the picture."""
    above, below = np.poly1d([k[4], k[1], k[0], 1.0]), np.poly1d([k[7], k[6], k[5], 1.0])
    s = np.poly1d([1.0, 0.0])
    rise = (above + 2 * s * above.deriv()) * below - 2 * s * above * below.deriv()
    roots: Any = np.concatenate([rise.roots, below.roots])
    real: Array = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(real.min()) if len(real) else np.inf


def _distort(x: Array, y: Array, k: Array) -> tuple[Array, Array]:
    s = x * x + y * y
    radial = (1 + s * (k[0] + s * (k[1] + s * k[4]))) / (1 + s * (k[5] + s * (k[6] + s * k[7])))
    twice = 2 * x * y
    return (x * radial + k[2] * twice + k[3] * (s + 2 * x * x), y * radial + k[2] * (s + 2 * y * y) + k[3] * twice)


def project(points: Array, K: Any, T: Any, distortion: Any, size: Optional[Sequence[int]]) -> Projection:
    """As Frame.project(), of points (n, 3)."""
    camera, pose, k, sides = _camera(K), _pose(T), _coefficients(distortion), _size(size)
    x, y, depth = pose[:3, :3] @ points.T.astype("f8") + pose[:3, 3:]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        visible = depth > 0
        x, y = np.where(visible, x / depth, np.nan), np.where(visible, y / depth, np.nan)
        if k.any():
            visible &= x * x + y * y < _limit(k)
            x, y = _distort(x, y, k)
        u = camera[0, 0] * x + camera[0, 1] * y + camera[0, 2]
        v = camera[1, 1] * y + camera[1, 2]
        if sides is not None:
            visible &= (u >= -0.5) & (u < sides[0] - 0.5) & (v >= -0.5) & (v < sides[1] - 0.5)
    return Projection(np.column_stack([u, v]), depth, visible)
