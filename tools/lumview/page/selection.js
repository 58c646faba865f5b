// Points that were selected by a box: what lies in it in the frames that are
// shown, also in those that come. They can be cropped to or hidden.
import { CHOICES, makeFilter } from "./filter.js";
import { NONE } from "./image.js";
import { fillList } from "./pick.js";
import { numbersOf } from "./plane.js";

const at = (id) => document.getElementById(id);

// What lies in a box of the picture of a camera, as it stands now, at any depth;
// box: in shares of the picture. side: of which pane's points it tells.
export function cloudVolume(camera, box, side) {
    const p = camera.projectionMatrix.elements;
    const v = camera.matrixWorldInverse.elements;
    // Row r of the product: x, y and w of the picture.
    const row = (r) => [0, 1, 2, 3].map((c) => [0, 1, 2, 3].reduce((sum, k) => sum + p[r + 4 * k] * v[k + 4 * c], 0));
    const [mx, my, mw] = [row(0), row(1), row(3)];
    const [left, right, top, bottom] = [2 * box.left - 1, 2 * box.right - 1, 1 - 2 * box.top, 1 - 2 * box.bottom];
    return {
        side,
        holds({ xyz }, i) {
            const [x, y, z] = [xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]];
            const w = mw[0] * x + mw[1] * y + mw[2] * z + mw[3];
            const across = mx[0] * x + mx[1] * y + mx[2] * z + mx[3];
            const up = my[0] * x + my[1] * y + my[2] * z + my[3];
            return w > 0 && across >= left * w && across <= right * w && up >= bottom * w && up <= top * w;
        },
    };
}

// What lies in a box of the picture of both eyes, behind others too; box: pixels,
// the last row and column not included.
export function imageVolume(image, box, sight, sensor) {
    const seen = { x: 0, y: 0, z: 0 };
    return {
        side: 0,
        holds({ xyz, sensor: of }, i) {
            if (of[i] !== sensor) {
                return false;
            }
            sight(xyz, i, seen);
            const pixel = image.pixelOf(seen.x, seen.y, seen.z);
            const [row, column] = [Math.floor(pixel / image.columns), pixel % image.columns];
            return pixel !== NONE && row >= box.top && row < box.bottom && column >= box.left && column < box.right;
        },
    };
}

const metres = (numbers) => numbers.map((v) => v.toFixed(3)).join("  ");

const ROWS = [
    ["points", (n) => n.count.toLocaleString("en")],
    ["from", (n) => n.count && `${metres(n.min)} m`],
    ["to", (n) => n.count && `${metres(n.max)} m`],
    ["extent", (n) => n.count && `${metres(n.max.map((v, k) => v - n.min[k]))} m`],
    ["plane, its normal", (n) => (n.plane ? metres(n.plane.normal) : "none: too few points, or on a line")],
    ["plane, distance", (n) => n.plane && `${n.plane.distance.toFixed(4)} m`],
    ["plane, residual", (n) => n.plane && `${n.plane.residual.toFixed(4)} m RMS`],
];

// cloud: its slots; changed(): another picture is due.
export function makeSelection({ cloud, settings, eyes, changed }) {
    let current = null; // the volume whose points are selected
    let cuts = []; // { volume, keeps }: only what is in it is left, or nothing of it
    let choosing = 0; // counts changes
    let made = null; // the numbers

    const isOut = (points, i) => cuts.some(({ volume, keeps }) => volume.holds(points, i) !== keeps);

    function kindOf(points, i) {
        if (isOut(points, i)) {
            return CHOICES.out;
        }
        return current?.holds(points, i) ? CHOICES.selected : CHOICES.plain;
    }

    // see(points, i, slot) for each shown point that is selected, or for each
    // where nothing is; of two profiles those of the pane that the box was drawn in.
    function each(see) {
        const passes = makeFilter(settings.values, eyes());
        const wanted = current ? CHOICES.selected : CHOICES.plain;
        for (const slot of cloud.slots) {
            const { points, size, split } = slot;
            const [from, to] = (current?.side ?? 0) === 0 ? [0, split] : [split, size];
            for (let i = from; i < to; i++) {
                if (points.chosen[i] === wanted && passes(points, i)) {
                    see(points, i, slot);
                }
            }
        }
    }

    function numbers() {
        made ??= numbersOf((see) => each(({ xyz }, i) => see(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2])));
        return made;
    }

    function showNumbers() {
        at("selection").hidden = current === null;
        at("show-all").disabled = cuts.length === 0;
        if (current) {
            fillList(at("selection-data"), ROWS, numbers());
        }
    }

    function become(volume, next) {
        [current, cuts] = [volume, next];
        choosing++;
        changed();
    }

    const self = {
        get isOn() {
            return current !== null;
        },
        // Tells one choice of points from another; 0: all are shown, and none is selected.
        get choosing() {
            return current || cuts.length > 0 ? choosing : 0;
        },
        kindOf,
        each,
        numbers: () => (current ? numbers() : null),
        take: (volume) => become(volume, cuts),
        crop: () => current && become(current, [...cuts, { volume: current, keeps: true }]),
        hide: () => current && become(null, [...cuts, { volume: current, keeps: false }]),
        clear: () => current && become(null, cuts),
        showAll: () => (current || cuts.length > 0) && become(null, []),
        // Frames, filters or the choice of points changed.
        update() {
            cloud.select(self);
            made = null;
            showNumbers();
        },
    };

    at("selection-crop").addEventListener("click", self.crop);
    at("selection-hide").addEventListener("click", self.hide);
    at("selection-close").addEventListener("click", self.clear);
    at("show-all").addEventListener("click", self.showAll);
    return self;
}
