#!/usr/bin/env python3
"""Files above 2 GiB, which hosts of 32 bits reach only where they were compiled for it. The files are sparse."""
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

from support import BIN, PATIENCE_S, Folder, line, pcap, read_csv, run, simulate, summary, udp, word

LARGE = (1 << 31) + (1 << 24)
RECORD = 262144  # the longest of a pcap file


def sparse(path):
    """A file of LARGE bytes that takes none."""
    with open(path, "wb") as f:
        f.truncate(LARGE)
    return path


def holds_holes():
    with tempfile.TemporaryDirectory() as folder:
        return sparse(pathlib.Path(folder, "hole")).stat().st_blocks * 512 < LARGE // 2


def large_capture(path):
    """Records of zeros, and behind 2 GiB a line of a sensor; how many records."""
    data = pcap([udp(p) for p in line([word(2000, 1), word(3000, 2)])])
    with open(path, "wb") as f:
        f.write(data[:24])
        records = 0
        while f.tell() < LARGE:
            f.write(struct.pack("<IIII", 1_700_000_000, 0, RECORD, RECORD))
            f.seek(RECORD, os.SEEK_CUR)
            records += 1
        f.write(data[24:])
    return records + 4


@unittest.skipUnless(holds_holes(), "the folder of temporary files holds no sparse ones")
class LargeFiles(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def small(self):
        return self.folder.write("small.pcap", pcap([udp(p) for p in line([word(2000, 1)])]))

    def test_a_capture_is_read_to_its_end(self):
        source = self.folder / "in.pcap"
        records = large_capture(source)
        got = summary(source)
        self.assertEqual((got["records"], got["points"], got["truncated"]), (records, 2, False))
        with open(source, "rb") as f:
            r = subprocess.run([BIN / "lumdump", "-", "-q", "-o", self.folder / "out.csv"], stdin=f, capture_output=True,
                               timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(len(read_csv(self.folder / "out.csv")), 2)

    def test_a_capture_is_not_written_over_by_what_is_made_of_it(self):
        source = sparse(self.folder / "in.pcap")
        with open(source, "r+b") as f:
            f.write(pcap([]))
        source.with_name("link.pcap").symlink_to(source)
        for output in "in.pcap", "link.pcap", "./in.pcap":
            r = run("lumdump", source, "-o", f"{self.folder.path}/{output}")
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertEqual(source.stat().st_size, LARGE)

    def test_a_file_is_replaced(self):
        source = self.small()
        for name in "cloud.ply", "cloud.csv", "copy.pcap":
            output = sparse(self.folder / name)
            r = run("lumdump", source, "-o", output)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertTrue(100 < output.stat().st_size < 10000)
        output = sparse(self.folder / "behind.ply")
        (self.folder / "link.ply").symlink_to(output)
        r = run("lumdump", source, "-o", self.folder / "link.ply")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertTrue(100 < output.stat().st_size < 10000)
        simulate(sparse(self.folder / "sim.pcap"), "--frames", "1", "--lines", "64")
        self.assertLess((self.folder / "sim.pcap").stat().st_size, 1 << 30)

    def test_output_goes_on_behind_what_is_there(self):
        source = self.small()
        output = sparse(self.folder / "all.bin")
        for kind in "ply", "csv", "pcap":
            with open(output, "r+b") as f:
                f.seek(LARGE)
                r = subprocess.run([BIN / "lumdump", source, "-q", "-o", "-", "--format", kind], stdin=subprocess.DEVNULL,
                                   stdout=f, stderr=subprocess.PIPE, timeout=PATIENCE_S)
                self.assertEqual(r.returncode, 0, r.stderr)
            alone = run("lumdump", source, "-q", "-o", self.folder / f"alone.{kind}")
            self.assertEqual(alone.returncode, 0, alone.stderr)
            with open(output, "rb") as f:
                f.seek(LARGE)
                self.assertEqual(f.read(), (self.folder / f"alone.{kind}").read_bytes(), kind)
            os.truncate(output, LARGE)

    def test_a_configuration_is_refused_for_its_size(self):
        huge = sparse(self.folder / "huge.yaml")
        for arguments in (["lumdump", self.small(), "--calibration", huge], ["lumdump", self.small(), "--profile", huge],
                          ["lumsim", "-o", self.folder / "x.pcap", "--profile", huge], ["lumctl", "apply", huge]):
            r = run(*arguments)
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn("huge.yaml", r.stderr)
            self.assertNotIn("Value too large", r.stderr)


if __name__ == "__main__":
    unittest.main()
