"""rooms.py [TOP]: prints what goes against the rooms and arrows of docs/internals/design.md.

That is: an include along no arrow, a third-party header outside its room, a header of the C library that a freestanding
room does without, headers that include each other in a circle, files of a room that call each other in a circle. Only sources
are read, so that the files of every platform are looked at on each.
"""

import os
import re
import sys
from pathlib import Path

# Who may include whom, directly. "frame" stands where lines become frames.
ARROWS = {
    "core": [],
    "host": ["core"],
    "points": ["core"],
    "base": [],
    "net": ["capture", "base", "core"],
    "live": ["net", "host", "base", "core"],
    "capture": ["base", "core"],
    "frame": ["capture", "points", "base", "core"],
    "infer": ["capture", "base", "core"],
    "cloud": ["points", "base"],
    "map": ["base"],
    "picture": ["cloud"],
    "config": ["host", "base", "core"],
    "sim": ["host", "points", "core"],
}
TOOLS = ["common", "lumctl", "lumdump", "lumros2", "lumsim", "lumtable", "lumview", "wireshark"]
# Words of the compiler and the version: they belong to nobody.
EVERYBODY = {"lum/result.h", "lum/version.h"}
# Headers of third parties, and who may need them.
THIRD_PARTIES = {
    "pcap": [],  # judges the reader in tests
    "lz4frame.h": ["capture"],
    "bzlib.h": ["capture"],
    "zlib.h": ["capture"],
    "zstd.h": ["capture", "cloud"],
    "yaml.h": ["config"],
    "cairo": ["picture"],
    "libwebsockets": ["lumview"],
    "dds/": ["lumros2"],
    "editline": [],
    "histedit.h": [],
}
# Rooms that a computer's operating system is unknown to; what they may include of the C library.
FREESTANDING = {"stdint.h", "stddef.h", "stdbool.h", "string.h"}
BARE = {"core": FREESTANDING, "host": FREESTANDING, "points": FREESTANDING | {"math.h", "float.h"}}
# What stands there for hosts alone, behind conditions.
FOR_HOSTS = {"src/points/vectors/kernels.c": {"stdlib.h"}, "src/points/vectors/vector.h": {"arm_neon.h", "immintrin.h"}}

# Calls that may close a circle, and why.
MEANT = {
    ("tools/lumctl/commands.c", "tools/lumctl/shell.c"): "the shell is a command, and runs commands",
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
# Comments, text in quotes, lines of the preprocessor.
NOISE = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*""",
                   re.S | re.M)
WORD = re.compile(r"[A-Za-z_]\w*")


def reach(room):
    """The rooms at the end of its arrows, however many lead there."""
    found = set()
    todo = [room]
    while todo:
        for other in ARROWS[todo.pop()]:
            if other not in found:
                found.add(other)
                todo.append(other)
    return found


def allowed(room):
    if room not in TOOLS:
        return reach(room) | {room}
    return set(ARROWS) | {"common", room}


def room_of(path):
    """The room of a file by its path from the top; None: none of ours."""
    parts = path.split("/")
    if parts[:2] == ["include", "lum"]:
        if len(parts) == 4:
            return parts[2]
        return "points" if parts[2] in ("image.h", "points.h", "pose.h", "smooth.h") else "core"
    if len(parts) > 2 and parts[0] in ("src", "tools"):
        return parts[1]
    return None


def is_looked_at(path):
    return path.startswith(("src/", "include/lum/")) or path.split("/")[:2] in [["tools", tool] for tool in TOOLS]


def sources(top):
    """All of them, by their paths from the top."""
    found = {}
    for root in ("src", "include", "tools"):
        for folder, _, names in os.walk(top / root):
            for name in names:
                path = str(Path(folder, name).relative_to(top))
                if name.endswith((".c", ".h", ".cpp", ".hpp")) and is_looked_at(path):
                    found[path] = Path(folder, name).read_text(encoding="utf-8")
    return found


def resolve(path, name, all_sources):
    """The file that a quoted include means; None: one that is not looked at, such as one that a build makes."""
    beside = os.path.normpath(os.path.join(os.path.dirname(path), name))
    for candidate in (beside, f"include/{name}", f"src/{name}"):
        if candidate in all_sources:
            return candidate
    return None


def includes(all_sources):
    """(file, whether quoted, name, the file it means or None)"""
    for path in sorted(all_sources):
        for quote, name in INCLUDE.findall(all_sources[path]):
            yield path, quote == '"', name, resolve(path, name, all_sources) if quote == '"' else None


def unused(all_sources):
    """Arrows that no include follows, and third parties that a room could need and does not."""
    followed, needed = set(), set()
    for path, is_quoted, name, target in includes(all_sources):
        if target is not None and name not in EVERYBODY:
            followed.add((room_of(path), room_of(target)))
        elif not is_quoted:
            needed |= {(room_of(path), prefix) for prefix in THIRD_PARTIES if name.startswith(prefix)}
    for room, others in ARROWS.items():
        yield from (f"the arrow from {room} to {other}" for other in others if (room, other) not in followed)
    for prefix, owners in THIRD_PARTIES.items():
        yield from (f"{prefix} for {room}" for room in owners if (room, prefix) not in needed)


def owner_of_third_party(name):
    for prefix, rooms in THIRD_PARTIES.items():
        if name == prefix or not prefix.endswith(".h") and name.startswith(prefix):
            return rooms
    return None


def against_arrows(all_sources):
    for path, is_quoted, name, target in includes(all_sources):
        room = room_of(path)
        if room not in ARROWS and room not in TOOLS:
            yield f"{path}: the room {room} is in no arrow of tests/rooms/rooms.py"
        elif is_quoted and target is not None:
            other = room_of(target)
            if name not in EVERYBODY and other not in allowed(room):
                yield f"{path}: includes {name}: there is no arrow from {room} to {other}"
        elif is_quoted and name.startswith("lum/"):
            yield f"{path}: includes {name}, which is not there"
        elif not is_quoted:
            owners = owner_of_third_party(name)
            if owners is not None and room not in owners:
                yield f"{path}: includes <{name}>, which belongs to {' and '.join(owners) or 'no room'}"
            if room in BARE and name not in BARE[room] | FOR_HOSTS.get(path, set()):
                yield f"{path}: includes <{name}>, which {room} does without"


def circles(edges):
    """The groups of nodes that reach each other (Tarjan)."""
    index, low, on_stack, stack, found = {}, {}, set(), [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        on_stack.add(node)
        for other in sorted(edges.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on_stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group = []
            while not group or group[-1] != node:
                group.append(stack.pop())
                on_stack.discard(group[-1])
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return found


def header_circles(all_sources):
    edges = {}
    for path, _, _, target in includes(all_sources):
        if target is not None and path.endswith(".h"):
            edges.setdefault(path, set()).add(target)
    for group in circles(edges):
        yield f"headers that include each other: {', '.join(group)}"


def read_functions(text):
    """The functions that a source defines for others, those that it keeps, and every word in their bodies."""
    depth, outside, inside = 0, [], []
    for part in re.split(r"([{}])", NOISE.sub(" ", text)):
        if part == "{":
            depth += 1
            outside.append("{" if depth == 1 else "")
        elif part == "}":
            depth -= 1
        else:
            (outside if depth == 0 else inside).append(part)
    public, kept = set(), set()
    for head in re.findall(r"([^;{]*)\{", "".join(outside)):
        name = re.search(r"([A-Za-z_]\w*)\s*\(", head)
        if name is not None and "=" not in head:
            (kept if re.search(r"\bstatic\b", head) else public).add(name.group(1))
    return public, kept, set(WORD.findall(" ".join(inside)))


def calls(all_sources):
    """Of each room: which source calls which, by the words that are functions of the other."""
    rooms = {}
    for path, text in all_sources.items():
        if path.endswith((".c", ".cpp")):
            rooms.setdefault(room_of(path), {})[path] = read_functions(text)
    for room in sorted(rooms):
        files = rooms[room]
        edges = {}
        for path, (public, kept, words) in files.items():
            for other, (theirs, _, _) in files.items():
                used = (words & theirs) - public - kept
                if other != path and used:
                    edges.setdefault(path, {})[other] = sorted(used)
        yield room, edges


def call_circles(all_sources):
    """Files of a room that call each other in a circle: one module, or cut wrong."""
    for _, edges in calls(all_sources):
        kept = {path: {other for other in others if (path, other) not in MEANT} for path, others in edges.items()}
        for group in circles(kept):
            why = (f"{path}: {', '.join(edges[path][other])} of {other}"
                   for path in group for other in sorted(kept.get(path, set()) & set(group)))
            yield f"{', '.join(group)} call each other: {'; '.join(why)}"


def faults(top):
    all_sources = sources(top)
    return [*against_arrows(all_sources), *header_circles(all_sources), *call_circles(all_sources)]


def main():
    top = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
    found = faults(top)
    print("\n".join(found) if found else "every include follows an arrow")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
