"""script/test again and again, as the machine is, beside load and under a quota, with a tally that is kept."""
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
WAYS = ("quiet", "busy", "quota")
COMPUTING, WRITING = 4, 2  # programs beside a busy run
BURST_B = 64 << 20  # that each writes, syncs and removes
SHARE = 0.25  # of all processors, under a quota
PERIOD_US = 100_000
COMPUTE = "while True: sum(range(100000))"
WRITE = f"""
import os, sys
while True:
    with open(sys.argv[1], "wb") as f:
        for _ in range({BURST_B >> 20}):
            f.write(os.urandom(1 << 20))
        os.fsync(f.fileno())
    os.remove(sys.argv[1])
"""
FAILED = re.compile(r"^FAIL +(\S+)", re.M)
CLOSING = re.compile(r"^(\d+) passed, (\d+) failed(?:, (\d+) skipped)?$", re.M)


class Tally:
    """The runs so far, in a file that is whole at any moment."""

    def __init__(self, path):
        self.path = path
        self.runs = json.loads(path.read_text()) if path.exists() else []

    def add(self, run):
        self.runs.append(run)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        new = self.path.with_suffix(".new")
        new.write_text(json.dumps(self.runs, indent=1) + "\n")
        new.replace(self.path)

    def of(self, commit, way):
        return [r for r in self.runs if (r["commit"], r["way"]) == (commit, way)]


@contextlib.contextmanager
def busy(folder):
    """Other programs run beside; all are killed at the end."""
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        programs = [subprocess.Popen([sys.executable, "-c", COMPUTE], start_new_session=True) for _ in range(COMPUTING)]
        programs += [subprocess.Popen([sys.executable, "-c", WRITE, f"{scratch}/{i}"], start_new_session=True)
                     for i in range(WRITING)]
        try:
            yield []
        finally:
            for p in programs:
                p.kill()
            for p in programs:
                p.wait()


@contextlib.contextmanager
def quota(folder):
    """A control group, of either version, with SHARE of the processors; yields the words that start a command in it. Needs root."""
    del folder
    name = f"lumsdk-soak-{os.getpid()}"
    share_us = int(SHARE * (os.cpu_count() or 1) * PERIOD_US)
    with contextlib.ExitStack() as stack:
        mounts = [line.split() for line in pathlib.Path("/proc/mounts").read_text().splitlines()]
        first = next((m[1] for m in mounts if m[2] == "cgroup" and "cpu" in m[3].split(",")), None)
        second = next((m[1] for m in mounts if m[2] == "cgroup2"), None)
        top = pathlib.Path(first or second or tempfile.mkdtemp())
        if not first and not second:
            subprocess.run(["mount", "-t", "cgroup2", "none", top], check=True)
            stack.callback(lambda: subprocess.run(["umount", top], check=False))
            second = top
        group = top / name
        if not first:
            with contextlib.suppress(OSError):
                (top / "cgroup.subtree_control").write_text("+cpu")
        group.mkdir()
        stack.callback(group.rmdir)
        if first:
            (group / "cpu.cfs_period_us").write_text(str(PERIOD_US))
            (group / "cpu.cfs_quota_us").write_text(str(share_us))
        else:
            (group / "cpu.max").write_text(f"{share_us} {PERIOD_US}")
        yield ["sh", "-c", f'echo $$ >"{group}/cgroup.procs" && exec "$@"', "sh"]


@contextlib.contextmanager
def quiet(folder):
    del folder
    yield []


def run(way, folder, log):
    """Its result."""
    begun = time.monotonic()
    with {"quiet": quiet, "busy": busy, "quota": quota}[way](folder) as before, open(log, "w") as out:
        p = subprocess.Popen([*before, ROOT / "script" / "test"], stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                             start_new_session=True)
        try:
            status = p.wait()
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(p.pid, signal.SIGKILL)  # also what a test has left
            p.wait()
    said = log.read_text(errors="replace")
    closing = CLOSING.findall(said)
    return {"way": way, "status": status, "seconds": round(time.monotonic() - begun), "failed": sorted(set(FAILED.findall(said))),
            "closing": ", ".join(f"{n or 0} {w}" for n, w in zip(closing[-1], ("passed", "failed", "skipped"))) if closing else "none"}


def commit():
    r = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=10"], cwd=ROOT, capture_output=True, text=True, check=False)
    return r.stdout.strip() or "unknown"


def parse(plan):
    """way -> runs, of such a word as 10,8,2."""
    runs = plan.split(",")
    if len(runs) != len(WAYS) or not all(n.isdigit() for n in runs):
        raise SystemExit(f"soak: --plan {plan}: three numbers, such as 10,8,2: {', '.join(WAYS)}")
    return dict(zip(WAYS, map(int, runs)))


def soak(path, plan, folder):
    """plan: way -> runs. Whether all of them, also of earlier calls, were good."""
    tally, of = Tally(path), commit()
    if of.endswith("-dirty"):
        raise SystemExit("soak: commit first: runs are counted by commit")
    if plan.get("quota") and os.geteuid() != 0:
        raise SystemExit("soak: only root may set a quota; without it: --plan 10,8,0")
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    while True:
        left = [way for way in WAYS for _ in range(plan.get(way, 0) - len(tally.of(of, way)))]
        if not left:
            break
        log = path.parent / "running.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        result = {"commit": of, "at": time.strftime("%F %T"), **run(left[0], folder, log)}
        if result["status"] != 0:
            kept = path.parent / f"failed-{len(tally.runs)}.log"
            shutil.copy(log, kept)
            result["log"] = kept.name
        tally.add(result)
        print(f"{result['way']:5} {result['seconds']:5} s  {result['closing']}"
              + (f"; failed: {' '.join(result['failed'])}, see {result['log']}" if result["status"] else ""), flush=True)
    runs = [r for way in WAYS for r in tally.of(of, way)]
    bad = [r for r in runs if r["status"] != 0]
    print(f"{len(runs)} runs of {of}: {len(runs) - len(bad)} passed, {len(bad)} failed; {path}")
    return not bad
