"""HTTP and WebSocket byte by byte, so that a test can send what no browser would."""
import base64
import functools
import json
import os
import socket
import struct
import time

from support import PATIENCE_S

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
MASK = b"\x12\x34\x56\x78"


def request(method, path, host, *headers):
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host}", *headers]
    return "\r\n".join(lines).encode() + b"\r\n\r\n"


def upgrade(host, origin=None, path="/ws", protocol="lumview.1", *headers):
    """What a browser asks for a WebSocket with; origin "" leaves it out."""
    origin = f"http://{host}" if origin is None else origin
    key = base64.b64encode(os.urandom(16)).decode()
    wanted = ["Upgrade: websocket", "Connection: Upgrade", f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13"]
    wanted += [f"Origin: {origin}"] if origin else []
    wanted += [f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []
    return request("GET", path, host, *wanted, *headers)


def frame(kind, payload=b"", final=True, masked=True, reserved=0, length=None):
    """A frame as a browser sends it, or one that lies."""
    n = len(payload) if length is None else length
    bit = 0x80 if masked else 0
    if n < 126:
        size = bytes([bit | n])
    elif n < 1 << 16:
        size = bytes([bit | 126]) + struct.pack(">H", n)
    else:
        size = bytes([bit | 127]) + struct.pack(">Q", n)
    head = bytes([(0x80 if final else 0) | reserved | kind]) + size
    if not masked:
        return head + payload
    return head + MASK + bytes(c ^ MASK[i % 4] for i, c in enumerate(payload))


class Closed(Exception):
    """The other side has closed; code is None if it did so without a word."""

    def __init__(self, code):
        super().__init__(code)
        self.code = code


class Connection:
    """Bytes to and from a server."""

    def __init__(self, address, port, timeout=PATIENCE_S, receive_buffer=None, source=None):
        self.socket = socket.socket()
        if receive_buffer is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(timeout)
        if source is not None:
            self.socket.bind((source, 0))
        self.socket.connect((address, port))
        self.buffer = b""

    def close(self):
        self.socket.close()

    def send(self, data):
        """What the other side does not want any more is its affair."""
        try:
            self.socket.sendall(data)
        except (BrokenPipeError, ConnectionResetError):
            pass

    def more(self):
        try:
            data = self.socket.recv(1 << 20)
        except ConnectionResetError:
            data = b""
        if not data:
            raise Closed(None)
        self.buffer += data

    def take(self, n):
        while len(self.buffer) < n:
            self.more()
        out, self.buffer = self.buffer[:n], self.buffer[n:]
        return out

    def rest(self):
        """All that comes until the other side closes."""
        try:
            while True:
                self.more()
        except Closed:
            out, self.buffer = self.buffer, b""
            return out

    def answer(self, has_body=True):
        """(status, headers, body) of an HTTP answer; status None: it was closed."""
        try:
            while b"\r\n\r\n" not in self.buffer:
                self.more()
            head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
            first, *lines = head.decode("latin-1").split("\r\n")
            headers = {}
            for line in lines:
                name, value = line.split(":", 1)
                headers[name.lower()] = value.strip()
            body = self.take(int(headers.get("content-length", 0))) if has_body else b""
            return int(first.split()[1]), headers, body
        except Closed:
            return None, {}, b""


class Browser(Connection):
    """A WebSocket of lumview's."""

    def __init__(self, address, port, host=None, headers=(), **options):
        super().__init__(address, port, **options)
        self.send(upgrade(host or f"{address}:{port}", None, "/ws", "lumview.1", *headers))
        self.pieces = []  # of the frame that is coming
        self.shown = None  # the newest frame of points, whole
        status, self.headers, _ = self.answer(has_body=False)
        if status != 101:
            raise AssertionError(f"no WebSocket but {status}")

    def frame(self):
        """(final, kind, payload)"""
        first, second = self.take(2)
        n = second & 127
        if n == 126:
            n = struct.unpack(">H", self.take(2))[0]
        elif n == 127:
            n = struct.unpack(">Q", self.take(8))[0]
        assert second < 128, "a server does not mask"
        return first >= 128, first & 15, self.take(n)

    def message(self, answers_pings=True):
        """(kind, payload) of a whole message; Closed at its end."""
        kind, parts = None, []
        while True:
            final, opcode, payload = self.frame()
            if opcode == CLOSE:
                raise Closed(struct.unpack(">H", payload[:2])[0] if len(payload) >= 2 else None)
            if opcode == PING and answers_pings:
                self.send(frame(PONG, payload))
            elif opcode == PONG:
                return opcode, payload
            elif opcode < CLOSE:
                assert len(payload) <= 65536, len(payload)
                assert (opcode == 0) == (kind is not None), "a piece out of turn"
                kind = kind or opcode
                parts.append(payload)
                if final:
                    return kind, b"".join(parts)

    def whole(self, piece):
        """The frame that a piece completes, its pieces one behind the other; None: it lacks some."""
        at, count = struct.unpack_from("<II", piece, 84)
        if at == 0:
            self.pieces = []
        assert at == len(self.pieces), "a piece out of turn"
        self.pieces.append(piece)
        return b"".join(self.pieces) if at + 1 == count else None

    def messages(self, seconds=PATIENCE_S):
        """Messages as they come, frames of points whole; what has not come by then will not."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            opcode, payload = self.message()
            if opcode == BINARY:
                payload = self.whole(payload)
                self.shown = payload or self.shown
            if payload is not None:
                yield opcode, payload
        raise AssertionError(f"it did not come in {seconds} s")

    def text(self, kind="status"):
        """The next JSON of a kind."""
        for opcode, payload in self.messages():
            if opcode == TEXT:
                value = json.loads(payload)
                if value["type"] == kind:
                    return value

    def status(self, condition=lambda status: True):
        """The next status that fulfils a condition."""
        for opcode, payload in self.messages():
            if opcode == TEXT:
                value = json.loads(payload)
                if value["type"] == "status" and condition(value):
                    return value

    def cloud(self, condition=lambda cloud: True):
        """The next frame of points that fulfils a condition."""
        for opcode, payload in self.messages():
            if opcode == BINARY:
                value = Cloud(payload)
                if condition(value):
                    return value

    def say(self, command):
        self.send(frame(TEXT, command.encode()))

    def cloud_of(self, number):
        """A frame by its number. It may have come by itself, and the server does not send again what it shows."""
        if self.shown is not None and Cloud(self.shown).frame == number:
            return Cloud(self.shown)
        self.say(f"seek {number}")
        return self.cloud(lambda c: c.frame == number)

    def closing(self):
        """With which code the server closes."""
        try:
            for _ in self.messages():
                pass
        except Closed as end:
            return end.code


class Cloud:
    """A frame as the page gets it, its pieces one behind the other; see lum/frame/packed.h."""

    HEAD = struct.Struct("<IHHdddIBBBBIIIIddIfIIIIII")
    RUN = struct.Struct("<IIiiiHH3HBB")

    def __init__(self, data):
        self.data = data
        (magic, version, head, self.frame, self.clock, self.utc, self.points, self.edges, self.smooth, self.time_kind, parts,
         self.lines, self.lost, self.sensor, self.shown, self.complete, self.utc_error, self.second, self.step,
         *_) = self.HEAD.unpack_from(data)
        assert (magic, version, head, self.step) == (0x464D554C, 5, 104, 2**-9), data[:8]
        # Of each sensor of a rig: the number of its frame, its points, its place in the rig.
        self.parts = [struct.unpack_from("<dII", data, 104 + 16 * i) for i in range(parts)]

    @functools.cached_property
    def content(self):
        """All but what tells when it was shown."""
        pieces, at = [], 0
        while at < len(self.data):
            end = at + struct.unpack_from("<I", self.data, at + 80)[0]
            pieces.append(self.data[at + 80:end])
            at = end
        return b"".join(pieces)

    @functools.cached_property
    def rows(self):
        """Of each point: x, y, z, pulse width, line, pixel, return number and strongest, other bits."""
        rows, at = [None] * self.points, 0
        while at < len(self.data):
            at += self._piece(at, rows)
        assert None not in rows
        return rows

    def _piece(self, at, rows):
        bytes_, _, _, n, runs, others = struct.unpack_from("<IIIIII", self.data, at + 80)
        begin = at + 104 + 16 * len(self.parts)
        arrays = begin + 32 * runs
        columns = list(zip(*(struct.unpack_from(f"<{n}H", self.data, arrays + 2 * n * i) for i in range(4)),
                           self.data[arrays + 8 * n:arrays + 9 * n]))
        kinds = iter(struct.unpack_from(f"<{others}H", self.data, arrays + 9 * n + n % 2))
        bits = arrays + 9 * n + n % 2 + 2 * others
        done = 0
        for i in range(runs):
            first, line, *origin, count, pixel, a, b, c, exponent, eye = self.RUN.unpack_from(self.data, begin + 32 * i)
            pixels, bits = self._pixels(bits, pixel, count)
            for k in range(count):
                *steps, width, high = columns[done + k]
                xyz = [(o + s + ((high >> 2 * axis & 3) << 16)) / 2**exponent
                       for axis, (o, s) in enumerate(zip(origin, steps))]
                kind = (a, b, c)[high >> 6] if high < 192 else next(kinds)
                rows[first + k] = (*xyz, width, min(line, 65535), pixels[k], kind & 255, kind >> 8 | eye)
            done += count
        assert (done, list(kinds), self.data[bits:at + bytes_].strip(b"\0")) == (n, [], b"") and bits > at + bytes_ - 4
        return bytes_

    def _pixels(self, at, pixel, count):
        pixels, bit = [], 8 * at
        while len(pixels) < count:
            if self.data[bit >> 3] >> (bit & 7) & 1:
                pixels.append(pixel)
            else:
                pixel += 1
            bit += 1
        assert self.data[bit - 1 >> 3] >> (bit - 1 & 7) == 1, "bits behind the last point"
        return pixels, bit + 7 >> 3

    def xyz(self):
        return [row[:3] for row in self.rows]

    def _column(self, i):
        return tuple(row[i] for row in self.rows)

    def widths(self):
        return self._column(3)

    def line_numbers(self):
        return self._column(4)

    def pixels(self):
        return self._column(5)

    def return_numbers(self):
        return tuple(number & 127 for number in self._column(6))

    def strongest(self):
        return tuple(number > 127 for number in self._column(6))

    def bits(self):
        return self._column(7)
