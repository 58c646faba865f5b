"""HTTP and WebSocket byte by byte, so that a test can send what no browser would."""
import base64
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

    def messages(self, seconds=PATIENCE_S):
        """Messages as they come; what has not come by then will not."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            opcode, payload = self.message()
            if opcode == BINARY:
                self.shown = payload
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
    """A frame as the page gets it; see tools/lumview/frame.h."""

    HEAD = struct.Struct("<IHHdddIBBBBIIIIddII")

    def __init__(self, data):
        self.data = data
        (magic, version, head, self.frame, self.clock, self.utc, self.points, self.edges, self.smooth, self.time_kind, parts,
         self.lines, self.lost, self.sensor, self.shown, self.complete, self.utc_error, self.second, _) = self.HEAD.unpack_from(data)
        assert (magic, version, head) == (0x464D554C, 4, 80), data[:8]
        behind = 80 + 20 * self.points
        assert len(data) == behind + 16 * parts, (len(data), self.points, parts)
        # Of each sensor of a rig: the number of its frame, its points, its place in the rig.
        self.parts = [struct.unpack_from("<dII", data, behind + 16 * i) for i in range(parts)]

    def array(self, at, letter, count=1):
        return struct.unpack_from(f"<{count * self.points}{letter}", self.data, 80 + at * self.points)

    def xyz(self):
        numbers = self.array(0, "f", 3)
        return list(zip(numbers[::3], numbers[1::3], numbers[2::3]))

    def widths(self):
        return self.array(12, "H")

    def line_numbers(self):
        return self.array(14, "H")

    def pixels(self):
        return self.array(16, "H")

    def return_numbers(self):
        return tuple(number & 127 for number in self.array(18, "B"))

    def strongest(self):
        return tuple(number > 127 for number in self.array(18, "B"))

    def bits(self):
        return self.array(19, "B")
