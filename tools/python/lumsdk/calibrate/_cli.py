"""The program lumcal."""
from __future__ import annotations

import json
import sys
from typing import Optional

from .. import _run
from .._run import Outputs, Progress, need, told
from ._arguments import Options, parse

NAME = "lumcal"
EXTRA = "calibrate"

# A calibration is what this program looks for, or at: which one, its result says.
_KNOWN = ".*: it has a calibration of its own, which is not used"


def eyes(options: Options, outputs: Outputs, progress: Progress) -> int:
    """Find the calibration; the exit status."""
    need("scipy", "lumcal eyes", EXTRA)
    if options.report is not None:
        need("matplotlib", "--report", EXTRA)
    from . import _eyes, _report, _tell

    outputs.begin(options.output)
    outputs.begin(options.report)
    count = len(options.captures)
    progress(f"reading {count} capture{'' if count == 1 else 's'} and solving")
    reading = options.of_grid()
    solution = _eyes.run(_eyes.Options(options.captures, options.calibration, reading.pop("profile", None), reading,
                                       options.of_calibration(), options.calibration_name))
    progress.clear()
    outputs.write(options.report, lambda: _report.page(solution).encode())
    why = _tell.not_written(solution)
    if not why:
        outputs.write(options.output, lambda: _eyes.to_yaml(solution).encode())
    outputs.finish()
    if options.json:
        print(json.dumps(_eyes.to_json(solution), indent=2))
    elif not options.quiet:
        print(_tell.solution_text(solution), end="")
    if why:
        told(NAME, (f"{options.output} is not written: " if options.output else "") + why)
    return 1 if why else 0


def check(options: Options, outputs: Outputs, progress: Progress) -> int:
    """Measure how well a calibration fits; the exit status."""
    need("scipy", "lumcal check", EXTRA)
    if options.output is not None:
        need("matplotlib", "a picture", EXTRA)
    from . import _check, _check_picture, _tell

    outputs.begin(options.output)
    found = _check.check(options, progress)
    progress.clear()
    outputs.write(options.output, lambda: _check_picture.check_png(found))
    outputs.finish()
    if options.json:
        print(_tell.check_json(found), end="")
    elif not options.quiet:
        print(_tell.check_text(found), end="")
    return 0 if found.verdict == "meet" else 1


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit status 0 done, 1 failed, 2 bad arguments; a signal ends it as a signal does."""
    return _run.main(NAME, parse, lambda options, *made: (eyes if options.command == "eyes" else check)(options, *made), arguments,
                     _KNOWN)


if __name__ == "__main__":
    sys.exit(main())
