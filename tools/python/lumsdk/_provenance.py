"""What captures say of themselves in comments (docs/formats.md, "Provenance"): taken as lumdump takes it."""
from __future__ import annotations

from typing import Any, NamedTuple

from ._c import ffi, lib, sized, text
from ._errors import OptionError
from ._keys import quoted
from ._settings import Calibration, Profile

_MARK = b"# lumsdk "
_HEADS = {b"# lumsdk origin 1": "origin", b"# lumsdk calibration 1": "calibration", b"# lumsdk profile 1": "profile"}
_ORIGIN_BYTES = 6144
_ORIGINS_MAX = 4
_LINE_MAX = 400


class Comment(NamedTuple):
    """A comment of ours."""

    kind: str  # empty: of another version or kind
    text: bytes


def comments(capture: Any) -> list[tuple[str, list[Comment]]]:
    """The comments of ours of each source, by its name."""
    found = []
    source, length = sized("lum_capture_source"), ffi.new("size_t *")
    for i in range(lib.lum_capture_source_count(capture)):
        lib.lum_capture_get_source(capture, i, source)
        texts = []
        for k in range(lib.lum_capture_comment_count(capture, i)):
            pointer = lib.lum_capture_comment(capture, i, k, length)
            content = bytes(ffi.buffer(pointer, length[0]))
            if content.startswith(_MARK):
                texts.append(Comment(_HEADS.get(content.split(b"\n", 1)[0], ""), content))
        found.append((text(source.name), texts))
    return found


def _is_plain(content: bytes) -> bool:
    lines = content.split(b"\n")
    return (content.endswith(b"\n") and len(content) < _ORIGIN_BYTES and b"\n\n" not in content
            and all(len(line) <= _LINE_MAX and all(0x20 <= byte <= 0x7e for byte in line) for line in lines))


class Provenance:
    """What the comments of a capture give: a calibration, a profile, and where it comes from."""

    def __init__(self, capture: Any, calibration: Calibration, profile: Profile, named: tuple[bool, bool],
                 why: str = "{}= names another") -> None:
        """Read them.

        Args:
            capture: as lum_capture_open() gives it.
            calibration: that is used if the capture has none.
            profile: likewise.
            named: whether they are to be used in any case.
            why: what names them then; {} stands for calibration or profile.
        """
        self._why = why
        self.calibration, self.profile = calibration, profile
        self.origins: list[str] = []
        self.notes: list[str] = []
        self.takes = {kind for kind, is_named in zip(("calibration", "profile"), named) if not is_named}
        sources = comments(capture)
        speakers = [source for source in sources if source[1]]
        self.speaker, self.said = speakers[0] if speakers else sources[0]
        for comment in self.said:
            self._take_text(comment)
        self._take_keys("calibration", Calibration)
        self._take_keys("profile", Profile)
        self._check_both(calibration, profile)
        self.others = self._others(sources)
        if self.others:
            self.notes.append(f"{self.others[0]}: its calibration or its profile is not that of {self.speaker}, which "
                              "is used for all")
        self._note_left_out(capture, sources)

    def _take_text(self, comment: Comment) -> None:
        if not comment.kind:
            head = comment.text.split(b"\n", 1)[0][len(_MARK):].decode("latin-1")
            self.notes.append(f"{self.speaker}: it has the comment '{quoted(head)}', which this "
                              "version does not know; it is ignored")
        elif comment.kind == "origin" and not _is_plain(comment.text):
            self.notes.append(f"{self.speaker}: its origin cannot be read: it has to be lines of printable ASCII; it is "
                              "ignored")
        elif comment.kind == "origin" and len(self.origins) < _ORIGINS_MAX:
            self.origins.append(comment.text.decode())

    def _take_keys(self, kind: str, make: type[Any]) -> None:
        said = [comment for comment in self.said if comment.kind == kind]
        if not said:
            return
        if kind not in self.takes:
            self.notes.append(f"{self.speaker}: it has a {kind} of its own, which is not used: {self._why.format(kind)}")
        elif len(said) > 1:
            self.notes.append(f"{self.speaker}: it has {len(said)} {kind}s of its own, and it is unknown which "
                              f"is right: the built-in one is used; name one by {kind}=")
        else:
            try:
                setattr(self, kind, make._of_text(said[0].text, f"{self.speaker}: its {kind}"))
            except OptionError as error:
                self.notes.append(f"{error}; the built-in one is used: name another by {kind}=")

    def _check_both(self, calibration: Calibration, profile: Profile) -> None:
        layout, projector = ffi.new("lum_layout *"), ffi.new("lum_projector *")
        if (lib.lum_layout_init(layout, self.profile._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK
                or lib.lum_projector_init(projector, self.calibration._to_c(), layout) != lib.LUM_OK):
            self.calibration, self.profile = calibration, profile
            self.notes.append(f"{self.speaker}: its calibration and its profile contradict each other; both are ignored")

    def _others(self, sources: list[tuple[str, list[Comment]]]) -> list[str]:
        """The sources that say what the speaker did not, once for each thing said."""
        return [name for name, texts in sources for comment in texts
                if comment.kind in self.takes and comment not in self.said]

    def _note_left_out(self, capture: Any, sources: list[tuple[str, list[Comment]]]) -> None:
        for i, (name, _) in enumerate(sources):
            if lib.lum_capture_comments_left_out(capture, i):
                self.notes.append(f"{name}: it has more than {lib.LUM_CAPTURE_COMMENTS_MAX} comments; what the rest say "
                                  "of its calibration and profile is ignored")
                return
