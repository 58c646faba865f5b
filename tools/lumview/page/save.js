// Points as files that a browser saves: CSV and PLY, with the columns and units
// of lumdump. They have no timestamps, which are not on the page.
import { EYE_BIT, RISING_BIT } from "./frame.js";
import { labelValueOf, NO_LABEL } from "./colouring.js";
import { directionOf, eyeOf, returnOf } from "./filter.js";

const BLOCK = 20000; // points of a part of a file

// Name in CSV, decimals there (null: as many as it has); name and type in PLY; the value of p.
const COLUMNS = [
    ["x", 4, "x", "float", (p) => p.x],
    ["y", 4, "y", "float", (p) => p.y],
    ["z", 4, "z", "float", (p) => p.z],
    ["range", 4, "scalar_range", "float", (p) => p.range],
    ["azimuth", 5, "scalar_azimuth", "float", (p) => p.azimuth],
    ["elevation", 5, "scalar_elevation", "float", (p) => p.elevation],
    ["pulse_width", 3, "intensity", "float", ({ points, i }) => points.pulse[i] * 0.01],
    ["frame", 0, "scalar_frame", "int", (p) => p.frame],
    ["eye", 0, "scalar_eye", "uchar", ({ points, i }) => points.flags[i] & EYE_BIT],
    ["line", 0, "scalar_line", "int", ({ points, i }) => points.line[i]],
    ["pixel", 0, "scalar_pixel", "uint16", ({ points, i }) => points.pixel[i]],
    ["return_number", 0, "scalar_return_number", "uint16", ({ points, i }) => returnOf(points, i)],
    ["number_of_returns", 0, "scalar_number_of_returns", "uint16", ({ points, i }) => points.flags[i] >> 2],
    ["edge", 0, "scalar_edge", "uchar", ({ points, i }) => Number((points.flags[i] & RISING_BIT) !== 0)],
];
const SENSOR = ["sensor", 0, "scalar_sensor", "uchar", ({ points, i }) => points.sensor[i]];
const LABEL = ["label", null, "scalar_label", "double", ({ points, i }) => labelValueOf(points, i)]; // a number as the array has it
// What a column is of that frames of a program need not have: eyes name what they lack.
const OF = {
    range: "place", azimuth: "place", elevation: "place", eye: "eye", line: "line", pixel: "line",
    return_number: "return", number_of_returns: "return", edge: "edge",
};

// What is not known of a point is left out, rather than made up.
function columnsOf({ isRig, isLabelled }, eyes) {
    const lacks = new Set(eyes.flatMap((eye) => eye.lacks ?? []));
    return [...COLUMNS.filter(([name]) => !lacks.has(OF[name])), ...(isRig ? [SENSOR] : []), ...(isLabelled ? [LABEL] : [])];
}

const TYPES = {
    double: [8, (view, at, v) => view.setFloat64(at, v, true)],
    float: [4, (view, at, v) => view.setFloat32(at, v, true)],
    int: [4, (view, at, v) => view.setInt32(at, v, true)],
    uint16: [2, (view, at, v) => view.setUint16(at, v, true)],
    uchar: [1, (view, at, v) => view.setUint8(at, v)],
};

// Of a rig the number that its sensor's frame has.
const frameOf = (points, i, { number, parts }) => parts.find(({ sensor }) => sensor === points.sensor[i])?.number ?? number;

// each(see): calls see(points, i, slot) for all points; write: what becomes of one.
// The parts of the file, and how many points it has.
function collect(each, eyes, write, close) {
    const parts = [];
    let count = 0;
    each((points, i, slot) => {
        const placeIn = (xyz) => [xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]];
        const [x, y, z] = placeIn(points.xyz);
        const measured = placeIn(slot.isMoved ? slot.own : points.xyz); // by the sensor, where it was then
        write({ points, i, x, y, z, frame: frameOf(points, i, slot), ...directionOf(measured, eyeOf(points, i, eyes)) });
        count++;
        if (count % BLOCK === 0) {
            parts.push(close());
        }
    });
    return { parts: [...parts, close()], count };
}

// has: { isRig, isLabelled }
export function makeCsv({ each, eyes, has }) {
    const columns = columnsOf(has, eyes);
    let rows = [];
    const format = (v, decimals) => (decimals === null ? String(v) : v.toFixed(decimals));
    const write = (p) => rows.push(columns.map(([, decimals, , , value]) => format(value(p), decimals)).join(","));
    const close = () => {
        const text = rows.map((row) => `${row}\n`).join("");
        rows = [];
        return text;
    };
    const { parts } = collect(each, eyes, write, close);
    return [`${columns.map(([name]) => name).join(",")}\n`, ...parts];
}

// about: { program, source, frames, step, seenFrom }; step: metres that coordinates are rounded to, 0: they are not;
// seenFrom: the frame from which those of other frames are seen, by poses, null: each has its own.
function plyHead(columns, count, { program, source, frames, step, seenFrom }) {
    const rounded = step > 0 ? `coordinates are rounded to steps of ${(1000 * step).toPrecision(3)} mm` : "coordinates are not rounded";
    return [
        "ply", "format binary_little_endian 1.0", `comment ${program}`,
        "comment metres, degrees; intensity is the pulse width in ns, in steps of 0.01 ns, at most 655.35",
        ...(columns.includes(LABEL) ? [`comment a label of ${NO_LABEL}: the point has none`] : []),
        ...(seenFrom === null ? [] : [`comment x, y, z are as seen from frame ${seenFrom}; range and angles are as measured`]),
        `comment source: ${JSON.stringify(source)}`, `comment ${frames}`, `comment ${rounded}`, `element vertex ${count}`,
        ...columns.map(([, , name, type]) => `property ${type} ${name}`), "end_header", "",
    ].join("\n");
}

export function makePly({ each, eyes, has, about }) {
    const columns = columnsOf(has, eyes);
    const width = columns.reduce((sum, [, , , type]) => sum + TYPES[type][0], 0);
    const bytes = new DataView(new ArrayBuffer(BLOCK * width));
    let end = 0;
    const write = (p) => {
        for (const [, , , type, value] of columns) {
            TYPES[type][1](bytes, end, value(p));
            end += TYPES[type][0];
        }
    };
    const close = () => {
        const part = bytes.buffer.slice(0, end);
        end = 0;
        return part;
    };
    const { parts, count } = collect(each, eyes, write, close);
    return [plyHead(columns, count, about), ...parts];
}

// The browser saves parts of a file under a name.
export function save(parts, type, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(parts, { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
