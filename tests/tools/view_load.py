"""lumview on a live sensor: what the server takes of a core, and how old a frame is when a browser has it whole."""
import json
import os
import pathlib
import signal
import statistics
import subprocess
import time

from load import cpu_seconds, wait_for
from support import PATIENCE_S
from websocket import BINARY, Browser, Cloud

WARM_S = 4  # until the returns of a laser that was switched on have come to full strength


def resident_bytes(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def watch(browser, seconds):
    """Ages of the frames that came, seconds; points and bytes of them."""
    ages, points, size = [], 0, 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        kind, payload = browser.message()
        whole = browser.whole(payload) if kind == BINARY else None
        if whole is not None:
            now = time.monotonic()
            cloud = Cloud(whole)
            ages.append(now - cloud.complete)
            points += cloud.points
            size += len(whole)
    return ages, points, size


def measure(view, place, seconds):
    browser = Browser(place["address"], place["port"])
    try:
        browser.say("view both 31")
        watch(browser, WARM_S)
        cpu, memory, began = cpu_seconds(view.pid), resident_bytes(view.pid), time.monotonic()
        ages, points, size = watch(browser, seconds)
        wall = time.monotonic() - began
        return {"cpu": (cpu_seconds(view.pid) - cpu) / wall, "median_age_s": statistics.median(ages), "most_age_s": max(ages),
                "frames": len(ages), "frames_per_second": len(ages) / wall, "points_per_second": points / wall, "bytes_per_point": size / points,
                "memory": memory, "memory_growth": resident_bytes(view.pid) - memory,
                "skipped": browser.status()["skipped"], "losses": browser.status()["losses"]}
    finally:
        browser.close()


def run(bin_dir, folder, seconds, address="127.41.0.1"):
    """64 lines at 10 Hz, both eyes, both edges, angles smoothed: about 2.7 million points a second."""
    log = pathlib.Path(folder) / "view.log"
    log.unlink(missing_ok=True)
    sensor = subprocess.Popen([bin_dir / "lumsim", "--address", address, "--lines", "64", "--rate", "10", "--returns-max", "2",
                               "--log", log, "-q"],
                              stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    view = None
    try:
        wait_for(log, "frames", sensor)
        view = subprocess.Popen([bin_dir / "lumview", "--no-open", "--json", "--laser", f"udp://{address}"],
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        place = json.loads(view.stdout.readline())
        wait_for(log, "stream", sensor)
        return measure(view, place, seconds)
    finally:
        for p in (view, sensor):
            if p is not None and p.poll() is None:
                p.send_signal(signal.SIGTERM)
                p.wait(PATIENCE_S)
        if view is not None:
            view.stdout.close()
