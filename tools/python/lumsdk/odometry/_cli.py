"""The program lumodom."""
from __future__ import annotations

import sys
from typing import Optional

import numpy as np

from .. import _run
from .._c import VERSION
from .._errors import CaptureError
from .._run import Outputs, Progress, need
from ._arguments import Options, parse

NAME = "lumodom"
EXTRA = "odometry"


def odometry(options: Options, outputs: Outputs, progress: Progress) -> int:
    """Find the poses and measure them; the exit status."""
    need("kiss_icp", NAME, EXTRA)
    if options.report is not None:
        need("matplotlib", "--report", EXTRA)
    from .._poses import Poses
    from . import _metrics, _picture, _result
    from ._drive import Drive
    from ._estimate import Estimate

    truth = None if options.truth is None else Poses(options.truth)
    outputs.begin(options.output)
    outputs.begin(options.report)
    with Drive(options.drive, options.reading) as drive:
        def tell(count: int) -> None:
            progress("aligning frames", count / max(drive.expected(), count))

        track = Estimate(options.settings).run(drive, tell)
    progress.clear()
    if len(track.numbers) < 2:
        count = "one frame" if track.numbers else "no frame"
        raise CaptureError(f"{options.drive}: has {count} with points; a motion needs at least two")
    path = _metrics.path(np.array(track.poses), track.times_s())
    errors = None if truth is None else _metrics.compare(truth, track)
    found = _result.Result(options.drive, options.settings, track, path, drive.frames, errors,
                           _result.notes(drive, options.settings, path, track, options.time, errors))
    whose = "vehicle" if "rig" in options.reading else "sensor"
    outputs.write(options.output, lambda: _result.poses_text(track, options.time, f"lumodom {VERSION}", whose).encode())
    outputs.write(options.report, lambda: _picture.to_png(found))
    outputs.finish()
    if options.json:
        print(_result.to_json(found), end="")
    elif not options.quiet:
        print(_result.text(found), end="")
    return 0


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit status 0 done, 1 failed, 2 bad arguments; a signal ends it as a signal does."""
    return _run.main(NAME, parse, odometry, arguments)


if __name__ == "__main__":
    sys.exit(main())
