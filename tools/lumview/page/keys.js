// The keyboard. Help is made of the same table that the keys are found in.
import { moveByKey } from "./camera.js";

const TEXTS = "input[type=number], select, textarea";
const SLIDER_KEYS = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown"]);
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };

// Whether the element that has the focus wants the key for itself.
function isTaken(event) {
    const target = event.target;
    if (document.querySelector("dialog[open]") || target.matches?.(TEXTS)) {
        return true;
    }
    if (target.matches?.("input[type=range], .stats")) {
        return SLIDER_KEYS.has(event.key);
    }
    return event.key === " " && target.matches?.("button, input, a");
}

const how = (event) => (event.ctrlKey ? "orbit" : event.shiftKey ? "pan" : "plain");

// Groups of [keys shown, event.key values, what it does, action].
function makeTable(app) {
    const { camera, settings, panel, player } = app;
    const { values, set } = settings;
    const flip = (key) => () => set({ [key]: !values[key] });
    const add = (key, by, least, most) => () => set({ [key]: Math.max(least, Math.min(most, values[key] + by)) });
    const colour = () => {
        panel.next("colour", "colour");
        set({ from: null, to: null });
    };
    return {
        Camera: [
            ["↑ ↓", [], "nearer, farther"],
            ["← →", [], "turn about what is looked at"],
            ["Page up, Page down", [], "look more from above, from below"],
            ["Shift + arrows", [], "pan"],
            ["Ctrl + arrows", [], "orbit the sensor"],
            ["0", ["0"], "view from the start", () => app.view("home")],
            ["1", ["1"], "view from above", () => app.view("top")],
            ["2", ["2"], "view level, forward", () => app.view("front")],
            ["3", ["3"], "view from the sensor", () => app.view("sensor")],
            ["T", ["t"], "turn about the point in the middle", app.turnAboutMiddle],
            ["Q", ["q"], "parallel projection on, off", flip("flat")],
        ],
        Points: [
            ["R", ["r"], "next choice of returns", () => panel.next("return", "return")],
            ["E", ["e"], "next choice of edges", () => panel.next("edges", "edges")],
            ["S", ["s"], "next smoothing of angles", () => panel.next("smooth", "smooth")],
            ["B", ["b"], "blue eye on, off", flip("blue")],
            ["G", ["g"], "green eye on, off", flip("green")],
            ["C", ["c"], "colour by the next", colour],
            ["M", ["m"], "next colour map", () => panel.next("map", "map")],
            ["+ −", ["+", "="], "larger, smaller points", add("size", 0.5, 1, 10)],
            [null, ["-"], null, add("size", -0.5, 1, 10)],
            ["4", ["4"], "depth shading: auto, on, off", () => panel.next("edl", "edl")],
            ["A, Shift + A", ["a"], "one frame more, less at once", add("accumulate", 1, 1, 50)],
            [null, ["A"], null, add("accumulate", -1, 1, 50)],
            ["K", ["k"], "data of the point in the middle", app.pickMiddle],
            ["X", ["x"], "distance from there to the next point, or no more", app.measure],
            ["W", ["w"], "draw a box that selects points: arrows, Shift + arrows, Enter", app.drawBox],
            ["U", ["u"], "show what was cropped and hidden", app.showAll],
            ["Escape", ["Escape"], "close the point's data, end the selection", app.closePick],
        ],
        Capture: [
            ["Space", [" "], "pause, play; live: hold, go on", player.toggle],
            [", .", [","], "one frame back, on", () => player.step(-1)],
            [null, ["."], null, () => player.step(1)],
            ["< >", ["<"], "ten frames back, on", () => player.step(-10)],
            [null, [">"], null, () => player.step(10)],
            ["Home, End", ["Home"], "first, last frame", player.toFirst],
            [null, ["End"], null, player.toLast],
            ["N, Shift + N", ["n"], "next, previous mark of a loss or a pause", player.toNextMark],
            [null, ["N"], null, player.toPreviousMark],
            ["L", ["l"], "loop on, off", player.toggleLoop],
            ["[ ]", ["["], "slower, faster", () => player.changeSpeed(-1)],
            [null, ["]"], null, () => player.changeSpeed(1)],
        ],
        Page: [
            ["Tab", [], "next control"],
            ["V", ["v"], "back to the picture", app.focusCanvas],
            ["5", ["5"], "theme: of the system, dark, light", () => panel.next("theme", "theme")],
            ["D", ["d"], "grid on, off", flip("grid")],
            ["O", ["o"], "range rings on, off", flip("rings")],
            ["8", ["8"], "frames where they were taken, by poses: on, off", flip("world")],
            ["9", ["9"], "ground truth on, off", flip("truth")],
            ["H", ["h"], "controls on, off", () => app.toggle("panel")],
            ["I", ["i"], "statistics on, off", () => app.toggle("stats")],
            ["Y", ["y"], "legend folded, unfolded", () => app.toggle("legend")],
            ["J", ["j"], "pictures beside the cloud on, off", () => app.toggle("strip")],
            ["P", ["p"], "screenshot", app.shot],
            ["F", ["f"], "open files (lumview.html)", app.openFiles],
            ["Z", ["z"], "reset all controls", settings.reset],
            ["?", ["?"], "this help", app.help],
        ],
    };
}

const MOUSE = [
    ["left drag", null, "turn about what is looked at"],
    ["double click", null, "turn about this point"],
    ["wheel", null, "nearer to what is under the pointer, farther"],
    ["Shift + drag, right drag", null, "pan"],
    ["Ctrl + drag", null, "orbit the sensor"],
    ["click", null, "data of a point"],
    ["Shift + click", null, "distance from the point picked before"],
    ["one finger, two fingers", null, "turn; zoom and pan"],
];

function helpTable(title, rows) {
    const table = document.createElement("table");
    table.createCaption().textContent = title;
    for (const [keys, , text] of rows.filter((r) => r[0] !== null)) {
        const line = table.insertRow();
        const head = document.createElement("th");
        head.scope = "row";
        const key = document.createElement("kbd");
        key.textContent = keys;
        head.append(key);
        line.append(head);
        line.insertCell().textContent = text;
    }
    return table;
}

function moveCamera(camera, event) {
    if (event.key === "PageUp" || event.key === "PageDown") {
        moveByKey(camera, 0, event.key === "PageUp" ? 1 : -1, "tilt");
        return true;
    }
    const arrow = ARROWS[event.key];
    if (arrow) {
        moveByKey(camera, arrow[0], arrow[1], how(event));
    }
    return Boolean(arrow);
}

export function attachKeys(app) {
    const table = makeTable(app);
    const rows = Object.values(table).flat();
    const actions = new Map(rows.flatMap(([, keys, , run]) => keys.map((key) => [key, run])));
    const tables = Object.entries(table).map(([title, group]) => helpTable(title, group));
    document.getElementById("help-tables").replaceChildren(...tables, helpTable("Mouse and touch", MOUSE));

    document.addEventListener("keydown", (event) => {
        if (event.defaultPrevented || event.altKey || event.metaKey || isTaken(event)) {
            return;
        }
        const key = event.key;
        const run = event.ctrlKey ? null : (actions.get(key) ?? actions.get(event.shiftKey ? key : key.toLowerCase()));
        if (moveCamera(app.camera, event)) {
            event.preventDefault();
        } else if (run) {
            event.preventDefault();
            run();
        }
    });
}
