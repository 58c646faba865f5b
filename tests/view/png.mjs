// PNG files of a browser to pixels, and what one can say of two pictures.
import { inflateSync } from "node:zlib";

const CHANNELS = { 2: 3, 6: 4 }; // by colour type: RGB, RGBA

function chunks(file) {
    const found = { data: [] };
    for (let at = 8; at < file.length; ) {
        const length = file.readUInt32BE(at);
        const type = file.toString("latin1", at + 4, at + 8);
        const body = file.subarray(at + 8, at + 8 + length);
        if (type === "IHDR") {
            found.head = body;
        } else if (type === "IDAT") {
            found.data.push(body);
        }
        at += 12 + length;
    }
    return found;
}

function paeth(a, b, c) {
    const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

const FILTERS = [() => 0, (a) => a, (a, b) => b, (a, b) => (a + b) >> 1, paeth];

function unfilter(raw, width, height, channels) {
    const stride = width * channels;
    const out = Buffer.alloc(stride * height);
    for (let y = 0; y < height; y++) {
        const predict = FILTERS[raw[y * (stride + 1)]];
        for (let x = 0; x < stride; x++) {
            const at = y * stride + x;
            const left = x >= channels ? out[at - channels] : 0;
            const up = y > 0 ? out[at - stride] : 0;
            const corner = x >= channels && y > 0 ? out[at - stride - channels] : 0;
            out[at] = raw[y * (stride + 1) + 1 + x] + predict(left, up, corner);
        }
    }
    return out;
}

export function decode(file) {
    const { head, data } = chunks(file);
    const [width, height, channels] = [head.readUInt32BE(0), head.readUInt32BE(4), CHANNELS[head[9]]];
    if (head[8] !== 8 || !channels || head[12] !== 0) {
        throw new Error("a PNG that is not RGB or RGBA of 8 bits");
    }
    return { width, height, channels, bytes: unfilter(inflateSync(Buffer.concat(data)), width, height, channels) };
}

function differs(a, b, pixel) {
    for (let k = 0; k < 3; k++) {
        if (Math.abs(a.bytes[pixel * a.channels + k] - b.bytes[pixel * b.channels + k]) > 24) {
            return true;
        }
    }
    return false;
}

// Share of pixels that differ, and in how many of 8 x 8 regions at least one
// in a hundred does.
export function compare(a, b) {
    const regions = new Array(64).fill(0);
    let count = 0;
    for (let i = 0; i < a.width * a.height; i++) {
        if (differs(a, b, i)) {
            const [x, y] = [i % a.width, Math.floor(i / a.width)];
            regions[8 * Math.floor((8 * y) / a.height) + Math.floor((8 * x) / a.width)]++;
            count++;
        }
    }
    const enough = (a.width * a.height) / 64 / 100;
    return { share: count / (a.width * a.height), regions: regions.filter((n) => n >= enough).length };
}

// Share of pixels that have colour: points do, grid and rings hardly.
export function coloured(a) {
    let count = 0;
    for (let i = 0; i < a.width * a.height; i++) {
        const c = a.bytes.subarray(i * a.channels, i * a.channels + 3);
        count += Math.max(...c) - Math.min(...c) > 60;
    }
    return count / (a.width * a.height);
}
