// The camera: three's OrbitControls, with views, keys and a second camera for
// parallel projection. x forward, y left, z up.
import { MOUSE, OrthographicCamera, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const DEGREE = Math.PI / 180;
const NEAREST = 0.2; // metres
const FARTHEST = 2000;
const FIELD = 50; // degrees, vertically
const WIDE = 105; // horizontally, from the sensor
const STEP = 5 * DEGREE; // of a key
const WHEEL = 2.5; // a step of the wheel leaves 88 % of the way
const GLIDE_MS = 70; // what is left of a movement after it: a third
const PAUSE_MS = 1000; // pictures further apart are of two movements
const LEAST_MS = 4; // between two; a movement that stood still would not be seen as one
const NUMBERS = 8; // of the address
const DIGITS = 4; // behind their points
const STEEPEST = 89.9999; // degrees; beyond it a camera that looks down has no forward direction
const FAR = 1e5; // metres, degrees
const STILL = window.matchMedia("(prefers-reduced-motion: reduce)"); // nothing glides
const UP = new Vector3(0, 0, 1);

// reach: metres that a view should take in; narrow: how much farther away the
// same width is seen whole.
const VIEWS = {
    home: (reach, narrow) => ({ target: [12, 0, -1], pitch: 22, distance: 26 * narrow, field: FIELD, flat: false }),
    top: (reach, narrow) => ({ target: [reach / 2, 0, 0], pitch: 89.999, distance: 1.2 * reach * narrow, field: FIELD, flat: true }),
    front: (reach) => ({ target: [reach / 2, 0, 1], pitch: 0, distance: 0.45 * reach, field: FIELD, flat: true }),
    sensor: () => ({ target: [0.5, 0, -0.05], pitch: 6, distance: 0.5, field: null, flat: false }),
};

// Of points that lie about another place than the sensor.
const VIEWS_ABOUT = {
    ...VIEWS,
    home: (reach, narrow) => ({ ...VIEWS.home(reach, 1), distance: 2.5 * reach * narrow }),
    top: (reach, narrow) => ({ ...VIEWS.top(reach, 1), distance: 2.5 * reach * narrow }),
    front: (reach) => ({ ...VIEWS.front(reach), distance: 2.5 * reach }),
};

// The numbers of an address; null: they are no camera's.
function parseText(text) {
    const numbers = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
    const [, , , , , away, degrees, height] = numbers;
    const isSound = numbers.length === NUMBERS && numbers.every((v) => Math.abs(v) <= FAR);
    const isSized = away >= NEAREST / 2 && away <= 2 * FARTHEST && height >= 0 && (degrees === 0 || (degrees >= 1 && degrees <= 120));
    return isSound && isSized ? numbers : null;
}

function makeControls(camera, canvas) {
    const controls = new OrbitControls(camera, canvas);
    controls.zoomToCursor = true;
    controls.zoomSpeed = WHEEL;
    controls.minDistance = NEAREST;
    controls.maxDistance = FARTHEST;
    controls.enableDamping = !STILL.matches;
    STILL.addEventListener("change", () => {
        controls.enableDamping = !STILL.matches;
    });
    controls.mouseButtons.MIDDLE = MOUSE.PAN;
    controls.cursorStyle = "grab";
    return controls;
}

export function makeCamera(canvas, changed) {
    const perspective = new PerspectiveCamera(FIELD, 1, 0.05, 4000);
    const parallel = new OrthographicCamera(-1, 1, 1, -1, -4000, 4000);
    perspective.up.copy(UP);
    parallel.up.copy(UP);
    const controls = makeControls(perspective, canvas);
    const { target } = controls;
    const ahead = new Vector3();
    const right = new Vector3();
    let view = VIEWS.home(40, 1);
    let half = 1; // metres, of the parallel picture's height before its zoom
    let size = { width: 1, height: 1, left: 0, right: 0 };
    let goal = null; // where the turning point is on its way to
    let last = 0; // milliseconds
    let isDragged = false;
    let start = ""; // what the view from the start is in the address

    const active = () => controls.object;
    const isFlat = () => active() === parallel;
    const distance = () => active().position.distanceTo(target);
    const tangent = () => Math.tan((perspective.fov / 2) * DEGREE);

    // From the sensor the width counts, elsewhere the height.
    function field() {
        const free = size.width - size.left - size.right;
        const wide = Math.atan((Math.tan((WIDE / 2) * DEGREE) * size.height) / free) / DEGREE;
        return view.field ?? Math.min(90, 2 * wide);
    }

    // The middle of the picture is that of what nothing lies over.
    function project() {
        const { width, height } = size;
        perspective.fov = field();
        perspective.aspect = width / height;
        perspective.near = Math.max(0.02, distance() / 500);
        perspective.far = 4000 + distance();
        parallel.top = half;
        parallel.bottom = -half;
        parallel.right = (half * width) / height;
        parallel.left = -parallel.right;
        for (const camera of [perspective, parallel]) {
            camera.setViewOffset(width, height, (size.right - size.left) / 2, 0, width, height);
        }
    }

    function settle() {
        project();
        active().updateMatrixWorld();
        active().getWorldDirection(ahead);
        right.setFromMatrixColumn(active().matrixWorld, 0);
    }

    function update() {
        controls.update();
        settle();
    }

    // What is left of a movement is carried out.
    function stop() {
        const glides = controls.enableDamping;
        controls.enableDamping = false;
        controls.update();
        controls.enableDamping = glides;
        goal = null;
    }

    // Both cameras show the same at the turning point.
    function use(flat) {
        const from = active();
        if (flat === isFlat()) {
            return;
        }
        if (flat) {
            half = distance() * tangent();
            parallel.zoom = 1;
            parallel.position.copy(from.position);
        } else {
            const away = half / parallel.zoom / tangent();
            perspective.position.copy(target).addScaledVector(ahead, -away);
        }
        controls.object = flat ? parallel : perspective;
        update();
    }

    function show(name, { reach, middle }) {
        const free = size.width - size.left - size.right;
        const made = (middle ? VIEWS_ABOUT : VIEWS)[name](reach, Math.max(1, (1.25 * size.height) / free) ** 0.8);
        const isFlatView = made.flat;
        stop();
        use(false);
        view = middle && name !== "sensor" ? { ...made, target: middle } : made;
        const [cos, sin] = [Math.cos(view.pitch * DEGREE), Math.sin(view.pitch * DEGREE)];
        target.fromArray(view.target);
        perspective.position.copy(target).add(new Vector3(-cos, 0, sin).multiplyScalar(view.distance));
        update();
        use(isFlatView);
        changed();
    }

    // For the address: turning point, angles, distance; the field of view, 0 where the picture's width decides; metres of a
    // parallel picture's height, 0 without.
    function textOf() {
        const { yaw, pitch } = self.look();
        const away = active().position.distanceTo(target);
        const sizes = [view.field ?? 0, isFlat() ? (2 * half) / parallel.zoom : 0];
        return [...target.toArray(), yaw, pitch, away, ...sizes].map((v) => Number(v.toFixed(DIGITS))).join(",");
    }

    function place([x, y, z, yaw, pitch, away, degrees, height], flat) {
        const tilt = Math.max(-STEEPEST, Math.min(STEEPEST, pitch)) * DEGREE;
        const turn = yaw * DEGREE;
        stop();
        use(false);
        view = { ...view, field: degrees || null };
        target.set(x, y, z);
        const back = new Vector3(-Math.cos(turn) * Math.cos(tilt), -Math.sin(turn) * Math.cos(tilt), Math.sin(tilt));
        perspective.position.copy(target).addScaledVector(back, away);
        update();
        use(flat);
        if (flat && height > 0) {
            half = height / 2;
            update();
        }
        changed();
    }

    function pitchOf() {
        return Math.asin(Math.max(-1, Math.min(1, -ahead.z)));
    }

    controls.addEventListener("change", () => {
        settle();
        changed();
    });
    controls.addEventListener("start", () => {
        isDragged = true;
        goal = null;
    });
    controls.addEventListener("end", () => {
        isDragged = false;
        changed();
    });

    const self = {
        get active() {
            return active();
        },
        // From the turning point, metres.
        get distance() {
            return isFlat() ? half / parallel.zoom / tangent() : distance();
        },
        // Whether fingers or a button hold the camera.
        get dragged() {
            return isDragged;
        },
        // Moves on; before each picture.
        tick(now) {
            const passed = now - last < PAUSE_MS ? Math.max(LEAST_MS, now - last) : 1000 / 60;
            const share = controls.enableDamping ? 1 - Math.exp(-passed / GLIDE_MS) : 1;
            last = now;
            controls.dampingFactor = share;
            if (goal) {
                target.lerp(goal, share);
                goal = target.distanceTo(goal) > 1e-3 * distance() ? goal : null;
            }
            update();
        },
        // Metres that a pixel covers at a place.
        metresOfPixel(place) {
            const depth = Math.max(0.01, place.clone().sub(active().position).dot(ahead));
            const metres = isFlat() ? half / parallel.zoom : depth * tangent();
            return (2 * metres) / size.height;
        },
        // Where a place stands, in pixels of the page about its middle.
        pageOf(place) {
            const at = place.clone().project(active());
            return { x: (at.x * size.width) / 2, y: (-at.y * size.height) / 2 };
        },
        // left, right: pixels that something lies over; isPane: it is one of
        // several, so the controls do not know where in it the pointer is.
        resize(next) {
            size = next;
            controls.zoomToCursor = !next.isPane;
            update();
            changed();
        },
        setFlat(flat) {
            stop();
            use(flat);
            changed();
        },
        rotate(yaw, pitch) {
            controls.rotateLeft(-yaw);
            controls.rotateUp(pitch);
            changed();
        },
        // About the sensor, with all that the camera sees.
        orbit(yaw, pitch) {
            stop();
            const most = Math.PI / 2 - 1e-4;
            const tilt = Math.max(-most, Math.min(most, pitchOf() + pitch)) - pitchOf();
            for (const place of [active().position, target]) {
                place.applyAxisAngle(right, -tilt).applyAxisAngle(UP, yaw);
            }
            update();
            changed();
        },
        // The middle of the picture, in pixels of the canvas.
        middle: () => [(size.left + size.width - size.right) / 2, size.height / 2],
        // By pixels of the page: the scene follows the pointer.
        pan(x, y) {
            controls.pan(x, y);
            changed();
        },
        zoom(factor) {
            controls.dollyIn(factor);
            changed();
        },
        // As far away as this place is what the wheel leads to, and what the
        // pointer holds.
        reachTo(position) {
            if (!isFlat()) {
                stop();
                const away = new Vector3().fromArray(position).distanceTo(active().position);
                target.copy(active().position).addScaledVector(ahead, Math.max(NEAREST, away));
                update();
            }
        },
        // The turning point.
        turnAbout(position) {
            stop();
            goal = new Vector3().fromArray(position);
            changed();
        },
        // By what extentOf() tells.
        show: (name, extent) => {
            show(name, extent);
            start = name === "home" ? textOf() : start;
            return view.flat;
        },
        // For the address; null: the view from the start.
        get text() {
            const text = textOf();
            return text === start ? null : text;
        },
        // By the text of an address; what makes no sense changes nothing.
        take(text, flat) {
            const numbers = parseText(text);
            if (numbers) {
                place(numbers, flat);
            }
        },
        look: () => ({
            position: active().position.toArray(),
            target: target.toArray(),
            yaw: Math.atan2(target.y - active().position.y, target.x - active().position.x) / DEGREE,
            pitch: pitchOf() / DEGREE,
            distance: self.distance,
            flat: isFlat(),
        }),
    };
    update();
    return self;
}

// Arrow keys and the page keys: x to the right, y up, in steps.
export function moveByKey(camera, x, y, how) {
    const moves = {
        plain: () => (y !== 0 ? camera.zoom(0.9 ** y) : camera.rotate(-x * STEP, 0)),
        tilt: () => camera.rotate(0, y * STEP),
        pan: () => camera.pan(-40 * x, 40 * y),
        orbit: () => camera.orbit(-x * STEP, y * STEP),
    };
    moves[how]();
}
