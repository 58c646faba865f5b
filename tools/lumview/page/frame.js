// A binary message of the server as a frame: views into the message, nothing
// is copied. The layout is that of tools/lumview/frame.h.

import { makeMoment } from "./moment.js";

const MAGIC = 0x464d554c;
const VERSION = 4;
const HEAD_BYTES = 80;
const POINT_BYTES = 20;
const PART_BYTES = 16;
const EDGES = [null, "rising", "falling", "both"];

export const EYE_BIT = 1;
export const RISING_BIT = 2;
export const STRONGEST_BIT = 128; // of the return number

function checkHead(head, bytes) {
    if (bytes < HEAD_BYTES || head.getUint32(0, true) !== MAGIC) {
        throw new Error("a message of lumview is not a frame");
    }
    const version = head.getUint16(4, true);
    if (version !== VERSION || head.getUint16(6, true) !== HEAD_BYTES) {
        throw new Error(`frames of version ${version}; this page knows ${VERSION}: reload it`);
    }
    const count = head.getUint32(32, true);
    if (bytes !== HEAD_BYTES + POINT_BYTES * count + PART_BYTES * head.getUint8(39)) {
        throw new Error(`a frame of ${count} points has ${bytes} bytes`);
    }
    return count;
}

// The sensors of a rig whose frames these are, with the first of their points; none without a rig.
function partsOf(head, count) {
    let first = 0;
    return Array.from({ length: head.getUint8(39) }, (_, i) => {
        const at = HEAD_BYTES + POINT_BYTES * count + PART_BYTES * i;
        const part = { number: head.getFloat64(at, true), first, sensor: head.getUint32(at + 12, true) };
        first += head.getUint32(at + 8, true);
        return part;
    });
}

// Edges and smoothing, as the server is asked for them.
export const viewOf = ({ edges, smooth }) => `${edges} ${smooth}`;

export function parseFrame(buffer) {
    const head = new DataView(buffer);
    const count = checkHead(head, buffer.byteLength);
    const at = (bytes) => HEAD_BYTES + bytes * count;
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
        parts: partsOf(head, count),
        xyz: new Float32Array(buffer, at(0), 3 * count),
        pulse: new Uint16Array(buffer, at(12), count),
        line: new Uint16Array(buffer, at(14), count),
        pixel: new Uint16Array(buffer, at(16), count),
        turn: new Uint8Array(buffer, at(18), count), // return number, and whether it is the strongest
        flags: new Uint8Array(buffer, at(19), count),
    };
}
