#!/usr/bin/env python3
"""fuzz_lumview.py SECONDS [SEED]: mutated requests and WebSocket frames at a lumview that is best built with ASan. It
must answer at the end as at the start, end with status 0 and have said nothing. LUM_BIN is where the tools are."""
import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import time

from support import PATIENCE_S
from websocket import (BINARY, CLOSE, PING, PONG, TEXT, Browser, Connection, frame, request, upgrade)

BIN = pathlib.Path(os.environ.get("LUM_BIN", "build/bin")).resolve()
METHODS = "GET HEAD POST PUT OPTIONS CONNECT DELETE PATCH PRI get".split()
PATHS = ["/", "/icon.svg", "/ws", "/nothing", "*", "/../x", "/%2e%2e/", "/%00", "/?token=x", "/ws?a=b&a=b", "//", "",
         "http://127.0.0.1/", "/" + "a" * 3000]
HEADERS = ["Connection: close", "Connection: Upgrade", "Upgrade: websocket", "Upgrade: h2c", "Content-Length: 7",
           "Content-Length: -1", "Transfer-Encoding: chunked", "Cookie: lumview-1=x; a=b", "Origin: null",
           "Range: bytes=0-",
           "Accept-Encoding: gzip", "Expect: 100-continue", "HTTP2-Settings: AAMAAABkAARAAAAAAAIAAAAA",
           "Sec-WebSocket-Extensions: permessage-deflate; client_max_window_bits", "Sec-WebSocket-Protocol: a, b, c",
           "X: " + "y" * 9000, ": x", "Authorization: Basic eDp5", "Sec-WebSocket-Key: x", "Host: x"]
COMMANDS = ["play", "pause", "step 1", "step -1", "seek 5", "seek -5", "speed 2", "loop on", "loop off", "view both 31",
            "view rising 0", "view falling 63", "laser on", "view both 64", "speed nan", "", "x" * 64, "x" * 65,
            "x" * 5000]


def mutate(rng, data):
    """Some bytes changed, cut, doubled or put in."""
    out = bytearray(data)
    for _ in range(rng.choice((0, 0, 1, 1, 2, 5, 20))):
        at = rng.randrange(len(out) + 1)
        kind = rng.randrange(5)
        if kind == 0 and at < len(out):
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del out[at:at + rng.choice((1, 2, 8, 100))]
        elif kind == 2:
            out[at:at] = rng.randbytes(rng.choice((1, 2, 8, 100)))
        elif kind == 3:
            out[at:at] = out[at:at + rng.choice((1, 10, 1000))]
        else:
            out[at:at] = rng.choice((b"\r\n", b"\0", b"\r", b"\n", b" ", b"%", b"\xff" * 9, b":", b"?", b"&token="))
    return bytes(out)


def some_request(rng, host):
    lines = rng.sample(HEADERS, rng.choice((0, 0, 1, 2, 5)))
    out = request(rng.choice(METHODS), rng.choice(PATHS), rng.choice((host, host, host, "evil.example", "")), *lines)
    return out * rng.choice((1, 1, 1, 2, 10)) + rng.randbytes(rng.choice((0, 0, 7, 500)))


def some_frame(rng):
    kind = rng.choice((TEXT, TEXT, TEXT, TEXT, 0, BINARY, CLOSE, PING, PONG, rng.randrange(16)))
    payload = rng.choice(COMMANDS).encode()
    if rng.random() < 0.3:
        payload = rng.randbytes(rng.choice((0, 1, 2, 60, 125, 126, 70000)))
    length = rng.choice((0, 125, 126, 65535, 1 << 20, 1 << 31, 1 << 62)) if rng.random() < 0.1 else None
    return frame(kind, payload, final=rng.random() < 0.8, masked=rng.random() < 0.9,
                 reserved=rng.choice((0,) * 9 + (0x40, 0x20, 0x70)), length=length)


def attack(rng, address, port):
    """One connection's worth."""
    host = f"{address}:{port}"
    c = Connection(address, port, timeout=0.05)
    try:
        if rng.random() < 0.5:
            data = mutate(rng, some_request(rng, host))
        else:
            data = upgrade(host)
            data = mutate(rng, data) if rng.random() < 0.3 else data
            frames = b"".join(some_frame(rng) for _ in range(rng.choice((1, 1, 3, 30))))
            data += mutate(rng, frames) if rng.random() < 0.5 else frames
        while data:
            n = len(data) if rng.random() < 0.7 else rng.randrange(1, len(data) + 1)
            c.send(data[:n])
            data = data[n:]
        if rng.random() < 0.3:
            c.socket.shutdown(rng.choice((socket.SHUT_WR, socket.SHUT_RDWR)))
        if rng.random() < 0.5:
            c.rest()
    except OSError:
        pass  # it hung up, or has nothing more to say
    finally:
        c.close()


def check(address, port):
    """A page and a browser are served as ever; places may all be taken for a few seconds."""
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            c = Connection(address, port)
            c.send(request("GET", "/", f"{address}:{port}", "Connection: close"))
            if c.answer()[0] != 200:
                raise OSError("no page")
            b = Browser(address, port)
            b.text("hello")
            b.say("play")
            b.cloud()
            b.close()
            return
        except (OSError, AssertionError):
            if time.monotonic() > end:
                raise
            time.sleep(0.5)


def main():
    seconds = float(sys.argv[1])
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else random.randrange(1 << 32)
    rng = random.Random(seed)
    print(f"fuzz_lumview: seed {seed}", flush=True)
    server = subprocess.Popen([BIN / "../tests/fake/lumview_fake", "--no-open", "--json", "--quiet", "none.pcap"],
                              env={**os.environ, "FAKE_POINTS": "2000"}, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    place = json.loads(server.stdout.readline())
    address, port = place["address"], place["port"]
    count, end = 0, time.monotonic() + seconds
    try:
        check(address, port)
        while time.monotonic() < end and server.poll() is None:
            attack(rng, address, port)
            count += 1
            if count % 500 == 0:
                check(address, port)
        if server.poll() is None:
            check(address, port)
            server.send_signal(signal.SIGTERM)
        _, said = server.communicate(timeout=PATIENCE_S)
    finally:
        server.kill()
    print(f"fuzz_lumview: {count} connections, status {server.returncode}")
    if server.returncode != 0 or said:
        sys.stderr.write(said.decode(errors="replace"))
        sys.exit(1)


if __name__ == "__main__":
    main()
