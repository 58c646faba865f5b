// The legend: the map of the colours with values and units.
import { chosenDomain, COLOURINGS } from "./colouring.js";
import { STEPS } from "./palette.js";

const css = ([r, g, b]) => `rgb(${Math.round(r)}, ${Math.round(g)}, ${Math.round(b)})`;

function linearTicks([a, b]) {
    const raw = (b - a) / 5;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const step = unit * [1, 2, 5, 10].find((k) => k * unit >= raw);
    const first = Math.ceil(a / step - 1e-9);
    const count = Math.floor(b / step + 1e-9) - first + 1;
    return Array.from({ length: count }, (_, i) => Number(((first + i) * step).toPrecision(6)));
}

function logarithmicTicks([a, b]) {
    const ticks = [];
    for (let unit = 10 ** Math.floor(Math.log10(a)); unit <= b; unit *= 10) {
        ticks.push(...[1, 2, 5].map((k) => Number((k * unit).toPrecision(6))));
    }
    const inside = ticks.filter((v) => v >= a * 0.999 && v <= b * 1.001);
    return inside.length >= 3 ? inside : linearTicks([a, b]);
}

// { title, unit, ticks: [{ at: 0..1, text }], plain } for what is shown.
export function legendOf(values, automatic) {
    const { title, unit, labels, logarithmic } = COLOURINGS[values.colour];
    if (labels) {
        const ticks = labels.map((text, i) => ({ at: (i + 0.5) / labels.length, text }));
        return { title, unit, ticks, parts: labels.length, ends: [labels[0], labels.at(-1)] };
    }
    const [a, b] = chosenDomain(values, automatic);
    const share = logarithmic ? (v) => Math.log(v / a) / Math.log(b / a) : (v) => (v - a) / (b - a);
    const marks = (logarithmic ? logarithmicTicks : linearTicks)([a, b]);
    return { title, unit, ticks: marks.map((v) => ({ at: share(v), text: `${v} ${unit}`.trim() })), parts: 0, ends: [`${a}`, `${b} ${unit}`.trim()] };
}

// Colour at a share of the bar.
function colourAt(values, legend, bytes, share) {
    const n = legend.parts;
    const { colours } = COLOURINGS[values.colour];
    if (colours) {
        return css(colours[Math.floor(share * n) % colours.length].map((v) => 255 * v));
    }
    const t = n ? Math.floor(share * n) / (n - 1) : share;
    return css(bytes.subarray(4 * Math.round(t * (STEPS - 1))));
}

export function drawBar(pen, x, y, width, height, values, legend, bytes) {
    for (let row = 0; row < height; row++) {
        pen.fillStyle = colourAt(values, legend, bytes, Math.min(0.999, 1 - (row + 0.5) / height));
        pen.fillRect(x, y + row, width, 1);
    }
}

// The same lying, for a legend that is folded.
function drawStrip(canvas, values, legend, bytes) {
    const pen = canvas.getContext("2d");
    for (let x = 0; x < canvas.width; x++) {
        pen.fillStyle = colourAt(values, legend, bytes, (x + 0.5) / canvas.width);
        pen.fillRect(x, 0, 1, canvas.height);
    }
}

export function makeLegend() {
    const at = (id) => document.getElementById(id);
    const [bar, list, title] = ["legend-bar", "legend-ticks", "legend-title"].map(at);
    let shown = "";

    function tickItem({ at, text }) {
        const item = document.createElement("li");
        item.textContent = text;
        item.style.bottom = `${100 * at}%`;
        return item;
    }

    return function draw(values, automatic, bytes) {
        const legend = legendOf(values, automatic);
        const key = JSON.stringify([legend, values.map]);
        if (key === shown) {
            return;
        }
        shown = key;
        title.textContent = legend.title;
        list.className = legend.parts ? "ticks plain" : "ticks";
        list.replaceChildren(...legend.ticks.map(tickItem));
        [at("legend-from").textContent, at("legend-to").textContent] = legend.ends;
        drawStrip(at("legend-strip"), values, legend, bytes);
        drawBar(bar.getContext("2d"), 0, 0, bar.width, bar.height, values, legend, bytes);
    };
}
