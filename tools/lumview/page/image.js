// The picture of both eyes, whose rows and columns lie as the world does: where
// points lie in it, by the rules of include/lum/image.h. Every product and every
// sum is rounded as there, so that each point has the same pixel.

const f = Math.fround;
const RADIANS = Math.PI / 180;
export const TYPICAL = { left: 60, right: -60, top: 3, bottom: -17, columns: 1600, rows_step: 64 }; // where a greeting has none
export const NONE = -1; // outside of the picture

const [A, B, C] = [f(0.99999483), f(-0.33295711), f(0.19534659)];
const [D, E, F] = [f(-0.12044859), f(0.05658999), f(-0.01313038)];

// The arc tangent of -1 to 1; q: its square.
function arc(a, q) {
    const qq = f(q * q);
    const last = f(f(C + f(q * D)) + f(qq * f(E + f(q * F))));
    return f(a * f(f(A + f(q * B)) + f(qq * last)));
}

function quickArc(a) {
    const q = a * a;
    const qq = q * q;
    return a * (A + q * B + qq * (C + q * D + qq * (E + q * F)));
}

const MARGIN = 0.01; // of half a pixel, and more than all roundings make

const isNearEdge = (place) => Math.abs(2 * place - Math.round(2 * place)) < MARGIN;

// view: of the server's greeting. lines: how many an eye has. It lies before the
// sensor, and within 45 degrees of the level.
export function makeImage(view, lines) {
    const { columns, rows_step: step } = view;
    const rows = Math.ceil(Math.max(1, lines) / step) * step;
    const perColumn = columns / ((view.left - view.right) * RADIANS);
    const perRow = rows / ((view.top - view.bottom) * RADIANS);
    const [left, top] = [f(view.left * RADIANS * perColumn), f(view.top * RADIANS * perRow)];
    const [twoColumns, oneRow] = [f(2 * f(perColumn)), f(perRow)];

    function pixelAt(across, down) {
        if (!(across >= -0.5 && across < columns + 0.5 && down >= -0.5 && down < rows + 0.5)) {
            return NONE;
        }
        return Math.min(rows - 1, Math.trunc(down)) * columns + Math.min(columns - 1, Math.trunc(across));
    }

    // Half the azimuth is found, which both sides of the sensor reach without a
    // case of their own.
    function exactPixel(x, y, z) {
        const level = f(Math.sqrt(f(f(x * x) + f(y * y))));
        const sum = f(level + x);
        const part = f(1 / f(level * sum));
        const half = f(f(y * level) * part);
        const slope = f(f(z * sum) * part);
        const steep = f(slope * slope);
        const across = f(left - f(arc(half, f(half * half)) * twoColumns));
        const down = f(top - f(arc(slope, steep) * oneRow));
        return x >= 0 && steep <= 1 ? pixelAt(across, down) : NONE;
    }

    // The same without the roundings, which take most of the time; where they
    // could matter, with them.
    function pixelOf(x, y, z) {
        const level = Math.sqrt(x * x + y * y);
        const half = y / (level + x);
        const slope = z / level;
        const steep = slope * slope;
        if (!(x >= 0 && steep <= 1 - MARGIN)) {
            return x >= 0 && steep < 1 + MARGIN ? exactPixel(x, y, z) : NONE;
        }
        const across = left - quickArc(half) * twoColumns;
        const down = top - quickArc(slope) * oneRow;
        return isNearEdge(across) || isNearEdge(down) ? exactPixel(x, y, z) : pixelAt(across, down);
    }

    return { ...view, rows, columns, pixelOf };
}

// From the frame of the points to that of their sensor; pose: three rows of four
// numbers, or none where these are the same. Writes x, y, z to out.
export function makeSight(pose) {
    if (!pose) {
        return (xyz, i, out) => {
            out.x = xyz[3 * i];
            out.y = xyz[3 * i + 1];
            out.z = xyz[3 * i + 2];
        };
    }
    const m = pose;
    return (xyz, i, out) => {
        const x = xyz[3 * i] - m[3];
        const y = xyz[3 * i + 1] - m[7];
        const z = xyz[3 * i + 2] - m[11];
        out.x = f(m[0] * x + m[4] * y + m[8] * z);
        out.y = f(m[1] * x + m[5] * y + m[9] * z);
        out.z = f(m[2] * x + m[6] * y + m[10] * z);
    };
}

const roomIn = (old, Type, count) =>
    (old && old.buffer.byteLength >= 4 * count ? new Type(old.buffer, 0, count) : new Type(count + (count >> 3)).subarray(0, count));

// The pixels and the squared ranges of points; NONE for those that are not looked at. old: what it gave before, whose
// arrays are used again.
export function findPixels(image, xyz, [from, to], sight, isOfSensor, old) {
    const pixels = roomIn(old?.pixels, Int32Array, to - from);
    const squares = roomIn(old?.squares, Float32Array, to - from);
    const at = { x: 0, y: 0, z: 0 };
    for (let i = from; i < to; i++) {
        if (!isOfSensor(i)) {
            pixels[i - from] = NONE;
            continue;
        }
        sight(xyz, i, at);
        pixels[i - from] = image.pixelOf(at.x, at.y, at.z);
        squares[i - from] = f(f(at.x * at.x) + f(at.y * at.y)) + f(at.z * at.z);
    }
    return { pixels, squares };
}

// Which point each pixel shows, -1 for none: the nearest of those that pass(i).
export function fillIndex(index, { pixels, squares }, from, passes) {
    index.fill(-1);
    for (let k = 0; k < pixels.length; k++) {
        const pixel = pixels[k];
        if (pixel !== NONE && passes(from + k) && (index[pixel] < 0 || squares[k] < squares[index[pixel] - from])) {
            index[pixel] = from + k;
        }
    }
    return index;
}
