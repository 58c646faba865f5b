// A box that is drawn over a picture, with the mouse, a finger or the keyboard.

const STILL_PX = 4; // a click may move so far
const STEP_PX = 10; // of an arrow key
const SHARE = 0.25; // of the picture: a box that the keyboard begins
const ARROWS = { ArrowUp: [0, -1], ArrowDown: [0, 1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };

const limit = (v, most) => Math.max(0, Math.min(most, v));

// canvas: the picture; frame: the element over it that shows the box. on: box({
// left, top, right, bottom }) in pixels of the canvas, and mode(isOn). Dragging
// draws while the mode is on, or always.
export function makeBox(canvas, frame, on, isAlways = false) {
    let isOn = false;
    let held = null; // { id, x, y }: the pointer that draws, and where it began
    let box = null;

    const size = () => [canvas.clientWidth, canvas.clientHeight];

    function show(next) {
        box = next;
        frame.hidden = box === null;
        if (box) {
            [frame.style.left, frame.style.top] = [`${canvas.offsetLeft + box.left}px`, `${canvas.offsetTop + box.top}px`];
            [frame.style.width, frame.style.height] = [`${box.right - box.left}px`, `${box.bottom - box.top}px`];
        }
    }

    function setMode(next) {
        isOn = next;
        held = null;
        show(null);
        on.mode?.(isOn);
    }

    function finish() {
        const made = box;
        setMode(false);
        if (made) {
            on.box(made);
        }
    }

    const place = (event) => {
        const at = canvas.getBoundingClientRect();
        const [width, height] = size();
        return { x: limit(event.clientX - at.left, width), y: limit(event.clientY - at.top, height) };
    };

    // Nothing else hears of what draws: the camera stands still.
    function take(event) {
        event.preventDefault();
        event.stopPropagation();
    }

    function press(event) {
        if (event.target !== canvas || !(isOn || isAlways) || event.button !== 0 || held) {
            return;
        }
        if (isOn) {
            take(event);
            canvas.focus();
            show(null); // what the keyboard began
        }
        canvas.setPointerCapture(event.pointerId);
        held = { id: event.pointerId, ...place(event) };
    }

    function move(event) {
        if (event.pointerId !== held?.id) {
            return;
        }
        take(event);
        const { x, y } = place(event);
        const isMoved = box !== null || Math.hypot(x - held.x, y - held.y) > STILL_PX;
        if (isMoved) {
            const [left, right] = [held.x, x].sort((a, b) => a - b);
            const [top, bottom] = [held.y, y].sort((a, b) => a - b);
            show({ left, top, right, bottom });
        }
    }

    // A press that did not move is a click, of whoever hears of clicks.
    function release(event) {
        if (event.pointerId !== held?.id) {
            return;
        }
        held = null;
        if (box) {
            take(event);
            finish();
        }
    }

    function cancel(event) {
        if (event.pointerId === held?.id) {
            setMode(false);
        }
    }

    function moveBy(x, y, isSize) {
        const [width, height] = size();
        const { left, top, right, bottom } = box;
        if (isSize) {
            show({ left, top, right: Math.max(left + 1, limit(right + x, width)), bottom: Math.max(top + 1, limit(bottom + y, height)) });
        } else {
            const [dx, dy] = [limit(left + x, width - right + left) - left, limit(top + y, height - bottom + top) - top];
            show({ left: left + dx, top: top + dy, right: right + dx, bottom: bottom + dy });
        }
    }

    const KEYS = { Enter: finish, Escape: () => setMode(false) };

    function pressKey(event) {
        const arrow = ARROWS[event.key];
        const run = KEYS[event.key];
        if (!isOn || event.ctrlKey || event.altKey || !(arrow || run)) {
            return;
        }
        take(event);
        if (run) {
            run();
        } else {
            moveBy(STEP_PX * arrow[0], STEP_PX * arrow[1], event.shiftKey);
        }
    }

    const options = { capture: true };
    const around = canvas.parentElement;
    around.addEventListener("pointerdown", press, options);
    around.addEventListener("pointermove", move, options);
    around.addEventListener("pointerup", release, options);
    around.addEventListener("pointercancel", cancel, options);
    canvas.addEventListener("keydown", pressKey, options);

    return {
        get isOn() {
            return isOn;
        },
        end: () => setMode(false),
        // Begins with a box in the middle, or about a place.
        begin([x, y] = size().map((v) => v / 2)) {
            const [width, height] = size();
            const [w, h] = [SHARE * width, SHARE * height];
            setMode(true);
            canvas.focus();
            const [left, top] = [limit(x - w / 2, width - w), limit(y - h / 2, height - h)];
            show({ left, top, right: left + w, bottom: top + h });
        },
    };
}
