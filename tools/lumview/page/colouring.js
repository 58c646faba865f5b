// What colours mean: for each choice its number in the shader, unit, and the
// values that the two ends of the map stand for.
import { rangeOf } from "./filter.js";

const SAMPLES = 4000; // enough for a percentile

const pulseOf = (points, i) => points.pulse[i] * 0.01;

export const COLOURINGS = {
    range: { mode: 0, unit: "m", title: "Range", value: rangeOf, logarithmic: true },
    height: { mode: 1, unit: "m", title: "Height", value: (points, i) => points.xyz[3 * i + 2] },
    pulse: { mode: 2, unit: "ns", title: "Pulse width", value: pulseOf, skipsZero: true },
    return: { mode: 3, unit: "", title: "Return", fixed: [1, 4], labels: ["1", "2", "3", "4 and up"] },
    line: { mode: 4, unit: "", title: "Line", value: (points, i) => points.line[i], whole: true },
    eye: { mode: 5, unit: "", title: "Eye", fixed: [0, 1], labels: ["blue", "green"] },
};

function sampled(colouring, { points, size }, eyes) {
    const step = Math.max(1, Math.floor(size / SAMPLES));
    const values = [];
    for (let i = 0; i < size; i += step) {
        const v = colouring.value(points, i, eyes);
        if (v !== 0 || !colouring.skipsZero) {
            values.push(v);
        }
    }
    return Float64Array.from(values).sort();
}

// Two digits are enough, and keep the colours still from frame to frame.
const rounded = (value) => Number(value.toPrecision(2));

function ends(colouring, slot, eyes) {
    const values = sampled(colouring, slot, eyes);
    if (values.length === 0) {
        return null;
    }
    if (colouring.whole) {
        return [0, Math.max(1, values.at(-1))];
    }
    const at = (share) => values[Math.floor(share * (values.length - 1))];
    return [rounded(at(0.02)), rounded(at(0.98))];
}

const isNear = (a, b) => a.every((v, i) => Math.abs(v - b[i]) <= 0.15 * Math.abs(b[1] - b[0]));

// The ends of the colours; before is kept while the points differ little from
// those that it was made of, and where there are none.
export function domainOf(values, slot, eyes, before) {
    const colouring = COLOURINGS[values.colour];
    if (colouring.fixed) {
        return colouring.fixed;
    }
    const found = slot && ends(colouring, slot, eyes);
    if (!found) {
        return before ?? [1, 100];
    }
    return before && isNear(found, before) ? before : found;
}

// The user's ends before those of the points; never empty.
export function chosenDomain(values, automatic) {
    const colouring = COLOURINGS[values.colour];
    if (colouring.fixed) {
        return colouring.fixed;
    }
    let [a, b] = [values.from ?? automatic[0], values.to ?? automatic[1]];
    if (colouring.logarithmic) {
        a = Math.max(a, 0.1);
    }
    return [a, b > a ? b : a + (colouring.logarithmic ? a : 1) * 0.1];
}
