// A click picks the point under it.
import * as THREE from "three";
import { labelOf } from "./colouring.js";
import { RISING_BIT } from "./frame.js";
import { directionOf, eyeOf, makeFilter, returnOf } from "./filter.js";
import { kindOf, timeOf } from "./moment.js";

const NEAR_PX = 4; // within it the point in front is meant
const FAR_PX = 14; // beyond it none is

// Where points stand on the page: writes x, y in pixels and the depth to out.
export function makeProjection(camera, width, height) {
    const m = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
    return (xyz, i, out) => {
        const [x, y, z] = [xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]];
        const w = m[3] * x + m[7] * y + m[11] * z + m[15];
        out.x = (0.5 + (0.5 * (m[0] * x + m[4] * y + m[8] * z + m[12])) / w) * width;
        out.y = (0.5 - (0.5 * (m[1] * x + m[5] * y + m[9] * z + m[13])) / w) * height;
        out.depth = (m[2] * x + m[6] * y + m[10] * z + m[14]) / w;
        return w > 0 && out.depth >= -1 && out.depth <= 1;
    };
}

function isBetter(near, distance, depth, best) {
    if (near !== best.near) {
        return near;
    }
    return near ? depth < best.depth : distance < best.distance;
}

// { slot, index } of the point meant by a click at x, y, or null. rangeOf: the
// points of a slot that are looked at.
export function findPoint(slots, rangeOf, project, passes, x, y) {
    const at = {};
    let best = { near: false, distance: FAR_PX, depth: Infinity, slot: null };
    for (const slot of slots) {
        const [from, to] = rangeOf(slot);
        for (let i = from; i < to; i++) {
            if (!project(slot.points.xyz, i, at)) {
                continue;
            }
            const distance = Math.hypot(at.x - x, at.y - y);
            const near = distance <= NEAR_PX;
            if (distance < FAR_PX && isBetter(near, distance, at.depth, best) && passes(slot.points, i)) {
                best = { near, distance, depth: at.depth, slot, index: i };
            }
        }
    }
    return best.slot && best;
}

// All that is known of a point.
export function describe({ slot, index: i }, eyes) {
    const { points: p, number, began, parts } = slot;
    const measured = slot.isMoved ? slot.own : p.xyz; // by the sensor, where it was then
    const flags = p.flags[i];
    const position = [p.xyz[3 * i], p.xyz[3 * i + 1], p.xyz[3 * i + 2]];
    const eye = eyeOf(p, i, eyes);
    const part = parts.find(({ sensor }) => sensor === p.sensor[i]);
    const known = (what, value) => (eye.lacks?.includes(what) ? null : value); // frames of a program need not have all
    return {
        position,
        step: slot.step,
        ...(eye.lacks?.includes("place") ? { distance: Math.hypot(...position) }
            : directionOf([0, 1, 2].map((k) => measured[3 * i + k]), eye)),
        sensor: eye.sensor ?? null,
        sensorFrame: part?.number ?? null,
        eye: eye.name,
        line: known("line", p.line[i]),
        pixel: known("line", p.pixel[i]),
        returnNumber: known("return", returnOf(p, i)),
        returns: flags >> 2,
        edge: known("edge", flags & RISING_BIT ? "rising" : "falling"),
        pulse: p.pulse[i] * 0.01,
        label: labelOf(p, i),
        frame: number,
        began,
    };
}

const coordinates = (at) => `${at.map((v) => v.toFixed(3)).join("  ")} m`;

const ROWS = [
    ["sensor", (p) => p.sensor],
    ["its frame", (p) => p.sensorFrame?.toString()],
    ["x y z", (p) => coordinates(p.position)],
    ["each within", (p) => `${(500 * p.step).toFixed(2)} mm`],
    ["range", (p) => p.range !== undefined && `${p.range.toFixed(3)} m`],
    ["azimuth", (p) => p.azimuth !== undefined && `${p.azimuth.toFixed(3)}°`],
    ["elevation", (p) => p.elevation !== undefined && `${p.elevation.toFixed(3)}°`],
    ["from 0", (p) => p.distance !== undefined && `${p.distance.toFixed(3)} m`],
    ["eye", (p) => p.eye],
    ["line, pixel", (p) => p.line !== null && `${p.line}, ${p.pixel}`],
    ["return", (p) => p.returnNumber !== null && `${p.returnNumber} of ${p.returns}`],
    ["edge", (p) => p.edge],
    ["pulse width", (p) => (p.pulse > 0 ? `${p.pulse.toFixed(2)} ns` : "unknown")],
    ["label", (p) => p.label],
    ["frame", (p) => String(p.frame)],
    ["frame began", (p) => timeOf(p.began)],
    ["its time is", (p) => kindOf(p.began)],
];

// Between two positions.
export function measure(from, to) {
    const [x, y, z] = to.map((v, k) => v - from[k]);
    return { from, to, distance: Math.hypot(x, y, z), horizontal: Math.hypot(x, y), x, y, z };
}

const MEASURE_ROWS = [
    ["horizontal", (m) => `${m.horizontal.toFixed(3)} m`],
    ["Δx Δy Δz", (m) => coordinates([m.x, m.y, m.z])],
    ["from", (m) => coordinates(m.from)],
    ["to", (m) => coordinates(m.to)],
];

// A list of names and what is told of each; what is null, false or 0 is left out.
export function fillList(list, rows, of) {
    const shown = (of ? rows : []).map(([name, text]) => [name, text(of)]).filter(([, text]) => text);
    list.replaceChildren(...shown.flatMap((texts) => ["dt", "dd"].map((kind, i) => {
        const item = document.createElement(kind);
        item.textContent = texts[i];
        return item;
    })));
}

const at = (id) => document.getElementById(id);

// mark(from, to): where signs are to stand, null for none.
export function makePick({ canvas, camera, panes, cloud, settings, eyes, mark }) {
    let picked = null; // { slot, index, filling, data }
    let from = null; // likewise: the other end of a distance

    const isOther = (a, b) => a.slot !== b.slot || a.filling !== b.filling || a.index !== b.index;
    const distance = () => (from && picked && isOther(from, picked) ? measure(from.data.position, picked.data.position) : null);

    function find(x, y) {
        const pane = panes.find(x);
        const project = makeProjection(camera.active, panes.width, canvas.clientHeight);
        const passes = makeFilter(settings.values, eyes());
        return findPoint(cloud.slots, (slot) => panes.range(slot, pane.side), project, passes, pane.x, y);
    }

    const known = (found) => found && { ...found, filling: found.slot.filling, data: describe(found, eyes()) };
    const look = (x, y) => known(find(x, y));

    function showDistance() {
        const measured = distance();
        at("pick-title").textContent = from ? "Distance" : "Point";
        at("measure").hidden = from === null;
        at("measure-distance").textContent = measured ? `${measured.distance.toFixed(3)} m` : "Pick the other end";
        fillList(at("measure-data"), MEASURE_ROWS, measured);
        at("pick-measure").textContent = from ? "End measuring" : "Measure from here";
        at("pick-measure").setAttribute("aria-pressed", String(from !== null));
    }

    // Where nothing is: said there, until the next key or click.
    function showMiss(place) {
        const miss = at("miss");
        miss.textContent = place ? "no point here" : "";
        miss.hidden = place === null;
        [miss.style.left, miss.style.top] = (place ?? [0, 0]).map((v) => `${v}px`);
    }

    function show(point) {
        picked = point;
        from = point ? from : null;
        at("pick").hidden = point === null;
        fillList(at("pick-data"), ROWS, point && point.data);
        showDistance();
        mark(from && from.data.position, point && point.data.position);
    }

    function measureFrom(point) {
        from = point;
        show(picked);
    }

    function isShown(point) {
        return cloud.slots.includes(point.slot) && point.slot.filling === point.filling &&
            makeFilter(settings.values, eyes())(point.slot.points, point.index);
    }

    const self = {
        get picked() {
            return picked && picked.data;
        },
        get distance() {
            return distance();
        },
        clear: () => show(null),
        // What is not shown any more is not picked.
        check() {
            const [goes, ends] = [picked && !isShown(picked), from && !isShown(from)];
            if (goes || ends) {
                from = ends ? null : from;
                show(goes ? null : picked);
            }
        },
        // isEnd: of a distance that begins at the point picked before.
        at(x, y, isEnd) {
            from = isEnd && from === null ? picked : from;
            const point = look(x, y);
            showMiss(point ? null : [x, y]);
            at("pick").classList.toggle("right", x < canvas.clientWidth / 2); // not over the point
            if (point || from === null) {
                show(point);
            }
        },
        // A point that was found elsewhere: { slot, index }, or null for none.
        take(found, isEnd) {
            from = isEnd && from === null ? picked : from;
            showMiss(null);
            if (found || from === null) {
                show(known(found));
            }
        },
        // What a click would find.
        under: find,
        // Which point of a slot is picked; -1: none.
        indexIn: (slot) => (picked && picked.slot === slot && picked.filling === slot.filling ? picked.index : -1),
        // From the point that is picked, or no more.
        measure() {
            if (picked) {
                measureFrom(from ? null : picked);
            }
        },
        // found([x, y, z]): where the point under x, y is, if there is one.
        find(x, y, found) {
            const point = look(x, y);
            if (point) {
                found(point.data.position);
            }
        },
    };

    for (const next of ["pointerdown", "keydown", "wheel"]) {
        document.addEventListener(next, () => showMiss(null), { capture: true, passive: true });
    }
    at("pick-measure").addEventListener("click", self.measure);
    at("pick-close").addEventListener("click", () => {
        show(null);
        canvas.focus();
    });
    return self;
}
