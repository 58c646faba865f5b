// The camera: it looks at a target from a distance. x forward, y left, z up.
import * as THREE from "three";

const DEGREE = Math.PI / 180;
const NEAREST = 0.2; // metres
const FARTHEST = 2000;
const FIELD = 50; // degrees, vertically
const WIDE = 105; // horizontally, from the sensor
const TURN = 0.3 * DEGREE; // of a pixel of drag
const STEP = 5 * DEGREE; // of a key

// reach: metres that a view should take in.
const VIEWS = {
    home: () => ({ target: [12, 0, -1], yaw: 0, pitch: 22, distance: 26, field: FIELD, flat: false }),
    top: (reach) => ({ target: [reach / 2, 0, 0], yaw: 0, pitch: 90, distance: 1.2 * reach, field: FIELD, flat: true }),
    front: (reach) => ({ target: [reach / 2, 0, 1], yaw: 0, pitch: 0, distance: 0.45 * reach, field: FIELD, flat: true }),
    sensor: () => ({ target: [0.5, 0, -0.05], yaw: 0, pitch: 6, distance: 0.5, field: null, flat: false }),
};

export function makeCamera(changed) {
    const perspective = new THREE.PerspectiveCamera(FIELD, 1, 0.05, 4000);
    const parallel = new THREE.OrthographicCamera(-1, 1, 1, -1, -4000, 4000);
    const target = new THREE.Vector3();
    const right = new THREE.Vector3();
    const up = new THREE.Vector3();
    const ahead = new THREE.Vector3();
    const basis = new THREE.Matrix4();
    const turned = new THREE.Quaternion();
    let at = { yaw: 0, pitch: 0, distance: 1, field: FIELD };
    let field = FIELD;
    let flat = false;
    let width = 1;
    let height = 1;

    function orient() {
        const [cy, sy, cp, sp] = [Math.cos(at.yaw), Math.sin(at.yaw), Math.cos(at.pitch), Math.sin(at.pitch)];
        ahead.set(cp * cy, cp * sy, -sp);
        right.set(sy, -cy, 0);
        up.crossVectors(right, ahead);
        basis.makeBasis(right, up, ahead.clone().negate());
        perspective.quaternion.setFromRotationMatrix(basis);
    }

    // From the sensor the width counts, elsewhere the height.
    function fieldNow() {
        const half = Math.atan((Math.tan((WIDE / 2) * DEGREE) * height) / width) / DEGREE;
        return at.field ?? Math.min(90, 2 * half);
    }

    function project() {
        field = fieldNow();
        const half = at.distance * Math.tan((field / 2) * DEGREE);
        perspective.fov = field;
        perspective.aspect = width / height;
        perspective.near = Math.max(0.02, at.distance / 500);
        perspective.far = 4000 + at.distance;
        parallel.top = half;
        parallel.bottom = -half;
        parallel.right = (half * width) / height;
        parallel.left = -parallel.right;
        perspective.updateProjectionMatrix();
        parallel.updateProjectionMatrix();
    }

    function update() {
        orient();
        perspective.position.copy(target).addScaledVector(ahead, -at.distance);
        parallel.quaternion.copy(perspective.quaternion);
        parallel.position.copy(perspective.position);
        project();
        perspective.updateMatrixWorld();
        parallel.updateMatrixWorld();
        changed();
    }

    function turn(yaw, pitch) {
        at.yaw = (at.yaw + yaw) % (2 * Math.PI);
        at.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, at.pitch + pitch));
    }

    const self = {
        get active() {
            return flat ? parallel : perspective;
        },
        // Metres that a pixel covers at a place.
        metresOfPixel(place) {
            const depth = flat ? at.distance : Math.max(0.01, place.clone().sub(perspective.position).dot(ahead));
            return (2 * depth * Math.tan((field / 2) * DEGREE)) / height;
        },
        // Where a place stands, in pixels of the page about its middle.
        pageOf(place) {
            const at = place.clone().project(self.active);
            return { x: (at.x * width) / 2, y: (-at.y * height) / 2 };
        },
        resize(w, h) {
            [width, height] = [w, h];
            update();
        },
        setFlat(isFlat) {
            flat = isFlat;
            update();
        },
        // About what the camera looks at.
        rotate(yaw, pitch) {
            turn(yaw, pitch);
            update();
        },
        // About the sensor, with all that the camera sees.
        orbit(yaw, pitch) {
            const before = perspective.quaternion.clone();
            turn(yaw, pitch);
            orient();
            target.applyQuaternion(turned.copy(perspective.quaternion).multiply(before.invert()));
            update();
        },
        // By pixels of the page: the scene follows the pointer.
        pan(x, y) {
            const metres = self.metresOfPixel(target);
            target.addScaledVector(right, -x * metres).addScaledVector(up, y * metres);
            update();
        },
        zoom(factor) {
            at.distance = Math.max(NEAREST, Math.min(FARTHEST, at.distance * factor));
            update();
        },
        // Returns whether the view wants parallel projection.
        show(name, reach) {
            const view = VIEWS[name](reach);
            target.fromArray(view.target);
            at = { yaw: view.yaw * DEGREE, pitch: view.pitch * DEGREE, distance: view.distance, field: view.field };
            update();
            return view.flat;
        },
        look: () => ({
            position: perspective.position.toArray(),
            target: target.toArray(),
            yaw: at.yaw / DEGREE,
            pitch: at.pitch / DEGREE,
            distance: at.distance,
            flat,
        }),
    };
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

function dragMove(camera, event, dx, dy) {
    if (event.shiftKey || event.buttons === 4 || (event.buttons === 2 && !event.ctrlKey)) {
        camera.pan(dx, dy);
    } else if (event.ctrlKey) {
        camera.orbit(-dx * TURN, dy * TURN);
    } else {
        camera.rotate(-dx * TURN, dy * TURN);
    }
}

const spread = ([a, b]) => Math.hypot(a.x - b.x, a.y - b.y);
const middle = ([a, b]) => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });

// Two fingers: their distance zooms, their middle pans.
function pinchMove(camera, before, after) {
    const [from, to] = [middle(before), middle(after)];
    camera.zoom(spread(before) / Math.max(1, spread(after)));
    camera.pan(to.x - from.x, to.y - from.y);
}

// Mouse, pen and fingers on the canvas. clicked(x, y): no drag.
export function attachPointer(canvas, camera, clicked) {
    const down = new Map();
    let path = 0;

    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        down.set(event.pointerId, { x: event.clientX, y: event.clientY });
        path = down.size === 1 ? 0 : Infinity;
    });
    canvas.addEventListener("pointermove", (event) => {
        const last = down.get(event.pointerId);
        if (!last) {
            return;
        }
        const before = [...down.values()];
        const now = { x: event.clientX, y: event.clientY };
        down.set(event.pointerId, now);
        path += Math.hypot(now.x - last.x, now.y - last.y);
        if (down.size === 2) {
            pinchMove(camera, before, [...down.values()]);
        } else if (path > 3) {
            dragMove(camera, event, now.x - last.x, now.y - last.y);
        }
    });
    const end = (event) => {
        const wasDown = down.delete(event.pointerId);
        if (wasDown && event.type === "pointerup" && event.button === 0 && path <= 3) {
            const box = canvas.getBoundingClientRect();
            clicked(event.clientX - box.left, event.clientY - box.top);
        }
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    const wheel = (event) => {
        event.preventDefault();
        const lines = event.deltaMode === 0 ? event.deltaY / 40 : event.deltaY;
        camera.zoom(1.04 ** Math.max(-10, Math.min(10, lines)));
    };
    canvas.addEventListener("wheel", wheel, { passive: false });
}
