"""The command line of lumodom."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Optional

from .._command_line import Parser, check_apart, check_end, parser
from .._errors import OptionError
from .._settings import Calibration, Profile, setting_of
from ._estimate import Settings

HELP = """\
Usage: lumodom DRIVE [-o poses.txt] [OPTION]...
Find where a sensor was during a drive from its frames alone, by kiss-icp, and
how far that is from the truth, if there is one.

  -o, --output FILE           the poses, .txt, as TUM has them: seconds, x, y,
                              z, qx, qy, qz, qw; without it, they are only
                              measured. The world begins at the first pose
      --time utc|sensor       the output's seconds: since 1970 UTC (default),
                              or by the sensor's clock
      --report FILE           the path, speeds, residuals and errors as a
                              picture, .png
      --truth FILE            true poses: TUM, or CSV with a header; what the
                              errors are measured by
      --no-deskew             points stay as they were measured, as if the
                              sensor had stood during each frame; --deskew is
                              the default
      --max-range M           points farther away are not used (default 100)
      --voxel M               edge of the map's cells (default 1)
      --eye blue|green|both   (default both)
      --range MIN:MAX         metres from the eye
      --frames A:B            frame numbers, both included; A: or :B too
      --sensor ADDRESS|NAME   take only this sensor, of a rig by its name
      --rig FILE              its sensors on a vehicle; poses are then the
                              vehicle's
      --calibration FILE      default: the drive's own, or typical values
      --profile FILE          wire profile of the drive
      --set KEY=VALUE         one key of them, such as tof_lsb_ps=13
      --json                  print one JSON object
  -q, --quiet                 no progress, no warnings, and without --json
                              nothing of the result
      --help, --version

Exit status: 0 done, 1 failed: files, a drive of one frame, frames without a
clock, a truth of another time. 2 bad arguments or configuration.

Examples:
  lumodom drive.pcap -o poses.txt --report drive.png
  lumodom drive.pcap --truth truth.txt --json
  lumdump drive.pcap --poses poses.txt --voxel 0.1 -o map.las
"""

_OF_OPEN = ("eye", "range", "frames", "sensor", "rig")
_TEXTS = ("truth", "time", "max-range", "voxel", "eye", "range", "frames", "rig")


@dataclass
class Options:
    """What the command line asks for."""

    drive: str = ""
    output: Optional[str] = None
    report: Optional[str] = None
    truth: Optional[str] = None
    time: str = "utc"
    settings: Settings = field(default_factory=Settings)
    reading: dict[str, Any] = field(default_factory=dict)
    """What lumsdk.open() is told."""
    json: bool = False
    quiet: bool = False
    help: str = ""
    """The text to print; empty: none was asked for."""
    version: bool = False


def _parser() -> Parser:
    made = parser("lumodom", "DRIVE", _TEXTS)
    made.add_argument("--deskew", action="store_true", default=True)
    made.add_argument("--no-deskew", action="store_false", dest="deskew")
    return made


def _metres(option: str, text: Optional[str], usual: float) -> float:
    if text is None:
        return usual
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.01 <= value <= 1000:
        raise OptionError(f"{option}: {text}: metres are needed, from 0.01 to 1000")
    return value


def _settings(given: Any) -> Settings:
    usual = Settings()
    made = Settings(_metres("--max-range", given.max_range, usual.max_range), _metres("--voxel", given.voxel, usual.voxel_size),
                    given.deskew)
    if made.voxel_size > made.max_range / 4:
        raise OptionError(f"--voxel: {made.voxel_size:g} m are too much for --max-range {made.max_range:g}: at most a quarter of it")
    return made


def _reading(given: Any) -> dict[str, Any]:
    made = {name: getattr(given, name) for name in _OF_OPEN if getattr(given, name) is not None}
    calibration = None if given.calibration is None else Calibration(given.calibration)
    profile = None if given.profile is None else Profile(given.profile)
    setting_of(calibration or Calibration(), profile or Profile(), given.set)  # refuses what --set cannot mean
    said = {"calibration": calibration, "profile": profile, "set": given.set or None}
    return {**made, **{name: value for name, value in said.items() if value is not None}}


def parse(arguments: list[str]) -> Options:
    """The options, of which each was looked at by itself; OptionError: what is wrong."""
    given = _parser().parse_intermixed_args(arguments)
    if given.help or given.version:
        return Options(help=HELP if given.help else "", version=not given.help)
    if len(given.drives) != 1:
        raise OptionError(f"one drive is needed, and {len(given.drives) or 'none'} {'are' if given.drives else 'is'} named; files of "
                          "one drive are named by a pattern in quotes, as 'drive-*.pcap'; see lumodom --help")
    if given.time not in (None, "utc", "sensor"):
        raise OptionError(f"--time: {given.time}: is utc or sensor")
    check_end("--output", given.output, ".txt", ".tum")
    check_end("--report", given.report, ".png")
    if given.time is not None and given.output is None:
        raise OptionError("--time: sets the seconds in the output, and there is none: name one by --output")
    check_apart((given.output, given.report), (*given.drives, given.truth, given.calibration, given.profile, given.rig))
    return Options(given.drives[0], given.output, given.report, given.truth, given.time or "utc", _settings(given), _reading(given),
                   given.json, given.quiet)
