"""lumview's server: what it serves, whom it refuses, and that nothing sent to it brings it down. Most tests feed it
frames out of nothing (tests/fake/fake_feed.c); the last ones a capture."""
import contextlib
import gzip
import hashlib
import itertools
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import stat
import struct
import subprocess
import time
import unittest
import urllib.parse

import shards
from live import Process, wait_until
from support import BIN, PATIENCE_S, Folder, frames_of, limited, read_csv, run, simulate, summary
from test_provenance import mounted, packets, section
from test_sources import later, split
from websocket import (BINARY, PING, PONG, TEXT, Browser, Closed, Connection, frame, request, upgrade)

PAGE = pathlib.Path(__file__).parent / "../../tools/lumview/page"
FAKE = BIN / "../tests/fake/lumview_fake"
ADDRESSES = (f"127.21.{shards.index()}.{i + 1}" for i in itertools.count())
CONNECTIONS_MAX, OF_ONE_HOST = 100, 30


class Case(unittest.TestCase):
    """A server for each test."""

    tool = FAKE
    source = "none.pcap"

    def setUp(self):
        self.folder = Folder(self)

    def serve(self, *arguments, points=1000, rate=20, source=None, sources=None, stdin=os.devnull):
        environment = {"FAKE_POINTS": str(points), "FAKE_HZ": str(rate)}
        command = ["env", *(f"{k}={v}" for k, v in environment.items()), self.tool, "--no-open", "--json", *arguments,
                   *(sources or [source or self.source])]
        with open(stdin, "rb") as f:
            self.server = Process(self, self.folder, *command, name="lumview", stdin=f)
        place = json.loads(wait_until(lambda: self.server.stdout() if self.server.stdout().endswith("\n") else
                                      self.fail(self.server.stderr()) if self.server.p.poll() is not None else "",
                                      what="lumview's JSON"))
        self.url, self.address, self.port = place["url"], place["address"], place["port"]
        self.host = f"{self.address}:{self.port}"
        self.token = self.url.partition("?token=")[2]
        self.addCleanup(self.is_clean)
        return place

    def is_clean(self):
        """It has said nothing but its address and warnings: no sanitizer's report, no complaint."""
        self.assertEqual(self.server.end(), 0, self.server.stderr())
        said = self.server.stderr().splitlines()
        self.warnings = [line for line in said if line.startswith("lumview: warning: ")]
        self.assertEqual([line for line in said if line not in self.warnings], [f"lumview: {self.url} (Ctrl-C ends it)"])

    def connect(self, **options):
        out = Connection(self.address, self.port, **options)
        self.addCleanup(out.close)
        return out

    def browser(self, **options):
        out = Browser(self.address, self.port, **options)
        self.addCleanup(out.close)
        return out

    def ask(self, data, has_body=True):
        """The answer to a request, or to what is none."""
        c = self.connect()
        c.send(data)
        try:
            return c.answer(has_body)
        finally:
            c.close()

    def get(self, path="/", *headers, host=None, method="GET"):
        return self.ask(request(method, path, host or self.host, *headers), has_body=method != "HEAD")

    def lives(self):
        self.assertIsNone(self.server.p.poll(), self.server.stderr())
        headers = [f"Cookie: lumview-{self.port}={self.token}"] if self.token else []
        self.assertEqual(self.get("/", *headers)[0], 200)


class Page(Case):
    def loads(self):
        """What the page loads."""
        status, headers, page = self.get("/")
        self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"))
        self.assertIn("<title>lumview</title>", page.decode())
        self.assertNotRegex(page.decode(), r"https?://(?!www\.w3\.org)", "it needs no network")
        return re.findall(r'<(?:link|script)\b[^>]*?(?:src|href)="([^"]+)"', page.decode())

    def test_the_page_loads_one_script_and_one_style(self):
        self.serve()
        icon, style, script = self.loads()
        self.assertEqual(icon, "/icon.svg")
        self.assertRegex(style, r"^/style-[0-9a-f]{16}\.css$")
        self.assertRegex(script, r"^/app-[0-9a-f]{16}\.js$")
        self.assertNotIn("importmap", self.get("/")[2].decode())
        for path, kind in ((icon, "image/svg+xml"), (style, "text/css; charset=utf-8"),
                           (script, "text/javascript; charset=utf-8")):
            status, headers, body = self.get(path)
            self.assertEqual((status, headers["content-type"]), (200, kind))
        text = gzip.decompress(body).decode()
        found = re.search(r"""(?m)(?:^|[;}])import[\s{*"']|\bimport\s*\(|sourceMappingURL""", text)
        self.assertIsNone(found, "it loads nothing else")
        self.assertTrue("WebGL" in text, "the modules are in it")

    def test_script_and_style_are_compressed_and_may_be_kept(self):
        self.serve()
        _, style, script = self.loads()
        for path in (style, script):
            for headers in ([], ["Accept-Encoding: gzip, deflate, br"], ["Accept-Encoding: *"]):
                status, headers, body = self.get(path, *headers)
                self.assertEqual((status, headers["content-encoding"]), (200, "gzip"), headers)
                self.assertEqual(headers["cache-control"], "private, max-age=31536000, immutable")
            plain = gzip.decompress(body)
            self.assertEqual(re.search(r"-([0-9a-f]+)\.", path)[1], hashlib.sha256(plain).hexdigest()[:16])
            self.assertLess(len(body), len(plain) / 2)
            status, headers, text = self.get(path, "Accept-Encoding: identity")
            self.assertEqual((status, text), (406, b"This is stored compressed: send Accept-Encoding: gzip.\n"))
            self.assertEqual(headers["cache-control"], "no-store")
        for path in ("/", "/icon.svg", "/licenses.txt"):
            status, headers, _ = self.get(path, "Accept-Encoding: identity")
            self.assertEqual((status, headers["cache-control"]), (200, "no-store"))
            self.assertNotIn("content-encoding", headers)

    def test_every_answer_has_the_strict_headers(self):
        self.serve()
        script = self.loads()[-1]
        for path, host, expected in (("/", None, 200), (script, None, 200), ("/no", None, 404), ("/", "evil", 403)):
            status, headers, _ = self.get(path, host=host)
            self.assertEqual(status, expected)
            policy = dict(part.strip().split(" ", 1) for part in headers["content-security-policy"].split(";"))
            self.assertEqual(policy["default-src"], "'none'")
            self.assertEqual(policy["script-src"], "'self'")
            self.assertEqual(policy["style-src"], "'self'")
            self.assertEqual(policy["img-src"], "'self' data: blob:")
            self.assertEqual(policy["connect-src"], f"'self' ws://{self.host} ws://localhost:{self.port}")
            for name in ("base-uri", "form-action", "frame-ancestors"):
                self.assertEqual(policy[name], "'none'", name)
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertEqual(headers["referrer-policy"], "no-referrer")
            self.assertEqual(headers["cross-origin-opener-policy"], "same-origin")
            self.assertEqual(headers["cross-origin-resource-policy"], "same-origin")
            self.assertEqual(headers["cache-control"] == "no-store", path != script)
            self.assertNotIn("server", headers)
            self.assertNotIn("set-cookie", headers)

    def test_head_tells_the_length_and_sends_nothing(self):
        self.serve()
        _, _, body = self.get("/icon.svg")
        c = self.connect()
        c.send(request("HEAD", "/icon.svg", self.host, "Connection: close"))
        status, headers, _ = c.answer(has_body=False)
        self.assertEqual((status, int(headers["content-length"])), (200, len(body)))
        self.assertEqual(c.rest(), b"")

    def test_one_connection_serves_many_requests(self):
        self.serve()
        c = self.connect()
        for path in ("/icon.svg", "/", "/licenses.txt", "/icon.svg"):
            c.send(request("GET", path, self.host))
            self.assertEqual(c.answer()[0], 200)

    def test_nothing_else_is_there(self):
        self.serve()
        for path in ("/nothing", "/app.js", "/icon.svg/", "//icon.svg/x", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/ws",
                     "/style.css", "/INDEX.HTML"):
            self.assertEqual(self.get(path)[0], 404, path)
        self.lives()

    def test_it_is_only_looked_at(self):
        self.serve()
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH"):
            status, headers, _ = self.get("/", method=method)
            self.assertEqual((status, headers.get("allow")), (405, "GET, HEAD"), method)
        self.assertEqual(self.ask(request("POST", "/", self.host, "Content-Length: 5") + b"hello")[0], 405)
        self.assertEqual(self.ask(request("GET", "/", self.host, "Content-Length: 5") + b"hello")[0], 413)
        self.assertEqual(self.ask(request("GET", "/", self.host, "Transfer-Encoding: chunked") + b"0\r\n\r\n")[0], 413)
        self.lives()


class Strangers(Case):
    def test_a_name_of_others_with_our_address_is_refused(self):
        self.serve()
        for host in ("evil.example", f"evil.example:{self.port}", "127.0.0.1", f"127.0.0.1:{self.port + 1}",
                     f"127.0.0.1.evil.example:{self.port}", f"0.0.0.0:{self.port}", f"[::1]:{self.port}",
                     f"{self.host}, evil.example", f"{self.host}@evil.example"):
            self.assertEqual(self.get("/", host=host)[0], 403, host)
            self.assertEqual(self.ask(upgrade(host))[0], 403, host)
            self.assertEqual(self.ask(upgrade(host, f"http://{self.host}"))[0], 403, host)
        self.assertEqual(self.get("/", f"Host: {self.host}")[0], 403, "two of them")
        self.assertEqual(self.ask(b"GET / HTTP/1.1\r\n\r\n")[0], 403, "none")
        self.assertEqual(self.get("/", host=f"localhost:{self.port}")[0], 200)
        self.lives()

    def test_a_page_of_others_is_refused(self):
        self.serve()
        for origin in ("http://evil.example", "null", "file://", f"https://{self.host}", "http://127.0.0.1",
                       f"http://127.0.0.1:{self.port + 1}", f"http://{self.host}.evil.example", f"http://{self.host}/"):
            self.assertEqual(self.ask(upgrade(self.host, origin))[0], 403, origin)
            self.assertEqual(self.get("/icon.svg", f"Origin: {origin}")[0], 403, origin)
        self.assertEqual(self.ask(upgrade(self.host, ""))[0], 403, "a browser always tells its origin")
        status, _, text = self.ask(upgrade(self.host, "http://evil.example"))
        self.assertEqual(text, b"This server answers only its own page.\n")
        self.assertEqual(self.get("/icon.svg", f"Origin: http://{self.host}")[0], 200)
        self.browser(host=f"localhost:{self.port}").text("hello")

    def test_only_one_protocol_at_one_place_is_spoken(self):
        self.serve()
        good = upgrade(self.host)
        for wrong in (upgrade(self.host, path="/"), upgrade(self.host, path="/icon.svg"),
                      upgrade(self.host, protocol=None), upgrade(self.host, protocol="http"),
                      upgrade(self.host, protocol="lumview.2"), good.replace(b"Version: 13", b"Version: 12"),
                      good.replace(b"Upgrade: websocket", b"Upgrade: h2c"),
                      re.sub(rb"Sec-WebSocket-Key: [^\r]*\r\n", b"", good)):
            self.assertIn(self.ask(wrong)[0], (404, None), wrong)
        h2c = request("GET", "/", self.host, f"Origin: http://{self.host}", "Connection: Upgrade, HTTP2-Settings",
                      "Upgrade: h2c", "HTTP2-Settings: AAMAAABkAARAAAAAAAIAAAAA")
        self.assertEqual(self.ask(h2c)[0], 404)
        self.lives()


class Token(Case):
    def setUp(self):
        super().setUp()
        self.place = next(ADDRESSES)

    def test_another_address_demands_the_token_that_is_printed(self):
        self.serve("--bind", self.place)
        self.assertEqual(self.address, self.place)
        self.assertRegex(self.url, rf"^http://{self.place}:\d+/\?token=[0-9a-f]{{32}}$")
        cookie = f"Cookie: lumview-{self.port}={self.token}"
        wrong = self.token[:-1] + ("0" if self.token[-1] != "0" else "1")
        for path, headers, expected in (
                ("/", [], 403), ("/?token=", [], 403), (f"/?token={wrong}", [], 403),
                (f"/?token={self.token}0", [], 403), (f"/?token={self.token[:31]}", [], 403),
                (f"/?tokens={self.token}", [], 403),
                ("/icon.svg", [], 403), ("/nothing", [], 403), (f"/?token={self.token}", [], 200),
                (f"/icon.svg?token={self.token}", [], 200), ("/", [cookie], 200), ("/icon.svg", [cookie], 200),
                ("/icon.svg", [f"Cookie: a=b; lumview-{self.port}={self.token}; c=d"], 200),
                (f"/?token={wrong}", [cookie], 403), ("/", [f"Cookie: lumview-{self.port}={wrong}"], 403),
                ("/", [f"Cookie: lumview-{self.port + 1}={self.token}"], 403), ("/nothing", [cookie], 404)):
            self.assertEqual(self.get(path, *headers)[0], expected, (path, headers))
        self.assertEqual(self.get("/")[2].decode().split(":")[0], "The token is missing or wrong")

    def test_the_page_sets_the_cookie_that_its_modules_send(self):
        self.serve("--bind", self.place)
        _, headers, _ = self.get(f"/?token={self.token}")
        self.assertEqual(headers["set-cookie"],
                         f"lumview-{self.port}={self.token}; Path=/; HttpOnly; SameSite=Lax")
        for path in ("/", "/?token=x", "/nothing"):
            self.assertNotIn("set-cookie", self.get(path)[1])

    def test_the_socket_demands_it_too(self):
        self.serve("--bind", self.place)
        cookie = f"Cookie: lumview-{self.port}={self.token}"
        self.assertEqual(self.ask(upgrade(self.host))[0], 403)
        self.assertEqual(self.ask(upgrade(self.host, path="/ws?token=x"))[0], 403)
        self.assertEqual(self.ask(upgrade(self.host, "http://evil.example", "/ws", "lumview.1", cookie))[0], 403)
        self.browser(headers=[cookie]).text("hello")
        self.assertEqual(self.ask(upgrade(self.host, path=f"/ws?token={self.token}"), has_body=False)[0], 101)

    def test_its_host_is_the_address_it_listens_on(self):
        self.serve("--bind", self.place)
        for host in (f"localhost:{self.port}", f"127.0.0.1:{self.port}", self.place, "evil.example"):
            self.assertEqual(self.get(f"/?token={self.token}", host=host)[0], 403, host)

    def test_each_run_has_a_token_of_its_own(self):
        tokens = set()
        for _ in range(3):
            self.serve("--bind", self.place)
            self.assertEqual(self.server.end(), 0)
            tokens.add(self.token)
        self.assertEqual(len(tokens), 3)
        self.assertTrue(all(len(set(t)) > 4 for t in tokens), tokens)

    def test_the_loopback_address_demands_one_if_it_is_asked_for(self):
        self.serve("--bind", "127.0.0.1")
        self.assertEqual(len(self.token), 32)
        self.assertEqual(self.get("/")[0], 403)
        self.assertEqual(self.get(f"/?token={self.token}", host=f"localhost:{self.port}")[0], 200)


class Malformed(Case):
    def test_requests_that_are_none_are_refused_or_dropped(self):
        self.serve()
        h = f"Host: {self.host}\r\n".encode()
        for data in (b"\x00\xff\x12garbage\r\n\r\n", b"\r\n\r\n", b" / HTTP/1.1\r\n\r\n", b"GET\r\n\r\n",
                     b"GET  \r\n\r\n",
                     b"BREW / HTTP/1.1\r\n" + h + b"\r\n", b"GET / HTTP/9.9\r\n" + h + b"\r\n\x00" * 9,
                     b"GET http://127.0.0.1/ HTTP/1.1\r\n" + h + b"\r\n",
                     b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes(9),
                     b"CONNECT a:1 HTTP/1.1\r\n" + h + b"\r\n", b"GET * HTTP/1.1\r\n" + h + b"\r\n",
                     b"GET /%zz HTTP/1.1\r\n" + h + b"\r\n", b"GET /%00 HTTP/1.1\r\n" + h + b"\r\n",
                     b"GET / HTTP/1.1\r\n: x\r\n" + h + b"\r\n", b"GET / HTTP/1.1\r\nHost\r\n\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"Content-Length: -1\r\n\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"Content-Length: 99999999999999999999\r\n\r\n",
                     b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + os.urandom(300), os.urandom(4000)):
            c = self.connect()
            c.send(data)
            c.socket.shutdown(socket.SHUT_WR)
            c.rest()
            self.lives()

    def test_headers_beyond_all_measure_are_dropped(self):
        self.serve()
        h = f"Host: {self.host}\r\n".encode()
        for data in (b"GET / HTTP/1.1\r\n" + h + b"X: " + b"a" * 200000 + b"\r\n\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"Cookie: " + b"a" * 200000 + b"\r\n\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"a" * 200000,
                     b"GET /" + b"a" * 200000 + b" HTTP/1.1\r\n" + h + b"\r\n",
                     b"GET /?" + b"a=b&" * 50000 + b" HTTP/1.1\r\n" + h + b"\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"X: y\r\n" * 50000 + b"\r\n",
                     b"GET / HTTP/1.1\r\n" + h + b"".join(b"X-%d: y\r\n" % i for i in range(20000)) + b"\r\n"):
            c = self.connect()
            c.send(data)
            self.assertNotIn(b" 200 ", c.rest()[:20])
            self.lives()

    def test_requests_that_do_not_end_are_given_up(self):
        self.serve()
        for data in (b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: "):
            c = self.connect()
            c.send(data)
            self.assertEqual(c.rest(), b"")
        c = self.connect()
        with self.assertRaises(OSError):
            for _ in range(200):
                c.socket.sendall(b"X")
                time.sleep(0.1)
        self.lives()

    def test_a_connection_that_asks_no_more_is_closed(self):
        self.serve()
        c = self.connect()
        c.send(request("GET", "/icon.svg", self.host))
        self.assertEqual(c.answer()[0], 200)
        self.assertEqual(c.rest(), b"")

    def test_frames_that_are_none_close_the_connection(self):
        self.serve()
        for data, codes in (
                (frame(0, b"play"), {1002}), (frame(TEXT, b"pl", final=False) + frame(TEXT, b"ay"), {1002}),
                (frame(TEXT, b"play", reserved=0x40), {1002}), (frame(3, b"x"), {1002}), (frame(11, b"x"), {1002}),
                (frame(PING, b"x", final=False), {1002}), (frame(PING, b"x" * 126), {1002}),
                (bytes([0x81, 0xFF]) + b"\xff" * 8 + b"aaaa", {1002}),
                (frame(TEXT, b"v" * 100000), {1008, None}), (frame(TEXT, b"v" * 65), {1008}),
                (frame(TEXT, b"\xff\xfe"), {1008, 1007}), (frame(TEXT, b""), {1008}),
                (frame(BINARY, b"play"), {1003}), (frame(BINARY, b""), {1003}),
                (frame(BINARY, b"pl", final=False), {1003})):
            b = self.browser()
            b.send(data)
            code = b.closing()
            if code is None and 1002 in codes:
                code = 1002  # libwebsockets tells it where nothing else is under way
            self.assertIn(code, codes, data[:40])
            self.lives()
        for _ in range(20):
            b = self.browser()
            b.send(os.urandom(3000))
            b.socket.shutdown(socket.SHUT_WR)
            b.closing()
        self.lives()

    def test_a_frame_without_a_mask_does_no_more_than_one_with(self):
        self.serve()
        b = self.browser()
        b.send(frame(TEXT, b"laser on", masked=False))
        self.assertIn(b.closing(), (1002, 1008))
        b = self.browser()
        b.send(frame(BINARY, os.urandom(100000), masked=False))
        self.assertIn(b.closing(), (1002, 1003, None))
        self.lives()

    def test_a_frame_of_a_monstrous_length_takes_no_memory(self):
        self.serve()
        before = self.memory()
        many = [self.browser() for _ in range(20)]
        for b in many:
            b.send(frame(TEXT, b"abc", length=1 << 62))
        self.lives()
        self.assertLess(self.memory() - before, 64 << 20)

    def memory(self):
        with open(f"/proc/{self.server.p.pid}/statm") as f:
            return int(f.read().split()[1]) * resource.getpagesize()


class Socket(Case):
    def test_the_greeting_and_then_the_status_come_first(self):
        self.serve("--speed", "2", "--loop")
        b = self.browser()
        self.assertEqual(b.headers["sec-websocket-protocol"], "lumview.1")
        kind, payload = b.message()
        hello = json.loads(payload)
        self.assertEqual(kind, TEXT)
        self.assertEqual(hello["type"], "hello")
        self.assertEqual(f"lumview {hello['version']}\n", run("lumview", "--version").stdout)
        self.assertEqual((hello["source"], hello["live"], hello["smooth_max"]), (self.source, False, 63))
        self.assertEqual([e["name"] for e in hello["eyes"]], ["blue", "green"])
        for eye in hello["eyes"]:
            self.assertEqual((len(eye["mount"]), len(eye["rotation"])), (3, 9))
        kind, payload = b.message()
        status = json.loads(payload)
        self.assertEqual((status["type"], status["state"], status["live"]), ("status", "playing", False))
        self.assertEqual((status["speed"], status["loop"], status["message"]), (2, True, ""))
        self.assertEqual((status["first_frame"], status["last_frame"], status["laser"]), (0, 1000, None))
        self.assertEqual(set(status["losses"]), {"wire_words", "wire_lines", "joined_words", "joined_lines", "pauses", "kernel", "ring", "refused"})
        self.assertEqual((status["browsers"], status["skipped"]), (1, 0))
        for key in ("frame packets bytes points frames points_per_second frames_per_second bytes_per_second").split():
            self.assertIsInstance(status[key], (int, float), key)

    def test_a_sensors_status_tells_its_bits_by_name(self):
        self.serve(source="udp://127.0.0.1")
        b = self.browser()
        self.assertTrue(b.text("hello")["live"])
        status = b.status()
        self.assertEqual((status["live"], status["first_frame"], status["last_frame"]), (True, None, None))
        self.assertEqual(status["laser"], {"status": 0x0820, "up": False, "on": False, "bits": ["BOARD_OVER_105", "TLV_CMD_ON"],
                                           "hazards": ["BOARD_OVER_105"]})

    def test_a_source_of_any_name_is_told_as_text(self):
        name = b'/tmp/"\\\n\xc3\xa4\xff\xed\xa0\x80<b>.pcap' + b"x" * 3000
        self.serve(source=os.fsdecode(name))
        self.assertEqual(self.browser().text("hello")["source"],
                         '/tmp/"\\\n\xe4\ufffd\ufffd\ufffd\ufffd<b>.pcap' + "x" * 3000)

    def test_frames_come_whole_and_each_once(self):
        self.serve(points=12345)
        b = self.browser()
        clouds = [b.cloud() for _ in range(12)]
        self.assertEqual({c.points for c in clouds}, {12345})
        numbers = [c.frame for c in clouds]
        self.assertEqual(numbers, sorted(set(numbers)))
        self.assertEqual([c.pixels()[:3] for c in clouds], [(0, 4, 8)] * 12)

    def test_rates_are_those_of_the_feed(self):
        self.serve(points=500, rate=20)
        b = self.browser()
        b.status()
        b.status()
        status = [b.status() for _ in range(3)][-1]
        self.assertAlmostEqual(status["bytes_per_second"] / status["points_per_second"], 4, delta=0.01)
        self.assertGreater(status["frames_per_second"], 0)

    def test_each_browser_has_its_own_view(self):
        self.serve()
        a, b = self.browser(), self.browser()
        a.say("view both 31")
        b.say("view falling 0")
        a.cloud(lambda c: (c.edges, c.smooth) == (3, 31))
        b.cloud(lambda c: (c.edges, c.smooth) == (2, 0))
        self.assertEqual({(a.cloud().edges, b.cloud().edges) for _ in range(10)}, {(3, 2)})
        self.assertEqual(a.status()["browsers"], 2)
        c = self.browser()
        c.cloud(lambda cloud: (cloud.edges, cloud.smooth) == (1, 0))
        b.close()
        a.status(lambda s: s["browsers"] == 2)

    def test_a_ninth_view_has_no_place(self):
        self.serve()
        many = [self.browser() for _ in range(8)]
        for i, b in enumerate(many):
            b.say(f"view both {2 * i + 3}")
            b.cloud(lambda c, i=i: c.smooth == 2 * i + 3)
        ninth = self.browser()
        taken = ninth.cloud().smooth
        ninth.say("view rising 0")
        ninth.status()
        ninth.status()
        cloud = ninth.cloud()
        self.assertEqual(cloud.smooth, taken)
        for i, b in enumerate(many):
            self.assertEqual(b.cloud(lambda c: c.shown > cloud.shown).smooth, 2 * i + 3, "nobody lost its own")
        ninth.say("view both 5")
        ninth.cloud(lambda c: c.smooth == 5)
        many[1].close()
        many[0].status(lambda s: s["browsers"] == 8)
        ninth.say("view rising 0")
        ninth.status()
        self.assertIn(ninth.cloud().smooth, (0, 5))

    def test_playing_is_shared_and_told_at_once(self):
        self.serve()
        a, b = self.browser(), self.browser()
        a.say("pause")
        at = b.status(lambda s: s["state"] == "paused")["frame"]
        b.say("step -3")
        a.status(lambda s: s["state"] == "paused" and s["frame"] == at - 3)  # not one of before
        a.say("seek 700")
        self.assertEqual(b.cloud(lambda c: c.frame >= 700).frame, 700)
        a.say("step 2")
        self.assertEqual(b.cloud(lambda c: c.frame > 700).frame, 702)
        a.say("speed 0.5")
        a.say("loop on")
        b.status(lambda s: s["speed"] == 0.5 and s["loop"])
        a.say("play")
        b.status(lambda s: s["state"] == "playing")
        self.assertLess(at, 700)

    def test_commands_may_come_in_pieces_and_pings_between(self):
        self.serve()
        b = self.browser()
        b.send(frame(TEXT, b"pa", final=False) + frame(PING, b"here?") + frame(0, b"", final=False) + frame(0, b"use"))
        seen = set()
        for kind, payload in b.messages():
            if kind == PONG:
                self.assertEqual(payload, b"here?")
                seen.add("pong")
            elif kind == TEXT and json.loads(payload).get("state") == "paused":
                seen.add("paused")
            if len(seen) == 2:
                break

    def test_anything_else_is_refused(self):
        self.serve()
        for text in ("laser on", "", "play ", "PLAY", "view rising", "view rising 2", "view rising 65", "view up 0",
                     "step", "step x", "seek 1e9999", "speed nan", "speed 0", "loop", "play\0", "x" * 64):
            b = self.browser()
            b.say(text)
            self.assertEqual(b.closing(), 1008, text)
        self.lives()

    def test_a_close_is_answered(self):
        self.serve(rate=1)
        b = self.browser()
        b.cloud()  # libwebsockets answers nothing in the middle of a message
        b.send(frame(8, struct.pack(">H", 1000)))
        self.assertEqual(b.closing(), 1000)

    def test_a_slow_browser_gets_the_newest_frame(self):
        self.serve(points=100000, rate=20)
        slow, fast = self.browser(receive_buffer=65536), self.browser()
        first = slow.cloud()
        for _ in range(12):  # more than buffers hold; the slow one must not be silent for so long that it is hung up
            newest = fast.cloud()
        late = [slow.cloud()]  # the kernel's buffers may hold older ones
        while late[-1].frame < newest.frame:
            late.append(slow.cloud())
        self.assertLess(len(late), 6, "they were queued")
        status = slow.status(lambda s: s["skipped"] > 0)
        self.assertGreaterEqual(status["skipped"], late[-1].frame - first.frame - 1 - len(late))
        self.assertLess(fast.status()["skipped"], status["skipped"])

    def test_a_browser_that_gives_no_sign_of_life_is_hung_up(self):
        self.serve(points=100000)
        dead, alive = self.browser(receive_buffer=65536), self.browser()
        alive.status(lambda s: s["browsers"] == 2)
        alive.status(lambda s: s["browsers"] == 1)
        with self.assertRaises(Closed):
            for _ in range(10000):
                dead.message(answers_pings=False)


class Crowd(Case):
    """Each of the loopback addresses is a host."""

    def sources(self):
        """As many as there can be connections, no more than may be of one host."""
        hosts = (f"127.0.{i}.1" for i in range(10, 20))
        return list(itertools.chain(*([h] * OF_ONE_HOST for h in hosts)))[:CONNECTIONS_MAX]

    def is_refused(self, **options):
        """A connection is closed without a word."""
        c = self.connect(**options)
        c.send(request("GET", "/", self.host))
        return c.rest() == b""

    def is_served(self, **options):
        c = self.connect(**options)
        c.send(request("GET", "/", self.host, "Connection: close"))
        return c.answer()[0] == 200

    def test_idle_web_sockets_of_one_host_leave_room_for_others(self):
        self.serve()
        idle = [self.browser(source="127.0.0.9") for _ in range(OF_ONE_HOST)]
        self.assertTrue(self.is_refused(source="127.0.0.9"))
        self.assertTrue(self.is_served(source="127.0.0.8"))
        self.browser(source="127.0.0.8").text("hello")
        idle[0].status(lambda s: s["browsers"] == OF_ONE_HOST + 1)
        idle.pop().close()
        idle[0].status(lambda s: s["browsers"] == OF_ONE_HOST)
        wait_until(lambda: self.is_served(source="127.0.0.9"), what="the place that is free again")
        self.lives()

    def test_idle_connections_of_one_host_too(self):
        self.serve()
        idle = [self.connect(source="127.0.0.9") for _ in range(OF_ONE_HOST)]
        self.assertTrue(self.is_refused(source="127.0.0.9"))
        self.assertTrue(self.is_served(source="127.0.0.8"))
        for c in idle:
            self.assertEqual(c.rest(), b"")
        self.lives()

    def test_a_hundred_idle_connections_are_all_there_can_be(self):
        self.serve()
        first, *others = self.sources()
        browser = self.browser(source=first)
        idle = [self.connect(source=source) for source in others]
        self.assertTrue(self.is_refused(source="127.0.0.9"))
        self.assertEqual(browser.status()["browsers"], 1)
        for c in idle:
            self.assertEqual(c.rest(), b"")
        self.lives()

    def test_a_hundred_browsers_are_served(self):
        self.serve()
        many = [self.browser(source=source) for source in self.sources()]
        many[-1].status(lambda s: s["browsers"] == CONNECTIONS_MAX)
        self.assertTrue(self.is_refused(source="127.0.0.9"))
        for b in many:
            b.cloud()
        for b in many[1:]:
            b.close()
        many[0].status(lambda s: s["browsers"] == 1)
        self.lives()


class Run(Case):
    def test_the_place_is_told_in_one_line(self):
        place = self.serve()
        self.assertEqual(place, {"url": f"http://127.0.0.1:{self.port}/", "address": "127.0.0.1", "port": self.port})
        self.assertEqual(self.server.stdout().count("\n"), 1)

    def test_each_signal_ends_it_with_0(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            self.serve()
            self.browser().text("hello")
            self.assertEqual(self.server.end(number), 0)

    def test_a_port_that_is_taken_is_told_by_whom(self):
        self.serve()
        r = subprocess.run([FAKE, "--no-open", "--port", str(self.port), "x"], capture_output=True, text=True,
                           timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertEqual(r.stderr, f"lumview: --port: port {self.port} of 127.0.0.1 is taken by lumview_fake (process "
                                   f"{self.server.p.pid}): choose another, or none for any that is free\n")

    def test_a_port_can_be_taken_again_at_once(self):
        self.serve()
        port, b = self.port, self.browser()
        b.text("hello")
        self.assertEqual(self.server.end(), 0)
        self.serve("--port", str(port))
        self.assertEqual(self.port, port)

    def test_an_address_of_others_is_told(self):
        r = subprocess.run([FAKE, "--no-open", "--bind", "192.0.2.1", "x"], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stderr),
                         (1, "lumview: --bind: 192.0.2.1 is not an address of this host; see: ip addr\n"))

    def test_the_browser_is_started_and_not_waited_for(self):
        seen = self.folder / "seen"
        script = self.folder / "look"
        script.write_text(f'#!/bin/sh\n{{ echo "$1"; ls -l /proc/$$/fd; }} >{seen}.part\n'
                          f'mv {seen}.part {seen}\nexec sleep 3\n')
        script.chmod(0o755)
        environment = {**os.environ, "BROWSER": f"/no/such/browser:{script}"}
        with subprocess.Popen([FAKE, "--quiet", "x"], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as p, limited(p):
            wait_until(seen.exists, what="the browser")
            p.send_signal(signal.SIGINT)
            self.assertEqual(p.wait(PATIENCE_S), 0)
            self.assertEqual((p.stdout.read(), p.stderr.read()), (b"", b""))
        url, files = seen.read_text().split("\n", 1)
        self.assertRegex(url, r"^http://127\.0\.0\.1:\d+/$")
        self.assertNotIn("socket:", files, "the browser would keep the port")

    def open_with_token(self, **environment):
        """The one argument that a browser gets, the URL that is printed, and the file that is named, while it is."""
        seen, script = self.folder / "seen", self.folder / "look"
        script.write_text(f'#!/bin/sh\nfor i; do echo "$i"; done >{seen}.part\nmv {seen}.part {seen}\n')
        script.chmod(0o755)
        environment = {**os.environ, "BROWSER": str(script), **environment}
        with subprocess.Popen([FAKE, "--bind", "127.0.0.1", "x"], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as p, limited(p):
            wait_until(seen.exists, what="the browser")
            argument, url = seen.read_text(), p.stderr.readline().split()[1]
            token = url.partition("?token=")[2]
            self.assertEqual(len(token), 32)
            for process in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
                with contextlib.suppress(OSError):
                    self.assertNotIn(token.encode(), process.read_bytes())
            self.assertRegex(argument, r"^file:///[^ ]*/lumview-\w{6}/open\.html\n$")
            file = pathlib.Path(urllib.parse.unquote(argument[len("file://"):-1]))
            self.assertEqual([stat.S_IMODE(f.stat().st_mode) for f in (file, file.parent)], [0o600, 0o700])
            text = file.read_text()
            self.assertIn(f'<meta http-equiv="refresh" content="0; url={url}">', text)
            self.assertIn(f'<a href="{url}">', text)
            p.send_signal(signal.SIGINT)
            self.assertEqual(p.wait(PATIENCE_S), 0, p.stderr.read())
        self.assertFalse(file.parent.exists(), "it is removed at the end")
        seen.unlink()
        return file.parent.parent

    def test_a_token_is_no_argument_of_the_browser(self):
        run_time, other = self.folder / "run time", self.folder / "other é"
        run_time.mkdir()
        other.mkdir()
        self.assertEqual(self.open_with_token(XDG_RUNTIME_DIR=str(run_time)), run_time)
        self.assertEqual(self.open_with_token(XDG_RUNTIME_DIR="/no/such", TMPDIR=str(other)), other)
        self.assertEqual(self.open_with_token(XDG_RUNTIME_DIR="", TMPDIR="relative"), pathlib.Path("/tmp"))

    def test_without_a_browser_the_address_is_told_all_the_same(self):
        server = Process(self, self.folder, "env", "-i", FAKE, "x", name="bare")
        wait_until(lambda: server.stderr().count("\n") == 2, what="the note")
        self.assertEqual(server.end(), 0)
        self.assertRegex(server.stderr(), r"^lumview: http://127\.0\.0\.1:\d+/ \(Ctrl-C ends it\)\n"
                                          r"lumview: no browser could be started: open this URL in one\n$")


class Licenses(Case):
    """What is in the page is what the lock file names, and comes with its permission."""

    def setUp(self):
        super().setUp()
        r = run("lumview", "--licenses")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.text, self.parts = r.stdout, {}
        for part in re.split(r"(?m)^==== ", r.stdout)[1:]:
            title, text = part.split("\n", 1)
            self.parts[title] = text
        known = json.loads((PAGE / "modules.json").read_text())
        self.versions = {name.partition("/")[0].lstrip("@"): about["version"] for name, about in known.items()}

    def test_each_module_that_the_page_is_made_of_has_its_permission(self):
        titles = {f"three {self.versions['three']} (MIT)"}
        version = run("lumview", "--version").stdout.split()[1]
        others = {f"esbuild {self.versions['esbuild']}", f"lumsdk {version}"}
        self.assertEqual(set(self.parts), titles | others)
        for title in titles:
            self.assertRegex(self.parts[title], r"Copyright (©|\(c\)|\d{4})")
            self.assertRegex(self.parts[title], r"(?i)permission (is hereby granted|to use, copy, modify)", title)

    def test_what_the_script_has_of_others_is_listed(self):
        bundle = json.loads((BIN / "../tools/lumview/bundle/bundle.json").read_text())
        inputs = {name for out in bundle["outputs"].values() for name in out["inputs"]}
        modules = {name.rpartition("node_modules/")[2].split("/")[0] for name in inputs if "node_modules/" in name}
        self.assertTrue(modules)
        self.assertEqual({m for m in modules if not any(title.startswith(m + " ") for title in self.parts)}, set())
        own = {pathlib.Path(name).name for name in inputs if "node_modules/" not in name}
        apart = {"boot.js", "engine.js", "wasi.js", "worker.js"}  # of lumview.html alone
        self.assertEqual(own, {p.name for p in PAGE.glob("*.js")} - apart | {"style.css"})

    def bundle(self, modules):
        """The page put together anew, of modules at another place."""
        esbuild = next(modules.glob("@esbuild/*/bin/esbuild"))
        values = {"PAGE": PAGE, "MODULES": modules, "ESBUILD": esbuild, "GZIP": shutil.which("gzip"), "NAME": "x",
                  "LICENSE": PAGE / "../../../LICENSE", "OUT": self.folder / "out"}
        return subprocess.run(["cmake", *(f"-D{name}={value}" for name, value in values.items()), "-P",
                               PAGE / "../bundle.cmake"], capture_output=True, text=True, timeout=PATIENCE_S)

    def test_modules_can_lie_in_a_folder_of_any_name(self):
        modules = self.folder / "some modules"
        cache = (BIN / "../CMakeCache.txt").read_text()
        brought = pathlib.Path(re.search(r"^LUM_VIEW_MODULES:PATH=(.*)$", cache, re.M)[1] or BIN / "../lumview")
        shutil.copytree(brought / "node_modules" if (brought / "node_modules").exists() else brought, modules)
        r = self.bundle(modules)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        text = (self.folder / "out/licenses.txt").read_text()
        self.assertEqual(text.split("\n", 1)[1], self.text.split("\n", 1)[1])
        (modules / "three/LICENSE").unlink()
        r = self.bundle(modules)
        self.assertNotEqual(r.returncode, 0)
        self.assertIn("there is no licence file to be shipped with it", " ".join(r.stderr.split()))

    def test_lumsdk_has_its_own(self):
        self.assertIn((PAGE / "../../../LICENSE").read_text(), self.text)

    def test_the_page_has_them_too(self):
        self.serve()
        self.assertIn('href="/licenses.txt"', self.get("/")[2].decode())
        status, headers, body = self.get("/licenses.txt")
        self.assertEqual((status, headers["content-type"]), (200, "text/plain; charset=utf-8"))
        self.assertEqual(body.decode(), self.text)


class Arguments(unittest.TestCase):
    def refused(self, *arguments):
        r = run("lumview", *arguments)
        self.assertEqual((r.returncode, r.stdout), (2, ""), arguments)
        self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
        self.assertTrue(r.stderr.startswith("lumview: "), r.stderr)
        return r.stderr[len("lumview: "):].strip()

    def test_what_is_wrong_is_told_and_what_would_be_right(self):
        one_address = "one address of this host, such as 192.168.1.5"
        for arguments, message in (
                ([], "no SOURCE: name captures, - for standard input, or udp://ADDRESS; see lumview --help"),
                (["a", "udp://127.0.0.1"], "udp://127.0.0.1: a sensor is the only source of its run; several sources are captures"),
                (["udp://127.0.0.1", "a"], "udp://127.0.0.1: a sensor is the only source of its run; several sources are captures"),
                (["--laser", "a", "b"], "--laser goes with a sensor, udp://ADDRESS"),
                (["--what", "a"], "--what: no such option; see lumview --help"),
                (["--no", "a"], "--no: no such option; did you mean --no-open? See lumview --help"),
                (["--por", "1", "a"], "--por: no such option; did you mean --port? See lumview --help"),
                (["-x", "a"], "-x: no such option; see lumview --help"),
                (["--port", "65536", "a"], "--port: '65536' is not a port from 0 to 65535, 0 any"),
                (["--port=x", "a"], "--port: 'x' is not a port from 0 to 65535, 0 any"),
                (["a", "--port"], "--port: a value is missing: a port from 0 to 65535, 0 any"),
                (["--bind", "0.0.0.0", "a"], f"--bind: '0.0.0.0' is not {one_address}"),
                (["--bind", "10.42.0", "a"], "--bind: '10.42.0' is neither an IPv4 address, four numbers from 0 to 255 such as "
                 "10.42.0.37, nor the name of a host"),
                (["--bind", "224.0.0.1", "a"], f"--bind: '224.0.0.1' is not {one_address}"),
                (["--json=yes", "a"], "--json takes no value: 'yes'"),
                (["--speed", "0", "a"], "--speed: '0' is not a number from 0.01 to 100"),
                (["--sensor", "1.2.3", "a"], "--sensor: '1.2.3' is neither an IPv4 address, four numbers from 0 to 255 such as "
                 "10.42.0.37, nor the name of a host"),
                (["--laser", "a"], "--laser goes with a sensor, udp://ADDRESS"),
                (["--interface", "lo", "a"], "--interface goes with a sensor, udp://ADDRESS"),
                (["--loop", "udp://127.0.0.1"], "--loop goes with a capture, not with a sensor"),
                (["--speed", "1", "udp://127.0.0.1"], "--speed goes with a capture, not with a sensor"),
                (["--paused", "udp://127.0.0.1"], "--paused goes with a capture, not with a sensor"),
                (["--sensor", "1.2.3.4", "udp://127.0.0.1"], "--sensor goes with a capture, not with a sensor"),
                (["udp://255.255.255.255"], "udp://255.255.255.255: no sensor can have this address; use udp://HOST or "
                 "udp://HOST:PORT, such as udp://10.42.0.37"),
                (["udp://"], "udp://: the host is missing; use udp://HOST or udp://HOST:PORT, such as udp://10.42.0.37"),
                (["127.0.0.1"], "127.0.0.1: there is no such file; a sensor is named as udp://127.0.0.1"),
                (["a", "udp:/127.0.0.1:5517"], "udp:/127.0.0.1:5517: there is no such file; a sensor is named as "
                 "udp://127.0.0.1:5517")):
            self.assertEqual(self.refused(*arguments), message)
        for url in ("udp://", "udp://host.invalid", "udp://1.2.3", "udp://1.2.3.4:0", "udp://1.2.3.4:65536", "udp://1.2.3.4/"):
            self.assertIn("use udp://HOST or udp://HOST:PORT", self.refused(url))

    def test_a_configuration_that_is_wrong_is_told(self):
        folder = Folder(self)
        (folder / "bad.yaml").write_text("nonsense: 1\n")
        for option in ("--calibration", "--profile"):
            self.assertIn("bad.yaml", self.refused(option, folder / "bad.yaml", "--no-open", "x.pcap"))

    def test_a_source_that_is_none_is_told(self):
        folder = Folder(self)
        (folder / "none.pcap").write_bytes(b"this is no capture")
        for name in ("none.pcap", "missing.pcap"):
            r = run("lumview", "--no-open", folder / name)
            self.assertEqual((r.returncode, r.stdout), (1, ""))
            self.assertIn(name, r.stderr)
            self.assertEqual(r.stderr.count("\n"), 1, r.stderr)

    def test_one_of_several_that_is_none_is_named(self):
        folder = Folder(self)
        good = [simulate(folder / f"r-{i}.pcap", "--frames", "1", "--lines", "64", "--seed", str(i)) for i in (1, 2)]
        folder.write("notes.txt", "not a capture, but long enough to be looked at")
        for name, message in (("r-3.pcap", "cannot be opened: No such file or directory"), ("notes.txt", "not a capture")):
            for sources in ([*good, folder / name], [folder / name, *good]):
                r = run("lumview", "--no-open", *sources)
                self.assertEqual((r.returncode, r.stdout, r.stderr.count("\n")), (1, "", 1), r.stderr)
                self.assertTrue(r.stderr.startswith(f"lumview: {folder / name}: {message}"), r.stderr)
        os.link(good[0], folder / "same.pcap")
        for other in good[0], folder / "same.pcap":
            self.assertIn("are one file: name each source once", self.refused("--no-open", *good, other))
        with open(good[1], "rb+") as out:
            r = subprocess.run([BIN / "lumview", "--no-open", "--json", *good], stdout=out, stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stderr), (2, b"lumview: standard output is the source itself, which this run reads: "
                                                       b"redirect it elsewhere\n"))

    def test_help_and_version(self):
        r = run("lumview", "--help")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.assertTrue(r.stdout.startswith("Usage: lumview [OPTION]... SOURCE...\n"))
        self.assertTrue(all(len(line) <= 80 for line in r.stdout.split("\n")))
        self.assertEqual(run("lumview", "-h").stdout, r.stdout)
        self.assertRegex(run("lumview", "--version").stdout, r"^lumview \d+\.\d+\.\d+\n$")


class Capture(Case):
    """Frames are those of the capture, as lumdump counts them."""

    tool = BIN / "lumview"

    def setUp(self):
        super().setUp()
        self.source = simulate(self.folder / "street.pcap", "--frames", "4", "--lines", "64")

    def points(self, number, *options):
        return summary(self.source, "--frames", f"{number}:{number}", *options)["sensors"][0]["points"]

    def test_each_frame_has_the_points_that_lumdump_counts(self):
        self.serve("--paused")
        b = self.browser()
        status = b.status(lambda s: s["first_frame"] is not None)
        for number in range(status["first_frame"], status["last_frame"] + 1):
            cloud = b.cloud_of(number)
            self.assertEqual(cloud.points, self.points(number))
            for edge, code in (("both", 3), ("falling", 2), ("rising", 1)):
                b.say(f"view {edge} 0")
                cloud = b.cloud(lambda c, n=number, e=code: (c.frame, c.edges) == (n, e))
                self.assertEqual(cloud.points, self.points(number, "--edge", edge))


    def test_a_damaged_part_is_said(self):
        made = self.folder / "damaged.pcapng"
        self.assertEqual(run("lumdump", self.source, "-q", "-o", made).returncode, 0)
        content = bytearray(made.read_bytes())
        at = content.index(list(frames_of(self.source.read_bytes()))[2000][42:]) - 42
        struct.pack_into("<I", content, at - 8, 65535)  # the length of its packet
        self.source = self.folder.write("damaged.pcapng", content)
        self.serve("--paused")
        said = self.browser().status(lambda s: s["message"])["message"]
        self.assertIn(f"1 part of it could not be read and was passed over: byte {at - 28}: a packet of 65535 bytes", said)

    def test_points_are_those_that_lumdump_writes(self):
        self.serve("--paused")
        b = self.browser()
        status = b.status(lambda s: s["first_frame"] is not None)
        number = status["first_frame"] + 1
        b.say(f"seek {number}")
        clouds = {}  # both before the first is compared: a browser that answers no ping for long is closed
        for window in (0, 31):
            b.say(f"view both {window}")
            clouds[window] = b.cloud(lambda c, w=window: (c.frame, c.edges, c.smooth) == (number, 3, w))
        for window, options in ((0, []), (31, ["--smooth", "31"])):
            cloud = clouds[window]
            table = self.folder / f"{window}.csv"
            r = run("lumdump", self.source, "-o", table, "--edge", "both", "--frames", f"{number}:{number}", *options)
            self.assertEqual(r.returncode, 0, r.stderr)
            rows = read_csv(table)
            self.assertEqual(cloud.points, len(rows))
            eyes = {"blue": 0, "0": 0, "green": 1, "1": 1}
            expected = sorted((int(row["line"]), int(row["pixel"]), eyes[row["eye"]], float(row["x"]), float(row["y"]),
                               float(row["z"])) for row in rows)
            got = sorted((n, p, bits & 1, *xyz) for n, p, bits, xyz in
                         zip(cloud.line_numbers(), cloud.pixels(), cloud.bits(), cloud.xyz()))
            for a, e in zip(got, expected):
                self.assertEqual(a[:3], e[:3])
                for i in (3, 4, 5):
                    self.assertAlmostEqual(a[i], e[i], delta=0.0011)
            r = run("lumdump", self.source, "-o", table, "--edge", "both", "--return", "strongest",
                    "--frames", f"{number}:{number}", *options)
            self.assertEqual(r.returncode, 0, r.stderr)
            keys = zip(cloud.strongest(), cloud.line_numbers(), cloud.pixels(), cloud.bits(), cloud.return_numbers())
            self.assertEqual(sorted((n, p, bits & 3, turn) for strongest, n, p, bits, turn in keys if strongest),
                             sorted((int(row["line"]), int(row["pixel"]), eyes[row["eye"]] | int(row["edge"]) << 1,
                                     int(row["return_number"])) for row in read_csv(table)))

    def test_a_capture_plays_to_its_end_and_begins_anew_if_asked(self):
        self.serve("--speed", "10")
        b = self.browser()
        end = b.status(lambda s: s["state"] == "ended")
        self.assertEqual(end["frame"], end["last_frame"])
        b.say("loop on")
        b.say("play")
        b.cloud(lambda c: c.frame == end["first_frame"])
        b.status(lambda s: s["state"] == "playing" and s["loop"])


class Configuration(Case):
    """A calibration and a profile on standard input, which can be read only once."""

    tool = BIN / "lumview"

    def test_a_calibration_on_standard_input_is_used(self):
        self.source = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64")
        calibration = self.folder.write("c.yaml", "version: 1\neyes: {blue: {mount: {x_m: 10.0, yaw_deg: 12.5}}}\n")
        told = []
        for name, stdin in ((calibration, os.devnull), ("-", calibration)):
            self.serve("--calibration", name, stdin=stdin)
            told.append(self.browser().text("hello")["eyes"])
        self.assertEqual(*told)
        self.assertIn("10", json.dumps(told[1]))

    def test_a_profile_on_standard_input_is_used(self):
        profile = self.folder.write("p.yaml", "version: 1\ndata_packet_type: 9\n")
        self.source = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64", "--profile", profile)
        self.serve("--profile", "-", stdin=profile)
        end = self.browser().status(lambda s: s["state"] == "ended")
        self.assertEqual((end["message"], end["frame"]), ("", end["last_frame"]))


class Beside(Case):
    """Two profiles side by side: the second's points follow the first's in each frame."""

    tool = BIN / "lumview"
    swapped = "version: 1\neye_values: {blue: 1, green: 0}\n"

    def setUp(self):
        super().setUp()
        self.source = simulate(self.folder / "s.pcap", "--frames", "8", "--lines", "64")
        self.one = self.folder.write("one.yaml", "version: 1\n")
        self.other = self.folder.write("other.yaml", self.swapped)

    def rows(self, number, profile):
        table = self.folder / "points.csv"
        r = run("lumdump", self.source, "--profile", profile, "--frames", f"{number}:{number}", "-o", table)
        self.assertEqual(r.returncode, 0, r.stderr)
        return sorted((int(row["line"]), int(row["pixel"]), int(row["eye"]), float(row["x"]), float(row["y"]), float(row["z"]))
                      for row in read_csv(table))

    def assert_points(self, cloud, first, last, rows):
        got = sorted(list(zip(cloud.line_numbers(), cloud.pixels(), (bits & 1 for bits in cloud.bits()), *zip(*cloud.xyz())))[first:last])
        self.assertEqual([g[:3] for g in got], [r[:3] for r in rows])
        self.assertLess(max(abs(a - b) for g, r in zip(got, rows) for a, b in zip(g[3:], r[3:])), 0.0011)

    def assert_both(self, b, *numbers):
        """Each of these frames has the points by both profiles. A browser that counts points does not answer meanwhile."""
        b.status(lambda s: s["first_frame"] is not None)
        clouds = {}
        for number in numbers:
            clouds[number] = b.cloud_of(number)
        for number, cloud in clouds.items():
            split = cloud.points - cloud.second
            self.assert_points(cloud, 0, split, self.rows(number, self.one))
            self.assert_points(cloud, split, cloud.points, self.rows(number, self.other))

    def test_each_frame_has_the_points_of_both_also_after_jumps(self):
        self.serve("--paused", "--profile", self.one, "--profile", self.other)
        b = self.browser()
        profiles = b.text("hello")["profiles"]
        self.assertEqual((profiles["one"], profiles["other"]), (str(self.one), str(self.other)))
        self.assertEqual(profiles["differences"], [{"key": "eye_values.blue", "one": "0", "other": "1"},
                                                   {"key": "eye_values.green", "one": "1", "other": "0"}])
        self.assert_both(b, 1, 2, 8, 3)

    def test_frames_that_end_together_are_each_beside_its_own(self):
        """The last frame has begun and has too few lines to end the one before: the end of the capture ends both."""
        at = packets = 0
        data = self.source.read_bytes()
        wanted = 3 * summary(self.source)["data"] // 8 + 60
        for packets, record in enumerate(frames_of(data)):
            at += 16 + len(record)
            if packets == wanted:
                break
        self.source = self.folder.write("cut.pcap", data[:24 + at])
        self.assertEqual(summary(self.source)["frames"], 4)
        self.serve("--paused", "--profile", self.one, "--profile", self.other)
        self.assert_both(self.browser(), 3, 4)

    def test_what_came_long_before_is_not_shown_as_if_it_were_new(self):
        """Packets by the second profile come during the first two of eight frames alone."""
        data = self.source.read_bytes()
        records, at = [], 24
        for record in frames_of(data):
            records.append((data[at:at + 16], record))
            at += 16 + len(record)
        out = [data[:24]]
        for i, (head, record) in enumerate(records):
            out += ([head, record[:50] + b"\x09" + record[51:]] if i < len(records) // 4 else []) + [head, record]
        self.source = self.folder.write("c.pcap", b"".join(out))
        late = self.folder.write("late.yaml", "version: 1\ndata_packet_type: 9\n")
        self.serve("--paused", "--profile", self.one, "--profile", late)
        b = self.browser()
        b.status(lambda s: s["first_frame"] is not None)
        for number, is_there in ((1, True), (2, True), (3, True), (4, False), (7, False), (1, True)):
            self.assertEqual(b.cloud_of(number).second > 0, is_there, number)

    def test_the_first_tells_the_time_and_the_second_may_have_none(self):
        wrong = self.folder.write("wrong.yaml", "version: 1\ndata_packet_type: 9\n")
        self.serve("--paused", "--profile", self.one, "--profile", wrong)
        cloud = self.browser().cloud(lambda c: c.frame == 1)
        self.assertEqual((cloud.second, cloud.points), (0, len(self.rows(1, self.one))))

    def test_one_profile_has_no_second(self):
        self.serve("--paused", "--profile", self.one)
        b = self.browser()
        self.assertIsNone(b.text("hello")["profiles"])
        self.assertEqual(b.cloud(lambda c: c.frame == 1).second, 0)

    def test_keys_that_are_set_are_of_both(self):
        self.serve("--paused", "--profile", self.one, "--profile", self.other, "--set", "line_span_us=3000", "--set", "eye_values.blue=7")
        self.assertEqual([d["key"] for d in self.browser().text("hello")["profiles"]["differences"]], ["eye_values.green"])

    def test_what_cannot_be_is_refused(self):
        bad = self.folder.write("bad.yaml", "nonsense: 1\n")
        for arguments, message in (
                (["--profile", self.one, "--profile", self.other, "--profile", self.one], "at most two profiles can be shown side by side"),
                (["--profile", self.one, "--profile", bad], "bad.yaml"),
                (["--profile", self.one, "--profile", self.other, "--set", "eye_values.green=1"], "eye_values"),
                (["--profile", "-", "--profile", "-"], "standard input can be read only once"),
                (["--profile", "-", "--poses", "-"], "standard input can be read only once: --profile and --poses both name it"),
                (["--profile", self.one, "--profile", ""], "--profile")):
            r = run("lumview", "--no-open", *arguments, self.source)
            self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
            self.assertIn(message, r.stderr)


class Layout(Case):
    """Where packets do not decode, the page has the command that finds their layout."""

    tool = BIN / "lumview"

    def told(self, *arguments):
        self.serve(*arguments)
        return self.browser().status(lambda s: s["state"] == "ended")["message"]

    def test_joined_datagrams_are_packets_of_the_layout(self):
        self.source = simulate(self.folder / "s.pcap", "--frames", "2", "--joined")
        found = summary(self.source)
        self.serve()
        end = self.browser().status(lambda s: s["state"] == "ended")
        self.assertEqual([end[key] for key in ("packets", "packets_joined", "points", "message")],
                         [found["data"], found["joined"], found["points"], ""])
        self.assertGreater(found["joined"], found["data"] // 2)

    def test_the_command_is_told_where_nothing_decodes(self):
        profile = self.folder.write("p.yaml", "version: 1\ndata_packet_type: 9\n")
        self.source = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64", "--profile", profile)
        self.assertRegex(self.told(), rf"(\d+) of \1 packets that may be data do not fit the layout: lumdump {self.source} "
                                      r"--infer -o profile\.yaml finds the layout")
        self.assertEqual(self.told("--profile", profile), "")

    def test_it_is_told_where_something_decodes(self):
        """By this profile other bytes are the number of samples: some packets have room for so many."""
        self.source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64")
        profile = self.folder.write("p.yaml", "version: 1\ngroup: {num_samples: 18, first_sample_index: 16}\n")
        self.assertIn("--infer", self.told("--profile", profile))

    def test_a_bad_network_is_no_other_layout(self):
        self.source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64", "--corrupt", "0.02", "--loss", "0.05")
        self.assertNotIn("--infer", self.told())


class Several(Case):
    """Captures that are named together are one stream."""

    tool = BIN / "lumview"

    def setUp(self):
        super().setUp()
        self.whole = simulate(self.folder / "whole.pcap", "--frames", "4", "--lines", "64", "--seed", "1")
        self.header, self.records = split(self.whole.read_bytes())

    def part(self, name, records):
        return self.folder.write(name, self.header + b"".join(records))

    def rotated(self, count):
        cuts = [len(self.records) * i // count for i in range(count + 1)]
        return [self.part(f"r-{i + 1}.pcap", self.records[cuts[i]:cuts[i + 1]]) for i in range(count)]

    def two(self, seconds):
        """Halves of the recording, so far apart."""
        half = len(self.records) // 2
        return self.part("a.pcap", self.records[:half]), self.part("b.pcap", [later(r, seconds) for r in self.records[half:]])

    def fifo(self, path):
        """A pipe, by name, that gives what the file has."""
        name = self.folder / f"{path.name}.fifo"
        os.mkfifo(name)
        feeder = Process(self, self.folder, "sh", "-c", f"exec cat {path} > {name}", name="feeder")
        self.addCleanup(feeder.end)
        return name

    def watch(self, *sources):
        self.serve("--paused", sources=sources)
        return self.browser()

    def clouds(self, *sources):
        """All frames: number, points and the time of their begin."""
        b = self.watch(*sources)
        status = b.status(lambda s: s["first_frame"] is not None)
        for number in range(status["first_frame"], status["last_frame"] + 1):
            cloud = b.cloud_of(number)
            yield number, cloud.points, cloud.clock, cloud.utc, cloud.utc_error, cloud.content

    def test_rotated_files_give_every_point_of_the_whole(self):
        whole = list(self.clouds(self.whole))
        self.assertEqual(len(whole), 4)
        self.assertGreater(min(points for _, points, *_ in whole), 1000)
        self.assertTrue(list(self.clouds(*self.rotated(3)[::-1])) == whole, "other points, or other times")

    def test_those_before_the_shown_frame_are_sent_to_who_asks(self):
        whole = {number: data for number, *_, data in self.clouds(self.whole)}
        b = self.watch(self.whole)
        b.say("frames 3")
        for last in (4, 3):
            shown = b.cloud_of(last).shown
            b.say(f"past {last} 7")  # the frame three before is not one of three at once
            for number in (last - 1, last - 2):
                past = b.cloud(lambda c: c.shown < shown)
                self.assertEqual((past.frame, past.content), (number, whole[number]))

    def test_they_have_a_name_together(self):
        parts = self.rotated(3)
        self.assertEqual(self.watch(*parts).text("hello")["source"], f"{parts[0]} and 2 more")

    def test_a_gap_between_files_is_told_before_they_are_played(self):
        a, b = self.two(12)
        told = self.watch(a, b).status(lambda s: s["message"])
        self.assertRegex(told["message"], rf"^12\.\d{{3}} seconds without a capture before {re.escape(str(b))}$")

    def test_what_follows_without_a_gap_is_told_nothing(self):
        self.assertEqual(self.watch(*self.rotated(3)).status(lambda s: s["last_frame"] is not None)["message"], "")

    def warned(self, last):
        """What it has said of the captures, on standard error; last: what the last of it has."""
        wait_until(lambda: last in self.server.stderr(), what=f"a warning of {last}")
        self.is_clean()
        return "\n".join(self.warnings)

    def test_captures_that_overlap_are_told(self):
        a, b = self.whole, simulate(self.folder / "other.pcap", "--frames", "4", "--lines", "64", "--seed", "2")
        later = "packets contradict others"  # is known when they are played, the overlap before
        told = self.watch(a, b).status(lambda s: later in s["message"])["message"]
        overlap = (r"0\.\d{3} seconds by which \S+\.pcap begins before the end of those before it: where both have "
                   r"packets of the shown sensor, its frames have points of both")
        self.assertRegex(told, overlap)
        self.assertRegex(self.warned(later), rf"(?m)^lumview: warning: {overlap}$[^$]*\nlumview: warning: .*{later}")
        self.assertRegex(run("lumdump", a, b).stdout, r" 0\.\d{3}  seconds by which")

    def test_a_gap_before_a_pipe_is_told_by_its_name(self):
        a, b = self.two(12)
        name = self.fifo(b)
        self.serve(sources=[a, name])
        end = self.browser().status(lambda s: s["state"] == "ended")
        self.assertRegex(end["message"], rf"^12\.\d{{3}} seconds without a capture before {re.escape(str(name))}$")
        self.assertEqual((end["first_frame"], end["frame"]), (None, summary(a, b)["sensors"][0]["frames"]))

    def test_one_that_breaks_off_ends_alone_and_is_named(self):
        parts = self.rotated(4)
        parts[1].write_bytes(parts[1].read_bytes()[:-10])
        self.serve("--speed", "100", sources=parts)
        end = self.browser().status(lambda s: s["state"] == "ended")
        self.assertRegex(end["message"], rf"^{re.escape(str(parts[1]))}: cannot be read beyond record \d+")
        self.assertEqual(end["packets"], len(self.records) - 1)

    def test_what_is_to_be_said_is_said_together(self):
        a, b = self.two(12)
        a.write_bytes(a.read_bytes()[:-10])
        self.serve("--speed", "100", sources=[a, b])
        end = self.browser().status(lambda s: s["state"] == "ended" and "without" in s["message"])
        self.assertRegex(end["message"], r"a\.pcap: cannot be read beyond .*; 12\.\d{3} seconds without a capture before .*b\.pcap$")

    def test_a_pipe_that_is_no_capture_is_told_by_its_name(self):
        name = self.fifo(self.folder.write("notes.txt", "not a capture, but long enough to be looked at"))
        self.serve(sources=[self.whole, name])
        failed = self.browser().status(lambda s: s["state"] == "failed")
        self.assertTrue(failed["message"].startswith(f"{name}: not a capture"), failed["message"])


class Others(Case):
    """Captures with a calibration of their own that is not used: the page tells."""

    tool = BIN / "lumview"

    def part(self, name, number, *comments):
        return self.folder.write(name, section(*comments) + packets([number]))

    def told(self, *sources, stdin=os.devnull, mount=None):
        """What the page says at the end. mount: of the blue eye, along x."""
        self.serve(sources=sources, stdin=stdin)
        b = self.browser()
        x = b.text("hello")["eyes"][0]["mount"][0]
        if mount is not None:
            self.assertEqual(x, mount)
        return b.status(lambda s: s["state"] == "ended")["message"]

    def of_stream(self, what="calibration", name="standard input"):
        return (f"{name}: it has a {what} of its own, which is not used: save it as a file and show that, or name its {what} by "
                f"--{what}")

    def test_a_streams_own_is_told(self):
        for comment, what in (mounted(7), "calibration"), (b"# lumsdk profile 1\nversion: 1\n", "profile"):
            path = self.part("s.pcapng", 0, comment)
            self.assertEqual(self.told("-", stdin=path), self.of_stream(what))
            option = self.folder.write("o.yaml", "version: 1\n")
            self.assertEqual(self.told(f"--{what}", option, "-", stdin=path), "")

    def test_a_stream_with_none_is_told_nothing(self):
        for comments in ([], [b"a drive in rain"], [b"# lumsdk origin 1\nsource: \"x\"\n"]):
            self.assertEqual(self.told("-", stdin=self.part("s.pcapng", 0, *comments)), "")

    def test_a_later_part_of_a_stream_too(self):
        path = self.part("s.pcapng", 0)
        path.write_bytes(path.read_bytes() + section(mounted(7)) + packets([1]))
        self.assertEqual(self.told("-", stdin=path), self.of_stream())

    def test_a_pipe_is_told_by_its_name(self):
        name = self.folder / "p.fifo"
        os.mkfifo(name)
        feeder = Process(self, self.folder, "sh", "-c", f"exec cat {self.part('s.pcapng', 0, mounted(7))} > {name}", name="feeder")
        self.addCleanup(feeder.end)
        self.assertEqual(self.told(name), self.of_stream(name=name))

    def test_a_pipe_that_is_gone_before_anybody_writes_keeps_nobody_waiting(self):
        name = self.folder / "p.fifo"
        os.mkfifo(name)
        self.serve(sources=[name])
        self.browser()
        wait_until(lambda: any(os.readlink(fd) == str(name) for fd in pathlib.Path(f"/proc/{self.server.p.pid}/fd").iterdir()),
                   what="the pipe to be open")
        name.unlink()
        self.assertEqual(self.server.end(), 0)

    def test_a_file_beside_a_stream_keeps_its_own(self):
        file = self.part("f.pcapng", 0, mounted(7))
        for stream, message in ((self.part("same.pcapng", 1, mounted(7)), ""), (self.part("none.pcapng", 1), ""),
                                (self.part("other.pcapng", 1, mounted(8)), self.of_stream())):
            for sources in ([file, "-"], ["-", file]):
                self.assertEqual(self.told(*sources, stdin=stream, mount=7), message)

    def test_a_file_that_has_none_does_not_take_a_streams(self):
        self.assertEqual(self.told(self.part("f.pcapng", 0), "-", stdin=self.part("s.pcapng", 1, mounted(7))), self.of_stream())

    def test_a_later_part_of_a_file_is_told_before_it_is_played(self):
        path = self.part("f.pcapng", 0, mounted(7))
        same = path.read_bytes() * 2
        path.write_bytes(path.read_bytes() + section(mounted(8)) + packets([1]))
        message = (f"{path}: a later part of it has another calibration or profile: those at its start are used for all")
        self.serve("--paused", sources=[path])
        self.assertEqual(self.browser().status(lambda s: s["message"])["message"], message)
        self.assertEqual(self.told(path, mount=7), message)
        path.write_bytes(same)
        self.assertEqual(self.told(path, mount=7), "")

    def test_of_several_files_it_is_told_whose_is_used(self):
        parts = [self.part(f"p-{i}.pcapng", i, mounted(7)) for i in range(2)]
        self.assertEqual(self.told(*parts, mount=7), "")
        parts[1].write_bytes(parts[1].read_bytes() + section(mounted(8)) + packets([2]))
        self.assertEqual(self.told(*parts, mount=7), f"{parts[1]}: its calibration or its profile is not that of {parts[0]}, "
                                                     "which is used for all")


class Times(Case):
    """Stamps in batches of 8 ms, and a clock that is off by 50 ppm: the sensor's clock tells the truth."""

    tool = BIN / "lumview"
    UNKNOWN, ARRIVAL, FITTED = range(3)
    EPOCH = 1767225600

    def setUp(self):
        super().setUp()
        self.source = simulate(self.folder / "batched.pcap", "--frames", "5", "--lines", "64", "--batch", "8", "--drift", "50")

    def clouds(self, *arguments):
        self.serve("--paused", *arguments)
        b = self.browser()
        status = b.status(lambda s: s["first_frame"] is not None)
        for number in range(status["first_frame"], status["last_frame"] + 1):
            yield b.cloud_of(number)

    def test_a_frame_began_when_the_sensors_clock_says(self):
        clouds = list(self.clouds())
        self.assertEqual([c.time_kind for c in clouds], [self.FITTED] * len(clouds))
        off = [c.utc - self.EPOCH - c.clock * 1.00005e-6 for c in clouds]
        delay = 1e-4  # of each line's first packet; nobody can see that
        self.assertTrue(-5e-5 < min(off) <= max(off) < delay + 5e-5, off)
        self.assertTrue(all(5e-6 < c.utc_error < 4e-3 for c in clouds), [c.utc_error for c in clouds])
        arrivals = self.arrivals()
        self.assertGreater(max(arrivals[c.frame] - c.utc for c in clouds), 1e-3)

    def arrivals(self):
        """When the first point of each frame came, by lumdump."""
        table = self.folder / "arrival.csv"
        r = run("lumdump", self.source, "-o", table, "--time", "arrival", "-q")
        self.assertEqual(r.returncode, 0, r.stderr)
        first = {}
        for row in read_csv(table):
            at = int(row["timestamp"]) * 1e-6
            first[int(row["frame"])] = min(at, first.get(int(row["frame"]), at))
        return first

    def test_without_a_clock_it_is_the_arrival(self):
        profile = self.folder.write("no_clock.yaml", "version: 1\ngroup: {timestamp: none}\n")
        clouds = list(self.clouds("--profile", profile))
        self.assertEqual({(c.time_kind, c.utc_error) for c in clouds}, {(self.ARRIVAL, 0.0)})
        self.assertAlmostEqual(clouds[0].utc, min(self.arrivals().values()), delta=1e-5)

    def test_without_any_time_it_is_unknown(self):
        header, records = split(self.source.read_bytes())
        self.source = self.folder.write("timeless.pcap", header + b"".join(struct.pack("<II", 0, 0) + r[8:] for r in records))
        self.assertEqual({(c.time_kind, c.utc, c.utc_error) for c in self.clouds()}, {(self.UNKNOWN, 0.0, 0.0)})


class Live(Case):
    """A simulated sensor."""

    tool = BIN / "lumview"

    def setUp(self):
        super().setUp()
        self.sensor = next(ADDRESSES)
        self.source = f"udp://{self.sensor}"
        self.log = self.folder / "sim.log"
        self.simulator = self.simulate()

    def simulate(self):
        out = Process(self, self.folder, BIN / "lumsim", "--address", self.sensor, "--log", self.log, "--quiet",
                      "--frames", "2")
        wait_until(lambda: self.events("frames"), what="lumsim's start")
        return out

    def events(self, kind):
        try:
            lines = self.log.read_text().split("\n")[:-1]
        except FileNotFoundError:
            return []
        return [e for e in map(json.loads, lines) if e["event"] == kind]

    def laser(self):
        return [e["up"] for e in self.events("laser")]

    def test_the_laser_is_on_while_it_is_looked_at(self):
        self.serve("--laser")
        b = self.browser()
        status = b.status(lambda s: s["laser"] is not None and s["laser"]["up"] and s["points"] > 0)
        self.assertTrue(status["live"])
        self.assertGreater(b.cloud().points, 1000)
        for command in ("pause", "step 1", "seek 1", "speed 2", "loop on"):
            b.say(command)
        self.assertEqual(b.status()["state"], "playing", "a sensor cannot be paused")
        self.assertEqual(self.server.end(signal.SIGINT), 0, self.server.stderr())
        self.assertEqual(self.laser()[-1], False)
        self.assertIn(True, self.laser())

    def test_without_the_option_the_laser_is_left_alone(self):
        self.serve()
        b = self.browser()
        b.text("hello")
        for _ in range(3):
            b.status()
        wait_until(lambda: self.events("tlv"), "a request")
        self.assertEqual(self.server.end(), 0)
        self.assertEqual({e["note"] for e in self.events("tlv")}, {"status poll"})

    def test_a_sensor_that_falls_silent_is_told_and_comes_back(self):
        self.serve("--laser")
        b = self.browser()
        b.cloud()
        self.simulator.end(signal.SIGKILL)
        status = b.status(lambda s: s["state"] == "silent")
        self.assertNotEqual(status["message"], "")
        self.log.unlink()
        self.simulator = self.simulate()
        b.status(lambda s: s["state"] == "playing")
        self.server.send(signal.SIGINT)
        self.server.wait()

    def test_where_nothing_decodes_the_commands_that_find_the_layout_are_told(self):
        self.serve("--profile", self.folder.write("p.yaml", "version: 1\ndata_packet_type: 9\n"))
        b = self.browser()
        b.status(lambda s: "none of them fits the layout" in s["message"] and
                 f"end lumview, then record it by lumdump udp://{self.sensor} --laser --duration 3 -o look.pcap; "
                 "lumdump look.pcap --infer -o profile.yaml finds the layout" in s["message"])

    def test_a_sensor_that_is_moved_is_named_with_its_new_address(self):
        self.serve()
        b = self.browser()
        b.cloud()
        new = next(ADDRESSES)
        self.assertEqual(run("lumctl", "--host", self.sensor, "set-ip", new).returncode, 0)
        status = b.status(lambda s: new in s["message"])
        self.assertIn(f"the data comes from {new} now, not from {self.sensor}", status["message"])
        self.assertEqual(self.server.end(), 0)

    def test_laser_off_that_a_moved_sensor_does_not_answer_is_advised_at_its_new_address(self):
        self.serve("--laser")
        b = self.browser()
        b.cloud()
        new = next(ADDRESSES)
        self.assertEqual(run("lumctl", "--host", self.sensor, "set-ip", new).returncode, 0)
        b.status(lambda s: new in s["message"])
        self.server.send(signal.SIGINT)
        wait_until(lambda: "laser off is repeated for" in self.server.stderr(), "the time in which nothing ends it")
        self.server.send(signal.SIGINT)
        self.server.wait()
        self.assertIn(f"{self.sensor}: laser off was not answered", self.server.stderr())
        self.assertIn(f"make sure by lumctl --host {new} laser off", self.server.stderr())

    def is_clean(self):
        """Warnings of a session may stand there."""
        self.assertIn(self.server.end(), (0, 1))
        self.assertIn(f"lumview: {self.url} (Ctrl-C ends it)\n", self.server.stderr())


if __name__ == "__main__":
    shards.main()
