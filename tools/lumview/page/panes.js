// The picture: one pane, or two side by side, which show the same by two
// profiles, with one camera.

const at = (id) => document.getElementById(id);
const LEFT = 0;
const RIGHT = 1;

// What a profile has that the other has not.
function describe(name, differences, side) {
    const keys = differences.map((one) => `${one.key} ${(side === LEFT ? one.one : one.other) || "none"}`);
    return { name: name.split("/").at(-1), text: keys.join(", ") || "the same layout" };
}

function showName(side, { name, text }) {
    at(`beside-${side}`).textContent = name;
    at(`beside-${side}-keys`).textContent = text;
}

export function makePanes(canvas, renderer) {
    let names = null; // of the profiles, where there are two

    const count = () => (names ? 2 : 1);
    const width = () => canvas.clientWidth / count();

    function drawPane(side, draw) {
        const box = [side * width(), 0, width(), canvas.clientHeight];
        renderer.setViewport(...box);
        renderer.setScissor(...box);
        draw();
    }

    return {
        // Of each.
        get width() {
            return width();
        },
        get names() {
            return names;
        },
        // profiles: of the server's greeting; null: there is one.
        show(profiles) {
            names = profiles && [profiles.one, profiles.other].map((name) => name.split("/").at(-1));
            at("beside").hidden = names === null;
            if (profiles) {
                showName(LEFT, describe(profiles.one, profiles.differences, LEFT));
                showName(RIGHT, describe(profiles.other, profiles.differences, RIGHT));
            }
        },
        // The pane under a place of the canvas, and where it is in that.
        find(x) {
            const side = names && x >= width() ? RIGHT : LEFT;
            return { side, x: x - side * width() };
        },
        // The points of a slot that a pane shows, from the first to before the last.
        range: (slot, side) => (side === LEFT ? [0, slot.split] : [slot.split, slot.size]),
        // Where a pane begins, in pixels of the canvas.
        left: (side) => side * width(),
        // draw(): the scene; choose(side): the points that it has then.
        render(choose, draw) {
            renderer.setScissorTest(names !== null);
            for (let side = 0; side < count(); side++) {
                choose(side);
                drawPane(side, draw);
            }
        },
    };
}
