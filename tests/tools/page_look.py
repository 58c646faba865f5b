#!/usr/bin/env python3
"""page_look.py: lumview's page in Chromium, as a person first sees it: it opens, shows every point that lumdump counts, draws
them, and complains of nothing. Chromium is driven by its own protocol, so nothing else is needed. What the page can do, and
each pixel, is in tests/view. Status 77 where there is no Chromium."""
import json
import os
import shutil
import sys
import time
import unittest
import urllib.request

import websocket
from live import Process, tool, wait_until
from support import PATIENCE_S, Folder, simulate, summary

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
# Drawn in software, and without the services that ask the network.
ARGUMENTS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--disable-quic", "--remote-debugging-port=0", "--remote-allow-origins=*", "--window-size=640,400", "about:blank")


class Page(websocket.Browser):
    """A page of Chromium's."""

    def __init__(self, port, path):
        websocket.Connection.__init__(self, "127.0.0.1", port)
        self.send(websocket.upgrade(f"127.0.0.1:{port}", path=path, protocol=None))
        status, _, _ = self.answer(has_body=False)
        assert status == 101, status
        self.calls, self.complaints = 0, []

    def message(self):
        """The next JSON; what the page complains of is kept."""
        parts = []
        final = False
        while not final:
            final, _, payload = self.frame()
            parts.append(payload)
        said = json.loads(b"".join(parts))
        if said.get("method") == "Runtime.exceptionThrown" or \
                said.get("method") == "Runtime.consoleAPICalled" and said["params"]["type"] == "error":
            self.complaints.append(json.dumps(said["params"]))
        return said

    def call(self, method, **arguments):
        """Its result, or None where the page was left meanwhile."""
        self.calls += 1
        self.say(json.dumps({"id": self.calls, "method": method, "params": arguments}))
        while True:
            said = self.message()
            if said.get("id") == self.calls:
                return said.get("result")

    def value(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True) or {}
        return result.get("result", {}).get("value")


class Look(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.capture = self.folder / "street.pcap"
        simulate(self.capture, "--frames", "2", "--lines", "64", "--seed", "5")

    def open(self):
        server = tool(self, self.folder, "lumview", "--no-open", "--json", "--paused", self.capture)
        place = json.loads(wait_until(lambda: server.stdout() if server.stdout().endswith("\n") else "", what="lumview's JSON"))
        profile = self.folder / "profile"
        browser = Process(self, self.folder, CHROMIUM, f"--user-data-dir={profile}", *ARGUMENTS, name="chromium")
        told = profile / "DevToolsActivePort"
        port = int(wait_until(lambda: told.read_text().split("\n")[0] if told.is_file() else "", what="Chromium's port"))
        self.addCleanup(browser.end)
        pages = wait_until(lambda: [p for p in json.load(urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list"))
                                    if p["type"] == "page"], what="a page")
        page = Page(port, pages[0]["webSocketDebuggerUrl"].split(str(port), 1)[1])
        self.addCleanup(page.close)
        page.call("Runtime.enable")
        page.call("Page.navigate", url=place["url"])
        return page

    def wait_for(self, page, what, why):
        end = time.monotonic() + PATIENCE_S
        while not page.value(what):
            self.assertLess(time.monotonic(), end, f"{why}: {page.complaints}")
            time.sleep(0.1)

    def test_the_page_shows_every_point_and_complains_of_nothing(self):
        page = self.open()
        self.wait_for(page, "window.lumview?.share === 1 && window.lumview.pictures > 0", "no picture of a whole frame came")
        frame = page.value("window.lumview.frame")
        counted = summary(self.capture, "--frames", f"{frame}:{frame}")
        self.assertEqual(page.value("window.lumview.counts().rising"), counted["points"])
        # a slow machine draws fewer until the page has been at rest for a while
        self.wait_for(page, f"window.lumview.drawn === {counted['points']}", "not every point was drawn")
        self.assertEqual(page.complaints, [])


if __name__ == "__main__":
    if CHROMIUM is None:
        print("there is no Chromium (Debian: chromium)")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], "-v"])
