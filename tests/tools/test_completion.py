#!/usr/bin/env python3
"""Completion in bash and, where it is installed, zsh: asked as the shells ask."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from support import BIN, PATIENCE_S, Folder, run, simulate

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "tools" / "completion"


def complete(*words):
    """What bash offers for the last word."""
    script = """
        source "$0"
        COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
        _lumsdk "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
        printf '%s\\n' "${COMPREPLY[@]}"
    """
    r = subprocess.run(["bash", "-c", script, str(FOLDER / "lumsdk.bash"), *words], capture_output=True, text=True,
                       env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}, timeout=PATIENCE_S)
    return r.stdout.split()


def leaves(text):
    """Paths of the values of YAML in lines."""
    path = []
    for indent, key, value in re.findall(r"^((?:  )*)([a-z_]+):(.*)$", text, re.M):
        path = path[:len(indent) // 2] + [key]
        if value:
            yield ".".join(path)


def faults():
    """Those that lumsim knows, out of its complaint about another."""
    return sorted(run("lumsim", "--fault", "none@1").stderr.split("one of ")[1].strip().split(", "))


class Faults(unittest.TestCase):
    """The names of --fault stand in several texts."""

    def check(self, text):
        words = set(re.findall(r"[a-z][a-z-]*[a-z]", text))
        self.assertLessEqual(set(faults()), words)
        self.assertFalse([w for w in words if re.fullmatch(r"galvo-\w+", w) and w not in faults()])

    def test_help(self):
        self.check(re.search(r"--fault(.*?)--jitter", run("lumsim", "--help").stdout, re.S)[1])

    def test_manual(self):
        text = (FOLDER.parents[1] / "docs/man/lumsim.1").read_text()
        self.check(re.search(r"\.It Fl \\-fault(.*?)\.It Fl \\-jitter", text, re.S)[1])

    def test_there_are_some(self):
        self.assertIn("fan", faults())
        self.assertGreater(len(faults()), 9)


class Bash(unittest.TestCase):
    def test_commands_are_those_of_lumctl(self):
        text = run("lumctl", "--help").stdout
        named = set(re.findall(r"^  ([a-z][a-z-]+) ", text, re.M))
        offered = set(complete("lumctl", ""))
        self.assertTrue(offered)
        self.assertLessEqual(offered, named)
        for command in ("status", "set-ip", "doctor", "shell"):
            self.assertIn(command, offered)
        for command in sorted(named):
            if run("lumctl", command, "--help").returncode == 0 and command != "lumctl":
                self.assertIn(command, offered)

    def test_words_of_commands(self):
        self.assertEqual(complete("lumctl", "laser", "o"), ["on", "off"])
        self.assertEqual(complete("lumctl", "--json", "threshold", ""), ["green", "blue"])
        self.assertEqual(complete("lumctl", "wait", ""), ["answers", "up", "down", "clear"])
        self.assertEqual(complete("lumctl", "lines", ""), ["640", "64"])
        for command in "power", "send", "yscan", "status":
            self.assertEqual(complete("lumctl", command, ""), [], command)
        self.assertEqual(complete("lumctl", "sta"), ["status"])
        for words in (["threshold", "green"], ["laser", "on"], ["lines", "64"], ["offset", "blue"], ["apply", "a.yaml"], ["wait", "up"],
                      ["sweep", "a.yaml"]):
            self.assertEqual(complete("lumctl", *words, ""), [], words)

    def test_files_and_folders(self):
        folder = Folder(self)
        plan = str(folder.write("plan.yaml", ""))
        (folder / "plans").mkdir()
        begin = str(folder / "pl")
        for words in (["apply"], ["sweep"], ["status", "--csv"], ["status", "--prometheus"], ["--calibration"]):
            self.assertEqual(sorted(complete("lumctl", *words, begin)), [plan, str(folder / "plans")], words)
        for option in "-o", "--output":
            self.assertEqual(complete("lumctl", "sweep", plan, option, begin), [str(folder / "plans")])
            self.assertIn(plan, complete("lumdump", option, begin))

    def test_options_are_those_of_the_help(self):
        for tool in ("lumctl", "lumdump", "lumsim", "lumtable"):
            offered = complete(tool, "--")
            text = run(tool, "--help").stdout
            self.assertGreater(len(offered), 5)
            for option in offered:
                self.assertIn(option, text)
        self.assertIn("--laser", complete("lumdump", "--la"))
        self.assertEqual(complete("lumdump", "--rec"), ["--receive-buffer"])

    def test_options_of_a_command_are_those_that_it_takes(self):
        self.assertIn("--force", complete("lumctl", "--json", "set-ip", "--"))
        self.assertEqual(complete("lumctl", "status", "--w"), ["--watch"])
        for command in complete("lumctl", ""):
            offered = complete("lumctl", command, "--")
            self.assertIn("--interface", offered)
            for option in {"--dry-run", "--json", "--watch", "--force", "--heartbeat"} & set(offered):
                # a word too many ends a command that has the option, before anything is sent
                r = run("lumctl", "--host", "127.0.0.1", command, option, "x", "y", "z")
                self.assertNotRegex(r.stderr, f"{option} (does not go|cannot be)", command)
        self.assertFalse({"--dry-run", "--watch", "--lines"} & set(complete("lumctl", "doctor", "--")))

    def test_help_has_two_names(self):
        for tool in ("lumctl", "lumdump", "lumsim", "lumtable", "lumview"):
            with self.subTest(tool):
                r = run(tool, "-h")
                self.assertEqual((r.returncode, r.stderr), (0, ""))
                self.assertEqual(r.stdout, run(tool, "--help").stdout)

    def test_the_manual_has_every_option_of_the_help(self):
        for tool in ("lumctl", "lumdump", "lumsim", "lumtable", "lumview"):
            page = (FOLDER.parents[1] / f"docs/man/{tool}.1").read_text().replace("\\-", "-")
            options = re.findall(r"^ +(?:-\w, )?--([a-z][a-z-]*)", run(tool, "--help").stdout, re.M)
            self.assertGreater(len(options), 5, tool)
            for option in options:
                with self.subTest(f"{tool} --{option}"):
                    self.assertRegex(page, rf"Fl -{option}\b")

    def test_words_of_options(self):
        self.assertEqual(complete("lumdump", "--edge", ""), ["rising", "falling", "both"])
        self.assertEqual(complete("lumctl", "status", "--until", ""), ["hazard", "up", "down"])
        self.assertEqual(complete("lumsim", "--lines", ""), ["64", "640"])
        self.assertEqual(complete("lumdump", "--format", ""), "csv ply pcd las xyz png mcap pcap pcapng rosbag2".split())
        self.assertEqual(complete("lumdump", "--compression", ""), ["zstd", "none"])
        presets = "autoware lio-sam fast-lio kitti argoverse2 pdal".split()
        for option in "--preset", "--check-preset":
            self.assertEqual(complete("lumdump", option, ""), presets)
            self.assertEqual(complete("lumdump", option, "lio"), ["lio-sam"])
        self.assertEqual(complete("lumdump", "--mcap", ""), ["frames", "lines", "packets"])
        self.assertEqual(complete("lumdump", "--format", "pc"), ["pcd", "pcap", "pcapng"])

    def test_keys_are_those_of_the_files(self):
        offered = complete("lumdump", "--set", "")
        self.assertEqual(len(set(offered)), len(offered))
        for key in offered:
            r = run("lumdump", "none.pcap", "--set", key + "#")
            self.assertRegex(r.stderr, f"^lumdump: --set: {re.escape(key[:-1])}: '#' is ")
        source = simulate(Folder(self) / "one.pcap", "-n", 1)
        r = run("lumdump", "-q", source, "-o", "-", "--format", "xyz", "--comments", "--set", "tof_lsb_ps=12", "--set",
                "line_span_us=1")
        self.assertEqual(r.returncode, 0, r.stderr)
        written = re.findall(r"# # lumsdk (?:calibration|profile) 1\n((?:# +?.*\n)*?)(?=# ---|[^#])", r.stdout)
        self.assertEqual(len(written), 2)
        for text in written:
            for key in leaves(re.sub("^# ", "", text, flags=re.M)):
                self.assertTrue(key == "version" or key + "=" in offered, key)
        self.assertEqual(complete("lumview", "--set", "tof"), ["tof_lsb_ps="])

    def test_shapes_are_those_of_the_help(self):
        offered = complete("lumctl", "yscan", "--shape", "")
        text = run("lumctl", "yscan", "--help").stdout
        self.assertEqual(offered, ["uniform"] + [w for w in re.findall(r"^  ([a-z]+:)", text, re.M)])
        self.assertEqual(complete("lumctl", "yscan", "--shape", "ga"), ["gaussian:"])
        self.assertIn("tools", complete("lumctl", "yscan", "--shape", "csv", ":", str(FOLDER.parent)[:-1]).pop())

    def test_columns_are_those_of_the_help(self):
        text = re.search(r"--columns(.*?);", run("lumdump", "--help").stdout, re.S)[1]
        named = re.sub(r"\s+", "", text.split("):")[1]).split(",")
        self.assertEqual(complete("lumdump", "--columns", ""), named)
        self.assertEqual(complete("lumdump", "--columns", "x,y,ti"), ["x,y,timestamp", "x,y,time"])
        told = run("lumdump", "x", "-o", "x.csv", "--columns", "?").stderr.strip().split("columns are ")[1]
        self.assertEqual(named, told.split(", "))

    def test_faults_are_those_of_lumsim(self):
        self.assertEqual(sorted(complete("lumsim", "--fault", "")), [name + "@" for name in faults()])

    def test_a_live_source(self):
        self.assertEqual(complete("lumdump", "ud"), ["udp://"])


@unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
class Zsh(unittest.TestCase):
    def test_the_file_is_sound(self):
        r = subprocess.run(["zsh", "-n", str(FOLDER / "_lumsdk")], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stderr), (0, ""))

    def offered(self, *words):
        """What zsh is told to offer for the last word: completions that go on without a space, then those that end."""
        script = """
            compset() { [[ $PREFIX == $2* ]]; }
            _files() { print -r files $@; }
            compadd() { print -rl -- "$@"; }
            file=$1; shift; words=("$@") CURRENT=$# PREFIX=$words[-1]
            source $file
        """
        r = subprocess.run(["zsh", "-fc", script, "zsh", str(FOLDER / "_lumsdk"), *words], capture_output=True, text=True,
                           env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return r.stdout.split("\n")[:-1]

    def test_options_and_words_come_from_the_help(self):
        self.assertIn("--laser", self.offered("lumdump", "--la"))
        self.assertEqual(self.offered("lumdump", "--preset", "lio"), ["--", "lio-sam"])
        self.assertEqual(self.offered("lumctl", "wait", ""), ["--", "answers", "up", "down", "clear"])

    def test_it_is_what_bash_offers(self):
        for words in (("lumctl", ""), ("lumctl", "laser", "o"), ("lumctl", "doctor", "--"), ("lumcal", ""), ("lumcal", "--"),
                      ("lumview", "--"), ("lumsim", "--scene", ""), ("lumdump", "--check-preset", "")):
            self.assertEqual(self.offered(*words), ["--", *complete(*words)], words)

    def test_words_that_go_on_have_no_space_behind_them(self):
        for words in (("lumsim", "--fault", ""), ("lumdump", "--columns", "x,y,ti"), ("lumdump", "--set", "eyes.blue."),
                      ("lumctl", "yscan", "--shape", "g"), ("lumdump", "ud")):
            self.assertEqual(self.offered(*words), ["-S", "", "--", *complete(*words)], words)
        self.assertEqual(sorted(self.offered("lumsim", "--fault", "")[3:]), [name + "@" for name in faults()])

    def test_files(self):
        for words in (("lumdump", "x"), ("lumsim", "--truth", ""), ("lumctl", "apply", ""), ("lumctl", "yscan", "--shape", "csv:x")):
            self.assertEqual(self.offered(*words), ["files"], words)
        self.assertEqual(self.offered("lumctl", "sweep", "x", "-o", ""), ["files -/"])


if __name__ == "__main__":
    unittest.main()
