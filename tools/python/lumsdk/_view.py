"""A view that can be turned, of a capture or of frames: lumview.html with the data in it."""
from __future__ import annotations

import html
import json
import operator
import os
import pathlib
import re
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

from ._c import ffi
from ._errors import Error, OptionError, warn
from ._frame import Frame
from ._inputs import Files, Input, Memory, Stream
from ._shown import ALWAYS, MOST_BYTES, as_frame, of_frames, refuse_size, text_of
from ._source import Source, open as open_source
from ._sync import FrameSet

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from ._types import Given, Options, Path

    OneShown = Union[Frame, FrameSet, ArrayLike]
    Shown = Union[Source, Given, OneShown, Iterable[OneShown]]

_MOST_OF_CELL = 64 << 20
"""In a cell, as a notebook keeps it."""

_BY_PAGE = {"columns", "threads", "progress", "broken", "raw", "calibration", "profile", "set", "rig"}
"""Options of a source that the page needs not know, or is told. With others, it gets frames in place of the capture."""

_PACKED_OTHERWISE = (b"BZh", b"\x04\x22\x4d\x18")
"""How captures begin that bzip2 or lz4 compressed, which the page cannot unpack."""

_NO_PAGE = ("this installation has no lumview.html, which shows the points: in a clone, script/setup --test and cmake -B build && "
            "cmake --build build make it, and pip install . then takes it (docs/internals/wheels.md); frame.to_png() draws a picture")

_SENSOR = re.compile(r"(udp://)?(\d+\.){3}\d+(%\w+)?(:\d+)?")


def _refuse_live(name: str) -> TypeError:
    return TypeError(f"{name} is live, and a view holds what has been recorded: the program 'lumview {name}' shows it in a browser; "
                     "lumsdk.view(list(sensor.frames(2))) shows the frames of two seconds")


# --- What the page gets ---


def _read(file: Any, most: int) -> bytes:
    """All that a file object has, up to so many bytes; one read() may give less."""
    out = bytearray()
    while len(out) < most and (part := file.read(most - len(out))):
        out += part
    return bytes(out)


def _contents(given: Input) -> Iterator[tuple[str, bytes]]:
    """The names of captures, and their bytes."""
    what = "some of its frames, as lumsdk.view(source[:10]) has them, or the program 'lumview', which reads captures of any size"
    if isinstance(given, Files):
        paths = given._same_paths()
        size = sum(os.stat(path).st_size for path in paths)
        if size > MOST_BYTES:
            raise refuse_size(given.name, size, what)
        for path in paths:
            yield os.path.basename(path), pathlib.Path(path).read_bytes()
        return
    if isinstance(given, Memory):
        content = bytes(ffi.buffer(given._buffer))
    else:
        assert isinstance(given, Stream)
        content = _read(given._rewind(), MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise refuse_size(given.name, len(content), what)
    yield os.path.basename(given.name), content


def _settings(source: Source) -> dict[str, Any]:
    """The page's options for the calibration, the profile and the rig of a source."""
    rig = source.rig
    if rig is None:
        return {name: {"name": f"{name}.yaml", "text": getattr(source, name).to_yaml()} for name in ("calibration", "profile")}
    beside = {(name, what): f"{name}-{what}.yaml" for name in rig for what in ("calibration", "profile")}
    texts = [{"name": path, "text": getattr(rig[name], what).to_yaml()} for (name, what), path in beside.items()]
    return {"rig": {"name": "rig.yaml", "text": rig.to_yaml(beside)}, "beside": texts}


def _frames_of(source: Source) -> dict[str, Any]:
    rig = source.rig
    if rig is None:
        return of_frames(source, source.name, source.calibration)
    from ._sync import sync

    return of_frames(sync(source), source.name, None, {name: rig[name].calibration for name in rig})


def _of_source(source: Source) -> dict[str, Any]:
    """{"captures", "options"} for the page; or frames, where the source has some of the capture alone, or the page cannot read it."""
    source._check_open()
    chosen = [name for name, value in source._choice.given.items() if name not in _BY_PAGE and value != "all"]
    if source._sought_ns is not None or chosen or not source._input.can_reopen:
        return _frames_of(source)
    captures = []
    for name, content in _contents(source._input):
        if content.startswith(_PACKED_OTHERWISE):
            return _frames_of(source)
        captures.append({"name": name, "base64": text_of(content)})
    return {"captures": captures, "options": _settings(source)}


def _is_capture(given: Any) -> bool:
    """Whether it is what open() takes."""
    if isinstance(given, (list, tuple)):
        return len(given) > 0 and isinstance(given[0], (str, os.PathLike))
    return isinstance(given, (str, os.PathLike, bytes, bytearray, memoryview)) or callable(getattr(given, "read", None))


def _refuse_sensor(given: Any) -> None:
    from ._sensor import Sensor
    from ._stream import Frames

    if isinstance(given, Sensor):
        raise _refuse_live(given.address)
    if isinstance(given, Frames):
        raise _refuse_live(given._sensor.address)
    if isinstance(given, str) and _SENSOR.fullmatch(given):
        raise _refuse_live(given.replace("udp://", ""))


def _data(shown: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    _refuse_sensor(shown)
    if _is_capture(shown):
        given: Any = {"columns": ("x", "y", "z", "range", *ALWAYS), **options}
        with open_source(shown, **given) as source:
            return _of_source(source)
    if isinstance(shown, Source):
        if options:
            raise OptionError(f"{', '.join(options)}: a source has its options already; give them to lumsdk.open()")
        return _of_source(shown)
    others = [name for name in options if name != "calibration"]
    if others:
        raise OptionError(f"{', '.join(others)}: options of captures; with frames only calibration can be given")
    is_one = isinstance(shown, (Frame, FrameSet)) or hasattr(shown, "__array__") or hasattr(shown, "keys")
    if not is_one and not isinstance(shown, Iterable):
        shown = as_frame(shown, 0)
    return of_frames([shown] if is_one else shown, None, options.get("calibration"))


# --- The view ---


def _page() -> tuple[bytes, bytes]:
    """lumview.html before and behind the place of the data."""
    try:
        page = pathlib.Path(__file__).with_name("lumview.html").read_bytes()
    except OSError:
        raise Error(_NO_PAGE) from None
    at = page.index(b"</head>")
    return page[:at], page[at:]


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def _browser() -> Optional[Callable[[str], bool]]:
    """What opens a page in a window of its own; None: there is nothing but browsers of a terminal."""
    try:
        found = webbrowser.get()
    except webbrowser.Error:
        return None
    is_of_terminal = type(found) is webbrowser.GenericBrowser
    return None if is_of_terminal else found.open


class View:
    """What view() makes: a page with nothing stored elsewhere. In a notebook, it shows itself at the end of a cell."""

    def __init__(self, data: bytes, height: int) -> None:
        """Made by view()."""
        self._data, self._height = data, height
        self._path: Optional[str] = None

    @property
    def path(self) -> Optional[str]:
        """The file that open() has made. None: none yet."""
        return self._path

    def _parts(self) -> list[bytes]:
        """The page, with the data in it."""
        before, after = _page()
        return [before, b'<script type="application/json" id="lumview-data">', self._data, b"</script>", after]

    def save(self, path: Path) -> None:
        """Write the page as one file, such as "street.html", which any browser opens, without a network too."""
        with open(path, "wb") as file:
            file.writelines(self._parts())

    def open(self) -> str:
        """Show it in a browser, from a temporary file that nobody else can read. The file stays, as the browser needs it; the
        system removes it with its other temporary files.

        Returns:
            The path of the file. A warning tells where no browser can be opened, as over SSH.
        """
        if self._path is None:
            handle, path = tempfile.mkstemp(prefix="lumsdk-", suffix=".html")
            try:
                with os.fdopen(handle, "wb") as file:
                    file.writelines(self._parts())
            except BaseException:
                os.unlink(path)
                raise
            self._path = path
        show = _browser()
        if show is None or not show(pathlib.Path(self._path).as_uri()):
            warn(f"no browser can be opened here; the view is the file {self._path}", UserWarning)
        return self._path

    def _repr_html_(self) -> str:
        """In a notebook: the page itself, of which the notebook keeps a copy."""
        size = len(self._data)
        if size > _MOST_OF_CELL:
            return (f"<p>The view has {size / 2 ** 20:,.0f} MB, and a cell keeps at most {_MOST_OF_CELL >> 20} MB. Fewer frames are "
                    'smaller, as in lumsdk.view(source[:10]); .save("view.html") writes a file, and .open() shows it.</p>')
        text = b"".join(self._parts()).decode()
        return (f'<iframe title="lumview" sandbox="allow-scripts allow-downloads" srcdoc="{html.escape(text)}" '
                f'style="width:100%;height:{self._height}px;border:0"></iframe>')

    def __repr__(self) -> str:
        return f"<View of {len(self._data):,} bytes{f' in {self._path}' if self._path else ''}>"


def view(shown: Shown, *, height: int = 560, browser: bool = True, **options: Unpack[Options]) -> View:
    """Show points in a page where they can be turned, coloured, filtered, measured and saved, as the program lumview does it.

        lumsdk.view("street.pcap")                        # a capture: all of it, with a player
        lumsdk.view(source[100:110])                      # frames
        lumsdk.view(frame.with_columns(label=labels))     # coloured by a column of one's own: label, class or object
        lumsdk.view(points)                               # an array of the shape (n, 3), or a list of them

    In a notebook the value at the end of a cell is shown inside the cell. Elsewhere a browser opens, from a temporary file. The
    page holds the data, needs neither server nor network, and is shared by save("street.html").

    Args:
        shown: a capture, or several, as open() takes them; a Source; a Frame, or a FrameSet of sync(); an array; a mapping as
            Frame.from_arrays() takes it; several of these frames or arrays. A source that was opened with options that choose,
            such as range or frames, is shown as its frames; of others the page gets the packets.
        height: of the cell, in pixels.
        browser: whether a browser opens where this is no notebook; False leaves that to open().
        options: those of open(), where shown is a capture; with frames, calibration tells where the eyes are, from which the page
            computes ranges and angles; None is the built-in one. Where the frames' own column range differs, or there is none,
            the page tells how far a point is from 0 instead.

    Returns:
        The page. Coordinates of frames are rounded by at most 1 mm, and points without coordinates (NaN, or masked) are
        left out. Frames whose numbers do not rise are numbered from 0 on.

    Raises:
        OptionError: the data is larger than 256 MB, or an option or an array is not right.
        TypeError: it is a live sensor, which lumview shows, or something that has no points.
        CaptureError: a source cannot be read.
        Error: this installation has no page.
    """
    try:
        pixels = operator.index(height)
    except TypeError:
        pixels = 0
    if not 100 <= pixels <= 10000:
        raise OptionError(f"height is {height!r}; use a number of pixels from 100 to 10000")
    _page()
    text = json.dumps(_data(shown, options), separators=(",", ":"))
    made = View(text.replace("<", "\\u003c").encode(), pixels)
    if browser and not _in_notebook():
        made.open()
    return made
