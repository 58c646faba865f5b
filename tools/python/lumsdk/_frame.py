"""A frame: all points of one sweep of one sensor, as arrays."""
from __future__ import annotations

import datetime
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, cast, overload

import numpy as np

from . import _grid, _image, _lines
from ._c import address_of, ffi, lib
from ._columns import COLUMNS, NUMBERS, Memory, fill
from ._errors import UnknownKeyError, nearest
from ._grid import EYES
from ._info import Info, Members
from ._raw import RAW_COLUMNS, Raw, attach
from ._raw import of as raw_of
from ._settings import Profile

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped,unused-ignore]
    import pyarrow  # type: ignore[import-untyped,unused-ignore]
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Literal

    from ._poses import Poses
    from ._project import Projection
    from ._types import (AnyColumn, Array, Eye, Eyes, Filling, FloatColumn, Floats, ImageColumn, Int16Column, Moment, Outside,
                         OwnColumn, PictureColour, Places, Preset, Records, TableColumn, Uint8Column, Uint16Column, Uint32Column)
    from ._write import Line

_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)


class Frame:
    """All points of one sweep of one sensor.

    ``frame["range"]`` is a column, one value a point; ``frame.columns`` names them. Points are in the order of their
    lines. Arrays are views of the frame's memory, nothing is copied; they stay valid after the frame and after its
    source. A frame can be pickled: what comes back has the same values in memory of its own.
    """

    __slots__ = ("__weakref__", "_arrays", "_block", "_c", "_count", "_info_made", "_lines_made", "_members", "_moved", "_own", "_raw")

    def __init__(self, pointer: Any, members: Optional[Members] = None) -> None:
        """Keep a frame of the library. Programs get frames from a source or a sensor."""
        self._members = members
        self._c = ffi.gc(lib.lum_frame_keep(pointer), lib.lum_frame_release)
        self._count: int = lib.lum_frame_count(self._c)
        self._arrays: dict[str, Array] = {}
        self._block: Optional[Floats] = None  # x, y and z where they lie together in memory
        self._own: tuple[str, ...] = ()  # names of columns that with_columns() added
        self._info_made: Optional[Info] = None
        self._lines_made: Optional[Records] = None
        self._raw: Optional[Raw] = None
        self._moved = ""  # to where its points were moved; "": they are as the sensor saw them

    # What is known of it as a whole.

    @property
    def _info(self) -> Info:
        if self._info_made is None:
            self._info_made = Info.of(self._c, self._members)
        return self._info_made

    @property
    def number(self) -> int:
        """The frame's number."""
        return self._info.number

    @property
    def sensor(self) -> str:
        """The name of its sensor: that of the rig, such as "front", or without a rig its address, such as "10.42.0.37".

        If another sensor with that address came before, its interface follows: "10.42.0.37%eth1".
        """
        if self._info.name:
            return self._info.name
        interface = self._info.interface
        return address_of(self._info.sensor) + (f"%{interface}" if interface else "")

    @property
    def pose(self) -> Optional[Array]:
        """Where its sensor is on the vehicle, by the rig: (4, 4) float64, which takes points of the sensor, as columns, into
        the vehicle's frame. x, y and z are in the vehicle's frame already. None: it was read without a rig, or it has the
        points of several sensors."""
        return None if self._info.pose is None else np.array(self._info.pose)

    @property
    def complete(self) -> bool:
        """Whether nothing of it is known to be missing."""
        return self._info.is_complete

    @property
    def paused(self) -> bool:
        """Whether the sensor, or one of its eyes, paused inside it: it lacks lines, or has a part of another sweep."""
        return self._info.has_pause

    @property
    def first(self) -> bool:
        """Whether it is the first of its sensor. It was under way when the recording began, and may lack its start."""
        return self._info.is_first

    @property
    def last(self) -> bool:
        """Whether the recording ended with it. It may lack its end."""
        return self._info.is_last

    @property
    def utc_ns(self) -> int:
        """When its earliest line was measured, in nanoseconds since 1970 UTC.

        It is the sensor's clock converted to UTC by a fit to the arrival times of the packets. Where the profile has
        no timestamp, it is the arrival of that line, and utc_error_ns is None.
        """
        return self._info.begin_utc_ns or self._info.begin_arrival_ns

    @property
    def utc_error_ns(self) -> Optional[int]:
        """The estimated error of utc_ns in both directions.

        None: not known, since the profile has no clock, the host's clock was stepped nearby, or its stamps stand still.
        """
        error_ns = self._info.utc_error_ns
        return error_ns if self._info.begin_utc_ns and error_ns != lib.LUM_CLOCK_ERROR_UNKNOWN else None

    @property
    def time(self) -> datetime.datetime:
        """utc_ns as a datetime in UTC, down to the microsecond."""
        return _EPOCH + datetime.timedelta(microseconds=self.utc_ns // 1000)

    @property
    def duration(self) -> float:
        """Seconds from its earliest line to its latest, on the sensor's clock."""
        return (self._info.end_clock_us - self._info.begin_clock_us) * 1e-6

    @property
    def losses(self) -> dict[str, int]:
        """What is missing in it, by cause, with lumdump's names.

        no_range counts words without a range above zero, which are no damage. lines_late are lines of earlier
        frames that came after their frame had been given out.
        """
        return dict(self._info.losses)

    @property
    def info(self) -> dict[str, Any]:
        """All that is known of it as a whole: numbers, clocks, lines of both eyes, and what losses has."""
        values = {**vars(self._info)}
        losses = values.pop("losses")
        for name in ("interface", "member", "name", "pose", "rig"):
            del values[name]
        values["utc_error_ns"] = self.utc_error_ns
        values["sensor"] = self.sensor
        for name in ("lines", "rows"):
            both = values.pop(name)
            values.update({f"{name}_{eye}": both[i] for i, eye in enumerate(EYES)})
        return {**values, "points": self._count, **losses}

    # Its arrays.

    def __len__(self) -> int:
        """How many points it has."""
        return self._count

    def __bool__(self) -> bool:
        """A frame is one, even without a point."""
        return True

    @property
    def columns(self) -> tuple[AnyColumn, ...]:
        """The names of its columns, as open(columns=...) chose them; behind them those of with_columns()."""
        if self._c is None:
            names = [name for name in (*NUMBERS, *RAW_COLUMNS) if name in self._arrays]
        else:
            mask = lib.lum_frame_columns(self._c)
            names = [name for name, c in NUMBERS.items() if mask >> c & 1]
        return cast("tuple[AnyColumn, ...]", (*names, *self._own))

    def _number_of(self, name: str) -> Optional[int]:
        """The library's number of a column that is in its memory; None: it is an array."""
        return None if self._c is None else NUMBERS.get(name)

    def _refuse(self, name: object) -> UnknownKeyError:
        has = ", ".join(self.columns) or "none"
        if name in COLUMNS:
            return UnknownKeyError(f"the frame has no column {name!r}, only {has}: name it in columns= when the source is opened, "
                                   f'say columns="all", or set it by replace({name}=...)')
        if name in RAW_COLUMNS:
            is_place = name == "raw_place" and "tof" in self
            why = "its words came in the order of pixels" if is_place else f"open the source with raw=True, or give {name}"
            return UnknownKeyError(f"the frame has no column {name!r}, only {has}: {why}")
        near = nearest(str(name), (*COLUMNS, *RAW_COLUMNS, *self._own))
        return UnknownKeyError(f"there is no column {name!r}; " + (f"did you mean {near[0]!r}? " if near else "") +
                               f"there are {', '.join((*COLUMNS, *self._own))}")

    @overload
    def __getitem__(self, key: FloatColumn) -> Floats: ...
    @overload
    def __getitem__(self, key: Uint32Column) -> NDArray[np.uint32]: ...
    @overload
    def __getitem__(self, key: Union[Uint16Column, Literal["raw_place"]]) -> NDArray[np.uint16]: ...
    @overload
    def __getitem__(self, key: Union[Uint8Column, Literal["sensor"]]) -> NDArray[np.uint8]: ...
    @overload
    def __getitem__(self, key: Literal["tof"]) -> NDArray[np.int32]: ...
    @overload
    def __getitem__(self, key: Int16Column) -> NDArray[np.int16]: ...
    @overload
    def __getitem__(self, key: OwnColumn) -> Array: ...
    @overload
    def __getitem__(self, key: Places) -> Frame: ...

    def __getitem__(self, key: Any) -> Union[Array, Frame]:
        """A column, or a frame of some of the points.

            frame["range"]                   # (n,), of the type in COLUMNS: a view of the frame's memory
            frame[frame["range"] < 50]       # the points of a mask, copied
            frame[1000:2000], frame[::4]     # a slice: views
            frame[places]                    # an array of places in ascending order, copied

        In a frame of some points, lines tells where each line's points are now; number, clocks and losses are
        those of the whole frame.

        Raises:
            UnknownKeyError: the frame has no such column.
            OptionError: a mask has a wrong length, or places are invalid.
        """
        try:
            return self._arrays[key]
        except (KeyError, TypeError):
            pass
        if not isinstance(key, str):
            from ._build import select

            return select(self, key)
        if self._c is None or key not in NUMBERS:
            raise self._refuse(key)
        address = int(ffi.cast("uintptr_t", lib.lum_frame_column(self._c, NUMBERS[key])))
        if not address:
            raise self._refuse(key)
        made = np.asarray(Memory(self._c, address, (self._count,), None, COLUMNS[key]))
        self._arrays[key] = made
        return made

    def _array(self, name: str) -> Array:
        """A column by any text."""
        return self[cast("AnyColumn", name)]

    def __contains__(self, name: object) -> bool:
        """Whether it has a column."""
        return name in self.columns

    def __iter__(self) -> Iterator[AnyColumn]:
        """The names of its columns, as of a dictionary."""
        return iter(self.columns)

    def keys(self) -> tuple[AnyColumn, ...]:
        """The names of its columns: with this, dict(frame) works."""
        return self.columns

    @property
    def xyz(self) -> Floats:
        """x, y and z in metres: (n, 3) float32, a view of the frame's memory. x forward, y left, z up.

        Where x, y and z are arrays of a program that do not lie together, it is a copy that cannot be written to.
        """
        block = self._joined()
        if block is None:
            block = np.array([self["x"], self["y"], self["z"]], "f4").T
            block.flags.writeable = False
        return block

    def _joined(self) -> Optional[Floats]:
        """x, y and z as one view; None: they do not lie together."""
        if self._block is None and self._c is not None:
            spacing = ffi.new("size_t *")
            first = lib.lum_frame_xyz(self._c, spacing)
            if first:
                address, row = int(ffi.cast("uintptr_t", first)), 4 * max(spacing[0], 1)
                memory = Memory(self._c, address, (self._count, 3), (4, row), np.dtype("f4"))
                self._block = np.asarray(memory)
        return self._block

    @property
    def lines(self) -> Records:
        """Its lines, in the order in which they were complete: a structured array.

        number, eye (0 blue, 1 green), first_point and point_count (its points are those from first_point on),
        angle_count (pixels with angles, of 1000), lost_words, clock_us (the sensor's clock), arrival_ns (since 1970).
        """
        if self._lines_made is None:
            self._lines_made = _lines.of_library(self._c)
        return self._lines_made

    def grid(self, column: ImageColumn, eye: Optional[Eye] = None, returns: int = 1, lines: Optional[int] = None) -> Floats:
        """A column as a grid: (lines, 1000) float32, or (lines, 1000, returns) where returns is above 1.

        "xyz" gives all three coordinates: (lines, 1000, 3), or (lines, 1000, returns, 3).

        Cells without a point are NaN. Cell [line, pixel, k] is the k-th point of that pixel among those of the frame.
        Needs the column "pixel". eye may be left out where the frame has lines of one eye alone. lines is the
        number of rows; without it, the plausible line numbers of this eye decide, since
        a damaged packet can claim any. A warning says which lines with points have no row.
        """
        return _grid.grid(self, column, eye, returns, lines)

    # What it was made of.

    @property
    def angles(self) -> NDArray[np.int16]:
        """The raw angles of its lines, azimuth and elevation of each pixel: (lines, 1000, 2) int16. Of open(raw=True)."""
        return raw_of(self).angles

    @property
    def has_angles(self) -> NDArray[np.bool_]:
        """Which pixels of its lines have angles: (lines, 1000) bool; the others are 0 in angles. Of open(raw=True)."""
        return raw_of(self).has_angles()

    @property
    def packets(self) -> Records:
        """The packets that its lines were made of, a structured array. Of open(raw=True).

        line (its place in frame.lines), tag (2 angles, 3 ranges), first_sample_index, num_samples, bad_words (of these, words that
        were skipped), clock_raw (ticks as sent), arrival_ns, order (in which packets were accepted). A line has all that were
        accepted; or none, where not all are known: after a seek, if it began before the place where reading continued.
        """
        return raw_of(self).packets

    @property
    def profile(self) -> Profile:
        """The profile that it was read with. Of open(raw=True)."""
        origin = raw_of(self).origin
        return Profile() if origin is None else origin.profile

    def with_raw(self, angles: Any, has_angles: Any = None, packets: Any = None, profile: Any = None) -> Frame:
        """The frame with other angles and packets, for write_capture().

        Args:
            angles: as the property has them, for the lines of this frame.
            has_angles: likewise; without it, all pixels have angles.
            packets: likewise; without them, lines are cut as the sensor does it.
            profile: for the clocks of these packets; without it, the frame's own.
        """
        from ._build import assemble

        raw = attach(self, angles, has_angles, packets, profile)
        return assemble(self._info, self.to_dict(), self.lines, self._moved, self._joined(), raw)

    def to_lines(self) -> list[Line]:
        """Its lines as values, in copies. Of open(raw=True)."""
        from ._write import to_lines

        return to_lines(self)

    # Other frames of it, and frames of arrays.

    @classmethod
    def from_arrays(cls, columns: Optional[Mapping[str, ArrayLike]] = None, /, *, lines: Optional[Records] = None,
                    number: Optional[int] = None, sensor: Optional[str] = None, utc_ns: int = 0, utc_error_ns: Optional[int] = None,
                    clock_us: Optional[int] = None, **more: ArrayLike) -> Frame:
        """A frame of a program's own arrays, which it keeps: they are not copied if they have the columns' types.

            lumsdk.Frame.from_arrays(xyz=points, intensity=intensity)
            lumsdk.Frame.from_arrays(numpy.asarray(frame), lines=frame.lines, number=frame.number, utc_ns=frame.utc_ns)
            lumsdk.Frame.from_arrays(numpy.load("frame.npy"))

        The columns of files that are not of points are used where nothing else says the same: frame, which has to be one, for
        number; timestamp for the clocks of lines, where there are neither lines nor clock_us, and for utc_ns if it is UTC; sensor for
        the address. Places in a rig cannot be used: they are left out, and a warning says so.

        Args:
            columns: arrays by their names, or a structured array; keywords do the same. Those of COLUMNS are converted to its
                types where no number changes. xyz, (n, 3), stands for x, y and z. Others are columns of one's own.
            lines: as Frame.lines; without it they are made from the columns line and eye. Without both there are none, and
                no grid, and files without the columns line, eye and timestamp.
            number: the frame's, below 2 ** 31, as files have it; 0 if nothing says it.
            sensor: the address of its sensor, such as "10.42.0.37"; "0.0.0.0" if nothing says it.
            utc_ns: when its earliest line was measured, nanoseconds since 1970 UTC; 0: not known.
            utc_error_ns: how far off that may be; None: not known.
            clock_us: the same moment on the sensor's clock; without it, that of the earliest line, else 0.

        Raises:
            OptionError: values do not fit, lengths differ, or lines are not those of the columns.
            TypeError: what is given is no array of numbers.
        """
        from ._build import from_arrays

        return from_arrays(columns, more, lines, number, sensor, utc_ns, utc_error_ns, clock_us)

    def replace(self, columns: Optional[Mapping[str, ArrayLike]] = None, /, **more: ArrayLike) -> Frame:
        """The frame with other values in some columns: frame.replace(x=..., range=...). It shares all others.

        Takes columns of COLUMNS, also those that the frame lacks, xyz, and the frame's own ones. As from_arrays(), it keeps
        arrays of the right type. If all points of each line get a new line or eye, lines has it, too.
        """
        from ._build import replace

        return replace(self, columns, more)

    def with_columns(self, columns: Optional[Mapping[str, ArrayLike]] = None, /, **more: ArrayLike) -> Frame:
        """The frame with columns of one's own: frame.with_columns(label=labels). It shares all others.

        A column is one number a point: bool, integers or floats. The array is kept as it is, and can be written to if it could
        be before. Names are letters of ASCII, digits and _, and none of COLUMNS. convert() writes them into all formats that
        have named columns.
        """
        from ._build import with_columns

        return with_columns(self, columns, more)

    # The sensor's motion.

    def deskew(self, poses: Poses, to: Moment = "start", outside: Outside = "nan") -> Frame:
        """The frame as if the sensor had stood still: each point is moved by the sensor's motion since, or until, a moment.

        Args:
            poses: where the sensor was.
            to: the moment: when the frame began, or halfway between its earliest and its latest line.
            outside: what becomes of points whose time has no pose: "nan", and a warning tells how many; "nearest" moves them
                by the nearest pose; "raise" refuses the frame.

        Returns:
            A frame with the same columns, where x, y and z are moved. Needs the columns x, y, z and time. A frame that was
            moved is not moved again.
        """
        from ._poses import move

        if to not in ("start", "middle"):
            raise ValueError(f'to is {to!r}; use "start" or "middle"; frame.to_world() moves into the world')
        return move(self, poses, to, None, outside)

    def to_world(self, poses: Poses, origin: Optional[Sequence[float]] = None, outside: Outside = "nan") -> Frame:
        """The frame in the poses' fixed frame, each point by the pose of its own time.

        Args:
            poses: where the sensor was.
            origin: x, y, z in metres, which is subtracted: float32 loses more than half a millimetre farther than 5 km from 0.
                Without one a warning says so; poses.origin() gives one.
            outside: as deskew() has it.

        Returns:
            A frame as deskew() returns it.
        """
        from ._poses import move

        return move(self, poses, "world", origin, outside)

    # Pictures.

    def image(self, column: ImageColumn, eye: Eyes = "both", returns: Filling = "nearest", *,
              view: Optional[Sequence[float]] = None, rows: Optional[int] = None, columns: Optional[int] = None) -> Floats:
        """A column as a picture oriented like the scene: (rows, columns) float32, NaN where there is no point.

        Rows are elevations, from the highest down, and columns are azimuths, from left to right as one looks forward, both
        seen from the sensor's origin. Raw lines, as of grid(), bend and alternate in direction; here a straight edge is
        straight. "xyz" gives all three coordinates: (rows, columns, 3).

        Args:
            column: The name of a column, or "xyz".
            eye: "blue" (it looks right), "green" (left), or "both" as one picture of 120 degrees.
            returns: Which of the points that lie in a pixel fills it: "nearest", "farthest", "strongest" (the widest pulse;
                needs the column "pulse_width"), "first" or "last" in the frame.
            view: Degrees at the left, right, top and bottom edge. (60, -60, 3, -17) for both eyes, without it; green ends
                and blue begins at 0. A warning says how many points lie outside.
            rows: Without it, as many as the lines, rounded up to a multiple of 64.
            columns: 800 for an eye and 1600 for both, without it.
        """
        for name in ("x", "y", "z") if column == "xyz" else (column,):
            if name not in self.columns:
                raise self._refuse(name)
        index = self.image_index(eye, returns, view=view, rows=rows, columns=columns)
        if column == "xyz":
            return np.stack([_image.take(self, cast("AnyColumn", name), index) for name in "xyz"], axis=-1)
        return _image.take(self, column, index)

    def image_index(self, eye: Eyes = "both", returns: Filling = "nearest", *, view: Optional[Sequence[float]] = None,
                    rows: Optional[int] = None, columns: Optional[int] = None) -> NDArray[np.int32]:
        """Which point fills each pixel of image(): (rows, columns) int32, -1 for none.

        ``index[mask]`` are the points that fill the pixels of a mask, with -1 for empty ones. All points that lie in
        them, also those that lost their pixel to another one, are found by image_pixels().
        """
        return _image.index(self, eye, returns, view, rows, columns, pixels=False)

    def image_pixels(self, eye: Eyes = "both", *, view: Optional[Sequence[float]] = None, rows: Optional[int] = None,
                     columns: Optional[int] = None) -> NDArray[np.int32]:
        """In which pixel of image() each point lies, whether it fills it or not: (n,) int32, row x columns + column.

        -1: it lies outside, or is of another eye. So ``(pixels >= 0) & mask.ravel()[pixels]`` are all points in a mask.
        """
        return _image.index(self, eye, "nearest", view, rows, columns, pixels=True)

    def to_png(self, colour: PictureColour = "range", size: tuple[int, int] = (1600, 1200)) -> bytes:
        """From above, and as both eyes see it, in width and height of 640 to 8000 pixels, as lumdump draws it. Needs matplotlib.

        "height" is z; "label" a column of whole numbers that with_columns() added.
        """
        from ._notebook import to_png
        return to_png(self, colour, size)

    def project(self, K: ArrayLike, T: ArrayLike, distortion: Optional[Sequence[float]] = None,
                size: Optional[tuple[int, int]] = None) -> Projection:
        """Where its points are in a camera's picture.

            seen = frame.project(K, T, distortion=(k1, k2, p1, p2, k3), size=(1920, 1080))
            draw(seen.pixels[seen.visible], seen.depth[seen.visible])

        A frame that was taken while the sensor moved is corrected first: frame.deskew(poses).project(...).

        Args:
            K: the camera's matrix, [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], in pixels.
            T: what takes points of the sensor, or with a rig of the vehicle, as columns, into the camera's frame, which OpenCV
                has with x to the right, y downwards and z forward: (4, 4) or (3, 4).
            distortion: k1 k2 p1 p2 [k3 [k4 k5 k6]], as OpenCV has them.
            size: (width, height) of the picture; without it, all points in front of the camera are visible.

        Returns:
            pixels, depth and visible, in the order of the points. Where the distortion would bring points from far outside back
            into the picture, they are not visible.

        Raises:
            OptionError: a matrix, the distortion or the size is invalid.
        """
        from ._project import project

        return project(self.xyz, K, T, distortion, size)

    # Into other forms.

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Array:
        """numpy.asarray(frame): as to_structured()."""
        if copy is False:
            raise ValueError("a frame is several arrays, and a structured array is a copy of them: use copy=None, or one "
                             'column as frame["x"], or frame.xyz')
        if dtype is not None and np.dtype(dtype).names is None and np.dtype(dtype) != object:
            raise TypeError(f"a frame is not one array of {np.dtype(dtype)}: frame.xyz has the coordinates, (n, 3), and "
                            'frame["x"] is one column')
        made = self.to_structured()
        return made if dtype is None else made.astype(dtype, copy=False)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """For libraries that take Arrow's C stream, such as pyarrow.table(frame) and polars.DataFrame(frame): as to_arrow().

        One record batch, without a copy where Arrow has the type. Needs pyarrow.
        """
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def to_dict(self) -> dict[str, Array]:
        """Its columns by their names, as views."""
        return {name: self[name] for name in self.columns}

    def to_structured(self) -> Records:
        """A copy as a structured array: (n,), with a field for each column."""
        made = np.empty(self._count, [(name, column.dtype) for name, column in self.to_dict().items()])
        fill(made, self.to_dict().values())
        return made

    def to_arrow(self, columns: Union[Literal["all"], Iterable[TableColumn], None] = None,
                 preset: Optional[Preset] = None) -> pyarrow.Table:
        """As a table of Arrow, without a copy where Arrow has the type. Needs pyarrow."""
        from ._table import to_arrow

        return to_arrow(self, columns, preset)

    def to_pandas(self, columns: Union[Literal["all"], Iterable[TableColumn], None] = None,
                  preset: Optional[Preset] = None) -> pandas.DataFrame:
        """As a DataFrame. Needs pandas."""
        from ._table import to_pandas

        return to_pandas(self, columns, preset)

    def _repr_html_(self) -> Optional[str]:
        """In a notebook: its picture, if matplotlib is there, and its counts."""
        from ._notebook import to_html

        return to_html(self)

    # As a value.

    def __repr__(self) -> str:
        info = self._info
        state = "complete" if info.is_complete else "incomplete"
        lines = ", ".join(f"{count} {eye}" for eye, count in zip(EYES, info.lines))
        return f"<Frame {info.number} of {self.sensor}: {self._count} points, lines {lines}, {state}>"

    def __eq__(self, other: object) -> bool:
        """Whether all columns, lines and clocks are the same, bit by bit. angles and packets are not compared."""
        if not isinstance(other, Frame):
            return NotImplemented
        return (self.columns == other.columns and self._info == other._info and np.array_equal(self.lines, other.lines)
                and all(self[name].dtype == other[name].dtype and self[name].tobytes() == other[name].tobytes()
                        for name in self.columns))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        from ._build import restore

        return restore, (vars(self._info), self.to_dict(), self.lines, self._moved, self._raw)
