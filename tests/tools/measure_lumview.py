#!/usr/bin/env python3
"""measure_lumview.py [SECONDS [VIEW]]: what a live view costs. lumsim sends 64 lines ten times a second, both eyes, two
returns; a browser that does nothing but read gets the frames of a view such as "both 31". Prints the server's share of
a core, frames and points a second, and the time from a frame's completion to its last byte here."""
import json
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import time

from websocket import BINARY, Browser, Cloud

BIN = pathlib.Path(os.environ.get("LUM_BIN", "build/bin")).resolve()
ADDRESS = "127.23.0.1"


def seconds_of_cpu(process):
    with open(f"/proc/{process.pid}/stat") as f:
        fields = f.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watch(browser, server, seconds):
    began, cpu = time.monotonic(), seconds_of_cpu(server)
    delays, points = [], 0
    while time.monotonic() - began < seconds:
        kind, payload = browser.message()
        if kind == BINARY:
            cloud = Cloud(payload)
            delays.append(time.monotonic() - cloud.complete)
            points += cloud.points
    took = time.monotonic() - began
    print(f"server: {(seconds_of_cpu(server) - cpu) / took:.2f} of a core; {len(delays) / took:.1f} frames/s, "
          f"{points / took / 1e6:.2f} million points/s; from completion to the last byte: median "
          f"{statistics.median(delays) * 1e3:.0f} ms, worst {max(delays) * 1e3:.0f} ms")


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10
    sensor = subprocess.Popen([BIN / "lumsim", "--address", ADDRESS, "--quiet", "--returns-max", "2"])
    server = subprocess.Popen([BIN / "lumview", "--no-open", "--json", "--quiet", "--laser", f"udp://{ADDRESS}"],
                              stdout=subprocess.PIPE)
    try:
        place = json.loads(server.stdout.readline())
        browser = Browser(place["address"], place["port"])
        browser.say("view " + (sys.argv[2] if len(sys.argv) > 2 else "both 31"))
        browser.cloud(lambda cloud: cloud.points > 0)
        watch(browser, server, seconds)
    finally:
        server.send_signal(signal.SIGINT)
        server.wait()
        sensor.terminate()
        sensor.wait()


if __name__ == "__main__":
    main()
