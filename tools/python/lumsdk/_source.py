"""Captures as sources of frames."""
from __future__ import annotations

import datetime
import itertools
import math
import operator
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union, overload

from ._c import LOSSES
from ._errors import ClosedError, OptionError, warn
from ._frame import Frame
from ._inputs import Input, open_input
from ._options import Choice
from ._reading import Reading
from ._settings import Calibration, Profile

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._rig import Rig
    from ._types import Given, Options


class Frames(Iterator[Frame]):
    """The frames of one pass over a source."""

    def __init__(self, source: Source, reading: Reading) -> None:
        """Made by iter() of a source."""
        self._source, self._reading = source, reading
        self._has_begun = self._has_ended = False

    def __next__(self) -> Frame:
        self._source._check_open()
        self._has_begun = True
        frame = None if self._has_ended else self._reading.next()
        if frame is None:
            self._has_ended = True
            self._source._note_end(self._reading)
            raise StopIteration
        return frame

    def __length_hint__(self) -> int:
        """About how many frames are left: for progress bars."""
        total = 0 if self._has_ended else self._source.__length_hint__()
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
        self._readings: weakref.WeakSet[Reading] = weakref.WeakSet()
        self._origins: list[str] = []
        self._frame_count: Optional[int] = None
        self._settings = self._ask()
        self._ready: Optional[Reading] = self._read()
        self._latest: Reading = self._ready
        self._jumper: Optional[Reading] = None
        self._sought_ns: Optional[int] = None  # UTC at which the next iteration begins
        self._begun: Callable[[], Optional[Frames]] = lambda: None

    def _ask(self) -> tuple[Calibration, Profile]:
        """The calibration and the profile, those of the capture where none is named."""
        choice = self._choice
        named = choice.calibration, choice.profile
        capture = self._input.ask()
        if capture is not None:
            from ._provenance import Provenance

            is_rig = choice.rig is not None
            found = Provenance(capture, *named, (is_rig or choice.names_calibration, is_rig or choice.names_profile),
                               "the rig names those of each sensor" if is_rig else "{}= names another")
            for note in found.notes:
                warn(note)
            named = found.calibration, found.profile
            self._origins = found.origins
        return choice.with_set(*named)

    def _read(self) -> Reading:
        reading = Reading(self._input, self._choice, self._settings, self._origins)
        self._readings.add(reading)
        return reading

    def _read_on(self) -> Reading:
        """The reading of the next iteration."""
        reading = self._read()
        if self._sought_ns is not None:
            reading.load_index()
            reading.seek_time(self._sought_ns)
        return reading

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"{self.name}: the source is closed; open it again to read it")
        self._latest_here()

    def _latest_here(self) -> Reading:
        """The latest iteration of this process."""
        if self._latest.was_forked and not self._closed:
            self._input.after_fork()
            self._readings = weakref.WeakSet()
            self._jumper = None
            self._latest = self._ready = self._read_on()
        return self._latest

    def _note_end(self, reading: Reading) -> None:
        if not reading.was_sought:
            self._frame_count = reading.frames

    # Frames.

    def __iter__(self) -> Frames:
        """Begin at the start: the first frame comes next, also if another iteration is under way."""
        self._check_open()
        reading, self._ready, self._sought_ns = self._ready, None, None
        self._latest = reading or self._read()
        frames = Frames(self, self._latest)
        self._begun = weakref.ref(frames)
        return frames

    def __length_hint__(self) -> int:
        """About how many frames there are. It is exact once all were read, and 0 while nothing is known."""
        if self._frame_count is not None:
            return self._frame_count
        latest = self._latest_here()
        done, total = latest.progress()
        return latest.frames * total // done if done else 0

    def __len__(self) -> int:
        """How many frames there are: all are found, as by index(). TypeError if it can be read only once, and of an
        iteration that has not given a frame yet."""
        self._check_open()
        if self._frame_count is not None:
            return self._frame_count
        if not self._input.can_reopen:
            raise TypeError(f"{self.name}: it can be read only once, so how many frames it has is known only at the end")
        # list() asks behind iter(), and takes TypeError for an answer: else it would read everything twice.
        begun = self._begun()
        if begun is not None and not begun._has_begun:
            raise TypeError(f"{self.name}: an iteration has just begun; ask for the length before, or index()")
        return self.index()

    def __bool__(self) -> bool:
        return True

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Selection: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, Selection]:
        """Frames by their place in the order of the stream: source[100], source[-1], source[10:20].

        A frame is the one that iteration gives, in each column and clock. Places below 0 count from the end, for which
        the whole capture is read once. A slice is a sequence whose frames are read when they are asked for.
        """
        self._check_open()
        if isinstance(index, slice):
            return Selection(self, index)
        place = _place(index)
        return self._at(place if place >= 0 else self._from_end(place))

    def _from_end(self, place: int) -> int:
        count = self.index()
        if place + count < 0:
            raise IndexError(f"{self.name}: there is no frame {place}: it has {count}")
        return place + count

    def _find(self, place: int) -> Optional[Frame]:
        """The frame of a place from 0 on; None: there are not so many."""
        reading = self._jumping()
        reading.seek_frame(place)
        return reading.next()

    def _at(self, place: int) -> Frame:
        """The frame of a place from 0 on."""
        frame = self._find(place)
        if frame is None:
            raise IndexError(f"{self.name}: there is no frame {place}: it has {self._jumping().known()[0]}")
        return frame

    def _jumping(self) -> Reading:
        """The reading for frames by their place: one that has ended and knows them all, or one more."""
        self._check_open()
        if self._jumper is None or self._jumper.was_stopped:
            latest = self._latest
            if latest.can_jump and latest.ended and not (latest.truncated or latest.was_stopped):
                self._jumper = self._latest
            else:
                self._jumper = self._read()
                self._jumper.load_index()
        return self._jumper

    def index(self, keep: bool = False) -> int:
        """Find all frames, reading what was not read yet, and tell how many there are.

        Then each can be read directly. keep: write the index beside the capture, as its name with ".lumindex"; a
        later source[...] and seek() use it if capture and options are the same.
        """
        reading = self._jumping()
        count, is_whole = reading.known()
        if not is_whole:
            reading.seek_frame(2 ** 62)
            if reading.next() is None:
                count, _ = reading.known()
        if keep:
            reading.save_index()
        self._frame_count = count
        return count

    def seek(self, time: Union[datetime.datetime, int, float]) -> Source:
        """Let the next iteration begin with the first frame that begins at a time or later; returns this source.

        time is a datetime with its time zone; a whole number, nanoseconds since 1970 UTC as Frame.utc_ns; or a float,
        seconds from the beginning of the first frame. Counts and losses then begin at about that place.
        """
        self._check_open()
        self._sought_ns = self._utc_ns(time)
        reading = self._read_on()
        if self._ready is not None and self._ready is not self._latest:
            self._ready.close()
        self._ready = reading
        return self

    def _utc_ns(self, time: Any) -> int:
        if isinstance(time, datetime.datetime):
            if time.tzinfo is None:
                raise ValueError(f"{time!r} has no time zone; add one, such as tzinfo=datetime.timezone.utc")
            since = time - datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
            return (since.days * 86400 + since.seconds) * 10 ** 9 + since.microseconds * 1000
        if hasattr(time, "__index__") and not isinstance(time, bool):
            return int(time.__index__())
        if isinstance(time, bool) or not hasattr(time, "__float__"):
            raise TypeError(f"a time is given as {type(time).__name__}; use a datetime, nanoseconds since 1970 as a "
                            "whole number, or seconds from the first frame as a float")
        if not math.isfinite(time):
            raise ValueError(f"{time} is not a time")
        return self._at(0).utc_ns + round(float(time) * 1e9)

    # What is known of it.

    def _names(self) -> list[str]:
        """The sensors whose frames are to come, as far as it is known before."""
        return [sensor.name for sensor in self._choice.wanted]

    @property
    def name(self) -> str:
        """What it is called in messages: its path, or the first of several."""
        return self._input.name

    @property
    def calibration(self) -> Calibration:
        """The calibration that points are made with: that of the option, else the capture's own, else the built-in.

        With a rig, each sensor has its own: source.rig["front"].calibration."""
        self._refuse_of_rig("calibration")
        return self._settings[0]

    @property
    def profile(self) -> Profile:
        """The wire profile that packets are read with, chosen as the calibration is."""
        self._refuse_of_rig("profile")
        return self._settings[1]

    def _refuse_of_rig(self, what: str) -> None:
        if self._choice.rig is not None:
            raise OptionError(f"{self.name}: it was opened with a rig, in which each sensor has its own {what}: "
                              f'source.rig["{self._choice.wanted[0].name}"].{what}')

    @property
    def rig(self) -> Optional[Rig]:
        """The rig that it was opened with, or None."""
        return self._choice.rig

    @property
    def provenance(self) -> list[str]:
        """Where the capture says that it comes from: texts of YAML, the nearest origin first."""
        return list(self._origins)

    @property
    def counts(self) -> dict[str, int]:
        """What was counted so far in the latest iteration, with the names of `lumdump --json`: packets, lines, losses.

        points are those that frames have, or had if an iteration gives only some of them.
        """
        return dict(self._latest_here().count().counts)

    @property
    def losses(self) -> dict[str, int]:
        """What was lost so far in the latest iteration, by cause, with lumdump's names.

        lines_late are lines that came after their frame had been handed out, and are in none; points_late are their
        points. no_range counts words without a range above zero. Those that end with under_way are parts of
        lines_missing_angles, lost_words, no_angle and lines_missing that are no losses: they come from lines and frames
        that were under way when the recording began or ended. stray_at_breaks is the part of stray that is in pauses.
        """
        counts = self._latest_here().count().counts
        return {name: counts[name] for name in LOSSES}

    @property
    def paused_s(self) -> float:
        """How long no lines came, in all pauses that losses["pauses"] counts so far in the latest iteration."""
        return self._latest_here().count().paused_s

    @property
    def sensors(self) -> list[str]:
        """The sensors that sent data so far in the latest iteration, as Frame.sensor names them, such as "10.42.0.37"; with a
        rig such as "front", and by their addresses those that it does not name."""
        return list(self._latest_here().count().sensors)

    @property
    def counts_by_sensor(self) -> dict[str, dict[str, int]]:
        """What counts has, of each of the sensors: source.counts_by_sensor["front"]["lost_words"].

        It lacks what is not of a sensor, such as damaged parts of the capture."""
        return {name: dict(counts) for name, counts in self._latest_here().count().by_sensor.items()}

    @property
    def progress(self) -> tuple[int, int]:
        """Bytes that the latest iteration has read, and all of them; 0: not known."""
        return self._latest_here().progress()

    @property
    def truncated(self) -> bool:
        """Whether the latest iteration found that the capture breaks off before its end."""
        return self._latest_here().truncated

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    def __repr__(self) -> str:
        if self._closed:
            return f"<Source {self.name}: closed>"
        latest = self._latest
        frames = f"{0 if latest.was_forked else latest.frames} frames read"
        done, total = (0, 0) if latest.was_forked else latest.progress()
        return f"<Source {self.name}: {frames}" + (f", {100 * done // total} %>" if total else ">")

    def __reduce__(self) -> Any:
        """Opened again, with the same options, wherever the files or URLs that it was opened with can be read."""
        self._check_open()
        given = self._input.given
        if given is None:
            raise TypeError(f"{self.name}: only a source opened from paths or URLs can be copied or sent "
                            "to another process: open this one there, or send its frames")
        return _reopen, (given, self._choice.to_give(), self._input.storage, self._sought_ns)

    # Its end.

    def close(self) -> None:
        """Close it. Its frames, and arrays of them, stay valid. What was counted can still be asked for."""
        for reading in list(self._readings):
            reading.close()
        self._closed, self._ready, self._jumper = True, None, None
        self._input.close()

    def __enter__(self) -> Source:
        self._check_open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Selection(Sequence[Frame]):
    """Some frames of a source, as source[10:20] gives them. Each is read when it is asked for, and not kept."""

    def __init__(self, source: Source, part: slice) -> None:
        """Made by a source."""
        self._source = source
        self._part = slice(*(None if value is None else _place(value) for value in (part.start, part.stop, part.step)))
        if self._part.step == 0:
            raise ValueError("the step of a slice is 0")
        self._found: Optional[range] = None

    @property
    def _places(self) -> range:
        """The places of its frames, for which all frames have to be known."""
        if self._found is None:
            self._found = range(*self._part.indices(self._source.index()))
        return self._found

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Selection: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, Selection]:
        if isinstance(index, slice):
            places = self._places[index]
            made = Selection(self._source, slice(None))
            made._found = places
            return made
        return self._source._at(self._places[_place(index)])

    def __iter__(self) -> Iterator[Frame]:
        start, stop, step = self._part.start or 0, self._part.stop, self._part.step or 1
        if self._found is None and start >= 0 and step > 0 and (stop is None or stop >= 0):
            places: Iterable[int] = itertools.count(start, step) if stop is None else range(start, stop, step)
        else:
            places = self._places
        for place in places:
            frame = self._source._find(place)
            if frame is None:
                return
            yield frame

    def __repr__(self) -> str:
        known = f"{len(self)} frames" if self._found is not None else "frames"
        return f"<Selection of {self._source.name}: {known}>"


def _reopen(given: Given, options: Options, storage: Optional[Mapping[str, Any]], sought_ns: Optional[int]) -> Source:
    """A source that was pickled."""
    source = open(given, storage_options=storage, **options)
    return source if sought_ns is None else source.seek(sought_ns)


def _place(index: Any) -> int:
    try:
        return operator.index(index)
    except TypeError:
        raise TypeError(f"a frame is asked for by {index!r}, of type {type(index).__name__}; use a whole number, its "
                        "place in the stream from 0 on, or a slice; open(frames=...) chooses by number, seek() by time"
                        ) from None


def open(source: Given, *, storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[Options]) -> Source:
    """Open a capture, or several as one.

    source is a path; a pattern such as "drive-*.pcap"; a list of these; the bytes of a capture; a binary file object,
    which is read from where it stands; or a URL, by fsspec, with storage_options as its store needs them. Captures are
    pcap, pcapng, MCAP or bag files, also compressed. Several are read as one stream, by their times.

    Options are those of lumdump, by the same names; all but set and progress may be texts as lumdump takes them:

        columns      names of columns, or "all"; x y z range pulse_width line pixel eye if not given (COLUMNS has all)
        returns      "all", "first", "last", "strongest", or the one of a number from 1, of each pixel
        edge         "rising", "falling" or "both"
        eye          "blue", "green" or "both"
        sensor       only this one, such as "10.42.0.37"; with a rig its name
        rig          the sensors of a vehicle: a path, a mapping, a list of sensors, or a Rig. Each is read by its own
                     calibration and profile; x, y, z and box are in the vehicle's frame, and Frame.sensor is the name
        port         the sensors' UDP port in the capture, if NAT has changed it; 5517 if not given
        frames       numbers of frames: (first, last), both included and either None, or one number
        range        (min, max) metres from the eye, both included and either None
        box          three such pairs for x, y and z in metres
        incomplete   "keep" or "drop" lines that lack angles or words
        smooth       0 for off, a window such as 31, or (window, order): angles are smoothed along each line
        calibration  a path, a mapping, a text of YAML, or a Calibration
        profile      likewise a Profile
        set          single keys of both, {"group.line.at": 14} or ["group.line.at=14"]
        broken       "raise" a CaptureError where a capture breaks off or has parts that cannot be read, once all its frames
                     have come; or "warn", as lumdump does
        raw          True: every word is a row, also those that give no point (NaN), with the columns tof, raw_azimuth and
                     raw_elevation, and raw_place if words came in another order than that of pixels, or bad ones among them;
                     frame.angles and frame.packets. For write_capture(); not with edge, returns, range, box
        threads      how many make the points, 1 to 64; 2 if not given, or 1 where there is one core. The frames
                     are the same, bit by bit
        progress     a function that is called with the bytes read and the bytes in all (0: not known)

    Raises CaptureError if a source cannot be read, OptionError for a value that is not allowed, TypeError for one of a
    wrong type and for an option that is not known.
    """
    choice = Choice(options)
    return Source(open_input(source, storage_options), choice)
