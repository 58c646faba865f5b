#!/usr/bin/env python3
"""What is packed is unpacked as it was; what is broken is refused by file and line; a merge by union may stay as it is."""
import base64
import hashlib
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import corpus  # noqa: E402
import make_corpus  # noqa: E402

INPUTS = [b"", b"\0", b"\n", b"\r\n" * 40, bytes(range(256)), bytes(100000), b"seed" * 9]


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.archive = self.folder / "some.txt"
        corpus.write(self.archive, INPUTS)

    def lines(self):
        return self.archive.read_bytes().split(b"\n")[:-1]

    def put(self, *lines):
        self.archive.write_bytes(b"".join(line + b"\n" for line in lines))

    def command(self, *words):
        r = subprocess.run([sys.executable, "-B", HERE / "corpus.py", *words], capture_output=True, text=True, cwd=self.folder)
        return r.returncode, r.stdout, r.stderr


class Format(InFolder):
    def test_a_line_is_an_input_in_order_and_once(self):
        self.assertEqual(len(self.lines()), len(INPUTS))
        self.assertEqual(self.lines(), sorted(self.lines()))
        before = self.archive.read_bytes()
        corpus.write(self.archive, [*reversed(INPUTS), *INPUTS])
        self.assertEqual(self.archive.read_bytes(), before)
        self.assertEqual(set(corpus.read(self.archive)), set(INPUTS))

    def test_lines_may_be_unsorted_and_doubled(self):
        self.put(*reversed(self.lines()), *self.lines()[:3])
        self.assertEqual(set(corpus.read(self.archive)), set(INPUTS))
        corpus.write(self.archive, corpus.read(self.archive))
        self.assertEqual(self.lines(), sorted(map(corpus.encode, INPUTS)))

    def test_what_another_zlib_packed_keeps_its_line(self):
        stored = base64.b64encode(zlib.compress(b"seed" * 9, 0))
        self.put(stored)
        corpus.write(self.archive, INPUTS)
        self.assertEqual(set(self.lines()), {stored, *(corpus.encode(i) for i in INPUTS[:-1])})
        self.put(stored, corpus.encode(b"seed" * 9))
        corpus.write(self.archive, corpus.read(self.archive))
        self.assertEqual(self.lines(), [min(stored, corpus.encode(b"seed" * 9))])

    def test_what_is_broken_is_refused_by_its_line(self):
        good = self.lines()
        line = corpus.encode(b"seed" * 9)
        packed = base64.b64decode(line)
        for broken in (b"", b" ", b"!", line + b" ", line + b"\r", b" " + line, line[:-1], line[1:], line[:-4], line + line, line.lower(),
                       base64.b64encode(packed[:-1]), base64.b64encode(packed + b"\0"), base64.b64encode(b"seed"), b"<<<<<<< ours",
                       base64.b64encode(zlib.compress(b"one") + zlib.compress(b"two")), "zwölf".encode()):
            with self.subTest(broken):
                self.put(*good[:4], broken, *good[4:])
                with self.assertRaisesRegex(corpus.Broken, f"^{self.archive}:5: ."):
                    corpus.read(self.archive)

    def test_a_changed_character_makes_no_other_input(self):
        refused = 0
        for data in b"", b"\0", b"ab", b"seed" * 9:
            line = corpus.encode(data)
            for at in range(len(line)):
                for other in b"AQgw+9=":
                    try:
                        self.assertEqual(corpus.decode(line[:at] + bytes([other]) + line[at + 1:]), data)  # bits that mean nothing
                    except ValueError:
                        refused += 1
        self.assertGreater(refused, 300)

    def test_a_file_that_was_cut_off_is_refused(self):
        text = self.archive.read_bytes()
        for cut, line in ((text[:-1], len(INPUTS)), (text[:-9], len(INPUTS)), (b"", 1)):
            self.archive.write_bytes(cut)
            with self.assertRaisesRegex(corpus.Broken, f":{line}: "):
                corpus.read(self.archive)

    def test_what_is_broken_is_not_written_over(self):
        self.put(*self.lines(), b"broken")
        before = self.archive.read_bytes()
        with self.assertRaises(corpus.Broken):
            corpus.write(self.archive, INPUTS)
        self.assertEqual(self.archive.read_bytes(), before)

    def test_an_archive_is_never_empty(self):
        before = self.archive.read_bytes()
        with self.assertRaises(corpus.Broken):
            corpus.write(self.archive, [])
        self.assertEqual(self.archive.read_bytes(), before)

    def test_a_write_that_ends_in_the_middle_leaves_what_was_there(self):
        before = self.archive.read_bytes()
        (self.folder / "new").mkdir()
        (self.folder / "new" / "large").write_bytes(b"".join(hashlib.sha1(bytes([i])).digest() for i in range(200)))
        r = subprocess.run([sys.executable, "-B", HERE / "corpus.py", "pack", "some.txt", "new"], cwd=self.folder, capture_output=True,
                           text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
        self.assertEqual(r.returncode, 1)
        self.assertIn("too large", r.stderr)
        self.assertEqual(self.archive.read_bytes(), before)
        self.assertEqual(sorted(os.listdir(self.folder)), ["new", "some.txt"])


class Unpacked(InFolder):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def content(self):
        return sorted(file.read_bytes() for file in self.out.iterdir())

    def test_a_round_trip_is_bit_for_bit(self):
        corpus.unpack(self.archive, self.out)
        self.assertEqual(self.content(), sorted(INPUTS))
        for file in self.out.iterdir():
            self.assertEqual(file.name, hashlib.sha1(file.read_bytes()).hexdigest())
        again = self.folder / "again.txt"
        corpus.write(again, corpus.files_of(self.out))
        self.assertEqual(again.read_bytes(), self.archive.read_bytes())

    def test_only_another_archive_is_unpacked_anew(self):
        corpus.unpack(self.archive, self.out)
        first = {file: file.stat().st_mtime_ns for file in self.out.iterdir()}
        os.utime(self.archive)
        corpus.unpack(self.archive, self.out)
        self.assertEqual({file: file.stat().st_mtime_ns for file in self.out.iterdir()}, first)
        mark = self.folder / "out.unpacked"
        self.assertGreaterEqual(mark.stat().st_mtime_ns, self.archive.stat().st_mtime_ns)  # or it would be made in each build
        (self.out / "README").write_text("not an input of the archive's")
        corpus.write(self.archive, [b"\0", b"other"])
        corpus.unpack(self.archive, self.out)
        self.assertEqual(self.content(), sorted([b"\0", b"other", b"not an input of the archive's"]))
        shutil.rmtree(self.out)
        corpus.unpack(self.archive, self.out)
        self.assertEqual(self.content(), [b"\0", b"other"])

    def test_a_broken_archive_leaves_the_folder_and_is_not_remembered(self):
        corpus.unpack(self.archive, self.out)
        self.put(b"broken")
        for _ in range(2):
            with self.assertRaises(corpus.Broken):
                corpus.unpack(self.archive, self.out)
        self.assertEqual(self.content(), sorted(INPUTS))

    def test_a_folder_beside_its_archive_leaves_that(self):
        before = self.archive.read_bytes()
        corpus.unpack(self.archive, self.folder / "some")
        self.assertEqual(self.archive.read_bytes(), before)

    def test_commands(self):
        self.assertEqual(self.command("unpack", "some.txt", "deep/out"), (0, "", ""))
        self.assertEqual(self.command("pack", "other.txt", "deep/out"), (0, "", ""))
        self.assertEqual(self.command("check", "some.txt", "other.txt"),
                         (0, f"some.txt: {len(INPUTS)} inputs\nother.txt: {len(INPUTS)} inputs\n", ""))
        self.put(*self.lines(), b"broken")
        for words in ("check", "other.txt", "some.txt"), ("unpack", "some.txt", "deep/out"), ("pack", "some.txt", "deep/out"):
            status, _, stderr = self.command(*words)
            self.assertEqual(status, 1)
            self.assertIn(f"some.txt:{len(INPUTS) + 1}: ", stderr)
        for words in (), ("check",), ("pack", "some.txt"), ("unpack", "some.txt"), ("unpack", "none.txt", "out"), ("pack", "new.txt", "none"):
            self.assertEqual(self.command(*words)[0], 1)
        self.assertFalse((self.folder / "new.txt").exists())


class Archives(unittest.TestCase):
    def test_every_archive_is_whole_and_of_a_fuzzer(self):
        archives = sorted((HERE / "corpus").iterdir())
        self.assertGreaterEqual(len(archives), 11)
        for file in archives:
            corpus.read(file)
            self.assertTrue((HERE / f"fuzz_{file.stem}.c").exists(), f"{file} is of no fuzzer")

    def test_every_seed_is_in_its_archive(self):
        for name, make in make_corpus.SEEDS.items():
            if name != "index":  # lumsdk makes those
                inputs = corpus.read(HERE / "corpus" / f"{name}.txt")
                missing = [seed for seed, content in make().items() if content not in inputs]
                self.assertEqual(missing, [], f"{name}: tests/fuzz/make_corpus.py adds them")


if __name__ == "__main__":
    unittest.main()
