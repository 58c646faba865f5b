"""Poses as 4x4 matrices of float64, or stacks of them: the moving frame in the fixed one."""
from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

_SMALL = 1e-9


def inverse(pose: Array) -> Array:
    """Where the fixed frame is in the moving one."""
    made = np.zeros_like(pose)
    turned = np.swapaxes(pose[..., :3, :3], -1, -2)
    made[..., :3, :3] = turned
    made[..., :3, 3] = -np.einsum("...ij,...j->...i", turned, pose[..., :3, 3])
    made[..., 3, 3] = 1
    return made


def angle(pose: Array) -> Array:
    """How far each pose turns, 0 to pi. Exact also for small angles, of which the cosine is 1."""
    r = pose[..., :3, :3]
    axis = np.stack([r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], -1)
    made: Array = np.arctan2(np.linalg.norm(axis, axis=-1), np.trace(r, axis1=-2, axis2=-1) - 1)
    return made


def _cross(v: Array) -> Array:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _screw(turn: Array) -> tuple[Array, Array]:
    """The rotation of a turn by an axis times an angle, and what bends a straight path into the screw's."""
    theta, k = float(np.linalg.norm(turn)), _cross(turn)
    if theta < _SMALL:
        return np.eye(3) + k, np.eye(3) + k / 2
    a, b = np.sin(theta) / theta, (1 - np.cos(theta)) / theta ** 2
    return np.eye(3) + a * k + b * k @ k, np.eye(3) + b * k + (1 - a) / theta ** 2 * k @ k


def part(motion: Array, share: float) -> Array:
    """A share of a motion, at constant velocity and turn rate; the motion turns by less than half a turn."""
    r, theta = motion[:3, :3], float(angle(motion))
    turn = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    turn *= 0.5 if theta < _SMALL else theta / (2 * np.sin(theta))
    straight = np.linalg.solve(_screw(turn)[1], motion[:3, 3])
    made = np.eye(4)
    made[:3, :3], along = _screw(share * turn)
    made[:3, 3] = along @ (share * straight)
    return made
