#!/usr/bin/env python3
"""layout.py OLD NEW: structs whose layout in the dump NEW would break programs that know it from OLD. Members keep their places.
One that begins with struct_size may have more of them at its end, and then another size, so that the size tells whether a caller
knows of them. libabigail looks at more than this, but takes what a struct that may grow points to for harmless, and growth into
the padding at an end."""
import sys
import xml.etree.ElementTree as xml


def structs(dump):
    """The size and the members of each struct, in bits."""
    found = {}
    for one in xml.parse(dump).getroot().iter("class-decl"):
        if one.get("size-in-bits"):
            found[one.get("name")] = int(one.get("size-in-bits")), [
                (m.find("var-decl").get("name"), int(m.get("layout-offset-in-bits"))) for m in one.findall("data-member")]
    return found


def tells_its_size(members):
    return members[:1] == [("struct_size", 0)]


def faults(old, new):
    before, after = structs(old), structs(new)
    for name in sorted(before.keys() & after.keys()):
        (size, members), (new_size, new_members) = before[name], after[name]
        if new_members[:len(members)] != members:
            yield name, "members went, moved or have another name"
        elif len(new_members) > len(members) and not tells_its_size(members):
            yield name, "it grew, and does not tell its size"
        elif (new_size > size) != (len(new_members) > len(members)) or new_size < size:
            yield name, "it has more members and the same size, or the other way round: padding of its own before the new ones helps"


if __name__ == "__main__":
    found = list(faults(*sys.argv[1:]))
    for fault in found:
        print("%s: %s" % fault)
    sys.exit(bool(found))
