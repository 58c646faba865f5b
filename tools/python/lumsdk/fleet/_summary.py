"""What the user sees: progress on a terminal, and the summary."""
from __future__ import annotations

import json
import time
from collections import Counter
from typing import Any

from .. import _run
from .._c import LOSSES
from ._ledger import Record, Totals

PERIOD_S = 0.5
_NO_LOSSES = ("no_range", "lines_missing", "stray_at_breaks")  # also of a capture that lacks nothing; lines_skipped tells
SHOWN_FAILURES = 10
UNITS = ("B", "kB", "MB", "GB", "TB", "PB")


def size(count: float) -> str:
    """Bytes for people."""
    unit = 0
    while count >= 1000 and unit < len(UNITS) - 1:
        count /= 1000
        unit += 1
    return f"{count:.0f} {UNITS[unit]}" if unit == 0 or count >= 99.95 else f"{count:.1f} {UNITS[unit]}"


def span(seconds: float) -> str:
    """Seconds for people."""
    whole = int(seconds + 0.5)
    if whole < 100:
        return f"{whole} s"
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {whole % 60:02} s"


def captures(count: int) -> str:
    return f"{count:,} capture{'' if count == 1 else 's'}"


class Progress(_run.Progress):
    """One line on a terminal; nothing elsewhere."""

    def __init__(self, totals: Totals, is_on: bool) -> None:
        super().__init__(is_on)
        self._totals = totals
        self._begin = self._begun = self._last = time.monotonic()
        self.done = self.size = self.failed = 0

    def add(self, record: Record, planned_size: int) -> None:
        self._last = time.monotonic()
        self.done += 1
        self.size += planned_size
        self.failed += record["status"] != "done"

    def begin(self, when: float) -> None:
        """The first worker is ready; rates count from here."""
        self._begun = when

    def converting(self) -> float:
        """Without start and end."""
        return max(self._last - self._begun, 0.0)

    def seconds(self) -> float:
        return time.monotonic() - self._begin

    def line(self) -> str:
        """Done of all, rates, time left: of bytes or of captures, whichever takes longer."""
        passed = max(time.monotonic() - self._begun, 1e-3)
        text = f"{self.done:,} of {captures(self._totals.pending)}, {size(self.size)} of {size(self._totals.pending_size)}," \
               f" {self.size / passed / 1e9:.2f} GB/s, {self.done / passed:.1f} captures/s"
        if self.failed:
            text += f", {self.failed:,} failed"
        if self.done:
            left = max((self._totals.pending - self.done) / self.done, (self._totals.pending_size - self.size) / max(self.size, 1))
            text += f", {span(passed * left)} left"
        return text

    def show(self) -> None:
        if time.monotonic() - self._shown_s >= PERIOD_S:
            self(self.line())


class Summary:
    """Counts of a run."""

    def __init__(self, out: str, form: str, totals: Totals) -> None:
        self._out, self._format, self._totals = out, form, totals
        self.converted = self.unchanged = self.failed = self.truncated = self.lossy = 0
        self.unchanged_now = 0  # of those that had to be looked into
        self.points = self.frames = self.out_size = self.size = 0
        self.losses: Counter[str] = Counter()
        self.causes: Counter[str] = Counter()
        self.other_versions = self.left_out = 0
        self.seconds = self.converting = 0.0
        self.workers = 0
        self.lost = 0
        self.interrupted = False
        self.manifest = ""

    def add_made(self, record: Record) -> None:
        """A capture that this run converted or tried to."""
        if record["status"] != "done":
            self.failed += 1
            self.causes[record["message"].replace(record["source"], "CAPTURE")] += 1
            return
        self.converted += 1
        self.size += record["size"]

    def add_row(self, record: Record, version: str) -> None:
        """A row of the manifest, of this run's captures."""
        if record["status"] != "done":
            return
        self.points += record.get("points") or 0
        self.frames += record.get("frames") or 0
        self.out_size += record.get("output_size") or 0
        self.truncated += bool(record.get("truncated"))
        self.left_out += record.get("left_out") or 0
        self.other_versions += record["version"] != version
        lost = {name: record[name] for name in LOSSES
                if record.get(name) and not name.endswith("under_way") and name not in _NO_LOSSES}
        self.lossy += bool(lost)
        self.losses.update(lost)

    @property
    def left(self) -> int:
        return self._totals.pending - self.converted - self.unchanged_now - self.failed

    def text(self) -> str:
        t = self._totals
        passed = max(self.converting, 1e-3)
        lines = [f"{captures(t.captures)}, {size(t.size)}, to {self._out} as {self._format}",
                 f"  converted   {self.converted:,}, {size(self.size)}, in {span(passed)}: "
                 f"{self.size / passed / 1e9:.2f} GB/s, {self.converted / passed:.1f} captures/s"
                 f" with {self.workers} worker{'' if self.workers == 1 else 's'}"]
        if self.unchanged:
            lines.append(f"  unchanged   {self.unchanged:,}")
        if self.failed:
            lines.append(f"  failed      {self.failed:,}, for these reasons:")
            for cause, count in sorted(self.causes.items(), key=lambda pair: (-pair[1], pair[0]))[:SHOWN_FAILURES]:
                lines.append(f"    {count:,} x {cause}")
            if len(self.causes) > SHOWN_FAILURES:
                lines.append(f"    and {len(self.causes) - SHOWN_FAILURES:,} other reasons")
        if self.left:
            lines.append(f"  not begun   {self.left:,}; the same command continues")
        lines.append(f"  in OUT now  {self.frames:,} frames, {self.points:,} points, {size(self.out_size)}")
        lines += self._lacks()
        if self.lost:
            lines.append(f"  retried     {self.lost:,}, because a worker or a machine died")
        lines.append(f"  manifest    {self.manifest}")
        return "\n".join(lines)

    def _lacks(self) -> list[str]:
        """What is not in the outputs, or may not be."""
        lines = []
        if self.losses:
            lines.append(f"  losses in   {captures(self.lossy)}: " + ", ".join(f"{n} {c:,}" for n, c in sorted(self.losses.items())))
        if self.left_out:
            lines.append(f"  left out    {self.left_out:,} points, which came too late or exceeded what a frame can hold")
        if self.truncated:
            lines.append(f"  broken off  {captures(self.truncated)}, converted as far as they go")
        if self.other_versions:
            lines.append(f"  versions    {captures(self.other_versions)} converted by another version; --again converts them again")
        return lines

    def json(self) -> str:
        t = self._totals
        data: dict[str, Any] = {
            "out": self._out, "format": self._format, "captures": t.captures, "bytes": t.size, "converted": self.converted,
            "converted_bytes": self.size, "unchanged": self.unchanged, "failed": self.failed, "not_begun": self.left,
            "frames": self.frames, "points": self.points, "output_bytes": self.out_size, "truncated": self.truncated,
            "losses": dict(sorted(self.losses.items())), "left_out": self.left_out,
            "other_versions": self.other_versions, "retried": self.lost, "interrupted": self.interrupted,
            "seconds": round(self.seconds, 3), "converting_seconds": round(self.converting, 3), "workers": self.workers,
            "manifest": self.manifest}
        return json.dumps(data, indent=2)


def plan_json(totals: Totals, out: str, form: str) -> str:
    """What --dry-run says with --json."""
    return json.dumps({"out": out, "format": form, "captures": totals.captures, "bytes": totals.size,
                       "to_convert": totals.pending, "to_convert_bytes": totals.pending_size,
                       "unchanged": totals.captures - totals.pending}, indent=2)


def plan_text(totals: Totals, out: str, form: str) -> str:
    """What --dry-run says at its end."""
    count = totals.captures - totals.pending
    unchanged = f", {count:,} are there and unchanged" if count else ""
    return f"{captures(totals.pending)}, {size(totals.pending_size)}, would be converted to {out} as {form}{unchanged}"
