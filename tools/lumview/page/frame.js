// Binary messages as frames. The layout is that of include/lum/frame/packed.h: a frame comes in pieces of whole lines.

import { makeMoment } from "./moment.js";

const MAGIC = 0x464d554c;
const VERSION = 5;
const HEAD_BYTES = 104;
const PART_BYTES = 16;
const RUN_BYTES = 32;
const EDGES = [null, "rising", "falling", "both"];
const WRITTEN_OUT = 3; // the kind of a point that is none of its run's

// A frame that takes longer is shown before it is whole: when an eighth, a quarter and a half have come. More pictures of
// it would keep a slow computer from taking what comes.
const WHOLE_MS = 250;
const FIRST_SHARE = 1 / 8;

export const EYE_BIT = 1;
export const RISING_BIT = 2;
export const STRONGEST_BIT = 128; // of the return number

// Of each point: the type of its numbers, and how many there are.
const ARRAYS = {
    xyz: [Float32Array, 3],
    pulse: [Uint16Array, 1],
    line: [Uint16Array, 1],
    pixel: [Uint16Array, 1],
    turn: [Uint8Array, 1], // return number, and whether it is the strongest
    flags: [Uint8Array, 1],
};

// Edges and smoothing, as the server is asked for them.
export const viewOf = ({ edges, smooth }) => `${edges} ${smooth}`;

function checkHead(head) {
    if (head.byteLength < HEAD_BYTES || head.getUint32(0, true) !== MAGIC) {
        throw new Error("a message of lumview is not a frame");
    }
    const version = head.getUint16(4, true);
    if (version !== VERSION || head.getUint16(6, true) !== HEAD_BYTES) {
        throw new Error(`frames of version ${version}; this page knows ${VERSION}: reload it`);
    }
    const bytes = head.getUint32(80, true);
    if (bytes < HEAD_BYTES || bytes > head.byteLength) {
        throw new Error("a message of lumview is cut short");
    }
}

// The sensors of a rig whose frames these are, with the first of their points; none without a rig.
function partsOf(head) {
    let first = 0;
    return Array.from({ length: head.getUint8(39) }, (_, i) => {
        const at = HEAD_BYTES + PART_BYTES * i;
        const part = { number: head.getFloat64(at, true), first, sensor: head.getUint32(at + 12, true) };
        first += head.getUint32(at + 8, true);
        return part;
    });
}

const POINT_BYTES = Object.values(ARRAYS).reduce((sum, [Type, width]) => sum + width * Type.BYTES_PER_ELEMENT, 0);
const SPARES = 2;
const spares = []; // buffers of frames that nobody has any more, as a collector lets hundreds of megabytes lie about

function takeBuffer(size) {
    const at = spares.findIndex(({ byteLength }) => byteLength >= size && byteLength <= 2 * size);
    const [buffer] = at < 0 ? [new ArrayBuffer(size)] : spares.splice(at, 1);
    new Uint8Array(buffer).fill(0);
    return buffer;
}

// One behind the other in a buffer, the widest types first.
function makeArrays(count) {
    const buffer = takeBuffer(POINT_BYTES * count);
    let at = 0;
    return Object.fromEntries(Object.entries(ARRAYS).map(([name, [Type, width]]) => {
        const array = new Type(buffer, at, width * count);
        at += array.byteLength;
        return [name, array];
    }));
}

// The arrays of a frame are used again: nobody looks at them from here on.
export function letGo(frame) {
    spares.push(frame.xyz.buffer);
    spares.splice(0, spares.length - SPARES);
    Object.keys(ARRAYS).forEach((name) => delete frame[name]);
}

function beginFrame(head) {
    const count = head.getUint32(32, true);
    return {
        number: head.getFloat64(8, true),
        clock: head.getFloat64(16, true),
        began: makeMoment(head.getFloat64(24, true), head.getUint8(38), head.getFloat64(64, true)),
        count,
        split: count - head.getUint32(72, true), // behind it are points by the second profile
        edges: EDGES[head.getUint8(36)],
        smooth: head.getUint8(37),
        lines: head.getUint32(40, true),
        lost: head.getUint32(44, true),
        sensor: head.getUint32(48, true),
        shown: head.getUint32(52, true),
        complete: head.getFloat64(56, true),
        step: head.getFloat32(76, true), // to which coordinates are rounded, or less
        share: 1, // of its points that have come
        isNew: true, // no part of it was shown before
        parts: partsOf(head),
        ...makeArrays(count),
    };
}

// The arrays of a piece, as they lie in the message.
function openPiece(head) {
    const [points, runs, others] = [92, 96, 100].map((at) => head.getUint32(at, true));
    const { buffer, byteOffset } = head;
    const begin = HEAD_BYTES + PART_BYTES * head.getUint8(39);
    let at = byteOffset + begin + RUN_BYTES * runs;
    const words = (count) => {
        const out = new Uint16Array(buffer, at, count);
        at += 2 * count;
        return out;
    };
    const [x, y, z, pulse] = [points, points, points, points].map(words);
    const high = new Uint8Array(buffer, at, points);
    at += points + (points % 2);
    return { head, begin, runs, x, y, z, pulse, high, kinds: words(others), bits: new Uint8Array(buffer), bit: 8 * at, point: 0, kind: 0 };
}

function openRun(head, at) {
    const number = (offset) => head.getInt32(at + offset, true);
    const word = (offset) => head.getUint16(at + offset, true);
    return {
        first: head.getUint32(at, true),
        line: Math.min(65535, head.getUint32(at + 4, true)),
        origin: [number(8), number(12), number(16)],
        count: word(20),
        pixel: word(22),
        kinds: [word(24), word(26), word(28)],
        step: 2 ** -head.getUint8(at + 30),
        eye: head.getUint8(at + 31),
    };
}

function takeSpace(frame, piece, run) {
    const { x, y, z, pulse, high, point } = piece;
    const { first, count, step, origin: [X, Y, Z] } = run;
    const { xyz } = frame;
    for (let i = 0, to = 3 * first; i < count; i++, to += 3) {
        const bits = high[point + i];
        xyz[to] = (X + (x[point + i] | (bits & 3) << 16)) * step;
        xyz[to + 1] = (Y + (y[point + i] | (bits & 12) << 14)) * step;
        xyz[to + 2] = (Z + (z[point + i] | (bits & 48) << 12)) * step;
    }
    frame.pulse.set(pulse.subarray(point, point + count), first);
    frame.line.fill(run.line, first, first + count);
}

function takeKinds(frame, piece, run) {
    const { high, point } = piece;
    for (let i = 0; i < run.count; i++) {
        const code = high[point + i] >> 6;
        const kind = code === WRITTEN_OUT ? piece.kinds[piece.kind++] : run.kinds[code];
        frame.turn[run.first + i] = kind;
        frame.flags[run.first + i] = kind >> 8 | run.eye;
    }
}

// A 0 goes on by one pixel, a 1 is a point. A run begins with a byte.
function takePixels(frame, piece, run) {
    const { bits } = piece;
    let { bit } = piece;
    let pixel = run.pixel;
    for (let i = run.first; i < run.first + run.count; bit++) {
        if (bits[bit >> 3] >> (bit & 7) & 1) {
            frame.pixel[i++] = pixel;
        } else if (bit >= 8 * bits.length) {
            throw new Error("a message of lumview is cut short");
        } else {
            pixel++;
        }
    }
    piece.bit = (bit + 7) & ~7;
}

// Returns which points have come.
function takePiece(frame, head) {
    const piece = openPiece(head);
    return Array.from({ length: piece.runs }, (_, i) => {
        const run = openRun(head, piece.begin + RUN_BYTES * i);
        takeSpace(frame, piece, run);
        takeKinds(frame, piece, run);
        takePixels(frame, piece, run);
        piece.point += run.count;
        return { first: run.first, count: run.count };
    });
}

// The frame without the lines that have not come yet.
function partOf(frame, runs) {
    const sorted = [...runs].sort((a, b) => a.first - b.first);
    const countBefore = (end) => sorted.reduce((n, { first, count }) => n + (first < end ? count : 0), 0);
    const count = countBefore(frame.count);
    const arrays = makeArrays(count);
    for (const [name, [, width]] of Object.entries(ARRAYS)) {
        let to = 0;
        for (const run of sorted) {
            arrays[name].set(frame[name].subarray(width * run.first, width * (run.first + run.count)), to);
            to += width * run.count;
        }
    }
    const parts = frame.parts.map((part) => ({ ...part, first: countBefore(part.first) }));
    return { ...frame, ...arrays, count, parts, split: countBefore(frame.split), share: count / frame.count };
}

// Puts pieces together. Its function takes a message, or several one behind the other, and returns the frames that are to
// be shown: whole ones, and of one that comes slowly what has come, with its share below 1.
export function makeFrames(clock = () => performance.now()) {
    let coming = null; // { frame, runs, count, begun, next: the share from which on it is shown }

    const share = () => coming.count / coming.frame.count;

    function show() {
        coming.next = 2 * Math.max(coming.next, share());
        coming.isShown = true;
        const part = partOf(coming.frame, coming.runs);
        coming.frame.isNew = false;
        return part;
    }

    // One that was not whole is not completed any more.
    function begin(head) {
        const left = coming && !coming.isShown ? [show()] : [];
        coming = { frame: beginFrame(head), runs: [], count: 0, begun: clock(), next: FIRST_SHARE, isShown: true };
        return left;
    }

    function add(runs) {
        coming.runs.push(...runs);
        coming.count += runs.reduce((n, { count }) => n + count, 0);
        coming.isShown = false;
    }

    function end() {
        const { frame } = coming;
        coming = null;
        return [frame];
    }

    function take(head) {
        checkHead(head);
        const [piece, pieces] = [84, 88].map((at) => head.getUint32(at, true));
        const left = piece === 0 ? begin(head) : [];
        if (coming === null) {
            return left; // its begin is missing
        }
        add(takePiece(coming.frame, head));
        if (piece + 1 === pieces) {
            return left.concat(end());
        }
        return share() >= coming.next && clock() - coming.begun >= WHOLE_MS ? left.concat(show()) : left;
    }

    return (buffer) => {
        const out = [];
        for (let at = 0; at < buffer.byteLength;) {
            const head = new DataView(buffer, at);
            out.push(...take(head));
            at += head.getUint32(80, true);
        }
        return out;
    };
}
