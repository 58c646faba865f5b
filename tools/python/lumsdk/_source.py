"""Captures as sources of frames."""
from __future__ import annotations

import datetime
import warnings
from collections.abc import Iterator, Sequence
from typing import IO, TYPE_CHECKING, Any, Optional, Union, overload

from ._errors import CaptureWarning, ClosedError
from ._frame import Frame
from ._inputs import Input, open_input
from ._options import Choice
from ._reading import LOSSES, Reading
from ._settings import Calibration, Profile

if TYPE_CHECKING:
    import os

    from typing_extensions import Buffer, Unpack

    from ._options import Options

    Path = Union[str, os.PathLike[str]]
    Given = Union[Path, Sequence[Path], Buffer, IO[bytes]]


class Frames(Iterator[Frame]):
    """The frames of one pass over a source."""

    def __init__(self, source: Source, reading: Reading) -> None:
        """Made by iter() of a source."""
        self._source, self._reading = source, reading

    def __next__(self) -> Frame:
        frame = self._reading.next()
        if frame is None:
            self._source._note_end(self._reading)
            raise StopIteration
        return frame

    def __length_hint__(self) -> int:
        """About how many frames are left: for progress bars."""
        total = self._source.__length_hint__()
        return max(total - self._reading.frames, 0)


class Source:
    """A capture, or several as one: a source of frames, made by open().

    Each iteration gives its frames from the start. Only one thread at a time may use an iteration; two sources share
    nothing, so each thread opens its own. Frames, and arrays of them, stay valid after the source is closed.
    """

    def __init__(self, source: Input, choice: Choice) -> None:
        """Programs use open()."""
        self._input, self._choice = source, choice
        self._closed = False
        self._origins: list[str] = []
        self._frame_count: Optional[int] = None
        self._settings = self._ask()
        self._ready: Optional[Reading] = self._read()
        self._latest: Reading = self._ready

    def _ask(self) -> tuple[Calibration, Profile]:
        """The calibration and the profile, those of the capture where none is named."""
        choice = self._choice
        named = choice.calibration, choice.profile
        capture = self._input.ask()
        if capture is not None:
            from ._provenance import Provenance

            found = Provenance(capture, *named, (choice.names_calibration, choice.names_profile))
            for note in found.notes:
                warnings.warn(note, CaptureWarning, stacklevel=4)
            named = found.calibration, found.profile
            self._origins = found.origins
        return choice.with_set(*named)

    def _read(self) -> Reading:
        return Reading(self._input, self._choice, self._settings)

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"{self.name}: the source is closed; open it again to read it")

    def _note_end(self, reading: Reading) -> None:
        self._frame_count = reading.frames

    # Frames.

    def __iter__(self) -> Frames:
        """Begin at the start: the first frame comes next, also if another iteration is under way."""
        self._check_open()
        reading, self._ready = self._ready, None
        self._latest = reading or self._read()
        return Frames(self, self._latest)

    def __length_hint__(self) -> int:
        """About how many frames there are. It is exact once all were read, and 0 while nothing is known."""
        if self._frame_count is not None:
            return self._frame_count
        done, total = self._latest.progress()
        return self._latest.frames * total // done if done else 0

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, list[Frame]]:
        """Frames by their place in the order of the stream, from 0; below 0 from its end."""
        self._check_open()
        frames = list(Frames(self, self._read()))
        return frames[index]

    # What is known of it.

    @property
    def name(self) -> str:
        """What it is called in messages: its path, or the first of several."""
        return self._input.name

    @property
    def calibration(self) -> Calibration:
        """The calibration that points are made with: that of the option, else the capture's own, else the built-in."""
        return self._settings[0]

    @property
    def profile(self) -> Profile:
        """The wire profile that packets are read with, chosen as the calibration is."""
        return self._settings[1]

    @property
    def provenance(self) -> list[str]:
        """Where the capture says that it comes from: texts of YAML, the nearest origin first."""
        return list(self._origins)

    @property
    def counts(self) -> dict[str, int]:
        """What was counted so far in the latest iteration, with the names of `lumdump --json`: packets, lines, losses."""
        return dict(self._latest.count().counts)

    @property
    def losses(self) -> dict[str, int]:
        """What was lost so far in the latest iteration, by cause, with lumdump's names.

        no_range counts words without a range above zero. Those that end with under_way are parts of
        lines_missing_angles, lost_words and no_angle that are no losses: they come from lines that were under way when
        the recording began or ended.
        """
        counts = self._latest.count().counts
        return {name: counts[name] for name in LOSSES}

    @property
    def sensors(self) -> list[str]:
        """The addresses of the sensors that sent data so far in the latest iteration, such as "10.42.0.37"."""
        return list(self._latest.count().sensors)

    @property
    def progress(self) -> tuple[int, int]:
        """Bytes that the latest iteration has read, and all of them; 0: not known."""
        return self._latest.progress()

    @property
    def truncated(self) -> bool:
        """Whether the latest iteration found that the capture breaks off before its end."""
        return self._latest.truncated

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    def __repr__(self) -> str:
        if self._closed:
            return f"<Source {self.name}: closed>"
        frames = f"{self._latest.frames} frames read"
        done, total = self._latest.progress()
        return f"<Source {self.name}: {frames}" + (f", {100 * done // total} %>" if total else ">")

    # Its end.

    def close(self) -> None:
        """Close it. Its frames, and arrays of them, stay valid. What was counted can still be asked for."""
        for reading in (self._latest, self._ready):
            if reading is not None:
                reading.close()
        self._closed, self._ready = True, None
        self._input.close()

    def __enter__(self) -> Source:
        self._check_open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def seek(self, time: Union[datetime.datetime, int, float]) -> None:
        """Let the next iteration begin at a time."""
        raise NotImplementedError


def open(source: Given, **options: Unpack[Options]) -> Source:
    """Open a capture, or several as one.

    source is a path; a pattern such as "drive-*.pcap"; a list of these; the bytes of a capture; a binary file object,
    which is read from where it stands; or a URL, by fsspec. Captures are pcap or pcapng, also compressed by gzip or
    zstd. Several are read as one stream, by their times.

    Options are those of lumdump, by the same names; all but set and progress may be texts as lumdump takes them:

    columns      names of columns, or "all"; x y z range pulse_width line pixel eye if not given (COLUMNS has all)
    returns      "all", "first", "last", "strongest", or the one of a number from 1, of each pixel
    edge         "rising", "falling" or "both"
    eye          "blue", "green" or "both"
    sensor       only this one, such as "10.42.0.37"
    frames       numbers of frames: (first, last), both included and either None, or one number
    range        (min, max) metres from the eye, both included and either None
    box          three such pairs for x, y and z in metres
    incomplete   "keep" or "drop" lines that lack angles or words
    smooth       0 for off, a window such as 31, or (window, order): angles are smoothed along each line
    calibration  a path, a mapping, a text of YAML, or a Calibration
    profile      likewise a Profile
    set          single keys of both, {"group.line.at": 14} or ["group.line.at=14"]
    broken       "raise" a CaptureError where a capture breaks off, once all frames before that have come; or "warn",
                 as lumdump does
    progress     a function that is called with the bytes read and the bytes in all (0: not known)

    Raises CaptureError if a source cannot be read, OptionError for a value that is not allowed, TypeError for one of a
    wrong type and for an option that is not known.
    """
    choice = Choice(options)
    return Source(open_input(source), choice)
