"""Whether a sensor's texts refuse a command, read as lumctl reads them."""
from __future__ import annotations

import re
from collections.abc import Iterable

_REFUSES = ("refus", "reject", "invalid", "error", "unknown", "denied", "cannot", "out of range", "malformed", "illegal",
            "not allowed", "unsupported")
_CONFIRMS = frozenset(("set", "done", "ok", "accepted", "applied"))
_DOUBTS = frozenset(("not", "no", "range", "limit", "failed", "max", "min", "must"))


def _words(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z0-9]+", text))


def refusal_of(command: str, debug: Iterable[str]) -> str | None:
    """What the sensor said, where it refused a command or something that it does not name; None: it did not."""
    refuses = False
    for line in debug:
        lower = line.lower()
        words = _words(lower)
        says_no = any(stem in lower for stem in _REFUSES)
        confirms = bool(words & _CONFIRMS) and not words & _DOUBTS and not says_no
        is_named = any(word in _words(line) for word in command.split())
        refuses = refuses or (is_named and not confirms) or (not is_named and says_no)
    return "; ".join(debug) if refuses else None
