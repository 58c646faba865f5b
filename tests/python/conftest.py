"""What the tests of the Python package share: captures of lumsim, and the package of the build that LUM_BIN names."""
import os
import pathlib
import subprocess
import sys

import pytest

BIN = pathlib.Path(os.environ.get("LUM_BIN", pathlib.Path(__file__).parents[2] / "build/release/bin")).resolve()
PACKAGE = BIN.parent / "python"
os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", str(BIN.parent / "hypothesis"))

from hypothesis import HealthCheck, settings  # noqa: E402, what it reads is set

settings.register_profile("lumsdk", deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
settings.load_profile("lumsdk")

if "LUM_INSTALLED" not in os.environ:  # else the package is one that pip has installed
    sys.path.insert(0, str(PACKAGE))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(PACKAGE), *filter(None, [os.environ.get("PYTHONPATH")])])
os.environ["LUM_BIN"] = str(BIN)


def run(program, *arguments, **options):
    """A program of the build: its standard output, once it has ended well."""
    done = subprocess.run([str(BIN / program), *map(str, arguments)], capture_output=True, check=False, **options)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout


@pytest.fixture(scope="session")
def make_capture(tmp_path_factory):
    """make_capture(*options of lumsim, name="drive.pcap"): the path of a capture, made once for the same options."""
    made = {}

    def make(*options, name="drive.pcap"):
        key = (*map(str, options), name)
        if key not in made:
            path = tmp_path_factory.mktemp("captures") / name
            run("lumsim", "-o", path, *options)
            made[key] = path
        return made[key]

    return make


@pytest.fixture(scope="session")
def capture(make_capture):
    """The path of a capture of 10 frames without faults."""
    return make_capture("-n", 10)


@pytest.fixture(scope="session")
def lumdump():
    """lumdump(*arguments): its standard output as bytes."""
    return lambda *arguments: run("lumdump", *arguments)
