"""The formats that Python writes: LAZ, Parquet, Feather, npy, npz and KITTI's bin. A writer takes frames one by one."""
from __future__ import annotations

import json
import shutil
import struct
import tempfile
import uuid
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, BinaryIO, ClassVar, Optional, Union

import numpy as np

from ._c import cores
from ._columns import fill
from ._errors import Error, OptionError, install
from ._points_file import check_own, file_type
from ._table import COLUMNS, OF_RIG, Array, Layout, about_frame, arrow_batch, arrow_schema, extra, value
from ._target import Target, UrlTarget

if TYPE_CHECKING:
    from ._frame import Frame

AnyTarget = Union[Target, UrlTarget]


# --- Where the points come from ---


@dataclass
class About:
    """Where the points of a file come from."""

    program: str
    source: str
    options: list[str] = field(default_factory=list)
    calibration: str = ""
    """YAML with all keys."""
    profile: str = ""
    """YAML with all keys."""
    usual_calibration: bool = True
    usual_profile: bool = True
    rig: list[str] = field(default_factory=list)
    """Its sensors, a line each, if there are several: then there is no single calibration or profile."""
    earlier: list[str] = field(default_factory=list)
    """What the source itself says of its origin."""
    is_of_frames: bool = False
    """Whether they are of frames, which know the rig that they were read with, and neither calibration nor profile."""

    def text(self) -> str:
        """As lumdump writes it into files: YAML documents, with --- between them."""
        lines = ["# lumsdk origin 1", f"program: {json.dumps(self.program)}", f"source: {json.dumps(self.source)}"]
        if self.options:
            lines += ["options:", *(f"  - {json.dumps(option)}" for option in self.options)]
        if self.rig:
            lines += ["rig:", *(f"  - {json.dumps(sensor)}" for sensor in self.rig)]
        elif not self.is_of_frames:
            lines.append(f"calibration: {'built-in' if self.usual_calibration else 'below'}")
            lines.append(f"profile: {'built-in' if self.usual_profile else 'below'}")
        documents = ["\n".join(lines) + "\n"]
        if not self.usual_calibration:
            documents.append(f"# lumsdk calibration 1\n{self.calibration}")
        if not self.usual_profile:
            documents.append(f"# lumsdk profile 1\n{self.profile}")
        return "---\n".join(documents + self.earlier)

    def metadata(self) -> dict[str, str]:
        """As keys and texts. A name may have bytes that are no text."""
        source = self.source.encode(errors="surrogateescape").decode(errors="replace")
        made = {"lumsdk.program": self.program, "lumsdk.source": source}
        if self.options or not self.is_of_frames:
            made["lumsdk.options"] = json.dumps(self.options)
        if self.rig:
            made["lumsdk.rig"] = json.dumps(self.rig)
        elif not self.is_of_frames:
            made.update({"lumsdk.calibration": self.calibration, "lumsdk.profile": self.profile})
        return made


@dataclass
class Job:
    """What a writer is to write."""

    target: AnyTarget
    about: About
    layout: Layout
    time: str = "sensor"
    compression: Optional[str] = None


_AT_ONCE = 32768
"""As many points stay in a cache while they are made into what a file has of them."""


def _parts(frame: Frame) -> Iterator[Frame]:
    """A frame in parts, so that what is made of its points is small, and memory is used again."""
    for first in range(0, len(frame), _AT_ONCE):
        yield frame[first:first + _AT_ONCE]


class Writer:
    """A file of one format. Frames are added one by one, then finish() completes what is in the file."""

    name: ClassVar[str]
    module: ClassVar[str] = ""
    compressions: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[Optional[tuple[str, ...]]] = None
    """The columns of frames if the layout does not decide."""

    is_alone: ClassVar[bool] = False
    """Whether next to nothing else runs while it writes: a frame that is read meanwhile would only take memory."""

    _writer: Any = None
    """That of another library, if it writes the format."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._file: BinaryIO = job.target.file

    def add(self, frame: Frame) -> None:
        """Append the points of a frame."""
        raise NotImplementedError

    def finish(self, losses: dict[str, int]) -> None:
        """Complete what is in the file."""

    def abort(self) -> None:
        """Let go of all that the file needed; what is in it does not matter any more."""
        if self._writer is not None:
            self._writer.close()


# --- LAZ ---

_SCALE = 0.0001
_LIMIT = 214748.0
_UNIX_TO_ADJUSTED_S = 1315964782
_ABOUT_LAS = ("Points of a Luminar Model G2: metres, x forward, y left, z up. intensity: pulse width in units of 0.01 ns, "
              "655.35 ns or more as 65535. gps_time: adjusted standard GPS time (UTC + 18 s) if the global encoding says "
              "so, else seconds of the sensor's clock. return_number and number_of_returns above 15 stand as 15; the "
              "extra bytes hold them whole. scanner_channel: 0 blue eye, 1 green eye. scan_angle: azimuth.")
_EXTRAS = (("range", "f4", "metres from the eye"), ("azimuth", "f4", "degrees, of the eye"),
           ("elevation", "f4", "degrees, of the eye"), ("pulse_width", "f4", "nanoseconds, 0 if unknown"),
           ("frame", "i4", "number of the frame"), ("line", "u4", "number of the line"),
           ("pixel", "u2", "of the line, 0 to 999"), ("full_return_number", "u2", "from 1, of the edge"),
           ("full_number_of_returns", "u2", "of the pixel and edge"), ("eye", "u1", "0 blue, 1 green"),
           ("edge", "u1", "1 rising, 0 falling"))
_DATE_AT = 90


_CHUNK = 50_000
"""Points of lazrs's chunks. Each is compressed by one thread."""


def _compressed_at_once() -> int:
    """Points: a chunk or more for each core, up to 8 because of memory, and at least four, so that little time passes between."""
    return _CHUNK * min(cores(), 8) * -(-4 // cores())


def _away(numbers: Array, unit: float) -> Array:
    """In units, rounded, half a unit away from zero."""
    scaled = numbers.astype("f8")
    scaled /= unit
    scaled += np.copysign(0.5, scaled)
    return np.asarray(np.trunc(scaled, out=scaled))


class Laz(Writer):
    """LAS 1.4, point format 6 with extra bytes, compressed: field by field what lumdump writes as LAS."""

    name = "laz"
    module = "laspy"
    is_alone = True  # lazrs uses all cores, and keeps the lock of the interpreter
    needs = ("x", "y", "z", "range", "azimuth", "elevation", "pulse_width", "line", "pixel", "return_number",
             "number_of_returns", "eye", "edge")

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        self._laspy = extra("laspy", "laz")
        extra("lazrs", "laz")
        header = self._header()
        self._format = header.point_format
        self._records: Any = np.zeros(_compressed_at_once(), self._format.dtype())
        self._held = 0  # of the records, those that wait to be compressed
        self._writer = self._laspy.LasWriter(self._file, header, do_compress=True, closefd=False,
                                             laz_backend=self._laspy.LazBackend.LazrsParallel)

    def _header(self) -> Any:
        laspy = self._laspy
        header = laspy.LasHeader(point_format=6, version="1.4")
        own = self._job.layout.own
        check_own("las", None, own)
        header.add_extra_dims([laspy.ExtraBytesParams(name, dtype, about) for name, dtype, about in _EXTRAS]
                              + [laspy.ExtraBytesParams(name, file_type("las", dtype), OF_RIG.description if name == "sensor" else "")
                                 for name, dtype in own.items()])
        header.scales, header.offsets = np.full(3, _SCALE), np.zeros(3)
        header.system_identifier = "Luminar Model G2"
        header.generating_software = self._job.about.program
        header.uuid = uuid.UUID(int=0)
        header.global_encoding.wkt = True
        if self._job.time != "sensor":
            header.global_encoding.gps_time_type = laspy.header.GpsTimeType.STANDARD
        header.vlrs.append(laspy.VLR("LASF_Spec", 3, "what the fields mean", _ABOUT_LAS.encode()))
        header.vlrs.append(laspy.VLR("lumsdk", 1, "where the points come from", self._job.about.text().encode()))
        return header

    def add(self, frame: Frame) -> None:
        first = 0
        while first < len(frame):
            part = frame[first:first + min(_AT_ONCE, len(self._records) - self._held)]
            columns = self._columns(part)
            self._note(columns)
            fill(self._records[list(columns)][self._held:self._held + len(part)], columns.values())
            self._held += len(part)
            first += len(part)
            if self._held == len(self._records):
                self._compress()

    def _compress(self) -> None:
        if self._held:
            # Not by its own write_points(), which searches the records for what _note() knows.
            self._writer.point_writer.write_points(self._laspy.PackedPointRecord(self._records[:self._held], self._format))
        self._held = 0

    def _note(self, columns: dict[str, Array]) -> None:
        """What the header says of the points."""
        header = self._writer.header
        header.point_count += len(columns["X"])
        header.mins = np.minimum(header.mins, [columns[axis].min() * _SCALE for axis in "XYZ"])
        header.maxs = np.maximum(header.maxs, [columns[axis].max() * _SCALE for axis in "XYZ"])
        numbers = np.bincount(columns["bit_fields"] & 15, minlength=16)[1:]
        header.number_of_points_by_return += numbers.astype(header.number_of_points_by_return.dtype)

    def _columns(self, frame: Frame) -> dict[str, Array]:
        """What records have of points, by the names of the fields."""
        for name in "xyz":
            metres = value(frame, name)
            if not -_LIMIT < metres.min() <= metres.max() < _LIMIT:
                raise OptionError(f"a point of frame {frame.number} lies farther than {_LIMIT:.0f} m from the origin, which "
                                  f"LAS cannot hold at a scale of {_SCALE:g} m")
        width = value(frame, "pulse_width")
        number, count = (np.minimum(value(frame, name), 15).astype("u1") for name in ("return_number", "number_of_returns"))
        return {
            **{name.upper(): _away(value(frame, name), _SCALE) for name in "xyz"},
            "intensity": np.clip(np.floor(width.astype("f8") * 100.0 + 0.5), 0, 65535),
            "bit_fields": number | count << 4,
            "classification_flags": (value(frame, "eye") & 3) << 4,
            "scan_angle": np.clip(_away(value(frame, "azimuth"), 0.006), -30000, 30000),
            "gps_time": self._seconds(value(frame, "timestamp", self._job.time)),
            **{name: value(frame, name[5:] if name.startswith("full_") else name) for name, _, _ in _EXTRAS},
            **{name: value(frame, name) for name in self._job.layout.own}}

    def _seconds(self, us: Array) -> Array:
        whole = np.trunc(us / 1000000).astype("i8")
        shift = 0 if self._job.time == "sensor" else _UNIX_TO_ADJUSTED_S
        return np.asarray((whole - shift).astype("f8") + (us - whole * 1000000).astype("f8") / 1e6)

    def finish(self, losses: dict[str, int]) -> None:
        self._compress()
        self._writer.close()
        self._file.seek(_DATE_AT)
        self._file.write(bytes(4))  # no date: equal points make equal files
        self._file.seek(0, 2)


# --- Parquet and Feather ---


class Parquet(Writer):
    """Parquet: a row group a frame, metadata of the file and of each column."""

    name = "parquet"
    module = "pyarrow"
    compressions = ("lz4", "zstd", "snappy", "gzip", "none")

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        pq = extra("pyarrow.parquet", "parquet")
        if not hasattr(pq.ParquetWriter, "add_key_value_metadata"):
            raise Error(f"pyarrow is too old, 16 or later is needed: {install('parquet')}")
        self._schema = arrow_schema(job.layout, job.about.metadata())
        types = {name: COLUMNS[name].dtype for name in job.layout.columns if name in COLUMNS}
        # Dictionaries of these take longer than their compression, which finds what repeats when a float's bytes lie apart.
        by = {name: "BYTE_STREAM_SPLIT" if dtype.kind == "f" else "PLAIN" for name, dtype in types.items()
              if job.layout.about(name)[0] == dtype}
        self._writer = pq.ParquetWriter(self._file, self._schema, compression=job.compression or "lz4", column_encoding=by,
                                        use_dictionary=[name for name in job.layout.columns if name not in by] or False)
        self._frames: list[str] = []

    def add(self, frame: Frame) -> None:
        batch = arrow_batch(self._job.layout, frame, self._schema)
        self._writer.write_batch(batch, row_group_size=max(1, len(frame)))
        self._frames.append(json.dumps(about_frame(frame)))

    def finish(self, losses: dict[str, int]) -> None:
        self._writer.add_key_value_metadata({"lumsdk.frames": f"[{', '.join(self._frames)}]",
                                             "lumsdk.losses": json.dumps(losses)})
        self._writer.close()


class Feather(Writer):
    """Feather version 2, which is Arrow's IPC file: a record batch a frame."""

    name = "feather"
    module = "pyarrow"
    compressions = ("lz4", "zstd", "none")

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        pa = extra("pyarrow", "parquet")
        compression = job.compression or "lz4"
        options = pa.ipc.IpcWriteOptions(compression=None if compression == "none" else compression)
        self._schema = arrow_schema(job.layout, job.about.metadata())
        self._writer = pa.ipc.new_file(self._file, self._schema, options=options)

    def add(self, frame: Frame) -> None:
        batch = arrow_batch(self._job.layout, frame, self._schema)
        self._writer.write_batch(batch, custom_metadata={"lumsdk.frame": json.dumps(about_frame(frame))})

    def finish(self, losses: dict[str, int]) -> None:
        self._writer.close()


# --- npy, npz and KITTI ---


def npy_header(dtype: np.dtype[Any], count: Optional[int]) -> bytes:
    """The header of an npy file of one dimension. It has the same length for every count; None is scalar."""
    shape = "()" if count is None else f"({count},)"
    text = f"{{'descr': {np.lib.format.dtype_to_descr(dtype)!r}, 'fortran_order': False, 'shape': {shape}, }}"
    room = len(text) - len(shape) + 24
    total = -(-(10 + room + 1) // 64) * 64
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", total - 10) + text.encode().ljust(total - 11) + b"\n"


class Npy(Writer):
    """An array of records, a field a column, of all frames."""

    name = "npy"

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        from concurrent.futures import Future, ThreadPoolExecutor

        self._dtype = job.layout.dtype()
        self._records = np.empty((2, _AT_ONCE), self._dtype)  # one is written while the other is filled
        self._thread = ThreadPoolExecutor(1, "lumsdk-write")
        self._under_way: Optional[Future[int]] = None
        self._count = 0
        self._file.write(npy_header(self._dtype, 0))

    def add(self, frame: Frame) -> None:
        self._count += len(frame)
        for part in _parts(frame):
            self._records = self._records[::-1]
            records = self._records[0, :len(part)]
            fill(records, self._job.layout.values(part))
            self._wait()
            self._under_way = self._thread.submit(self._file.write, records.data)

    def _wait(self) -> None:
        if self._under_way is not None:
            self._under_way.result()

    def abort(self) -> None:
        self._thread.shutdown()

    def finish(self, losses: dict[str, int]) -> None:
        self._wait()
        self.abort()
        self._file.seek(0)
        self._file.write(npy_header(self._dtype, self._count))
        self._file.seek(0, 2)


_BLOCK = 1 << 20


class Npz(Writer):
    """An array a column, of all frames, and "metadata", a text of JSON.

    Each column grows in a file of its own beside the target until the end, so that memory does not grow.
    """

    name = "npz"

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        self._columns = [tempfile.TemporaryFile(dir=job.target.folder) for _ in job.layout.columns]
        self._count = 0
        self._frames: list[dict[str, Any]] = []

    def add(self, frame: Frame) -> None:
        for part in _parts(frame):
            for file, column in zip(self._columns, self._job.layout.values(part)):
                file.write(np.ascontiguousarray(column).data)
        self._count += len(frame)
        self._frames.append(about_frame(frame))

    def finish(self, losses: dict[str, int]) -> None:
        with zipfile.ZipFile(self._file, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, file in zip(self._job.layout.columns, self._columns):
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                    member.write(npy_header(self._job.layout.about(name)[0], self._count))
                    file.seek(0)
                    shutil.copyfileobj(file, member, _BLOCK)
            about = {**self._job.about.metadata(), "lumsdk.frames": self._frames, "lumsdk.losses": losses}
            text = np.array(json.dumps(about))
            archive.writestr(zipfile.ZipInfo("metadata.npy"), npy_header(text.dtype, None) + text.tobytes())
        self.abort()

    def abort(self) -> None:
        for file in self._columns:
            file.close()


_FULL_NS = np.float32(25.5)


class Kitti(Writer):
    """KITTI's bin: x, y, z and reflectance as float32, without a header."""

    name = "bin"
    needs = ("x", "y", "z", "pulse_width")

    def add(self, frame: Frame) -> None:
        for part in _parts(frame):
            out = np.empty((len(part), 4), "<f4")
            for i, name in enumerate("xyz"):
                out[:, i] = value(part, name)
            np.minimum(value(part, "pulse_width") / _FULL_NS, 1, out=out[:, 3])
            self._file.write(out.data)


WRITERS: dict[str, type[Writer]] = {kind.name: kind for kind in (Laz, Parquet, Feather, Npy, Npz, Kitti)}
"""The formats that Python writes, by name; the ending of a file is a dot and this name."""
