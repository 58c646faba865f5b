#!/usr/bin/env python3
"""read_back.py [--utc] [--rows] CSV FILE...: compare files of one capture, point by point and field by field.

Every FILE (.csv .ply .pcd .las .xyz) holds the points of CSV in another format. Each is read with libraries that
are not this project's: numpy, plyfile, pypcd4, laspy, and Open3D where it is installed. All points and all fields
have to agree, but for the rounding of the format. --utc: the files were written with UTC times. --rows: they are
organised clouds of one frame, and the CSV has a column time.
Prints a line for each disagreement and "N passed, N failed"; the exit status is 1 if any failed.
"""
import argparse
import pathlib
import sys

import numpy

FIELDS = (
    "x y z range azimuth elevation pulse_width timestamp frame eye line pixel return_number number_of_returns edge"
).split()
METRES, DEGREES, WIDTHS = ("x", "y", "z", "range"), ("azimuth", "elevation"), ("pulse_width",)
INTEGERS = FIELDS[7:]

# Half a unit in the last place of the CSV, and what float32 adds to that.
HALF = {name: 0.5e-4 for name in METRES} | {name: 0.5e-5 for name in DEGREES} | {name: 0.5e-3 for name in WIDTHS}
TIME_HALF = {"time": 0.5e-9}
FLOAT32 = 2.0**-24


def read_csv(path):
    """Integers stay integers: a UTC time in microseconds is more than a float64 prints."""
    with open(path, encoding="ascii") as file:
        header = file.readline().rstrip("\n").split(",")
    if header not in (FIELDS, [*FIELDS, "time"]):
        raise ValueError(f"the header is {header}")
    types = [(name, "i8" if name in INTEGERS else "f8") for name in header]
    table = numpy.loadtxt(path, delimiter=",", skiprows=1, dtype=types, ndmin=1)
    return {name: table[name] for name in header}


def read_xyz(path):
    table = numpy.loadtxt(path, ndmin=2).reshape(-1, 3)
    return {name: table[:, i] for i, name in enumerate("xyz")}


def renamed(columns):
    """Names as the CSV has them."""
    names = {name.removeprefix("scalar_"): name for name in columns}
    names["pulse_width"] = names.pop("intensity")
    return {plain: columns[name] for plain, name in names.items()}


def read_ply(path):
    from plyfile import PlyData

    vertex = PlyData.read(str(path))["vertex"].data
    return renamed({name: vertex[name] for name in vertex.dtype.names})


def read_pcd(path):
    from pypcd4 import PointCloud

    cloud = PointCloud.from_path(path)
    return renamed({name: cloud.pc_data[name] for name in cloud.fields})


def read_open3d(path):
    import open3d

    points = open3d.t.io.read_point_cloud(str(path)).point
    columns = {name: points[name].numpy().ravel() for name in points if name != "positions"}
    columns |= {name: points.positions.numpy()[:, i] for i, name in enumerate("xyz")}
    return renamed(columns)


def in_rows(columns):
    """The points of an organised cloud, if they are where they belong."""
    at = numpy.nonzero(~numpy.isnan(columns["x"]))[0]
    lines = len(columns["x"]) // 2000
    place = (columns["eye"].astype("i8") * lines + columns["line"]) * 1000 + columns["pixel"]
    if lines == 0 or (place != numpy.arange(lines * 2000)).any():
        raise ValueError("a pixel is not in its place")
    return {name: column[at] for name, column in columns.items()}


def las_microseconds(las, utc):
    """Microseconds since 1970 UTC, or of the sensor's clock."""
    if bool(las.header.global_encoding.gps_time_type) != utc:
        raise ValueError("the header gives the wrong kind of GPS time")
    microseconds = numpy.rint(numpy.asarray(las.gps_time) * 1e6).astype("i8")
    # GPS time began on 1980-01-06, is 18 s ahead of UTC, and is stored less 1e9 s.
    return microseconds + (315964800 + 10**9 - 18) * 10**6 if utc else microseconds


def check_las_itself(las):
    """What a LAS file says twice has to agree."""
    clipped = numpy.minimum(las.full_return_number, 15)
    counts = numpy.bincount(numpy.maximum(clipped, 1), minlength=16)[1:16]
    width = numpy.minimum(numpy.floor(numpy.asarray(las.pulse_width, "f8") * 100 + 0.5), 65535)
    facts = {
        "number of points": las.header.point_count == len(las.points),
        "points by return": list(las.header.number_of_points_by_return) == list(counts),
        "return numbers": (las.return_number == clipped).all(),
        "numbers of returns": (las.number_of_returns == numpy.minimum(las.full_number_of_returns, 15)).all(),
        "intensity": (las.intensity == width).all(),
        "scanner channel": (las.scanner_channel == las.eye).all(),
        "scan angle": (abs(las.scan_angle * 0.006 - numpy.asarray(las.azimuth, "f8")) < 0.00301).all(),
    }
    if len(las.points):
        facts["least"] = numpy.allclose(las.header.mins, las.xyz.min(axis=0), rtol=0, atol=1e-9)
        facts["greatest"] = numpy.allclose(las.header.maxs, las.xyz.max(axis=0), rtol=0, atol=1e-9)
    wrong = [name for name, fine in facts.items() if not fine]
    if wrong:
        raise ValueError(f"the header or the fields contradict each other: {', '.join(wrong)}")


def read_las(path, utc):
    import laspy

    las = laspy.read(path)
    if (str(las.header.version), las.header.point_format.id) != ("1.4", 6):
        raise ValueError(f"is version {las.header.version}, point format {las.header.point_format.id}")
    check_las_itself(las)
    columns = {name: numpy.asarray(las[name]) for name in FIELDS if name not in ("timestamp", *FIELDS[12:14])}
    columns["timestamp"] = las_microseconds(las, utc)
    columns["return_number"] = numpy.asarray(las.full_return_number)
    columns["number_of_returns"] = numpy.asarray(las.full_number_of_returns)
    return columns


def disagreement(name, want, got):
    """The first point whose field differs, in words, or None."""
    if len(got) != len(want):
        return f"{len(got)} points, want {len(want)}"
    if name in INTEGERS:
        differs = numpy.asarray(got) != want
    else:
        got = numpy.asarray(got, "f8")
        # LAS and text round on their own: two roundings may lie one unit apart.
        allowed = 2.02 * (HALF | TIME_HALF)[name] + FLOAT32 * abs(want)
        differs = ~(abs(got - want) <= allowed)
    if not differs.any():
        return None
    at = int(numpy.argmax(differs))
    return f"{name} of point {at} is {got[at]}, want {want[at]} ({int(differs.sum())} differ)"


def compare(want, got, fields):
    if sorted(got) != sorted(fields):
        return f"has the fields {sorted(got)}, want {sorted(fields)}"
    return next(filter(None, (disagreement(name, want[name], got[name]) for name in fields)), None)


def readers(path, utc, points):
    """What reads a file, by name: (reader, fields)."""
    ending = path.suffix.lower()
    if ending == ".xyz":
        return {"numpy": (read_xyz, "xyz")}
    if ending == ".las":
        return {"laspy": (lambda name: read_las(name, utc), FIELDS)}
    known = {".csv": ("numpy", read_csv), ".ply": ("plyfile", read_ply), ".pcd": ("pypcd4", read_pcd)}
    if ending not in known:
        raise SystemExit(f"{path}: the ending is none of .csv .ply .pcd .las .xyz")
    name, reader = known[ending]
    found = {name: (reader, FIELDS)}
    # Open3D takes no PCD without points.
    if ending != ".csv" and (points or ending != ".pcd") and has_open3d():
        found["open3d"] = (read_open3d, FIELDS)
    return found


def rows_only(found, want):
    """As readers() tells, for organised clouds; sorts the CSV's points as their rows are."""
    order = numpy.lexsort((want["pixel"], want["line"], want["eye"]))
    want.update({name: column[order] for name, column in want.items()})
    return {name: (lambda path, read=read: in_rows(read(path)), list(want)) for name, (read, _) in found.items()}


def has_open3d():
    try:
        import open3d  # noqa: F401
    except ImportError as error:
        print(f"open3d is left out: {error}")
        return False
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--utc", action="store_true", help="times are microseconds since 1970 UTC")
    parser.add_argument("--rows", action="store_true", help="the files are organised")
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("files", type=pathlib.Path, nargs="+")
    arguments = parser.parse_args()
    want = read_csv(arguments.csv)
    passed = failed = 0
    for path in arguments.files:
        found = readers(path, arguments.utc, len(want["x"]))
        for name, (reader, fields) in (rows_only(found, want) if arguments.rows else found).items():
            try:
                why = compare(want, reader(path), list(fields))
            except Exception as error:  # whatever a reader makes of a bad file
                why = f"{type(error).__name__}: {error}"
            passed, failed = passed + (not why), failed + bool(why)
            print(f"FAIL {path} with {name}: {why}" if why else f"ok   {path} with {name}: {len(want['x'])} points")
    print(f"{passed} passed, {failed} failed")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
