// Mouse, pen and fingers on the picture, as far as they are not the camera's
// controls': clicks, and where the wheel and two fingers lead to.
import { Vector2 } from "three";

const STILL_PX = 4; // a click may move so far
const DOUBLE_MS = 400;
const TURN = (0.3 * Math.PI) / 180; // of a pixel of drag about the sensor

const isTouching = (a, b) => Math.hypot(a.x - b.x, a.y - b.y) <= 20;
const isNear = (a, b) => Math.hypot(a.x - b.x, a.y - b.y) <= STILL_PX;

// on: { click(x, y, isEnd), doubleClick(x, y) } in pixels of the canvas. isEnd:
// with Shift. Browsers do not agree on whether fingers double-click.
function attachClicks(canvas, place, on) {
    const down = new Set();
    let from = null; // of what may become a click
    let last = { time: -Infinity };

    function click(event) {
        const at = { ...place(event), time: event.timeStamp };
        on.click(at.x, at.y, event.shiftKey);
        if (event.pointerType === "touch" && at.time - last.time < DOUBLE_MS && isTouching(at, last)) {
            on.doubleClick(at.x, at.y);
        }
        last = at;
    }

    canvas.addEventListener("pointerdown", (event) => {
        down.add(event.pointerId);
        from = down.size === 1 && event.button === 0 && !event.ctrlKey ? place(event) : null;
    });
    canvas.addEventListener("pointermove", (event) => {
        if (from && !isNear(from, place(event))) {
            from = null;
        }
    });
    canvas.addEventListener("pointerup", (event) => {
        down.delete(event.pointerId);
        if (from) {
            click(event);
        }
        from = null;
    });
    canvas.addEventListener("pointercancel", (event) => {
        down.delete(event.pointerId);
        from = null;
    });
    canvas.addEventListener("dblclick", (event) => {
        const at = place(event);
        on.doubleClick(at.x, at.y);
    });
}

// What is under the wheel, under a pan or between two fingers is what they are
// about. As long as the wheel stays where it is, it is about the same.
function attachReach(canvas, place, reach) {
    const touches = new Map();
    let wheel = null;
    const options = { capture: true, passive: true };

    canvas.addEventListener("wheel", (event) => {
        const at = place(event);
        if (!wheel || !isNear(wheel, at)) {
            reach(at.x, at.y);
            wheel = at;
        }
    }, options);
    canvas.addEventListener("pointerdown", (event) => {
        wheel = null;
        touches.set(event.pointerId, new Vector2().copy(place(event)));
        const [a, b] = [...touches.values()];
        if (touches.size === 2) {
            const middle = a.clone().add(b).multiplyScalar(0.5);
            reach(middle.x, middle.y);
        } else if (event.button !== 0 || event.shiftKey) {
            reach(a.x, a.y);
        }
    }, options);
    for (const end of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(end, (event) => touches.delete(event.pointerId), options);
    }
    document.addEventListener("keydown", () => {
        wheel = null;
    }, options);
}

// Ctrl + drag is not the controls' but orbits the sensor.
function attachOrbit(canvas, camera) {
    let at = null;
    canvas.addEventListener("pointerdown", (event) => {
        if (event.ctrlKey && event.button === 0) {
            event.stopImmediatePropagation();
            canvas.setPointerCapture(event.pointerId);
            at = { x: event.clientX, y: event.clientY };
        }
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => {
        if (at) {
            camera.orbit(-(event.clientX - at.x) * TURN, (event.clientY - at.y) * TURN);
            at = { x: event.clientX, y: event.clientY };
        }
    });
    for (const end of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(end, () => {
            at = null;
        });
    }
}

// on: as above, and reach(x, y): the pointer is about to move what is there.
export function attachPointer(canvas, camera, on) {
    const place = (event) => {
        const box = canvas.getBoundingClientRect();
        return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    attachReach(canvas, place, on.reach);
    attachOrbit(canvas, camera);
    attachClicks(canvas, place, on);
}
