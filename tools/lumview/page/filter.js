// Which points are shown, for the processor: picking and counting. The shader
// in cloud.js decides alike.
import { EYE_BIT, RISING_BIT } from "./frame.js";

const orElse = (value, other) => (value === null ? other : value);

export function limits(values) {
    return {
        range: [orElse(values.rangeMin, 0), orElse(values.rangeMax, Infinity)],
        height: [orElse(values.heightMin, -Infinity), orElse(values.heightMax, Infinity)],
    };
}

export function rangeOf(points, i, eyes) {
    const m = eyes[points.flags[i] & EYE_BIT].mount;
    return Math.hypot(points.xyz[3 * i] - m[0], points.xyz[3 * i + 1] - m[1], points.xyz[3 * i + 2] - m[2]);
}

function passesReturn(wanted, turn, flags) {
    if (wanted === "all") {
        return true;
    }
    return turn === (wanted === "last" ? flags >> 2 : Number(wanted));
}

// A function (points, i) -> bool. points: arrays as of a frame.
export function makeFilter(values, eyes) {
    const { range, height } = limits(values);
    const eye = [values.blue, values.green];
    const clipsRange = values.rangeMin !== null || values.rangeMax !== null;
    return (points, i) => {
        const flags = points.flags[i];
        const z = points.xyz[3 * i + 2];
        if (!eye[flags & EYE_BIT] || !passesReturn(values.return, points.turn[i], flags)) {
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
            out.returns[points.turn[i]] = (out.returns[points.turn[i]] ?? 0) + 1;
        }
    }
    return out;
}
