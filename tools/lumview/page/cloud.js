// The points: one three.js object for each frame that is shown, and one of a
// part of its points for while the camera moves. Arrays and buffers of the
// graphics card are kept and filled again.
import * as THREE from "three";
import { CHOICES, limits } from "./filter.js";
import { letGo, viewOf } from "./frame.js";
import { COLOURINGS } from "./colouring.js";
import { EYES, FADED, LABELS, SENSORS, UNKNOWN } from "./palette.js";

const GRAIN = 16384; // points; room grows in steps of this
const RETURNS = { all: 0, 1: 1, 2: 2, 3: 3, last: -1, strongest: -2 };

const VERTEX = `
attribute float pulse;
attribute float line;
attribute float turn;
attribute float flags;
attribute float sensor;
attribute float chosen;
attribute float label;
uniform vec3 mounts[EYES];
uniform vec2 eyes;
uniform vec2 rangeClip;
uniform vec2 heightClip;
uniform float wantedReturn;
uniform int mode;
uniform bool logarithmic;
uniform vec2 domain;
uniform sampler2D palette;
uniform vec3 eyeColours[2];
uniform vec3 sensorColours[SENSORS];
uniform vec3 labelColours[LABELS];
uniform vec3 unknown;
uniform bool fades;
uniform float gap;
uniform vec2 sizes;
uniform float halfHeight;
varying vec3 tint;
varying float size;

bool isReturn(float number, float count)
{
    if (wantedReturn == -2.0) { return turn > 127.5; }
    return wantedReturn == 0.0 || number == (wantedReturn < 0.0 ? count : wantedReturn);
}

bool passes(int eye, float range, float number, float count)
{
    return chosen < 1.5 && isReturn(number, count) && (eye == 0 ? eyes.x : eyes.y) > 0.5 && range >= rangeClip.x && range <= rangeClip.y &&
           position.z >= heightClip.x && position.z <= heightClip.y;
}

vec3 colour(int eye, float range, float number)
{
    if (mode == 7) { return label < 0.5 ? unknown : labelColours[int(mod(label - 0.5, float(LABELS)))]; }
    if (mode == 6) { return sensorColours[int(sensor)]; }
    if (mode == 5) { return eye == 0 ? eyeColours[0] : eyeColours[1]; }
    if (mode == 2 && pulse == 0.0) { return unknown; }
    float v = mode == 0 ? range : mode == 1 ? position.z : mode == 2 ? pulse * 0.01 : mode == 3 ? number : line;
    float t = logarithmic ? log(max(v, 1e-3) / domain.x) / log(domain.y / domain.x)
                          : (v - domain.x) / (domain.y - domain.x);
    return texture2D(palette, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
}

void main()
{
    float count = floor(flags / 4.0);
    int eye = int(mod(flags, 2.0));
    float range = distance(position, mounts[2 * int(sensor) + eye]);
    float number = mod(turn, 128.0);
    tint = colour(eye, range, number);
    if (fades && chosen < 0.5) { tint = mix(tint, unknown, FADED); }
    gl_Position = passes(eye, range, number, count) ? projectionMatrix * modelViewMatrix * vec4(position, 1.0)
                                            : vec4(2.0, 2.0, 2.0, 1.0);
    size = clamp(gap * range * projectionMatrix[1][1] * halfHeight / gl_Position.w, sizes.x, sizes.y);
    gl_PointSize = size;
}`;

const FRAGMENT = `
varying vec3 tint;
varying float size;

void main()
{
    vec2 c = gl_PointCoord - 0.5;
    if (size > 3.0 && dot(c, c) > 0.25) { discard; }
    gl_FragColor = vec4(tint, 1.0);
}`;

const ARRAYS = {
    xyz: [Float32Array, 3, "position"],
    pulse: [Uint16Array, 1, "pulse"],
    line: [Uint16Array, 1, "line"],
    pixel: [Uint16Array, 1, null], // for picking
    turn: [Uint8Array, 1, "turn"],
    flags: [Uint8Array, 1, "flags"],
    sensor: [Uint8Array, 1, "sensor"], // its place in the rig
    chosen: [Uint8Array, 1, "chosen"], // one of CHOICES in filter.js
    label: [Uint8Array, 1, "label"], // from 1 on; 0: none
};

function makeMaterial(palette) {
    const vector = () => new THREE.Vector3();
    const uniforms = {
        mounts: { value: Array.from({ length: 2 * SENSORS.length }, vector) },
        eyes: { value: new THREE.Vector2(1, 1) },
        rangeClip: { value: new THREE.Vector2() },
        heightClip: { value: new THREE.Vector2() },
        wantedReturn: { value: 0 },
        mode: { value: 0 },
        logarithmic: { value: true },
        domain: { value: new THREE.Vector2(1, 100) },
        palette: { value: palette.texture },
        eyeColours: { value: [vector().fromArray(EYES.blue), vector().fromArray(EYES.green)] },
        sensorColours: { value: SENSORS.map((colour) => vector().fromArray(colour)) },
        labelColours: { value: LABELS.map((colour) => vector().fromArray(colour)) },
        unknown: { value: vector().fromArray(UNKNOWN) },
        fades: { value: false },
        gap: { value: 0 }, // to the next point, as a share of the range
        sizes: { value: new THREE.Vector2() }, // least and most pixels of a point
        halfHeight: { value: 1 }, // pixels of the picture
    };
    const defines = { SENSORS: SENSORS.length, LABELS: LABELS.length, EYES: 2 * SENSORS.length, FADED: FADED.toFixed(2) };
    return new THREE.ShaderMaterial({ uniforms, defines, vertexShader: VERTEX, fragmentShader: FRAGMENT });
}

// Arrays for so many points, and what draws them.
function makePart(material, room) {
    const geometry = new THREE.BufferGeometry();
    const points = {};
    for (const [name, [Type, width, attribute]] of Object.entries(ARRAYS)) {
        points[name] = new Type(room * width);
        if (attribute) {
            const made = new THREE.BufferAttribute(points[name], width);
            made.setUsage(THREE.DynamicDrawUsage);
            geometry.setAttribute(attribute, made);
        }
    }
    const object = new THREE.Points(geometry, material);
    object.frustumCulled = false;
    return { points, object, room };
}

// The first of its points are new.
function renew({ object: { geometry } }, count) {
    for (const [, width, attribute] of Object.values(ARRAYS).filter((array) => array[2])) {
        const target = geometry.getAttribute(attribute);
        target.clearUpdateRanges();
        target.addUpdateRange(0, count * width);
        target.needsUpdate = true;
    }
    geometry.setDrawRange(0, count);
}

const MOVED = -1; // a choice of points by where they were before

let fillings = 0;

// Takes the frame over: its arrays are gone then.
function fill(slot, frame) {
    for (const name of Object.keys(ARRAYS).filter((name) => frame[name])) {
        slot.points[name].set(frame[name]);
    }
    letGo(frame);
    slot.points.sensor.fill(0);
    slot.points.chosen.fill(CHOICES.plain);
    frame.parts.forEach(({ first, sensor }) => slot.points.sensor.fill(sensor, first));
    slot.parts = frame.parts;
    renew(slot, frame.count);
    slot.size = frame.count;
    slot.split = frame.split;
    slot.step = frame.step;
    slot.lines = frame.lines;
    slot.number = frame.number;
    slot.share = frame.share;
    slot.shown = frame.shown;
    slot.began = frame.began;
    slot.clock = frame.clock;
    slot.isMoved = false;
    slot.placed = "";
    slot.smooth = frame.smooth;
    slot.filling = ++fillings;
    slot.choosing = 0;
}

// Which of its points are selected, and which are taken out.
function chooseIn(slot, { choosing, kindOf }) {
    if (slot.choosing === choosing) {
        return;
    }
    const { points, object, size } = slot;
    for (let i = 0; i < size; i++) {
        points.chosen[i] = kindOf(points, i);
    }
    const target = object.geometry.getAttribute("chosen");
    target.addUpdateRange(0, size);
    target.needsUpdate = true;
    slot.choosing = choosing;
}

// Moves its points; those as they came are kept. matrix: null for none.
function place(slot, matrix) {
    const placed = matrix ? matrix.elements.map((v) => v.toFixed(6)).join() : "";
    if (slot.placed === placed) {
        return;
    }
    const { xyz } = slot.points;
    if (!slot.isMoved) {
        slot.own = slot.own?.length === xyz.length ? slot.own : new Float32Array(xyz.length);
        slot.own.set(xyz);
        slot.isMoved = true;
    }
    const e = matrix?.elements ?? [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0];
    for (let i = 0; i < 3 * slot.size; i += 3) {
        const [x, y, z] = [slot.own[i], slot.own[i + 1], slot.own[i + 2]];
        xyz[i] = e[0] * x + e[4] * y + e[8] * z + e[12];
        xyz[i + 1] = e[1] * x + e[5] * y + e[9] * z + e[13];
        xyz[i + 2] = e[2] * x + e[6] * y + e[10] * z + e[14];
    }
    slot.placed = placed;
    slot.choosing &&= MOVED;
    renew(slot, slot.size);
    slot.filling = ++fillings;
}

// One point of each so many in a row, and not always the same: lines of the
// scan would show as stripes.
function thin(slot, part, stride) {
    const count = Math.floor(slot.size / stride);
    for (const [name, [, width, attribute]] of Object.entries(ARRAYS)) {
        const [from, to] = [slot.points[name], part.points[name]];
        for (let i = 0; attribute && i < count; i++) {
            const at = i * stride + ((Math.imul(i, 2654435761) >>> 16) % stride);
            for (let k = 0; k < width; k++) {
                to[width * i + k] = from[width * at + k];
            }
        }
    }
    renew(part, count);
    part.size = count;
    // One of both profiles' points would be either's.
    part.ends = [Math.floor(slot.split / stride), Math.ceil(slot.split / stride)];
}

function setRange({ geometry }, [end, begin], size, side) {
    const [from, to] = side === 0 ? [0, end] : [Math.min(begin, size), size];
    geometry.setDrawRange(from, to - from);
}

// A point covers what lies between it and the next, if those of a sensor's
// lines were spread evenly over what it sees.
const SEEN = 120 * 20; // square degrees
const LINE_POINTS = 1000;

function gapOf({ lines, parts }) {
    const count = (LINE_POINTS * Math.max(1, lines)) / Math.max(1, parts.length);
    return (Math.sqrt(SEEN / count) * Math.PI) / 180;
}

// As a share of the size that was chosen: points that lie far from the camera,
// and near to it.
const LEAST_SIZE = 0.75;
const MOST_SIZE = 5;
const MOST_SPREAD = 2; // of points that stand for others too

const finite = (v) => Math.max(-1e9, Math.min(1e9, v));

export function makeCloud(scene, palette) {
    const material = makeMaterial(palette);
    const u = material.uniforms;
    const slots = []; // by number: the frame that is shown, and before it those at once with it
    let kept = 1;
    let made = ""; // edges and smoothing of what is shown
    let isFresh = true;
    let labels = null; // of beside.js
    let size = 2;
    let spread = 1; // of a point: where not all are drawn, those that are cover more

    function dropPart(part) {
        scene.remove(part.object);
        part.object.geometry.dispose();
    }

    function drop(slot) {
        dropPart(slot);
        if (slot.thinned) {
            dropPart(slot.thinned);
        }
    }

    // What stands for the slot while one point of so many is drawn.
    function makeThin(slot, stride) {
        const needed = Math.ceil(slot.size / stride);
        if (slot.thinned && slot.thinned.room < needed) {
            dropPart(slot.thinned);
            slot.thinned = null;
        }
        if (!slot.thinned) {
            slot.thinned = makePart(material, Math.ceil((1.25 * needed + 1) / 1024) * 1024);
            scene.add(slot.thinned.object);
        }
        const part = slot.thinned;
        if (part.filling !== slot.filling || part.stride !== stride || part.choosing !== slot.choosing) {
            thin(slot, part, stride);
            [part.filling, part.stride, part.choosing] = [slot.filling, stride, slot.choosing];
        }
    }

    function spreadPoints() {
        u.gap.value = slots.length > 0 ? size * spread * gapOf(slots.at(-1)) : 0;
    }

    // Takes out what is not wanted.
    function takeOut(isWanted) {
        const free = slots.filter((slot) => !isWanted(slot));
        slots.splice(0, slots.length, ...slots.filter(isWanted));
        return free;
    }

    // Those at once with the frame of a number, that one apart.
    const isBefore = (number) => (slot) => slot.number < number && slot.number > number - kept;

    const trim = () => takeOut((slot) => slot === slots.at(-1) || isBefore(slots.at(-1).number)(slot)).forEach(drop);

    // Puts a frame in its place, into one of the slots that are free, or a new one.
    function put(frame, free) {
        let slot = free.find(({ room }) => room >= frame.count);
        free.filter((one) => one !== slot).forEach(drop);
        if (!slot) {
            slot = makePart(material, Math.ceil((frame.count + 1) / GRAIN) * GRAIN);
            scene.add(slot.object);
        }
        fill(slot, frame);
        labels?.of(slot, slot.points.label);
        slots.push(slot);
        slots.sort((a, b) => a.number - b.number);
    }

    return {
        slots,
        get newest() {
            return slots.at(-1) ?? null;
        },
        // Edges and smoothing of what is shown.
        get view() {
            return made;
        },
        // Null: the next frame is the first of its kind.
        get current() {
            return isFresh ? null : slots.at(-1) ?? null;
        },
        // The frame that is shown now.
        add(frame) {
            const view = viewOf(frame);
            const isOther = isFresh || view !== made;
            isFresh = false;
            made = view;
            put(frame, takeOut((slot) => !isOther && isBefore(frame.number)(slot)));
        },
        // One before it, unless it is not of these any more.
        addPast(frame) {
            const { number } = slots.at(-1);
            if (viewOf(frame) === made && isBefore(number)(frame)) {
                put(frame, takeOut((slot) => slot.number !== frame.number));
            }
        },
        // Those that are missing before the frame that is shown, from a first one on: 1 for the one just before it,
        // 2 for the one before that, 4, and so on, added.
        missing(first) {
            const { number } = slots.at(-1);
            const have = new Set(slots.map((slot) => slot.number));
            const all = Array.from({ length: kept - 1 }, (_, i) => number - 1 - i);
            return all.reduce((sum, n, i) => sum + (n >= first && !have.has(n) ? 2 ** i : 0), 0);
        },
        // The numbers of the frames, for people.
        get title() {
            const [from, to] = [slots[0].number, slots.at(-1).number];
            const holes = to - from + 1 - slots.length;
            return from === to ? `frame ${to}` : `frames ${from} to ${to}${holes > 0 ? `, ${holes} missing` : ""}`;
        },
        // One point of so many is drawn; returns how many are.
        thin(stride) {
            let drawn = 0;
            for (const slot of slots) {
                if (stride > 1) {
                    makeThin(slot, stride);
                }
                slot.object.visible = stride === 1;
                if (slot.thinned) {
                    slot.thinned.object.visible = stride > 1;
                }
                drawn += Math.floor(slot.size / stride);
            }
            spread = Math.min(MOST_SPREAD, Math.sqrt(stride));
            spreadPoints();
            return drawn;
        },
        // Draws the points by one of the profiles alone.
        choose(side) {
            for (const { object, split, size, thinned } of slots) {
                setRange(object, [split, split], size, side);
                if (thinned) {
                    setRange(thinned.object, thinned.ends, thinned.size, side);
                }
            }
        },
        // How many points there are by the first profile, and by the second.
        count: () => slots.reduce(([one, other], { split, size }) => [one + split, other + size - split], [0, 0]),
        // The next frame is the first of its kind, and replaces all others.
        refresh() {
            isFresh = true;
        },
        clear() {
            isFresh = true;
            takeOut(() => false).forEach(drop);
        },
        get isLabelled() {
            return labels !== null;
        },
        // null: points have none.
        setLabels(next) {
            labels = next;
            for (const slot of slots) {
                slot.points.label.fill(0);
                labels?.of(slot, slot.points.label);
                renew(slot, slot.size);
                slot.filling = ++fillings;
            }
        },
        place,
        setEyes(eyes) {
            eyes.forEach((eye, i) => u.mounts.value[i].fromArray(eye.mount));
        },
        // The points of a selection, in all frames that are shown.
        select(selection) {
            u.fades.value = selection.isOn;
            slots.forEach((slot) => chooseIn(slot, selection));
        },
        setDomain: (domain) => u.domain.value.fromArray(domain),
        // pageHeight: of the picture, in pixels of the page.
        apply(values, pixelRatio, pageHeight) {
            const { range, height } = limits(values);
            u.eyes.value.set(values.blue ? 1 : 0, values.green ? 1 : 0);
            u.rangeClip.value.set(finite(range[0]), finite(range[1]));
            u.heightClip.value.set(finite(height[0]), finite(height[1]));
            u.wantedReturn.value = RETURNS[values.return];
            u.mode.value = COLOURINGS[values.colour].mode;
            u.logarithmic.value = COLOURINGS[values.colour].logarithmic === true;
            size = values.size;
            u.sizes.value.set(LEAST_SIZE, MOST_SIZE).multiplyScalar(size * pixelRatio);
            u.halfHeight.value = 0.5 * pageHeight * pixelRatio;
            spreadPoints();
            kept = values.accumulate;
            trim();
        },
    };
}
