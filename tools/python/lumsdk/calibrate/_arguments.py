"""The command line of lumcal."""
from __future__ import annotations

import argparse
import os
from dataclasses import dataclass, field
from typing import Any, Optional

from .._command_line import Parser, check_apart, check_end, parser
from .._errors import OptionError
from .._settings import Calibration, Profile, setting_of

HELP = """\
Usage: lumcal eyes CAPTURE... [-o FILE] [OPTION]...
       lumcal check CAPTURE [OPTION]...
Find the calibration of a sensor from recordings of a room, and check whether
a calibration is right.

eyes   finds where each eye looks and how far it measures, from still
       captures of one room or yard with flat walls: at least 20 frames each,
       the sensor turned by 20 to 30 degrees between them. Use at least three
       captures, one of them rolled by about +12 degrees and one by -12.
       A value that they cannot determine keeps its starting value (it is
       held); the output names the recording that would determine it.
check  measures in one still capture how flat walls are, and the step where a
       wall or floor continues from one eye to the other.

See 'lumcal eyes --help' and 'lumcal check --help' for their options.

      --help, --version

Exit status: 0 done, 1 failed: files, captures, no flat face seen; eyes: the
result is useless; check: the eyes do not meet, or nothing shows whether they
do. 2 bad arguments or configuration.

Examples:
  lumcal eyes a.pcap b.pcap c.pcap -o calibration.yaml --report report.html
  lumcal check a.pcap --calibration calibration.yaml -o check.png
"""

_COMMON = """\
      --calibration FILE      {calibration}
      --profile FILE          wire profile of the captures
      --set KEY=VALUE         one key of them, such as tof_lsb_ps=13
      --sensor ADDRESS        take only this sensor
      --json                  print one JSON object
  -q, --quiet                 no progress, no warnings, and without --json
                              nothing of the result
      --help
"""

HELP_EYES = """\
Usage: lumcal eyes CAPTURE... [-o FILE] [OPTION]...
Find mounts, offsets, width and ends of the eyes from still captures of one
room or yard. Use at least three: one straight, and two turned by 20 to 30
degrees to either side and rolled, one by about +12 degrees, the other by -12.

  -o, --output FILE           the calibration, .yaml; without it the values
                              are only printed
      --report FILE           the residuals before and after, and the planes
                              that were found, as a page: .html
""" + _COMMON.format(calibration="where the search starts; default: the\n                              "
                     "captures' own, or typical values") + """
Status 1 if the result is useless: it is worse on faces left out of the fit, the
search did not settle, the eyes are exchanged, or the captures do not determine
the mount of the green eye, as one capture alone never does. Then the report is
written, but not the calibration, and a message says what to do.

Example:
  lumcal eyes a.pcap b.pcap c.pcap -o calibration.yaml --report report.html
"""

HELP_CHECK = """\
Usage: lumcal check CAPTURE [OPTION]...
How flat are walls, and how large is the step where one continues from eye to
eye?

  -o, --output FILE           a picture of it, .png
""" + _COMMON.format(calibration="what is checked; default: the capture's own,\n                              "
                     "or typical values") + """
Status 1 if the eyes do not meet, or if no wall or floor that both see can
show it.

Example:
  lumcal check a.pcap --calibration calibration.yaml -o check.png
"""

_HELPS = {"": HELP, "eyes": HELP_EYES, "check": HELP_CHECK}


def _given(**said: Any) -> dict[str, Any]:
    return {name: value for name, value in said.items() if value is not None}


@dataclass
class Options:
    """What the command line asks for."""

    command: str = ""
    captures: list[str] = field(default_factory=list)
    output: Optional[str] = None
    report: Optional[str] = None
    calibration: Optional[Calibration] = None
    calibration_name: str = ""
    """The file's name; empty: none was named."""
    profile: Optional[Profile] = None
    set: list[str] = field(default_factory=list)
    sensor: Optional[str] = None
    json: bool = False
    quiet: bool = False
    help: str = ""
    """The text to print; empty: none was asked for."""
    version: bool = False

    def of_open(self) -> dict[str, Any]:
        """What lumsdk.open() is told."""
        return _given(calibration=self.calibration, profile=self.profile, sensor=self.sensor, set=self.set or None)

    def _is_of_profile(self, pair: str) -> bool:
        return pair.partition("=")[0] in Profile()

    def of_grid(self) -> dict[str, Any]:
        """The same without what belongs to a calibration."""
        keys = [pair for pair in self.set if self._is_of_profile(pair)]
        return _given(profile=self.profile, sensor=self.sensor, set=keys or None)

    def of_calibration(self) -> list[str]:
        """What --set says of the calibration."""
        return [pair for pair in self.set if not self._is_of_profile(pair)]

    def begin(self) -> Calibration:
        """What is named, or typical values, with --set on top."""
        return setting_of(self.calibration or Calibration(), self.profile or Profile(), self.set)[0]


def _parser(command: str) -> Parser:
    return parser(f"lumcal {command}", "CAPTURE", ())


def _check_outputs(command: str, given: argparse.Namespace) -> None:
    if command == "eyes":
        check_end("--output", given.output, ".yaml", ".yml")
        check_end("--report", given.report, ".html", ".htm")
    else:
        if given.report is not None:
            raise OptionError("--report does not go with check, which draws a picture: -o FILE.png")
        check_end("--output", given.output, ".png")
    check_apart((given.output, given.report), (*given.captures, given.calibration, given.profile))


def _check_captures(command: str, captures: list[str]) -> None:
    if not captures:
        raise OptionError(f"no capture is named; see lumcal {command} --help")
    if command == "check" and len(captures) > 1:
        raise OptionError(f"check looks at one capture, and {len(captures)} are named: run it for each")
    if "-" in captures:
        raise OptionError("a capture is read more than once, which standard input cannot be: name a file")
    seen = set()
    for name in captures:
        path = os.path.realpath(name)
        if path in seen:
            raise OptionError(f"{name}: is named twice; each capture counts once")
        seen.add(path)


def _settings(given: argparse.Namespace, options: Options) -> None:
    if given.calibration is not None:
        options.calibration = Calibration(given.calibration)
    if given.profile is not None:
        options.profile = Profile(given.profile)
    options.begin()  # refuses what --set cannot mean


def parse(arguments: list[str]) -> Options:
    """The options, of which each was looked at by itself; OptionError: what is wrong."""
    command = arguments[0] if arguments else ""
    if command in ("--help", "--version"):
        return Options(help=HELP if command == "--help" else "", version=command == "--version")
    if command not in ("eyes", "check"):
        what = f"'{command}' is not a command" if command else "no command is given"
        raise OptionError(f"{what}; there are eyes and check; see lumcal --help")
    given = _parser(command).parse_intermixed_args(arguments[1:])
    if given.help or given.version:
        return Options(command, help=_HELPS[command] if given.help else "", version=not given.help)
    _check_captures(command, given.captures)
    _check_outputs(command, given)
    options = Options(command, given.captures, given.output, given.report, calibration_name=given.calibration or "",
                      set=given.set, sensor=given.sensor, json=given.json, quiet=given.quiet)
    _settings(given, options)
    return options
