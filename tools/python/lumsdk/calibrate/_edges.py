"""Collects the cells of known faces again, up to their edges, which the search by flat windows leaves out.

The ends of what a mirror sweeps, and the feet of walls, are at such edges: they tell widths, elevations and pitch best.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, binary_propagation

from .._grid import PIXELS
from ._model import Eye, Fixed, State, cells_of
from ._planes import Grid, block_of
from ._solution import Array

_REACH = 3, 4
"""Rows and columns of means by which a face may extend beyond its patch."""

_UNKNOWN = 1, 2
"""Rows and columns of means that it keeps from cells of no known face, which may lie across an edge."""

_OFF_M, _OFF = 0.015, 4.0
"""A cell fits its face within this many metres or standard deviations of its range."""

_CLEAR_M, _PARALLEL = 0.03, 0.97
"""Metres that it must keep from other faces there, unless these are nearly parallel (cosine)."""

_JUMP_M = 0.05, 0.25
"""A cell is beside an edge if the next one in its line, or column, is this many metres from its face, or missing in its line."""


@dataclass
class _Part:
    """A patch: its face, and where it may be."""

    index: int
    plane: int
    found: Array
    """Its cells as they were found: (lines, pixels)."""
    near: Array


def _widened(cells: Array, means: tuple[int, int]) -> Array:
    """Cells, and those within so many rows and columns of means of them."""
    rows, columns = (reach * size for reach, size in zip(means, block_of(len(cells))))
    made = binary_dilation(cells, np.ones((2 * rows + 1, 1), bool))
    return np.asarray(binary_dilation(made, np.ones((1, 2 * columns + 1), bool)))


def _part(index: int, plane: int, cells: Array, lines: int) -> _Part:
    found = np.zeros((lines, PIXELS), bool)
    found.ravel()[cells] = True
    return _Part(index, plane, found, _widened(found, _REACH))


class _Rays:
    """The rays of an eye's cells, and how they meet faces: arrays of (lines, pixels)."""

    def __init__(self, grid: Grid, capture: int, eye: int, state: State, fixed: Fixed) -> None:
        self.state, self.shape = state, grid.range_m[eye].shape
        seen = Eye(cells_of(grid, capture, eye, np.arange(grid.range_m[eye].size), 0), state, fixed)
        self.origin = seen.origin
        self.rays = (seen.points - seen.origin) / seen.expected[:, None]
        self.ranges = seen.residual + seen.expected + state.biases[0]
        self.noise = grid.sigma_m[eye]

    def _height(self, plane: int, ranges: Array) -> Array:
        """How far points on the rays are from a face."""
        normal, offset = self.state.normals[plane], self.state.offsets[plane]
        made: Array = float(normal @ self.origin) - offset + ranges * (self.rays @ normal)
        return made.reshape(self.shape)

    def away(self, plane: int) -> Array:
        """How far what was measured is from a face."""
        return self._height(plane, self.ranges - self.state.biases[plane])

    def between(self, plane: int, other: int) -> Array:
        """How far the points where rays meet a face are from another one: no matter how much ranges scatter."""
        normal = self.state.normals[plane]
        with np.errstate(divide="ignore"):
            return self._height(other, (self.state.offsets[plane] - float(normal @ self.origin)) / (self.rays @ normal))


def _beside_jumps(off: Array, noise: Array) -> Array:
    """Cells that have a cell beside them, in line or column, which is far from their face."""
    with np.errstate(invalid="ignore"):
        in_line, in_column = ~(np.abs(off) < _JUMP_M[0] + _OFF * noise), np.abs(off) > _JUMP_M[1] + _OFF * noise
    made = np.zeros(off.shape, bool)
    made[:, 1:] |= in_line[:, :-1]
    made[:, :-1] |= in_line[:, 1:]
    made[1:] |= in_column[:-1]
    made[:-1] |= in_column[1:]
    return made


def _is_clear(rays: _Rays, part: _Part, other: _Part) -> Array:
    """Cells that are of a face for sure, and not of another one beside it."""
    normals = rays.state.normals
    if float(normals[part.plane] @ normals[other.plane]) > _PARALLEL:
        made: Array = np.abs(rays.away(part.plane)) <= np.abs(rays.away(other.plane))
    else:
        rest = rays.between(part.plane, other.plane)
        side = 1.0 if np.median(rest[part.found]) > 0 else -1.0
        made = side * rest > _CLEAR_M
    return made | ~other.near


def collect(grid: Grid, capture: int, eye: int, patches: list[tuple[int, int, Array]], state: State, fixed: Fixed) -> dict[int, Array]:
    """The cells of each patch of an eye: patches are (number, face, cells found); by their numbers."""
    parts = [_part(*patch, grid.range_m.shape[1]) for patch in sorted(patches, key=lambda patch: -len(patch[2]))]
    rays = _Rays(grid, capture, eye, state, fixed)
    # Of a patch that stands elsewhere as a whole, all cells are told, for the solver to judge.
    every = [rays.away(part.plane) for part in parts]
    every = [off - np.nanmedian(off[part.found]) for part, off in zip(parts, every)]
    with np.errstate(invalid="ignore"):
        fits = [part.near & (np.abs(off) < np.maximum(_OFF_M, _OFF * rays.noise)) for part, off in zip(parts, every)]
    unknown = _widened(~np.any(fits, 0), _UNKNOWN)
    taken = np.zeros(rays.shape, bool)
    made = {}
    for part, off, fit in zip(parts, every, fits):
        kept = fit & ~taken & (part.found | ~unknown) & ~_beside_jumps(off, rays.noise)
        for other in parts:
            if other.plane != part.plane:
                kept &= _is_clear(rays, part, other)
        kept = binary_propagation(kept & part.found, mask=kept)
        taken |= kept
        made[part.index] = np.flatnonzero(kept)
    return made
