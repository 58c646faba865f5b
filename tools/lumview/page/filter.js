// Which points are shown, for the processor: picking and counting. The shader
// in cloud.js decides alike.
import { EYE_BIT, RISING_BIT, STRONGEST_BIT } from "./frame.js";

// What a selection makes of a point.
export const CHOICES = Object.freeze({ plain: 0, selected: 1, out: 2 });

const DEGREES = 180 / Math.PI;

// Until it is known where they are.
export const NO_EYES = ["blue", "green"].map((name) => ({ name, mount: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1] }));

const orElse = (value, other) => (value === null ? other : value);

export function limits(values) {
    return {
        range: [orElse(values.rangeMin, 0), orElse(values.rangeMax, Infinity)],
        height: [orElse(values.heightMin, -Infinity), orElse(values.heightMax, Infinity)],
    };
}

// The eye of a point among those of all sensors.
export const eyeOf = (points, i, eyes) => eyes[2 * points.sensor[i] + (points.flags[i] & EYE_BIT)];

export function rangeOf(points, i, eyes) {
    const m = eyeOf(points, i, eyes).mount;
    return Math.hypot(points.xyz[3 * i] - m[0], points.xyz[3 * i + 1] - m[1], points.xyz[3 * i + 2] - m[2]);
}

// The direction in the eye's own axes: R transposed times (p - mount).
export function directionOf(position, { mount: m, rotation: r }) {
    const d = position.map((v, k) => v - m[k]);
    const [x, y, z] = [0, 1, 2].map((k) => r[k] * d[0] + r[3 + k] * d[1] + r[6 + k] * d[2]);
    const range = Math.hypot(x, y, z);
    return { range, azimuth: Math.atan2(y, x) * DEGREES, elevation: Math.asin(z / range) * DEGREES };
}

export const returnOf = (points, i) => points.turn[i] & ~STRONGEST_BIT;

// By choice, whether a point is among the returns that are shown.
const RETURNS = {
    all: () => true,
    last: (points, i) => returnOf(points, i) === points.flags[i] >> 2,
    strongest: (points, i) => points.turn[i] >= STRONGEST_BIT,
};

function returnFilter(wanted) {
    const number = Number(wanted);
    return RETURNS[wanted] ?? ((points, i) => returnOf(points, i) === number);
}

// A function (points, i) -> bool. points: arrays as of a frame.
export function makeFilter(values, eyes) {
    const { range, height } = limits(values);
    const eye = [values.blue, values.green];
    const isReturn = returnFilter(values.return);
    const clipsRange = values.rangeMin !== null || values.rangeMax !== null;
    return (points, i) => {
        const flags = points.flags[i];
        const z = points.xyz[3 * i + 2];
        if (points.chosen[i] === CHOICES.out || !eye[flags & EYE_BIT] || !isReturn(points, i)) {
            return false;
        }
        if (z < height[0] || z > height[1]) {
            return false;
        }
        if (!clipsRange) {
            return true;
        }
        const r = rangeOf(points, i, eyes);
        return r >= range[0] && r <= range[1];
    };
}

// How many points there are and how many are shown, by what one can choose.
export function count(slots, values, eyes) {
    const passes = makeFilter(values, eyes);
    const out = { total: 0, shown: 0, blue: 0, green: 0, rising: 0, falling: 0, returns: {} };
    for (const { points, size } of slots) {
        out.total += size;
        for (let i = 0; i < size; i++) {
            if (!passes(points, i)) {
                continue;
            }
            const flags = points.flags[i];
            out.shown++;
            out[flags & EYE_BIT ? "green" : "blue"]++;
            out[flags & RISING_BIT ? "rising" : "falling"]++;
            const turn = returnOf(points, i);
            out.returns[turn] = (out.returns[turn] ?? 0) + 1;
        }
    }
    return out;
}
