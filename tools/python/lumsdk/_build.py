"""Frames of arrays: what was pickled, moved or chosen."""
from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._frame import Frame, _Info

if TYPE_CHECKING:
    from ._frame import Array
    from ._raw import Raw


def assemble(info: _Info, columns: Mapping[str, Array], lines: Array, moved: str, xyz: Optional[Array] = None,
             raw: Optional[Raw] = None) -> Frame:
    """A frame of these arrays, which are kept; x, y and z are then those of xyz if that is given."""
    frame = Frame.__new__(Frame)
    frame._c, frame._count = None, len(next(iter(columns.values()))) if columns else 0
    frame._info_made, frame._lines_made, frame._moved, frame._raw = info, lines, moved, raw
    frame._arrays = dict(columns)
    if xyz is not None:
        frame._arrays.update(zip("xyz", xyz.T), xyz=xyz)
    return frame


def restore(info: Mapping[str, Any], arrays: Mapping[str, Array], lines: Array, moved: str = "",
            raw: Optional[Raw] = None) -> Frame:
    """A frame that was pickled."""
    xyz = np.array([arrays[name] for name in "xyz"], "f4").T if all(name in arrays for name in "xyz") else None
    return assemble(_Info(**info), arrays, lines, moved, xyz, raw)
