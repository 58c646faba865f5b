"""What the tests of the Python package share: captures of lumsim, and the package of the build that LUM_BIN names."""
import os
import pathlib
import signal
import struct
import subprocess
import sys
import time

import pytest

BIN = pathlib.Path(os.environ.get("LUM_BIN", pathlib.Path(__file__).parents[2] / "build/release/bin")).resolve()
PACKAGE = BIN.parent / "python"
COMPLETION = pathlib.Path(__file__).parents[2] / "tools/completion/lumsdk.bash"

# For what has to come. It only ends a test that hangs: a busy machine may be slow.
PATIENCE_S = 300.0

# Ray takes what is slow for dead, and a program whose node is dead ends without a word. What has ended it notices at once.
for what in ("agent_register_timeout_ms", "health_check_timeout_ms"):
    os.environ.setdefault(f"RAY_{what}", "600000")
for what in ("gcs_rpc_server_reconnect_timeout_s", "gcs_server_request_timeout_seconds", "worker_register_timeout_seconds"):
    os.environ.setdefault(f"RAY_{what}", "600")

# What a shell runs in the background ignores it, and so would the programs that a test starts and signals.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

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


def interrupts_at_a_terminal(folder, call):
    """How often a program of the package is told to end, "one" or "several", if Ctrl-C at a terminal comes during a call: that
    goes to all programs of the terminal, and a second one ends them before they have tidied up."""
    program = folder / "program"
    program.write_text(f"""#!{sys.executable}
import pathlib, signal
ends = [signal.SIGINT, signal.SIGTERM]
signal.pthread_sigmask(signal.SIG_BLOCK, ends)
pathlib.Path("begun").touch()
signal.sigwait(ends)
again = signal.sigtimedwait(ends, 1)
pathlib.Path("interrupts").write_text("one" if again is None else "several")
""")
    program.chmod(0o755)
    user = f"""
import lumsdk._programs
lumsdk._programs.find = lambda name: {str(program)!r}
try:
    {call}
except KeyboardInterrupt:
    print("interrupted")
"""
    process = subprocess.Popen([sys.executable, "-c", user], cwd=folder, start_new_session=True, stdout=subprocess.PIPE)
    while not (folder / "begun").exists():
        assert process.poll() is None
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    assert process.communicate()[0] == b"interrupted\n"
    return (folder / "interrupts").read_text()


def on_interface(capture, path, name):
    """The capture as a pcapng file of an interface with a name of four letters, in nanoseconds."""
    data, at = capture.read_bytes(), 24
    unit = 1 if data[:4] == b"\x4d\x3c\xb2\xa1" else 1000

    def block(kind, body):
        size = struct.pack("<I", len(body) + 12)
        return struct.pack("<I", kind) + size + body + size

    blocks = [block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)),
              block(1, struct.pack("<HHIHH4sHHI", 1, 0, 0, 2, 4, name, 9, 1, 9))]
    while at < len(data):
        seconds, fraction, length = struct.unpack_from("<III", data, at)
        ns = seconds * 10**9 + fraction * unit
        body = struct.pack("<IIIII", 0, ns >> 32, ns & 0xFFFFFFFF, length, length) + data[at + 16:at + 16 + length]
        blocks.append(block(6, body + bytes(-length % 4)))
        at += 16 + length
    path.write_bytes(b"".join(blocks))
    return path


def pytest_configure(config):
    config.addinivalue_line("markers", "long: solves so much that only script/test --whole runs it")
    config.addinivalue_line("markers", "torch: needs torch, which is installed for script/test --all alone, for the system's Python")


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


_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]
_HANDLERS = {number: signal.getsignal(number) for number in _SIGNALS}


@pytest.fixture(autouse=True)
def own_signals():
    """What a program's main() does to signals ends with the test, also if a fixture of more tests called it."""
    yield
    for number, handler in _HANDLERS.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)


@pytest.fixture(scope="module")
def completion(tmp_path_factory):
    """completion(name, *command): complete(*words), which gives what bash offers for the last word of that program's command line."""
    script = """
        source "$0"
        COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
        _lumsdk "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
        printf '%s\\n' "${COMPREPLY[@]}"
    """

    def of(name, *command):
        folder = tmp_path_factory.mktemp("bin")
        program = folder / name
        program.write_text(f'#!/bin/sh\nexec {" ".join(command)} "$@"\n')
        program.chmod(0o755)

        def ask(*words):
            environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}
            return subprocess.run(["bash", "-c", script, COMPLETION, name, *words], capture_output=True, text=True, env=environment,
                                  timeout=PATIENCE_S).stdout.split()
        return ask
    return of
