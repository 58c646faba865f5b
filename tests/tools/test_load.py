#!/usr/bin/env python3
"""Three seconds of full load: whatever the machine can take, every datagram is received or counted as dropped."""
import unittest

import load
from support import BIN, Folder


class Load(unittest.TestCase):
    def test_every_datagram_is_received_or_counted(self):
        folder = Folder(self)
        r = load.run(BIN, folder.path, 3, 7.0, address="127.41.0.1")
        self.assertGreater(r["sent"], 1000)
        self.assertTrue(load.is_accounted_for(r), r)
        live = r["live"]
        # What came, less what the ring had no room for, was decoded.
        decoded = sum(live[k] for k in ("angle_packets", "range_packets", "tlv", "timestamp") if k in live)
        self.assertEqual(decoded, r["received"] - r["ring_drops"])
        recording = live["outputs"][0]
        self.assertEqual(recording["datagrams"], r["received"] - r["recording_drops"])
        self.assertEqual(recording["dropped"], r["recording_drops"])

    def test_what_cannot_be_counted_is_said_to_be_a_lower_bound(self):
        folder = Folder(self)
        r = load.run(BIN, folder.path, 1, 7.0, address="127.41.0.2", drops=True)
        self.assertGreater(r["kernel_drops"], 0)
        self.assertTrue(load.is_accounted_for(r), r)
        said = [text for text in r["stderr"].splitlines() if "the system dropped" in text]
        self.assertTrue(said)
        self.assertEqual("dropped at least" in said[-1], r["at_least"])


if __name__ == "__main__":
    unittest.main()
