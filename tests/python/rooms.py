"""Rooms as a sensor of known calibration sees them: grids as lumsdk.calibrate makes of captures, in milliseconds."""
import numpy as np

TYPICAL = {"blue": {"offset_m": 0.0, "width": 60.0, "low": -17.0, "high": 3.0, "mount": (0, 0, 0, 0, 0, -30.0)},
           "green": {"offset_m": 0.0, "width": 60.0, "low": -17.0, "high": 3.0, "mount": (0, 0, 0, 0, 0, 30.0)}}

PICOSECONDS_A_METRE = 2 / 3.0e8 * 1e12

FIVE = ((0, 0, 0), (0, 0, 25), (12, 0, -25), (-12, 4, 50), (0, -8, -48))
"""Roll, pitch and yaw of captures."""


def rotation(roll, pitch, yaw):
    """Rz(yaw) Ry(pitch) Rx(roll), of degrees."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in np.radians([roll, pitch, yaw]))
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]])


def true_calibration(rng):
    """As far from the typical one as bar allows: mounts by 2 degrees and 5 cm, offsets by 200 ps, widths by 1 %."""
    made = {}
    for eye, usual in TYPICAL.items():
        half = 10.0 * (1 + rng.uniform(-0.01, 0.01))
        middle = -7.0
        off = np.zeros(6) if eye == "blue" else np.r_[rng.uniform(-0.05, 0.05, 3), rng.uniform(-2, 2, 3)]
        made[eye] = {"offset_m": rng.uniform(-0.03, 0.03), "width": 60.0 * (1 + rng.uniform(-0.01, 0.01)),
                     "low": middle - half, "high": middle + half, "mount": tuple(np.add(usual["mount"], off))}
    return made


def boxes(kind="room"):
    """The shapes of a scene: (centre, half sizes, rotation, whether seen from within)."""
    size, lift = ((8.0, 6.0, 3.0), 1.5) if kind == "room" else ((30.0, 20.0, 60.0), 30.0)
    made = [((0.6, -0.4, lift), np.array(size) / 2, np.eye(3), True)]
    for x, y, yaw, half in ((2.4, 1.2, 31, (0.35, 0.5, 0.6)), (2.0, -2.0, 17, (0.5, 0.3, 0.9)),
                            (-1.6, 1.6, 40, (0.4, 0.6, 0.5)), (-2.2, -1.8, -20, (0.3, 0.3, 1.5))):
        scale = 1.0 if kind == "room" else 2.5
        made.append(((x * scale, y * scale, half[2] * scale), np.array(half) * scale, rotation(0, 0, yaw), False))
    return made


class Walls:
    """What is wrong, by the laws of lumsim: faces with waves of rms metres (0.8 to 4 m long) and biases, each face with its own, and
    mirrors that read a sine of one period over the view."""

    WAVES = 6

    def __init__(self, rng, rms=0.0, bias=0.0):
        self.rng, self.rms, self.bias, self.faces, self.phases = rng, rms, bias, {}, {}

    def face(self, key):
        if key not in self.faces:
            n = self.WAVES
            long, turn = np.exp(self.rng.uniform(np.log(0.8), np.log(4.0), n)), self.rng.uniform(0, 2 * np.pi, n)
            self.faces[key] = (2 * np.pi / long * np.cos(turn), 2 * np.pi / long * np.sin(turn), self.rng.uniform(0, 2 * np.pi, n),
                               self.rms * np.sqrt(2 / n), self.bias * self.rng.normal())
        return self.faces[key]

    def height(self, key, s, t):
        ks, kt, phase, size, _ = self.face(key)
        return size * sum(np.sin(a * s + b * t + c) for a, b, c in zip(ks, kt, phase))

    def wrong(self, mirror, turn):
        """What an encoder errs, at -1 to 1 of its mirror's way, of a height of 1."""
        if mirror not in self.phases:
            self.phases[mirror] = self.rng.uniform(0, 2 * np.pi)
        return np.sin(np.pi * turn + self.phases[mirror])


def cast(shapes, walls, origin, directions):
    """The nearest range along each direction, with the faces' faults."""
    best = np.full(len(directions), np.inf)
    for number, (centre, half, turn, within) in enumerate(shapes):
        o, d = (origin - centre) @ turn, directions @ turn
        with np.errstate(divide="ignore", invalid="ignore"):
            near, far = (-half * np.sign(d) - o) / d, (half * np.sign(d) - o) / d
        enter, leave = near.max(1), far.min(1)
        hit = (leave > 0) if within else (enter < leave) & (enter > 0)
        t = np.where(hit, leave if within else enter, np.inf)
        axis = far.argmin(1) if within else near.argmax(1)
        nearer = t < best
        best[nearer] = t[nearer]
        for a in range(3):
            for side in (-1, 1):
                chosen = nearer & (axis == a) & ((np.sign(d[:, a]) == side) == within)
                if not chosen.any():
                    continue
                key = number, a, side
                p = np.delete(o + best[chosen, None] * d[chosen], a, 1)
                change = walls.height(key, p[:, 0], p[:, 1]) / np.abs(d[chosen, a]) + walls.face(key)[4]
                best[chosen] += change
    return best


def see(pose, true, rng, walls, shapes, lines=64, frames=20, noise=0.02, sine=0.0):
    """A grid of a sensor at x, y, z, roll, pitch, yaw; sine is the height of what its encoders err, in degrees."""
    from lumsdk.calibrate._planes import Grid

    grids = {name: np.full((2, lines, 1000), np.nan) for name in ("azimuth", "elevation", "range_m", "sigma_m")}
    world = rotation(*pose[3:])
    for e, eye in enumerate(("blue", "green")):
        c = true[eye]
        u = np.broadcast_to(np.linspace(-0.99, 0.99, 1000), (lines, 1000))
        v = np.broadcast_to(np.linspace(0.98, -0.98, lines)[:, None], (lines, 1000))
        wrong = [sine * walls.wrong((e, mirror), turn) if sine else 0.0 for mirror, turn in enumerate((u, v))]
        az = np.radians(u * c["width"] / 2 + wrong[0])
        el = np.radians((c["low"] + c["high"]) / 2 + v * (c["high"] - c["low"]) / 2 + wrong[1])
        d = np.stack((np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)), -1).reshape(-1, 3)
        turn = world @ rotation(*c["mount"][3:])
        origin = np.array(pose[:3]) + world @ np.array(c["mount"][:3])
        r = cast(shapes, walls, origin, d @ turn.T) - c["offset_m"]
        sigma = noise / np.sqrt(frames)
        degree = 0.005 / np.sqrt(frames)
        grids["range_m"][e] = (r + sigma * rng.normal(size=len(r))).reshape(lines, 1000)
        grids["sigma_m"][e] = sigma
        grids["azimuth"][e] = u + degree / 30 * rng.normal(size=u.shape)
        grids["elevation"][e] = v + degree / 10 * rng.normal(size=u.shape)
        grids["range_m"][e][grids["range_m"][e] > 60] = np.nan
    return Grid(name="room", frames=frames, count=np.where(np.isfinite(grids["range_m"]), frames, 0), is_span=True, **grids)


def captures(seed, true, poses=FIVE[:3], kind="room", rms=0.0, bias=0.0, sine=0.0, **options):
    """Grids of a room, the sensor turned between them."""
    rng = np.random.default_rng(seed)
    walls, shapes = Walls(rng, rms, bias), boxes(kind)
    made = []
    for roll, pitch, yaw in poses:
        at = np.r_[rng.uniform(-0.3, 0.3, 2), 1.2 + rng.uniform(-0.1, 0.1)]
        made.append(see((*at, roll + rng.uniform(-2, 2), pitch + rng.uniform(-2, 2), yaw + rng.uniform(-3, 3)),
                        true, rng, walls, shapes, sine=sine, **options))
    return made
