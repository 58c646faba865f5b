"""The rooms' arrows hold, and rooms.py sees where they would not."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import rooms  # noqa: E402

TOP = Path(__file__).resolve().parents[2]
# What script/misra has cppcheck write beside a source, for a moment.
OF_LINTERS = (".dump", ".ctu-info")


class Tree(unittest.TestCase):
    def test_every_include_follows_an_arrow_and_no_files_call_each_other(self):
        self.assertEqual(rooms.faults(TOP), [])

    def test_every_room_and_every_tool_is_looked_at(self):
        seen = {rooms.room_of(path) for path in rooms.sources(TOP)}
        there = {path.name for path in (TOP / "src").iterdir() if path.is_dir()}
        self.assertEqual(there - seen, set())
        self.assertEqual(there - set(rooms.ARROWS), set())
        tools = {path.name for path in (TOP / "tools").iterdir() if path.is_dir()} - {"completion", "python", "ros", "ros2"}  # no C
        self.assertEqual(tools - seen, set())
        self.assertEqual(tools, set(rooms.TOOLS))

    def test_no_arrow_is_there_that_nothing_follows(self):
        self.assertEqual(list(rooms.unused(rooms.sources(TOP))), [])

    def test_arrows_are_those_of_the_picture(self):
        text = (TOP / "docs/internals/design.md").read_text()
        picture = re.search(r"^tools ─.*?^```", text, re.M | re.S)[0]
        drawn = {room: set() for room in rooms.ARROWS}
        for line in picture.splitlines():
            parts = re.split(r"─*>", line)
            for left, right in zip(parts, parts[1:]):
                for room in set(re.findall(r"\w+", left)) & set(drawn):
                    drawn[room] |= set(re.findall(r"\w+", right))
        for room, others in rooms.ARROWS.items():
            with self.subTest(room):  # the picture need not repeat what several arrows lead to; all lead to core
                drawn_far = drawn[room] | {far for near in drawn[room] for far in drawn.get(near, ())} | {"core"}
                self.assertLessEqual(set(others), drawn_far)
                self.assertLessEqual(drawn[room], rooms.reach(room))

    def test_quoted_includes_are_found(self):
        sources = rooms.sources(TOP)
        lost = {(path, name) for path, is_quoted, name, target in rooms.includes(sources)
                if is_quoted and target is None}
        self.assertEqual(lost, set())

    def test_what_is_meant_is_still_there(self):
        for pair in rooms.MEANT:
            files = dict(rooms.calls(rooms.sources(TOP)))[rooms.room_of(pair[0])]
            self.assertIn(pair[1], files[pair[0]])
            self.assertTrue(any(set(pair) <= set(group) for group in rooms.circles(files)))


class Structs(unittest.TestCase):
    """What liblumsdk and its callers hand each other, in rooms that are not for firmware (docs/internals/design.md)."""

    STRUCT = re.compile(r"/\*\*((?:[^*]|\*(?!/))*)\*/\s*typedef struct (lum_\w+) \{\s*([^;]*;)")

    def structs(self):
        headers = [path for room in ("base", "capture", "cloud", "frame", "live", "net") for path in (TOP / "include/lum" / room).glob("*.h")]
        found = [(path, *match.groups()) for path in sorted(headers) for match in self.STRUCT.finditer(path.read_text())]
        self.assertEqual(len(found), sum(len(re.findall(r"^typedef struct \w+ \{", path.read_text(), re.M)) for path in headers))
        return found

    def test_every_public_struct_tells_its_size_or_never_grows(self):
        found = self.structs()
        for path, comment, name, member in found:
            with self.subTest(name):
                is_sized = member == "size_t struct_size;"
                is_fixed = "never grows" in " ".join(comment.replace("*", " ").split())
                self.assertNotEqual(is_sized, is_fixed, f"{path}: {name} begins with struct_size, or its comment says that it never grows")

    def test_each_has_its_size_before_it_is_filled(self):
        """Without it nothing is filled in, and no caller has to look at the result."""
        sized = "|".join(name for _, _, name, member in self.structs() if member == "size_t struct_size;")
        headers = " ".join(path.read_text() for path in (TOP / "include/lum").rglob("*.h"))
        fill = re.findall(rf"\b(lum_\w+)\([^;()]*(?<!const )\b(?:{sized}) \*\w+\);", headers)
        self.assertIn("lum_demux_total", fill)
        for path, text in rooms.sources(TOP).items():
            for body in re.findall(r"^\{$(.*?)^\}$", text, re.M | re.S):
                for name in re.findall(rf"^ +(?:static )?(?:{sized}) (\w+);$", body, re.M):
                    if re.search(rf"\b(?:{'|'.join(fill)})\([^;]*&{name}\)", body):
                        with self.subTest(f"{path}: {name}"):
                            self.assertRegex(body, rf"\b{name}(?:\.struct_size)? =|_default\(&{name}\)")


class Files(unittest.TestCase):
    """Each module says what it does (script/files)."""

    def test_every_module_has_its_sentence(self):
        done = subprocess.run([sys.executable, "-B", TOP / "script/files", "--check"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_one_without_is_found(self):
        with tempfile.TemporaryDirectory() as top:
            for name, text in {"src/net/a.c": "#include <b.h>\n/* Not the head. */\n", "src/net/b.c": "int b;\n", "src/net/b.h": "/* What b does. */\n",
                               "include/lum/net/c.h": "/** @file\n * What c does\n * (docs). More. */\n", "src/net/c.c": "int c;\n",
                               "tools/d.py": "import e\n", "tools/f.js": "// Parts, and\n// how they meet.\n\n// More.\n",
                               "script/g": "#!/bin/sh\n# g [FILE]: greets, e.g. loudly. Needs sh.\n"}.items():
                Path(top, name).parent.mkdir(parents=True, exist_ok=True)
                Path(top, name).write_text(text)
            shutil.copy(TOP / "script/files", Path(top, "script/files"))
            said = [subprocess.run([sys.executable, "-B", Path(top, "script/files"), *words], capture_output=True, text=True, check=False)
                    for words in (["--check"], ["src", "include", "tools/", "script"], ["gone"])]
        self.assertEqual([one.returncode for one in said], [1, 0, 1])
        self.assertEqual(re.findall(r"^  (\S+)", said[0].stdout, re.M), ["a.c", "d.py"])
        for name, text in {"a.c": "its head comment has no first sentence", "b.{c,h}": "What b does.", "c.c": "What c does (docs).",
                           "f.js": "Parts, and how they meet.", "g": "greets, e.g. loudly."}.items():
            self.assertRegex(said[1].stdout, rf"(?m)^  {re.escape(name)} +{re.escape(text)}$")


class Changes(unittest.TestCase):
    """Of docs/internals/design.md, "To change something" names files that are there, and all that earlier changes have."""

    def section(self, title):
        text = (TOP / "docs/internals/design.md").read_text()
        start = text.index(f"\n## {title}\n")
        return text[start:text.find("\n## ", start + 1)]

    def expand(self, text):
        """As a shell does: a{b,c} is ab and ac."""
        found = re.search(r"\{([^{}]*)\}", text)
        return [text] if found is None else [each for part in found[1].split(",")
                                             for each in self.expand(text[:found.start()] + part + text[found.end():])]

    def paths(self, text):
        """Those between backticks, below a folder of the top or a file there; ROOM and TOOL are any."""
        tops = {path.name for path in TOP.iterdir() if path.name[0] != "."}
        for span in re.findall(r"`([^` ]+)`", text):
            if span.split("/")[0] in tops:
                yield from self.expand(re.sub(r"\b(?:ROOM|TOOL)\b", "*", span))

    def rows(self):
        """What is changed: what to edit for it, with the rows that this names."""
        lines = [re.split(r" \| ", line.strip("| ")) for line in self.section("To change something").splitlines() if line[:2] == "| "]
        rows = {line[0]: line[1] for line in lines if line[0] != "to change"}
        for what in rows:
            for name in re.findall(r"\*([^*]+)\*", rows[what]):
                self.assertTrue(name in rows, f"design.md, To change something, {what}: no row {name}")
                rows[what] += f" {rows[name]}"
        return rows

    def test_what_a_change_is_said_to_edit_is_there(self):
        text = self.section("To change something")
        paths = set(self.paths(text))
        self.assertGreater(len(paths), 300)
        for path in paths:
            with self.subTest(path):
                self.assertTrue(any(TOP.glob(path)), f"docs/internals/design.md, To change something: no {path}")
        named = re.findall(r"`(\w+)\(\)` (?:in|of) `([^`]*)`", text) + [
            (name, path) for path, name in re.findall(r"`([^` ]*)` \(`(\w+)\(\)`\)", text)]
        self.assertGreater(len(named), 1)
        for name, path in named:
            with self.subTest(name):
                self.assertIn(f"{name}(", (TOP / path).read_text())
        for name, path in re.findall(r"`([A-Z_]+|\w+\[\])` (?:in|of) `([^`]*)`", text):
            with self.subTest(name):
                self.assertIn(name, (TOP / path).read_text())

    SOURCES = ("src", "include", "tools", "calib")
    # Kinds of changes, and a word of one that was made: all that has it is among the places to edit.
    EXAMPLES = {
        "a setting: a command that `lumctl` remembers and `apply` sends": [
            (r"\bLUM_COMMAND_HOLDOFF\b", SOURCES), (r"\bholdoff\b|_HOLDOFF\b", ("tests/world/judges", "tests/world/dice", "tests/fuzz", "docs/python/live.md"))],
        "a bit of the laser status": [(r"FAN_PWM_BAD", SOURCES)],
        "a sentence of a live run": [(r"\bLUM_NEWS_(?:TEXT|LASER_LEFT|MOVED)\b", SOURCES)],
        "an event of a session": [(r"\bLUM_SENSOR_(?:ALERT|LINK|NO_ANSWER)\b", (*SOURCES, "tests/fuzz"))],
        "a counter of a session": [(r"\bkernel_drops\b", SOURCES)],
        "a shape of a Y-scan": [(r"\bLUM_YSCAN_REGIONS\b|\bregions\b", SOURCES)],
        "a TLV type": [(r"\bLUM_TLV_DEBUG\b", SOURCES)],
        "a path of the sensor": [(r"\blum_path_kind\b|\"circle\"", SOURCES)],
        "a calibration value": [(r"\bspeed_of_light\b|\btof_offset_ps\b", SOURCES)],
        "a key of the wire profile, a field of packets": [(r"\bangle_order\b", SOURCES)],
        "an event of the assembler": [(r"\bLUM_FRAME_READY\b", (*SOURCES, "examples", "tests/flat"))],
        "an event of the framer": [(r"\bLUM_FRAMER_FRAME(?:_END)?\b", SOURCES)],
        "a counter of packets or lines": [(r"\blines_missing_angles\b", (*SOURCES, "tests/flat"))],
        "a counter of frames, what is known of a frame": [(r"\blines_in_pauses\b", SOURCES)],
        "a column of points": [(r"\bnumber_of_returns\b", SOURCES)],
        "a link type of captures": [(r"SLL2", (*SOURCES, "tests/fuzz"))],
        "a compression of captures": [(r"bz2|BZ2", ("src", "include", "tools", "cmake", "script", "CMakeLists.txt"))],
        "a format of captures": [(r"\blum_bag_(?:is|reader_begin)\b", SOURCES)],
        "a format of clouds": [(r'"pcd"|\bLUM_FORMAT_PCD\b', SOURCES)],
        "a preset": [(r"lio-sam", SOURCES)],
        "a key of a rig": [(r"\bLUM_RIG_(?:INTERFACE|YAW)\b", SOURCES)],
        "a key of a sweep's plan": [(r"\bRECORD_FRAMES\b|\brecord_frames\b", SOURCES)],
        "an option of lumctl": [(r"\bOWN_FORCE\b", SOURCES)],
        "an option of lumdump": [(r'"frame-id"|\bvalues_take_frame_id\b', SOURCES)],
        "an option of lumsim": [(r'"boot-status"|\bboot_status\b', SOURCES)],
        "an option of lumview, lumtable, lumros2": [(r"\bno-open\b", SOURCES)],
        "a check of the doctor": [(r"\bdoctor_check_(?:clock|mtu)\b", SOURCES)],
        "a value of `--every` (a column of `--csv`, a metric)": [(r"\bround_trip_seconds\b|\bage_s\b", SOURCES)],
        "a fault of the sensor (`--fault`)": [(r'"fan"|\bFAULT_SILENCE\b|\bfan@', SOURCES)],
        "a fault of the network": [(r"\bLUM_FAULT_REORDER\b", SOURCES)],
        "a scene": [(r"\bLUM_PLACE_YARD\b|\"yard\"", ("src", "tools/lumsim", "tools/python/lumsdk/_simulate.py"))],
        "a control of lumview's page": [(r"\b(?:edl|accumulate)\b", ("tools/lumview",))],
        "a request of the page": [(r"\bCOMMAND_LOOP\b", SOURCES)],
        "a value of lumview's status": [(r"\bwire_words\b|\bjoined_words\b", SOURCES)],
        "a colour map": [(r"\bcividis\b", SOURCES)],
        "what colours mean": [(r'"pulse"|\bLUM_PICTURE_PULSE_WIDTH\b', SOURCES)],
        "an option of points, by lumdump's name": [(r'"smooth"', ("tools/python", "tools/ros"))],
        "an option of `convert()`": [(r'"pose_times"', ("tools/python",))],
        "a parameter of ROS": [(r"\beye_topics\b", ("tools/ros",)), (r'"?depth"?:', ("tools/ros2/lumsdk_ros2",))],
        "a message or topic of MCAP and ROS": [(r"\btf_static\b", SOURCES)],
        "a private module": [(r"\breturns(?:\.c)?\b", ("src/core/sources.cmake", "examples/porting/Makefile", "script/prove", "docs/firmware.md"))],
        "a room, or an arrow": [(r"\binfer\b", ("cmake", "CMakeLists.txt", "tests/rooms/rooms.py", "tests/package"))],
        "a tool": [(r"\blumtable\b", ("cmake", "CMakeLists.txt", "tests/rooms/rooms.py", "tools/completion", "docs/man", "docs/install.md"))],
        "a dependency": [(r"LUM_(?:WITH_)?LZ4\b|\bliblz4\b|\blz4frame", ("cmake", "CMakeLists.txt", "script", "tests/rooms/rooms.py", "tests/package",
                                                                 "tests/wheels", "tests/world/CMakeLists.txt"))],
    }

    def test_the_places_of_a_change_are_all_that_an_earlier_one_has(self):
        rows = self.rows()
        texts = {}
        for folder in sorted({folder for words in self.EXAMPLES.values() for _, folders in words for folder in folders}):
            for path in [TOP / folder, *(TOP / folder).rglob("*")]:
                if path.is_file() and path.suffix not in (".pyc", ".svg", *OF_LINTERS) and not {"node_modules", "corpus"} & set(path.parts):
                    texts[str(path.relative_to(TOP))] = path.read_text(errors="replace")
        for what, words in self.EXAMPLES.items():
            places = {str(path.relative_to(TOP)) for pattern in self.paths(rows[what]) for path in TOP.glob(pattern)}
            # A source stands for its header, and the other way; a folder for its files.
            stems = {place.rpartition(".")[0] for place in places}
            for word, folders in words:
                found = {path for path, text in texts.items() if f"{path}/".startswith(tuple(f"{folder}/" for folder in folders))
                         and re.search(word, text)}
                with self.subTest(f"{what}: {word}"):
                    self.assertGreater(len(found), 1)
                    self.assertEqual({path for path in found if path not in places and os.path.dirname(path) not in places
                                      and not (path.endswith((".c", ".h")) and path.rpartition(".")[0] in stems)}, set(),
                                     "design.md, To change something")

    def test_words_are_few_and_those_of_the_code(self):
        words = re.findall(r"^\| (.*?) \|", self.section("Words"), re.M)[1:]
        self.assertLessEqual(len(words), 30)
        code = "\n".join(f"{path} {text}" for path, text in rooms.sources(TOP).items())
        for word in words:
            with self.subTest(word):
                self.assertRegex(code, rf"(?i)(?<![a-z]){word.replace(' ', '[ _]')}(?![a-z])")
        for word in "stage", "cue", "reel", "lane":
            if re.search(rf"/{word}[._]", code):
                self.assertIn(word, words)


class Frames(unittest.TestCase):
    """One place makes frames of packets; besides it only programs for controllers, which have the core alone, and a replay,
    which makes none but asks whose a packet is."""

    MAKERS = {
        "lum_assembler": {"src/core/assembler.c", "src/capture/demux.c", "src/capture/demux_sensors.c",
                          "examples/firmware/gateway.c", "examples/porting/main.c"},
        "lum_demux": {"src/capture/demux.c", "src/frame/framer.c", "src/frame/framer_open.c", "src/frame/packet_writer.c",
                      "tools/lumsim/recording.c"},
    }

    def test_no_other_source_calls_an_assembler(self):
        for what, makers in self.MAKERS.items():
            called = re.compile(rf"\b{what}_(?:new|init|push|flush)\s*\(")
            found = {str(path.relative_to(TOP)) for folder in ("src", "tools", "examples")
                     for path in (TOP / folder).rglob("*.[ch]*")
                     if path.suffix in (".c", ".h", ".cpp", ".hpp") and called.search(rooms.NOISE.sub(" ", path.read_text()))}
            with self.subTest(what):
                self.assertEqual(found, makers)


class Laser(unittest.TestCase):
    """One room decides to send `u` or `d`: src/live (docs/safety.md). Others hand it what a person wants, and no other call has
    its letters."""

    # Calls and letters that switch a laser, and where else they may stand.
    SIGNS = {
        r"\blum_sensor_laser_off\w*\s*\(": set(),
        r"\blum_laser_rules_\w+\s*\(": set(),
        r'(?:send|command|request|tlv)\w*\s*\([^;)]*"[ud]"': set(),
        # The session; what Python sends has no word for the laser, which it refuses.
        r"\blum_sensor_command\s*\(": {"src/net/sensor.c", "tools/python/lumsdk/_commands.py"},
        # Command TLVs by hand: lumctl's settings, and its texts, which its laser session knows of.
        r"\blum_tlv_add\s*\([^;]*\bLUM_TLV_COMMAND\b": {"src/net/sensor.c", "tools/lumctl/settings_plan.c", "tools/lumctl/text_command.c"},
    }
    NOISE = re.compile(r'("(?:\\.|[^"\\\n])*")|/\*.*?\*/|//[^\n]*', re.S)

    def files(self):
        for folder in ("src", "tools"):
            for path in sorted((TOP / folder).rglob("*")):
                name = str(path.relative_to(TOP))
                is_script = path.is_file() and not path.suffix and path.read_bytes()[:2] == b"#!"
                if is_script or path.suffix in (".c", ".h", ".cpp", ".hpp", ".py"):
                    if not name.startswith(("src/live/", "src/sim/")):  # the owner, and the sensor itself
                        yield name, path.read_text()

    def owners(self, files):
        """(file, sign) of all that would be a second owner."""
        found = []
        for name, text in files:
            is_c = name.endswith((".c", ".h", ".cpp", ".hpp"))
            code = self.NOISE.sub(lambda m: m[1] or " ", text) if is_c else text.replace("'", '"')
            found += [(name, sign) for sign, homes in self.SIGNS.items() if name not in homes and re.search(sign, code)]
        return found

    def test_nothing_else_sends_u_or_d(self):
        self.assertEqual(self.owners(self.files()), [])

    def test_a_second_owner_is_found(self):
        for text in ('lum_sensor_command(s, on ? "u" : text)', "lum_sensor_laser_off(s, 9, NULL, NULL)", "lum_laser_rules_next (&r)",
                     'send(off, "d")', "self._command('u')", 'lum_tlv_add(w, 1,\n    b"u", 1)', "lum_sensor_command(line, text)",
                     "lum_tlv_add(&w,\n profile.tlv[LUM_TLV_COMMAND], text, 1)"):
            names = "tools/python/lumsdk/_stream.py", "tools/ros/lumsdk_ros/scripts/lumsdk_node", "tools/lumdump/receiving.c"
            for name in names[: 2 if "'" in text else 3]:
                with self.subTest(f"{name}: {text}"):
                    self.assertEqual(len({file for file, _ in self.owners([(name, text)])}), 1)

    def test_what_only_reads_is_none(self):
        for text in ("if (*text == 'u') {", '/* "u" */ lum_laser_session_want(k, LUM_WANT_ON, now); // lum_sensor_command(', 'printf("%d", d);'):
            self.assertEqual(self.owners([("tools/lumctl/laser_outcome.c", text)]), [])

    def test_each_home_is_one(self):
        files = dict(self.files())
        for sign, homes in self.SIGNS.items():
            for home in homes:
                with self.subTest(home):
                    self.assertRegex(files[home], sign)


class Headings(unittest.TestCase):
    """A file that one does not see at once says what stands where."""

    def test_long_files_have_sections(self):
        for path, text in dict(rooms.sources(TOP)).items():
            if text.count("\n") > 350:
                with self.subTest(path):
                    self.assertGreater(len(re.findall(r"^/\* --- \S.*\S --- \*/$", text, re.M)), 2,
                                       "more than 350 lines: give it headings such as /* --- Opening --- */")


class Sizes(unittest.TestCase):
    """What one reader can describe: files, and structs that have an owner."""

    LINES = 600
    FIELDS = 20

    def test_no_file_is_longer(self):
        long = {}
        for folder in ("src", "tools"):
            for path in sorted((TOP / folder).rglob("*")):
                name = str(path.relative_to(TOP))
                if path.suffix not in OF_LINTERS and path.is_file() and not {"node_modules", "__pycache__"} & set(path.parts):
                    lines = path.read_bytes().count(b"\n")
                    long.update({name: lines} if lines > self.LINES else {})
        self.assertEqual(long, {})

    def fields(self, body):
        """How many names a struct declares, with those of structs without a name inside it."""
        body = re.sub(r"\[[^\]]*\]", "", re.sub(r"\([^()]*\)", "", re.sub(r"\([^()]*\)", "", body)))
        declared = (part.strip() for part in re.split(r"[;{}]", body))
        return sum(part.count(",") + 1 for part in declared if part and not re.fullmatch(r"(?:struct|union|enum)(?:\s+\w+)?", part))

    def structs(self, text):
        """(name, body) of each struct of a C file."""
        text = rooms.NOISE.sub(" ", text)
        for found in re.finditer(r"\bstruct(?:\s+(\w+))?\s*\{", text):
            end, depth = found.end(), 1
            while depth:
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
            yield found[1] or re.match(r"\s*(\w*)", text[end:])[1], text[found.end():end - 1]

    def test_no_struct_has_more_fields(self):
        wide = {}
        for path, text in dict(rooms.sources(TOP)).items():
            for name, body in self.structs(text):
                only_grows = str(path).startswith("include/") and name.endswith(("_options", "_info"))
                if not only_grows and self.fields(body) > self.FIELDS:
                    wide[f"{path}: {name}"] = self.fields(body)
        self.assertEqual(wide, {})

    def test_fields_are_counted(self):
        text = "struct a { int x, y[3]; /* ; */ struct { char b; } c; void (*f)(int, int); } ; typedef struct { int q; } d;"
        self.assertEqual([(name, self.fields(body)) for name, body in self.structs(text)],
                         [("a", 5), ("c", 1), ("d", 1)])


class Values(unittest.TestCase):
    """What the protocol and a session take for usual is a number in one header."""

    HOMES = {
        r"0x0a2a0025": {"include/lum/wire.h"},
        r"(?<![\d.:])5517u?(?!\d)": {"include/lum/wire.h"},
        r"gap_us = \d|GAP_US\w* +\(?(?:UINT32_C\()?\d": {"include/lum/assembler.h"},
        r"#define +\w*HEARTBEAT\w*_(?:M|U|N)?S +\(?(?:\w+\()?\d": {"include/lum/wire.h", "include/lum/net/sensor.h"},
        r"SILENCE_NS +.*\b3\b|silence_ns = \d": set(),
        r"(?:rate|beat)\w*_hz\b[^;]*\?[^;:]*: *\d": set(),
    }
    # The same in comments and messages.
    WORDS = {
        r"\b(?:five|5(?:\.0+)?)(?: heartbeats)?[\s*/]+(?:a|per)[\s*/]+second": {"include/lum/wire.h"},
        r"\bfive heartbeats": set(),
    }

    def files(self):
        files = dict(rooms.sources(TOP))
        for path in (TOP / "examples").rglob("*.[ch]*"):
            files[str(path.relative_to(TOP))] = path.read_text()
        return files

    def check(self, files, all_homes):
        for pattern, homes in all_homes.items():
            found = {path for path, text in files.items() if re.search(pattern, text)}
            with self.subTest(pattern):
                self.assertEqual(found, homes)

    def test_each_stands_in_its_home_alone(self):
        self.check({path: re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', "", text, flags=re.S)
                    for path, text in self.files().items()}, self.HOMES)

    def test_no_text_repeats_it(self):
        self.check(self.files(), self.WORDS)


class Faults(unittest.TestCase):
    """A small tree with one fault each."""

    def faults(self, **files):
        with tempfile.TemporaryDirectory() as top:
            for folder in ("src", "include", "tools"):
                Path(top, folder).mkdir()
            for name, text in files.items():
                path = Path(top, name.replace("__", "/")[:-2] + "." + name[-1])
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return rooms.faults(Path(top))

    def test_none_in_a_tree_that_keeps_to_them(self):
        self.assertEqual(self.faults(include__lum__a_h="",
                                     include__lum__points_h='#include "lum/a.h"\n#include <math.h>\n',
                                     src__cloud__x_c='#include "lum/points.h"\n#include "lum/a.h"\n',
                                     tools__lumctl__m_c='#include "cloud/y.h"\n', src__cloud__y_h=""), [])

    def test_an_include_against_an_arrow(self):
        found = self.faults(include__lum__host__a_h="", src__core__b_c='#include "lum/host/a.h"\n')
        self.assertEqual(found, ["src/core/b.c: includes lum/host/a.h: there is no arrow from core to host"])

    def test_of_an_internal_header_and_of_one_beside(self):
        found = self.faults(src__cloud__a_h="", src__config__b_c='#include "cloud/a.h"\n#include "../cloud/a.h"\n')
        self.assertEqual(len(found), 2)

    def test_of_tools_by_the_libraries_and_of_a_tool_by_another(self):
        found = self.faults(tools__common__a_h="", tools__lumsim__b_h="",
                            src__net__c_c='#include "../../tools/common/a.h"\n',
                            tools__lumctl__d_c='#include "../lumsim/b.h"\n#include "../common/a.h"\n')
        self.assertEqual(found, ["src/net/c.c: includes ../../tools/common/a.h: there is no arrow from net to common",
                                 "tools/lumctl/d.c: includes ../lumsim/b.h: there is no arrow from lumctl to lumsim"])

    def test_a_header_that_is_not_there(self):
        found = self.faults(src__core__b_c='#include "lum/gone.h"\n')
        self.assertEqual(found, ["src/core/b.c: includes lum/gone.h, which is not there"])

    def test_a_room_without_arrows(self):
        self.assertEqual(self.faults(src__attic__b_c='#include "c.h"\n', src__attic__c_h="")[0],
                         "src/attic/b.c: the room attic is in no arrow of tests/rooms/rooms.py")

    def test_third_parties(self):
        found = self.faults(src__cloud__a_c="#include <cairo.h>\n#include <math.h>\n",
                            src__capture__b_c="#include <zstd.h>\n#include <zlib.h>\n# include <yaml.h>\n")
        self.assertEqual(found, ["src/capture/b.c: includes <yaml.h>, which belongs to config",
                                 "src/cloud/a.c: includes <cairo.h>, which belongs to picture"])
        self.assertEqual(self.faults(src__capture__a_c="#include <pcap/pcap.h>\n"),
                         ["src/capture/a.c: includes <pcap/pcap.h>, which belongs to no room"])

    def test_an_arrow_that_nothing_follows(self):
        self.assertIn("the arrow from cloud to points", list(rooms.unused({"src/cloud/a.c": ""})))
        self.assertIn("cairo for picture", list(rooms.unused({"src/picture/a.c": ""})))

    def test_a_freestanding_room_includes_no_more_than_it_may(self):
        self.assertEqual(self.faults(src__core__a_c="#include <string.h>\n#include <stdio.h>\n"),
                         ["src/core/a.c: includes <stdio.h>, which core does without"])

    def test_headers_in_a_circle(self):
        found = self.faults(src__net__a_h='#include "b.h"\n', src__net__b_h='#include "c.h"\n',
                            src__net__c_h='#include "a.h"\n')
        self.assertEqual(found, ["headers that include each other: src/net/a.h, src/net/b.h, src/net/c.h"])

    def test_files_that_call_each_other(self):
        found = self.faults(src__net__a_c="int a(int x)\n{\n    if (x > 0) {\n        return b(x);\n    }\n}\n",
                            src__net__b_c="int b(int x)\n{\n    return a(x);\n}\n")
        self.assertEqual(found, ["src/net/a.c, src/net/b.c call each other: src/net/a.c: b of src/net/b.c; "
                                 "src/net/b.c: a of src/net/a.c"])

    def test_files_that_call_each_other_by_others(self):
        found = self.faults(tools__lumctl__a_c="void a(void)\n{\n    b();\n}\n",
                            tools__lumctl__doctor__b_c="void b(void)\n{\n    c();\n}\n",
                            tools__lumctl__c_c="void c(void)\n{\n    a();\n    d();\n}\n",
                            tools__lumctl__d_c="void d(void)\n{\n}\n")
        self.assertEqual(found, ["tools/lumctl/a.c, tools/lumctl/c.c, tools/lumctl/doctor/b.c call each other: "
                                 "tools/lumctl/a.c: b of tools/lumctl/doctor/b.c; tools/lumctl/c.c: a of tools/lumctl/a.c; "
                                 "tools/lumctl/doctor/b.c: c of tools/lumctl/c.c"])

    def test_a_function_of_the_file_s_own_is_no_other_s(self):
        self.assertEqual(self.faults(src__net__a_c="static void b(void)\n{\n}\nvoid a(void)\n{\n    b();\n}\n",
                                     src__net__b_c="void b(void)\n{\n    a();\n}\n"), [])

    def test_words_of_comments_and_strings_call_nothing(self):
        self.assertEqual(self.faults(src__net__a_c='void a(void)\n{\n    /* b() */ puts("b"); // b\n}\n',
                                     src__net__b_c="void b(void)\n{\n    a();\n}\n"), [])


if __name__ == "__main__":
    unittest.main()
