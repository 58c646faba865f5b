#!/usr/bin/env python3
"""corpus.py pack ARCHIVE FOLDER...
corpus.py unpack ARCHIVE FOLDER
corpus.py check ARCHIVE...

The inputs of a fuzzer, in one text file that git can merge: corpus/NAME.txt.
Each line is one input, compressed by zlib and written in base64. Lines are sorted, and none is there twice. Readers also take
them in any order and more than once, as a merge by union leaves them. What is broken is refused by file and line.

pack    ARCHIVE gets the inputs of all files below the folders, and no others
unpack  FOLDER gets a file for each input, named by its SHA-1 as libFuzzer does; files so named of other inputs are removed.
        FOLDER.unpacked remembers the archive: if it is the same, nothing is done
check   says how many inputs each archive has
"""
import base64
import binascii
import hashlib
import os
import pathlib
import re
import sys
import zlib


class Broken(Exception):
    """FILE:LINE: what is wrong there."""


def encode(data):
    return base64.b64encode(zlib.compress(data, 9))


def decode(line):
    """Raises ValueError."""
    try:
        packed = base64.b64decode(line, validate=True)
        unpacker = zlib.decompressobj()
        data = unpacker.decompress(packed)
    except (binascii.Error, zlib.error) as e:
        raise ValueError(str(e)) from None
    if base64.b64encode(packed) != line:
        raise ValueError("bits behind the end of base64")
    if not unpacker.eof or unpacker.unused_data:
        raise ValueError("not one whole stream of zlib")
    return data


def parse(name, text):
    """The line of each input. Another zlib may pack the same input into another line: the first in the order of lines counts."""
    if not text:
        raise Broken(f"{name}:1: no input")
    if not text.endswith(b"\n"):
        raise Broken(f"{name}:{text.count(bytes([10])) + 1}: the line is cut off")
    inputs = {}
    for number, line in enumerate(text[:-1].split(b"\n"), 1):
        try:
            data = decode(line)
        except ValueError as e:
            raise Broken(f"{name}:{number}: {e}") from None
        inputs[data] = min(line, inputs.get(data, line))
    return inputs


def read(archive):
    return parse(archive, archive.read_bytes())


def write(archive, inputs):
    """What is in the archive already keeps its line."""
    known = read(archive) if archive.exists() else {}
    lines = sorted({known.get(data) or encode(data) for data in inputs})
    text = b"".join(line + b"\n" for line in lines)
    parse(archive, text)  # what could not be read again is not written
    if archive.exists() and archive.read_bytes() == text:
        return
    part = archive.with_suffix(".part")
    try:
        part.write_bytes(text)
        part.replace(archive)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def name_of(data):
    return hashlib.sha1(data).hexdigest()


def files_of(*folders):
    return [file.read_bytes() for folder in folders for file in sorted(folder.rglob("*")) if file.is_file()]


def unpack(archive, folder):
    text = archive.read_bytes()
    mark = folder.with_name(folder.name + ".unpacked")
    if folder.is_dir() and mark.exists() and mark.read_bytes() == text:
        os.utime(mark)  # make and ninja look at its time
        return
    inputs = {name_of(data): data for data in parse(archive, text)}
    mark.unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    for file in folder.iterdir():
        if re.fullmatch("[0-9a-f]{40}", file.name) and file.name not in inputs:
            file.unlink()
    for name, data in inputs.items():
        (folder / name).write_bytes(data)
    mark.write_bytes(text)


def main(words):
    command, *paths = words or [""]
    paths = [pathlib.Path(p) for p in paths]
    if command == "pack" and len(paths) > 1:
        for folder in paths[1:]:
            if not folder.is_dir():
                return f"{folder}: no such folder"
        write(paths[0], files_of(*paths[1:]))
    elif command == "unpack" and len(paths) == 2:
        unpack(*paths)
    elif command == "check" and paths:
        for archive in paths:
            print(f"{archive}: {len(read(archive))} inputs")
    else:
        return __doc__
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (Broken, OSError) as e:
        sys.exit(str(e))
