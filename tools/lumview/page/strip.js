// The pictures beside the cloud: what both eyes see as one strip, in the colours
// of the cloud, of the newest frame and of the first profile.
import { makeTint } from "./colouring.js";
import { CHOICES, makeFilter } from "./filter.js";
import { fillIndex, findPixels, makeImage, makeSight, TYPICAL } from "./image.js";
import { FADED, UNKNOWN } from "./palette.js";

const MORE = 64; // lines that a frame may have beyond twice as many as came: others are no lines
const LINES_MAX = 8192;
const NEAR = 4; // rows and columns from the pointer to the pixel that it means, on the page
const STEPS = { ArrowUp: [0, -1], ArrowDown: [0, 1], ArrowLeft: [-4, 0], ArrowRight: [4, 0] };
const at = (id) => document.getElementById(id);

// How many lines an eye has: 1 more than the highest number of those that can be right.
function linesOf({ points, split, lines }, sensor, before) {
    const limit = Math.min(LINES_MAX, 2 * Math.max(lines, before) + MORE);
    let most = 0;
    for (let i = 0; i < split; i++) {
        if (points.line[i] > most && points.line[i] < limit && points.sensor[i] === sensor) {
            most = points.line[i];
        }
    }
    return most + 1;
}

// The frame as a picture: which point is where.
function makePicture() {
    let image = null;
    let found = null; // pixels of the points
    let index = null;
    let filling = 0;
    let slot = null;
    let sensor = 0;
    let lines = 0;

    function look(hello) {
        const sight = makeSight(hello.rig?.poses?.[sensor]);
        lines = linesOf(slot, sensor, lines);
        image = { ...makeImage(hello.image ?? TYPICAL, lines), sight, sensor };
        found = findPixels(image, slot.points.xyz, [0, slot.split], sight, (i) => slot.points.sensor[i] === sensor, found);
        index = index?.length === image.rows * image.columns ? index : new Int32Array(image.rows * image.columns);
    }

    return {
        get image() {
            return image;
        },
        get slot() {
            return slot;
        },
        get index() {
            return index;
        },
        // Of the newest slot; which: of a rig's sensors.
        fill(next, hello, which, values, eyes) {
            if (next !== slot || next.filling !== filling || which !== sensor) {
                [slot, filling, sensor] = [next, next.filling, which];
                look(hello);
            }
            const passes = makeFilter(values, eyes);
            fillIndex(index, found, 0, (i) => passes(slot.points, i));
        },
        // There is no frame.
        clear() {
            [image, found, slot, lines] = [null, null, null, 0];
        },
        // The pixel of a point of that slot, { row, column }, or null.
        placeOf(i) {
            const pixel = found?.pixels[i] ?? -1;
            return pixel >= 0 && pixel < index.length ? { row: Math.floor(pixel / image.columns), column: pixel % image.columns } : null;
        },
        // The nearest pixel that shows a point, at most so many rows and columns away; the point, or -1.
        pointAt(row, column, rows, columns) {
            let best = { point: -1, away: Infinity };
            for (let r = Math.max(0, row - rows); r <= Math.min(image.rows - 1, row + rows); r++) {
                for (let c = Math.max(0, column - columns); c <= Math.min(image.columns - 1, column + columns); c++) {
                    const away = Math.hypot((r - row) / (rows || 1), (c - column) / (columns || 1));
                    if (index[r * image.columns + c] >= 0 && away < best.away) {
                        best = { point: index[r * image.columns + c], away };
                    }
                }
            }
            return best.point;
        },
    };
}

// What the pixels of a picture are filled with. old: what it gave before, which is used again.
function paint(canvas, old, { image, index, slot }, tint, fades) {
    const pen = canvas.getContext("2d");
    let data = old;
    if (data?.width !== image.columns || data.height !== image.rows) {
        [canvas.width, canvas.height] = [image.columns, image.rows];
        data = pen.createImageData(image.columns, image.rows);
    }
    data.data.fill(0);
    const colour = [0, 0, 0];
    for (let k = 0; k < index.length; k++) {
        const i = index[k];
        if (i < 0) {
            continue;
        }
        tint(slot.points, i, colour);
        const isFaded = fades && slot.points.chosen[i] !== CHOICES.selected;
        for (let part = 0; part < 3; part++) {
            data.data[4 * k + part] = isFaded ? colour[part] + FADED * (255 * UNKNOWN[part] - colour[part]) : colour[part];
        }
        data.data[4 * k + 3] = 255;
    }
    pen.putImageData(data, 0, 0);
    return data;
}

// What a point is, in a line, as far as it is known.
const textOf = (p) => [
    p.range === undefined ? `${p.distance.toFixed(2)} m from 0` : `${p.range.toFixed(2)} m`,
    `height ${p.position[2].toFixed(2)} m`,
    p.pulse > 0 && `${p.pulse.toFixed(2)} ns`,
    p.eye && `${p.eye} eye`,
    p.line !== null && `line ${p.line}, pixel ${p.pixel}`,
].filter(Boolean).join(", ");

// on: hover(point), pick(point, isEnd): of the slot that is shown, -1 for none;
// picked(slot): which of it is picked; describe(slot, i): what is known of one.
export function makeStrip(on) {
    const canvas = at("strip-canvas");
    const picture = makePicture();
    let painted = null;
    let isDue = true;
    let cursor = null; // { row, column }: of the keyboard
    let pointer = null; // likewise

    const isShown = () => !at("strip").hidden && picture.image !== null;

    function putMark(id, place) {
        at(id).hidden = place === null;
        if (place) {
            at(id).style.left = `${(100 * (place.column + 0.5)) / picture.image.columns}%`;
            at(id).style.top = `${(100 * (place.row + 0.5)) / picture.image.rows}%`;
        }
    }

    function tell(point) {
        const text = point >= 0 ? textOf(on.describe(picture.slot, point)) : "";
        if (at("strip-text").textContent !== text) {
            at("strip-text").textContent = text;
        }
    }

    function hover(point) {
        putMark("strip-hover", cursor ?? (point >= 0 ? picture.placeOf(point) : null));
        tell(point);
    }

    // What is under the pointer or the cursor, here and in the cloud.
    function look() {
        const cell = cursor ?? pointer;
        const point = cell ? pointAt(cell) : -1;
        hover(point);
        on.hover(point);
    }

    const ratios = () => [picture.image.columns / canvas.clientWidth, picture.image.rows / canvas.clientHeight];

    function cellOf(event) {
        const box = canvas.getBoundingClientRect();
        const [across, down] = ratios();
        return { row: Math.floor((event.clientY - box.top) * down), column: Math.floor((event.clientX - box.left) * across) };
    }

    function pointAt({ row, column }) {
        const [across, down] = ratios();
        return picture.pointAt(row, column, Math.ceil(NEAR * down), Math.ceil(NEAR * across));
    }

    function point(event) {
        if (isShown() && event.buttons === 0) {
            [pointer, cursor] = [cellOf(event), null];
            look();
        }
    }

    function leave() {
        [pointer, cursor] = [null, null];
        if (isShown()) {
            look();
        }
    }

    function step([x, y], many) {
        const { rows, columns } = picture.image;
        cursor ??= { row: rows >> 1, column: columns >> 1 };
        const limit = (v, size) => Math.max(0, Math.min(size - 1, v));
        cursor = { row: limit(cursor.row + many * y, rows), column: limit(cursor.column + many * x, columns) };
        look();
    }

    function press(event) {
        const arrow = STEPS[event.key];
        if (!isShown() || event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) {
            return;
        }
        if (arrow) {
            step(arrow, event.shiftKey ? 10 : 1);
            event.preventDefault();
        } else if (event.key === "Enter") {
            on.pick(cursor ? pointAt(cursor) : -1, event.shiftKey);
            event.preventDefault();
        }
    }

    canvas.addEventListener("pointermove", point);
    canvas.addEventListener("pointerleave", leave);
    canvas.addEventListener("pointerdown", leave);
    canvas.addEventListener("pointerup", (event) => isShown() && event.button === 0 && on.pick(pointAt(cellOf(event)), event.shiftKey));
    canvas.addEventListener("keydown", press);
    canvas.addEventListener("blur", leave);

    const self = {
        canvas,
        get slot() {
            return picture.slot;
        },
        get image() {
            return picture.image;
        },
        get isShown() {
            return isShown();
        },
        // Where the keyboard is, in pixels of the canvas.
        get cursor() {
            const [across, down] = isShown() ? ratios() : [1, 1];
            return cursor ? [cursor.column / across, cursor.row / down] : undefined;
        },
        // What it shows, with the point of each pixel.
        probe: () => (isShown() ? { rows: picture.image.rows, columns: picture.image.columns, frame: picture.slot.number, index: [...picture.index] } : null),
        invalidate() {
            isDue = true;
        },
        // Another source: nothing of the one before stays.
        clear() {
            [pointer, cursor] = [null, null];
            ["strip-hover", "strip-pick"].forEach((id) => putMark(id, null));
            at("strip-text").textContent = "";
            picture.clear();
            canvas.width = 1;
        },
        // After the cloud was drawn.
        draw({ slot, hello, sensor, values, domain, bytes, eyes, fades }) {
            if (!isDue || at("strip").hidden || !slot || !hello) {
                return;
            }
            isDue = false;
            picture.fill(slot, hello, sensor, values, eyes);
            painted = paint(canvas, painted, picture, makeTint(values, domain, bytes, eyes), fades);
            self.mark();
            if (cursor ?? pointer) {
                look();
            }
        },
        // The point that is picked.
        mark() {
            const i = isShown() ? on.picked(picture.slot) : -1;
            putMark("strip-pick", i >= 0 ? picture.placeOf(i) : null);
        },
        // What is under the pointer in the cloud: a point of a slot.
        hover: (slot, i) => isShown() && hover(slot === picture.slot ? i : -1),
        // Rows and columns in a box of the page.
        cellsOf({ left, top, right, bottom }) {
            const [across, down] = ratios();
            const [first, last] = [[left * across, top * down], [right * across, bottom * down]];
            return { left: Math.floor(first[0]), top: Math.floor(first[1]), right: Math.ceil(last[0]), bottom: Math.ceil(last[1]) };
        },
    };
    return self;
}
