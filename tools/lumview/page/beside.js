// What is known beside the points, from arrays of NumPy: the label of each point, and points that are true.
import * as THREE from "three";
import { nameLabels } from "./colouring.js";
import { parseNpy } from "./npy.js";
import { returnOf } from "./filter.js";
import { EYE_BIT } from "./frame.js";
import { DEFAULTS } from "./settings.js";
import { bytesOf } from "./source.js";

const KEYS = ["frame", "line", "eye", "pixel", "return_number"]; // of a point, in the order of lumdump's names
const LABELS = ["label", "class", "object"]; // the first of these columns that there is
const NAMED = ["", "ground", "building", "car", "truck or van", "cyclist", "person", "tree or bush", "pole", "sign", "other"]; // of lumsim
const OF_ONE = "labels belong to one sensor, as no column of theirs names it: open the capture without the rig";
const MOST = 254; // labels; one more is that of points without any
const FEW = 12; // names in a sentence
const FARTHEST = 2 ** 21; // metres; floats hold no place beyond, and Python's view takes none
const TRUE_COLOUR = 0xff5fd2;

const keyOf = (line, eye, pixel, turn) => ((line * 2 + eye) * 65536 + pixel) * 128 + turn;

// Rows in the order of frames, and in a frame of keys: { order, groups }, of each frame from where to where. Arrays mostly are.
function groupBy(frames, keys) {
    const compare = (a, b) => frames[a] - frames[b] || (keys ? keys[a] - keys[b] : 0) || a - b;
    const order = Uint32Array.from(frames, (_, i) => i);
    if (order.some((row) => row > 0 && compare(row - 1, row) > 0)) {
        order.sort(compare);
    }
    const groups = new Map();
    let from = 0;
    for (let i = 1; i <= order.length; i++) {
        if (i === order.length || frames[order[i]] !== frames[order[from]]) {
            groups.set(frames[order[from]], [from, i]);
            from = i;
        }
    }
    return { order, groups };
}

// Labels as small numbers, from 1 on, in the order of their values; 0 for those beyond the page's, and what to say of them.
function smallNumbers(values) {
    const all = [...new Set(values)].sort((a, b) => a - b);
    const present = all.slice(0, MOST);
    const places = new Map(present.map((value, i) => [value, i + 1]));
    const why = all.length > MOST
        ? `${all.length} different labels: the page shows the lowest ${MOST}; points with others look unlabelled` : "";
    return { present, why, small: Uint8Array.from(values, (value) => places.get(value) ?? 0) };
}

// { names, values, why, of(slot, out), lacks(number) }: of() writes a small number for each point of a slot; 0: it has no label.
// lacks(): of a frame that was asked for no point has one.
function makeLabels(table) {
    const name = LABELS.find((one) => table.names.includes(one));
    const [frame, line, eye, pixel, turn] = KEYS.map(table.column);
    const { present, why, small } = smallNumbers(table.column(name));
    const keys = Float64Array.from(frame, (_, i) => keyOf(line[i], eye[i], pixel[i], turn[i]));
    const { order, groups } = groupBy(frame, keys);
    const isLumsim = name === "class" && table.names.includes("object") && present.every((value) => NAMED[value]);

    const lacking = new Set(); // frames

    // The first place of a span whose key is not below one.
    function search([from, to], key) {
        let [low, high] = [from, to];
        while (low < high) {
            const middle = (low + high) >> 1;
            [low, high] = keys[order[middle]] < key ? [middle + 1, high] : [low, middle];
        }
        return low;
    }

    return {
        why,
        values: present,
        names: present.map((value) => (isLumsim ? NAMED[value] : String(value))),
        // Points mostly follow each other as the rows do.
        of({ points: p, number, size }, out) {
            const span = groups.get(number) ?? [0, 0];
            let place = span[0];
            let found = 0;
            for (let i = 0; i < size; i++) {
                const key = keyOf(p.line[i], p.flags[i] & EYE_BIT, p.pixel[i], returnOf(p, i));
                place = place < span[1] && keys[order[place]] === key ? place : search(span, key);
                const isThere = place < span[1] && keys[order[place]] === key;
                out[i] = isThere ? small[order[place]] : 0;
                place += isThere ? 1 : 0;
                found += isThere ? 1 : 0;
            }
            lacking[found > 0 || size === 0 ? "delete" : "add"](number);
        },
        lacks: (number) => lacking.has(number),
    };
}

// Those of frames that are in the page: { names, frames: [[number, base64 of a small number a point], ...] }.
function embeddedLabels({ names, frames }) {
    const small = new Map(frames.map(([number, base64]) => [number, new Uint8Array(bytesOf(base64))]));
    return {
        names,
        values: names.map(Number),
        of({ number, size }, out) {
            const found = small.get(number);
            if (found?.length === size) {
                out.set(found);
            } else {
                out.fill(0, 0, size); // a part of the frame
            }
        },
        lacks: () => false,
    };
}

// The points as one object of the scene; show(numbers): of these frames, if the points say which.
function makeTruth(table, columns) {
    const [x, y, z] = columns.map(table.column);
    const frames = table.names.includes("frame") ? table.column("frame") : null;
    const isNear = (v) => Math.abs(v) <= FARTHEST;
    const isPlace = (row) => isNear(x[row]) && isNear(y[row]) && isNear(z[row]) && !Number.isNaN(frames?.[row] ?? 0);
    const kept = Uint32Array.from(x, (_, row) => row).filter(isPlace);
    const grouped = frames ? groupBy(Float64Array.from(kept, (row) => frames[row])) : null;
    const xyz = new Float32Array(3 * kept.length);
    const origin = kept.length > 0 ? [x, y, z].map((column) => Math.round(column[kept[0]])) : [0, 0, 0]; // floats hold what is near it
    for (let i = 0; i < kept.length; i++) {
        const row = kept[grouped ? grouped.order[i] : i];
        xyz.set([x[row] - origin[0], y[row] - origin[1], z[row] - origin[2]], 3 * i);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(xyz, 3));
    const object = new THREE.Points(geometry, new THREE.PointsMaterial({ color: TRUE_COLOUR, size: 2, sizeAttenuation: false }));
    object.frustumCulled = false;
    object.matrixAutoUpdate = false;
    const shift = new THREE.Matrix4().makeTranslation(...origin);
    return {
        object,
        count: kept.length,
        left: table.rows - kept.length, // out, as they have no coordinates, or none that are near, or no frame
        place(world) {
            object.matrix = world && !grouped ? world.clone().multiply(shift) : shift;
            object.matrixWorldNeedsUpdate = true;
        },
        show(first, last) {
            const spans = [...(grouped?.groups ?? [])].filter(([number]) => number >= first && number <= last).map(([, span]) => span);
            const [from, to] = grouped ? [Math.min(...spans.map(([a]) => a)), Math.max(...spans.map(([, b]) => b))] : [0, kept.length];
            const count = spans.length > 0 || !grouped ? to - from : 0;
            geometry.setDrawRange(count > 0 ? from : 0, count);
            return count;
        },
    };
}

const leftOf = ({ left }) => (left > 0 ? [`${left.toLocaleString("en")} without coordinates left out`] : []);

const COORDINATES = [["x", "y", "z"], ["0", "1", "2"]];

const RIGHT = `points are rows of 3 numbers, of the shape (n, 3), or have the columns x, y, z; labels have ${KEYS.join(", ")} `
    + `and one of ${LABELS.join(", ")}`;

function whatIs({ shape, names }) {
    const more = names.length > FEW ? ` and ${(names.length - FEW).toLocaleString("en")} more` : "";
    return shape ? `its shape is ${shape}` : `its columns are ${names.slice(0, FEW).join(", ")}${more}`;
}

// { labels } or { truth }, by the columns that an array has.
export function takeArray(name, buffer) {
    try {
        const table = parseNpy(buffer);
        const has = (names) => names.every((one) => table.names.includes(one));
        if (has(KEYS) && LABELS.some((one) => table.names.includes(one))) {
            return { labels: makeLabels(table) };
        }
        const columns = COORDINATES.find(has);
        if (!columns || (columns[0] === "0" && table.names.length > 4)) {
            throw new Error(`${whatIs(table)}: ${RIGHT}`);
        }
        return { truth: makeTruth(table, columns) };
    } catch (error) {
        throw new Error(`${name}: ${error.message}`, { cause: error });
    }
}

// app: { scene, cloud, panel, settings, changed(), tell(sentence) }
export function makeBeside({ scene, cloud, panel, settings, changed, tell }) {
    const at = (id) => document.getElementById(id);
    const loaded = new Set(); // names of what lumview has served
    let truth = null;
    let labelled = null; // { name, labels } that are taken
    let isRig = false;
    let sources = 0; // that were shown so far
    let served = ""; // the source that lumview shows, and what it has for it

    // world: as seen from the newest frame, where that is known; points that are of no frame are in it, and those of frames
    // before do not stand where these were taken.
    function show(world = null) {
        if (truth) {
            truth.place(world);
            truth.object.visible = settings.values.truth;
            truth.object.material.size = settings.values.size * Math.min(2, window.devicePixelRatio);
            truth.show((world ? cloud.newest : cloud.slots[0])?.number ?? NaN, cloud.newest?.number ?? NaN);
        }
    }

    function dropTruth() {
        if (truth) {
            scene.remove(truth.object);
            truth.object.geometry.dispose();
            truth.object.material.dispose();
        }
        truth = null;
    }

    function takeLabels(labels, name = "") {
        labelled = labels && { labels, name };
        nameLabels(labels?.names ?? ["none"], labels?.values ?? []);
        cloud.setLabels(labels);
        panel.setLabels(labels !== null);
    }

    function takeTruth(name, next) {
        dropTruth();
        truth = next;
        if (truth) {
            scene.add(truth.object);
        }
        at("truth-row").hidden = truth === null;
        at("truth-name").textContent = truth
            ? [`${name}, ${truth.count.toLocaleString("en")} points`, ...leftOf(truth)].join("; ") : "";
    }

    function take(name, buffer) {
        try {
            const { labels, truth: points } = takeArray(name, buffer);
            if (labels && isRig) {
                throw new Error(`${name}: ${OF_ONE}`);
            } else if (labels) {
                takeLabels(labels, name);
            } else {
                takeTruth(name, points);
            }
            changed();
            if (labels?.why) {
                tell(`${name}: ${labels.why}`);
            }
        } catch (error) {
            tell(error.message);
        }
    }

    // What comes when another source is shown is of no use.
    async function takeFrom(name, read) {
        const source = sources;
        try {
            const buffer = await read();
            if (source === sources) {
                take(name, buffer);
            }
        } catch (error) {
            if (source === sources) {
                tell(`${name}: ${error.message}`);
            }
        }
    }

    function load(path, name) {
        loaded.add(path);
        takeFrom(name.split("/").at(-1), async () => (await fetch(path)).arrayBuffer());
    }

    // Of another source nothing is known yet.
    function forget() {
        sources++;
        loaded.clear();
        takeLabels(null);
        takeTruth("", null);
    }

    // A lumview that was started again may show something else.
    function forgetOther({ source, labels, truth: points }) {
        const next = JSON.stringify([source, labels, points]);
        if (loaded.size > 0 && next !== served) {
            forget();
        }
        served = next;
    }

    return {
        show,
        takeFrom,
        clear() {
            isRig = false;
            forget();
        },
        // The greeting of lumview names what it serves.
        greet(hello) {
            if (hello.labels?.frames) {
                takeLabels(embeddedLabels(hello.labels));
                settings.set(settings.values.colour === DEFAULTS.colour ? { colour: "label" } : {});
                return;
            }
            forgetOther(hello);
            isRig = Boolean(hello.rig);
            if (isRig && cloud.isLabelled) {
                tell(OF_ONE);
            }
            if (isRig || (!hello.labels && !cloud.isLabelled)) {
                takeLabels(null);
            }
            for (const path of ["labels", "truth"].filter((one) => hello[one] && !loaded.has(`/${one}`))) {
                load(`/${path}`, hello[path]);
            }
        },
        // That no point of the newest frame has a label.
        get sentence() {
            return labelled?.labels.lacks(cloud.newest?.number) ? `${labelled.name} has no label for this frame` : "";
        },
        // How many true points are shown, and where one of them is, for tests.
        get shown() {
            return truth?.object.visible ? truth.object.geometry.drawRange.count : 0;
        },
    };
}
