"""Whether a build is one to measure."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def fault(build, programs):
    """What makes a build unfit, or None."""
    for program in programs:
        if not (build / program).is_file():
            return f"{build / program} is not there"
    cache = (build / "CMakeCache.txt").read_text() if (build / "CMakeCache.txt").is_file() else ""
    settings = dict(re.findall(r"^(CMAKE_BUILD_TYPE|LUM_SANITIZE):\w+=(.*)$", cache, re.M))
    if settings.get("CMAKE_BUILD_TYPE", "Release") != "Release":
        return f"{build} is a build of type {settings['CMAKE_BUILD_TYPE'] or 'none'}, which is slower than Release"
    if settings.get("LUM_SANITIZE"):
        return f"{build} has sanitizers, which make it slow"
    return None


def need(build, programs):
    """Ends the script with status 2 if the build is unfit, and says what to do."""
    wrong = fault(build, programs)
    if wrong is None:
        return
    for other in ROOT / "build", ROOT / "build" / "release":
        if other != build.resolve() and fault(other, programs) is None:
            mend = f"use --build {other}"
            break
    else:
        mend = (f"make one by\n    cmake -S {ROOT} -B {build} -DCMAKE_BUILD_TYPE=Release && cmake --build {build}\n"
                "or name one by --build DIR; script/test makes one in build/release")
    print(f"{pathlib.Path(sys.argv[0]).name}: {wrong}: {mend}", file=sys.stderr)
    sys.exit(2)
