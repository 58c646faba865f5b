// What colours mean: for each choice its number in the shader, unit, and the
// values that the two ends of the map stand for.
import { rangeOf, returnOf } from "./filter.js";
import { EYE_BIT } from "./frame.js";
import { EYES, LABELS, SENSORS, STEPS, UNKNOWN } from "./palette.js";

const SAMPLES = 4000; // enough for a percentile

const pulseOf = (points, i) => points.pulse[i] * 0.01;

export const COLOURINGS = {
    range: { mode: 0, unit: "m", title: "Range", value: rangeOf, logarithmic: true },
    height: { mode: 1, unit: "m", title: "Height", value: (points, i) => points.xyz[3 * i + 2] },
    pulse: { mode: 2, unit: "ns", title: "Pulse width", value: pulseOf, skipsZero: true },
    return: { mode: 3, unit: "", title: "Return", value: returnOf, fixed: [1, 4], labels: ["1", "2", "3", "4 and up"] },
    line: { mode: 4, unit: "", title: "Line", value: (points, i) => points.line[i], whole: true },
    eye: { mode: 5, unit: "", title: "Eye", value: (points, i) => points.flags[i] & EYE_BIT, fixed: [0, 1], labels: ["blue", "green"], colours: [EYES.blue, EYES.green] },
    sensor: { mode: 6, unit: "", title: "Sensor", value: (points, i) => points.sensor[i], fixed: [0, 1], labels: ["all"], colours: SENSORS },
    label: { mode: 7, unit: "", title: "Label", value: (points, i) => points.label[i], fixed: [0, 1], labels: ["none"], colours: LABELS, skipsZero: true, fromOne: 1 },
};

// The sensors of a rig, by their places in it.
export function nameSensors(names) {
    COLOURINGS.sensor.labels = names;
    COLOURINGS.sensor.fixed = [0, names.length];
}

export const NO_LABEL = -1; // in files

// The labels of points, from the first on, and their values in the array; colours repeat.
export function nameLabels(names, values) {
    COLOURINGS.label.labels = names;
    COLOURINGS.label.values = values;
    COLOURINGS.label.fixed = [0, names.length];
}

export const labelValueOf = (points, i) => COLOURINGS.label.values[points.label[i] - 1] ?? NO_LABEL;

// null: it has none.
export const labelOf = (points, i) => (points.label[i] > 0 ? COLOURINGS.label.labels[points.label[i] - 1] : null);

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

// The ends lie on steps: frames that differ little have the same ones, whatever
// was shown before. On a logarithmic scale there are five steps a decade, else
// eight to twenty in what the values span.
const DECADE = [1, 1.6, 2.5, 4, 6.3, 10];

function logarithmicEnds(least, most) {
    const scale = (value) => 10 ** Math.floor(Math.log10(value));
    const [low, high] = [scale(least), scale(most)];
    const below = DECADE.findLast((step) => step * low <= least);
    const above = DECADE.find((step) => step * high >= most);
    return [below * low, above * high].map((value) => Number(value.toPrecision(3)));
}

function linearEnds(least, most) {
    const raw = (most - least) / 20 || 0.1;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const step = unit * [1, 2, 5, 10].find((k) => k * unit >= raw);
    return [Math.floor(least / step), Math.ceil(most / step)].map((n) => Number((n * step).toPrecision(6)));
}

export const SMALLEST = 0.1; // on a logarithmic scale, metres

function ends(colouring, slot, eyes) {
    const values = sampled(colouring, slot, eyes);
    if (values.length === 0) {
        return null;
    }
    if (colouring.whole) {
        return [0, Math.max(1, values.at(-1))];
    }
    const at = (share) => values[Math.floor(share * (values.length - 1))];
    return colouring.logarithmic
        ? logarithmicEnds(Math.max(SMALLEST, at(0.02)), Math.max(SMALLEST, at(0.98)))
        : linearEnds(at(0.02), at(0.98));
}

// The ends of the colours: of the newest frame that has any. Nothing but what
// is shown and the settings decides, so the same picture has the same colours.
export function domainOf(values, slots, eyes) {
    const colouring = COLOURINGS[values.colour];
    if (colouring.fixed) {
        return colouring.fixed;
    }
    for (const slot of slots.toReversed()) {
        const found = ends(colouring, slot, eyes);
        if (found) {
            return found;
        }
    }
    return [1, 100];
}

// The user's ends before those of the points; never empty.
export function chosenDomain(values, automatic) {
    const colouring = COLOURINGS[values.colour];
    if (colouring.fixed) {
        return colouring.fixed;
    }
    let [a, b] = [values.from ?? automatic[0], values.to ?? automatic[1]];
    if (colouring.logarithmic) {
        a = Math.max(a, SMALLEST);
    }
    return [a, b > a ? b : a + (colouring.logarithmic ? a : 1) * 0.1];
}

// The colour of a point as the shader in cloud.js makes it: (points, i, out) writes three bytes. bytes: those of the map.
export function makeTint(values, [a, b], bytes, eyes) {
    const { value, logarithmic, colours, skipsZero, fromOne } = COLOURINGS[values.colour];
    const share = logarithmic ? (v) => Math.log(Math.max(v, 1e-3) / a) / Math.log(b / a) : (v) => (v - a) / (b - a);
    const own = colours?.map((colour) => colour.map((part) => Math.round(255 * part)));
    const unknown = UNKNOWN.map((part) => Math.round(255 * part));
    const put = (from, at, out) => {
        [out[0], out[1], out[2]] = [from[at], from[at + 1], from[at + 2]];
    };
    return (points, i, out) => {
        const v = value(points, i, eyes);
        if (v === 0 && skipsZero) {
            put(unknown, 0, out);
        } else if (own) {
            put(own[(v - (fromOne ?? 0)) % own.length], 0, out);
        } else {
            put(bytes, 4 * Math.round((STEPS - 1) * Math.max(0, Math.min(1, share(v)))), out);
        }
    };
}
