"""Reads a PNG of 8 bits a colour, without a library."""
import struct
import zlib


def chunks(data):
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG")
    at = 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if struct.unpack_from(">I", data, at + 8 + length)[0] != zlib.crc32(kind + body):
            raise ValueError(f"a chunk {kind} has a wrong sum")
        yield kind, body
        at += 12 + length


def size(data):
    """Width and height; raises where the file is no whole picture in RGB."""
    found = list(chunks(data))
    if found[0][0] != b"IHDR" or found[-1][0] != b"IEND":
        raise ValueError("no whole PNG")
    width, height, depth, colour = struct.unpack_from(">IIBB", found[0][1])
    if (depth, colour) != (8, 2):
        raise ValueError(f"{depth} bits of kind {colour}, not RGB")
    return width, height


def _paeth(a, b, c):
    pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
    return a if pa <= pb and pa <= pc else b if pb <= pc else c


def _unfilter(kind, line, above):
    if kind == 0:
        return line
    if kind == 2:
        return bytearray(a + b & 255 for a, b in zip(line, above))
    step = 3
    for i, value in enumerate(line):
        a = line[i - step] if i >= step else 0
        if kind == 1:
            line[i] = value + a & 255
            continue
        c = above[i - step] if i >= step else 0
        guess = (a + above[i]) // 2 if kind == 3 else _paeth(a, above[i], c)
        line[i] = value + guess & 255
    return line


def rows(data, end=None):
    """Rows from the top as bytes, red, green and blue of each pixel."""
    width, height = size(data)
    raw = zlib.decompress(b"".join(body for kind, body in chunks(data) if kind == b"IDAT"))
    stride = 1 + 3 * width
    above = bytearray(3 * width)
    out = []
    for y in range(min(height, end or height)):
        line = _unfilter(raw[y * stride], bytearray(raw[y * stride + 1:(y + 1) * stride]), above)
        out.append(bytes(line))
        above = line
    return out


def colours(row, first, end):
    """The pixels of a row from first to before end."""
    return [tuple(row[3 * x:3 * x + 3]) for x in range(first, end)]
