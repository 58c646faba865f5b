#!/usr/bin/env python3
"""What changed is found, clang-tidy looks at it and at what includes it, and what it saw clean once it does not look at again,
in any clone. Each in a repository of its own."""
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "script"))
import changed  # noqa: E402
import tidy  # noqa: E402

CLEAN = "#include \"a.h\"\nint f(int x);\nint f(int x)\n{\n    return x + A;\n}\n"
FAULT = CLEAN.replace("return x + A;", "if (x) { return A; } else { return A; }")


class Repository:
    """Two sources and a header, of which only one includes it; the upstream is a branch of its own."""

    def __init__(self, test, name="one"):
        folder = tempfile.TemporaryDirectory()
        test.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name).resolve() / name
        (self.top / "build").mkdir(parents=True)
        self.git("init", "-q", "-b", "main")
        self.write(".gitignore", "/build/\n")
        self.write(".clang-tidy", "Checks: '-*,bugprone-branch-clone'\nWarningsAsErrors: '*'\n")
        self.write("a.h", "#define A 1\n")
        self.write("a.c", CLEAN)
        self.write("b.c", "int g(void);\nint g(void)\n{\n    return 0;\n}\n")
        self.commit()
        self.write("c.txt", "last\n")
        self.commit()
        entries = [{"directory": str(self.top), "file": str(self.top / f),
                    "command": f"clang -I{self.top} -o {f}.o -c {self.top / f}"} for f in ("a.c", "b.c")]
        (self.top / "build/compile_commands.json").write_text(json.dumps(entries))

    def git(self, *words):
        user = {"GIT_AUTHOR_NAME": "t", "GIT_AUTHOR_EMAIL": "t", "GIT_COMMITTER_NAME": "t", "GIT_COMMITTER_EMAIL": "t"}
        return subprocess.run(["git", "-C", self.top, *words], check=True, capture_output=True, text=True,
                              env={**os.environ, **user}).stdout.strip()

    def write(self, name, text):
        (self.top / name).write_text(text)

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "x")

    def follow_upstream(self):
        self.git("branch", "up")
        self.git("branch", "--set-upstream-to", "up")

    def look(self, everything=False):
        """Status, and the last line of what it said."""
        out = io.StringIO()
        paths = [self.top / f for f in ("a.c", "b.c")]
        status = tidy.look(self.top, self.top / "build", paths, "", [], everything, 1, out)
        self.said = out.getvalue()
        return status, self.said.splitlines()[-1].split(": ")[-1]


class Case(unittest.TestCase):
    def setUp(self):
        cache = tempfile.TemporaryDirectory()
        self.addCleanup(cache.cleanup)
        before = dict(os.environ)
        self.addCleanup(lambda: (os.environ.clear(), os.environ.update(before)))
        os.environ["LUM_CACHE"] = cache.name
        for name in [n for n in os.environ if n == "LUM_BASE" or n.startswith("GIT_")]:
            del os.environ[name]
        self.one = Repository(self)


class Changed(Case):
    def test_what_is_committed_changed_and_new_since_upstream(self):
        self.one.follow_upstream()
        self.one.write("a.c", FAULT)
        self.one.commit()
        self.one.write("a.h", "#define A 2\n")
        self.one.write("new.c", "\n")
        files, why = changed.changed(self.one.top)
        self.assertEqual(files, {"a.c", "a.h", "new.c"})
        self.assertIn("(up)", why)

    def test_a_fresh_clone_looks_at_its_last_commit_and_says_so(self):
        self.one.follow_upstream()
        files, why = changed.changed(self.one.top)
        self.assertEqual(files, {"c.txt"})
        self.assertIn("the commit before up", why)

    def test_without_upstream_it_is_all_and_says_so(self):
        files, why = changed.changed(self.one.top)
        self.assertIsNone(files)
        self.assertIn("all files, because", why)

    def test_a_base_by_name(self):
        os.environ["LUM_BASE"] = "HEAD^"
        self.assertEqual(changed.changed(self.one.top)[0], {"c.txt"})

    def test_without_a_common_commit_it_is_all_and_says_so(self):
        base = self.one.git("rev-parse", "HEAD")
        self.one.git("checkout", "-q", "--orphan", "other")
        self.one.commit()
        os.environ["LUM_BASE"] = base
        files, why = changed.changed(self.one.top)
        self.assertIsNone(files)
        self.assertIn("no commit in common", why)

    def test_a_copy_within_another_checkout_is_all(self):
        copy = self.one.top / "build" / "copy"
        copy.mkdir()
        (copy / "d.c").write_text("\n")
        files, why = changed.changed(copy)
        self.assertIsNone(files)
        self.assertIn("no checkout", why)
        self.assertEqual(changed.every(copy), {"d.c"})

    def test_a_git_that_fails_is_not_nothing(self):
        os.environ["LUM_BASE"] = "HEAD^"
        (self.one.top / ".git" / "index").write_text("broken")
        with self.assertRaisesRegex(changed.Refused, "git diff .* failed"):
            changed.changed(self.one.top)

    def test_a_base_that_is_none_is_refused(self):
        os.environ["LUM_BASE"] = "nowhere"
        with self.assertRaisesRegex(changed.Refused, "LUM_BASE=nowhere is no commit"):
            changed.changed(self.one.top)


@unittest.skipUnless(shutil.which("clang-tidy"), "there is no clang-tidy")
class Tidy(Case):
    def setUp(self):
        super().setUp()
        os.environ["LUM_BASE"] = "HEAD"

    def test_a_finding_in_what_changed_is_found_each_time(self):
        self.one.write("a.c", FAULT)
        for _ in range(2):
            self.assertEqual(self.one.look(), (1, "1 of 2 files; 0 of them are unchanged since they were clean, 1 with findings"))
            self.assertIn("bugprone-branch-clone", self.one.said)

    def test_what_did_not_change_is_not_looked_at_unless_all_is(self):
        self.one.write("a.c", FAULT)
        self.one.commit()
        self.assertEqual(self.one.look(), (0, "0 of 2 files; 0 of them are unchanged since they were clean, 0 with findings"))
        self.assertEqual(self.one.look(True), (1, "2 of 2 files; 0 of them are unchanged since they were clean, 1 with findings"))

    def test_a_header_brings_what_includes_it(self):
        self.one.write("a.h", "#define A 2\n")
        self.assertEqual(self.one.look(), (0, "1 of 2 files; 0 of them are unchanged since they were clean, 0 with findings"))

    def test_another_clone_has_the_same_records(self):
        self.assertEqual(self.one.look(True)[0], 0)
        other = Repository(self, "two")
        self.assertEqual(other.look(True), (0, "2 of 2 files; 2 of them are unchanged since they were clean, 0 with findings"))

    def test_a_header_the_checks_and_the_arguments_make_it_look_again(self):
        def seen():
            return int(self.one.look(True)[1].split("; ")[1].split()[0])
        self.assertEqual([seen(), seen()], [0, 2])
        self.one.write("a.h", "#define A 3\n")
        self.assertEqual([seen(), seen()], [1, 2])
        self.one.write(".clang-tidy", "Checks: '-*,bugprone-*'\nWarningsAsErrors: '*'\n")
        self.assertEqual([seen(), seen()], [0, 2])
        commands = self.one.top / "build/compile_commands.json"
        commands.write_text(commands.read_text().replace("clang -I", "clang -DB -I"))
        self.assertEqual([seen(), seen()], [0, 2])

    def test_what_cannot_be_compiled_or_no_build_compiles_fails(self):
        self.one.write("a.c", "int f(void) { return missing; }\n")
        self.assertEqual(self.one.look()[0], 1)
        (self.one.top / "build/compile_commands.json").write_text("[]")
        self.assertEqual(self.one.look()[0], 1)
        self.assertIn("no build compiles it", self.one.said)


TOP = pathlib.Path(__file__).resolve().parents[2]


@unittest.skipUnless((TOP / "build/release/compile_commands.json").exists() and (TOP / ".git").exists(), "no build, or no clone")
class Built(unittest.TestCase):
    def test_where_nothing_changed_each_source_is_in_a_build_all_the_same(self):
        r = subprocess.run([TOP / "script/lint", "--built"], capture_output=True, text=True, check=False,
                           env={**os.environ, "LUM_BASE": "HEAD"})
        self.assertEqual((r.returncode, [s for s in r.stderr.splitlines() if "in no CMakeLists" in s]), (0, []))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
