"""lumdump --preset and --check-preset: the fields that programs expect which read clouds, in each format alike."""
import math
import struct
import unittest

import shards
from mcap_file import File, cdr
from support import Folder, read_csv, run, simulate

PLAIN = ("--compression", "none")
TYPES = {2: "B", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
PCD_TYPES = {("U", "1"): "B", ("U", "2"): "H", ("I", "4"): "i", ("U", "4"): "I", ("F", "4"): "f", ("F", "8"): "d"}
PLY_TYPES = {"uchar": "B", "uint16": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
WIDTH_MAX_NS = 25.5

# As the consumers' own sources have them (docs/consumers.md): names with types as struct has them.
FIELDS = {
    "autoware": "x:f y:f z:f intensity:B return_type:B channel:H azimuth:f elevation:f distance:f time_stamp:I",
    "lio-sam": "x:f y:f z:f intensity:f ring:H time:f",
    "fast-lio": "x:f y:f z:f intensity:f time:f ring:H",
    "kitti": "x:f y:f z:f intensity:f",
    "argoverse2": "x:f y:f z:f intensity:B laser_number:B offset_ns:i",
    "pdal": "x:f y:f z:f Intensity:H ReturnNumber:B NumberOfReturns:B ScanChannel:B GpsTime:d",
}


def rows_of(fields, data):
    return [dict(zip(fields, row)) for row in struct.Struct("<" + "".join(fields.values())).iter_unpack(data)]


def read_pcd(path):
    header, data = path.read_bytes().split(b"DATA binary\n", 1)
    lines = dict(line.split(" ", 1) for line in header.decode().splitlines() if line[0] != "#")
    types = zip(lines["TYPE"].split(), lines["SIZE"].split())
    return rows_of(dict(zip(lines["FIELDS"].split(), map(PCD_TYPES.get, types))), data)


def read_ply(path):
    header, data = path.read_bytes().split(b"end_header\n", 1)
    words = [line.split() for line in header.decode().splitlines()]
    return rows_of({w[2]: PLY_TYPES[w[1]] for w in words if w[0] == "property"}, data)


def read_mcap(path):
    """Each cloud: its stamp and its points."""
    clouds = []
    for message in File(path.read_bytes()).of("/points"):
        b = cdr(message)
        stamp_ns = b.number(4) * 10**9 + b.number(4)
        b.text(), b.number(4)
        width, fields, offset = b.number(4), {}, 0
        for _ in range(b.number(4)):
            name = b.text()
            if b.number(4) != offset:
                raise ValueError(f"a gap before {name}")
            fields[name] = TYPES[b.number(1)]
            offset += struct.calcsize("<" + fields[name])
            b.number(4)
        b.number(1)
        if (b.number(4), b.number(4)) != (offset, offset * width):
            raise ValueError("the steps")
        clouds.append((stamp_ns, rows_of(fields, b.take(b.number(4)))))
    return clouds


def return_type(number, count):
    if count == 1:
        return 6
    return 2 if number == 1 else 1 if number == count else 7 if number == 2 else 0


def whole(value, highest):
    return min(math.floor(value + 0.5), highest)


def wanted(p):
    """All values that some preset has, of a point of the default columns."""
    x, y, z, width = p["x"], p["y"], p["z"], p["intensity"]
    ring = 2 * p["line"] + p["eye"]
    number, count = p["return_number"], p["number_of_returns"]
    return {
        "x": x, "y": y, "z": z, "return_type": return_type(number, count),
        "channel": ring, "ring": ring, "laser_number": min(ring, 255), "ReturnNumber": number,
        "NumberOfReturns": count, "ScanChannel": p["eye"], "GpsTime": p["timestamp"] * 1e-6,
        "Intensity": whole(100 * width, 65535), "azimuth": math.atan2(y, x),
        "elevation": math.atan2(z, math.hypot(x, y)), "distance": math.sqrt(x * x + y * y + z * z),
        "time": p["time"], "time_stamp": p["time"] * 1e9, "offset_ns": p["time"] * 1e9,
    }


def intensity(preset, width):
    if preset in ("autoware", "argoverse2"):
        return whole(255 * width / WIDTH_MAX_NS, 255)
    return min(width / WIDTH_MAX_NS, 1) if preset == "kitti" else width


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def dump(self, *arguments, status=0):
        r = run("lumdump", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        return r

    def street(self, *arguments):
        return simulate(self.folder / "street.pcap", "--frames", "2", "--seed", "5", "--loss", "0.01", *arguments)

    def cloud(self, source, *arguments):
        """Of a tenth of the points, which are as different as all are."""
        return self.dump(source, "--range", "10:12", *arguments)

    def points(self, source):
        columns = ("x,y,z,pulse_width,timestamp,frame,eye,line,pixel,return_number,number_of_returns,time")
        self.cloud(source, "--columns", columns, "-o", self.folder / "all.pcd")
        return read_pcd(self.folder / "all.pcd")

    def assert_same(self, preset, got, points):
        self.assertEqual(len(got), len(points))
        for row, point in zip(got, points):
            want = wanted(point) | {"intensity": intensity(preset, point["intensity"])}
            for name, value in row.items():
                # A time of a float, in ns, is between two whole numbers.
                delta = 1 if name in ("time_stamp", "offset_ns") else abs(want[name]) * 1e-6 + 1e-9
                if abs(value - want[name]) > delta:
                    self.fail(f"{preset}: {name} is {value}, want {want[name]} of {point}")


class Files(Case):
    def test_fields_and_values_of_pcd(self):
        source = self.street()
        points = self.points(source)
        for preset, fields in FIELDS.items():
            self.cloud(source, "--preset", preset, "-o", self.folder / "a.pcd")
            got = read_pcd(self.folder / "a.pcd")
            self.assertEqual(list(got[0]), [f.split(":")[0] for f in fields.split()])
            self.assert_same(preset, got, points)

    def test_types_in_every_header(self):
        source = self.street()
        for preset, fields in FIELDS.items():
            names = [self.folder / f"a.{ending}" for ending in ("pcd", "ply", "csv", "mcap")]
            self.cloud(source, "--preset", preset, *PLAIN, *(w for name in names for w in ("-o", name)))
            header = names[0].read_bytes().split(b"DATA", 1)[0].decode()
            lines = dict(line.split(" ", 1) for line in header.splitlines() if line[0] != "#")
            types = [PCD_TYPES[t] for t in zip(lines["TYPE"].split(), lines["SIZE"].split())]
            self.assertEqual([f"{n}:{t}" for n, t in zip(lines["FIELDS"].split(), types)], fields.split())
            words = [w.split() for w in names[1].read_bytes().split(b"end_header", 1)[0].decode().splitlines()]
            self.assertEqual([f"{w[2]}:{PLY_TYPES[w[1]]}" for w in words if w[0] == "property"], fields.split())
            self.assertEqual(list(read_csv(names[2])[0]), [f.split(":")[0] for f in fields.split()])
            for _, rows in read_mcap(names[3]):
                self.assertEqual(list(rows[0]), [f.split(":")[0] for f in fields.split()])

    def test_ply_has_the_rows_of_pcd_and_csv_their_text(self):
        source = self.street()
        for preset in FIELDS:
            names = [self.folder / f"a.{ending}" for ending in ("pcd", "ply", "csv")]
            self.cloud(source, "--preset", preset, *(w for name in names for w in ("-o", name)))
            pcd = read_pcd(names[0])
            self.assertEqual(read_ply(names[1]), pcd)
            for row, text in zip(pcd, read_csv(names[2]), strict=True):
                for name, value in row.items():
                    self.assertAlmostEqual(float(text[name]), value, delta=6e-4 if name == "intensity" else 6e-5)

    def test_the_body_of_a_kitti_pcd_is_a_bin(self):
        source = self.street()
        self.cloud(source, "--preset", "kitti", "-o", self.folder / "a.pcd")
        body = (self.folder / "a.pcd").read_bytes().split(b"DATA binary\n", 1)[1]
        values = [struct.unpack_from("<4f", body, 16 * i) for i in range(len(body) // 16)]
        points = self.points(source)
        self.assertEqual(len(body), 16 * len(points))
        self.assertEqual([v[:3] for v in values], [(p["x"], p["y"], p["z"]) for p in points])

    def test_rows_of_pixels(self):
        self.dump(self.street(), "--preset", "autoware", "--organized", "--return", "last", "--range", "2:20", "--frames", "1:1", "-o",
                  self.folder / "a.pcd")
        rows = read_pcd(self.folder / "a.pcd")
        missing = [r for r in rows if math.isnan(r["x"])]
        self.assertEqual(len(rows) % 1000, 0)
        self.assertTrue(0 < len(missing) < len(rows))
        self.assertEqual({(r["intensity"], r["time_stamp"]) for r in missing}, {(0, 0)})


class Messages(Case):
    def test_they_are_the_points_of_messages_without_preset(self):
        source = self.street()
        self.cloud(source, "-o", self.folder / "a.mcap", *PLAIN)
        default = File((self.folder / "a.mcap").read_bytes()).clouds()
        for preset in FIELDS:
            self.cloud(source, "--preset", preset, "-o", self.folder / "b.mcap", *PLAIN)
            clouds = read_mcap(self.folder / "b.mcap")
            self.assertEqual([c.stamp_ns for c in default], [stamp for stamp, _ in clouds])
            for cloud, (_, rows) in zip(default, clouds):
                self.assertEqual([(p.x, p.y, p.z) for p in cloud.points], [tuple(r.values())[:3] for r in rows])
                for key, scale in (("time", 1), ("time_stamp", 1e9), ("offset_ns", 1e9)):
                    for p, r in zip(cloud.points, rows):
                        if key in r and abs(r[key] - p.time * scale) > 1e-9 * scale:
                            self.fail(f"{preset}: {key} {r[key]}, want {p.time}")

    def test_they_have_the_values_of_files(self):
        source = self.street()
        for preset in FIELDS:
            self.cloud(source, "--preset", preset, "-o", self.folder / "a.mcap", "-o", self.folder / "a.pcd", *PLAIN)
            times = ("time", "time_stamp", "offset_ns")
            drop = lambda rows: sorted(tuple(v for k, v in r.items() if k not in times) for r in rows)
            clouds = read_mcap(self.folder / "a.mcap")
            self.assertEqual(drop(r for _, rows in clouds for r in rows), drop(read_pcd(self.folder / "a.pcd")))


class Check(Case):
    def check(self, preset, name, status):
        return self.dump("--check-preset", preset, name, status=status).stdout

    def test_what_a_preset_wrote_has_all_of_it(self):
        source = self.street()
        for preset in FIELDS:
            for ending in ("pcd", "ply", "csv", "mcap"):
                name = self.folder / f"a.{ending}"
                self.dump(source, "--preset", preset, "-o", name)
                self.assertIn(f"{preset} can read it.", self.check(preset, name, 0))

    def test_what_is_missing_and_what_differs(self):
        self.dump(self.street(), "-o", self.folder / "a.pcd")
        rows = [line.split(None, 3) for line in self.check("autoware", self.folder / "a.pcd", 1).splitlines()]
        self.assertEqual(rows[0], ["field", "wanted", "found", "difference"])
        self.assertIn(["intensity", "u8", "f32", "another type"], rows)
        self.assertIn(["time_stamp", "u32", "-", "missing"], rows)
        self.assertIn(["azimuth", "f32", "f32", "at byte 20, wanted at 16"], rows)
        self.assertIn(["x", "f32", "f32", "none"], rows)

    def test_order_matters_only_where_the_consumer_finds_fields_by_place(self):
        self.dump(self.street(), "--preset", "fast-lio", "-o", self.folder / "a.mcap")
        self.assertIn("lio-sam can read it.", self.check("lio-sam", self.folder / "a.mcap", 0))
        self.dump(self.street(), "--columns", "y,x,z,pulse_width", "-o", self.folder / "a.ply")
        rows = [line.split(None, 3) for line in self.check("kitti", self.folder / "a.ply", 1).splitlines()]
        self.assertIn(["x", "f32", "f32", "in another place"], rows)
        self.assertIn(["z", "f32", "f32", "none"], rows)

    def test_packets_stand_for_the_messages_that_are_made_of_them(self):
        source = self.street()
        self.assertIn("is packets", self.check("lio-sam", source, 0))
        self.check("fast-lio", "udp://10.42.0.37", 0)
        self.check("autoware", source, 1)

    def test_what_is_no_cloud(self):
        for name, data in (("a.pcd", "VERSION 0.7\n"), ("a.ply", "ply\n"), ("a.csv", ""), ("a.mcap", "no"),
                           ("b.mcap", b"\x89MCAP0\r\n" + b"\6" + b"\xff" * 30)):
            path = self.folder.write(name, data)
            r = self.dump("--check-preset", "kitti", path, status=2)
            self.assertIn("no fields of a point are found", r.stderr)
        r = self.dump("--check-preset", "kitti", self.folder.write("a.las", ""), status=2)
        self.assertIn("fields are looked for in .pcd, .ply, .csv and .mcap", r.stderr)

    def test_an_mcap_file_that_is_cut_anywhere_gives_fields_or_an_error(self):
        self.dump(self.street(), "--preset", "lio-sam", "-o", self.folder / "a.mcap")
        data = (self.folder / "a.mcap").read_bytes()
        self.dump(self.street(), "--preset", "lio-sam", "-o", self.folder / "c.mcap", *PLAIN)
        self.check("lio-sam", self.folder / "c.mcap", 0)
        for n in [*range(0, 6000, 157), len(data) - 1]:
            r = run("lumdump", "--check-preset", "lio-sam", self.folder.write("b.mcap", data[:n]))
            self.assertIn(r.returncode, (0, 2), (n, r.stderr))


class Refused(Case):
    def test_names_and_options_that_do_not_go_together(self):
        for arguments, why in (
                (("--preset", "auto", "-o", "a.pcd"), "'auto' is not a preset; presets are autoware, lio-sam"),
                (("--preset", "kitti"), "--preset goes with csv, ply, pcd and mcap output only"),
                (("--preset", "kitti", "-o", "a.las"), "--preset goes with csv, ply, pcd and mcap output only"),
                (("--preset", "kitti", "--columns", "x", "-o", "a.pcd"), "both choose the columns"),
                (("--check-preset", "kitti", "--json"), "--json does not go with --check-preset"),
                (("--check-preset", "kitti", "b.pcd"), "name one FILE")):
            r = self.dump("a.pcap", *arguments, status=2)
            self.assertIn(why, r.stderr)


if __name__ == "__main__":
    shards.main()
