// What is shown: each choice against lumdump's, and in pixels.
import assert from "node:assert/strict";
import { camera, choose, counts, drawn, openPoint, pixels, positions, probe, settings, shoot, type, until } from "./page.mjs";
import { coloured, compare } from "./png.mjs";
import { exactPoints } from "./facts_pictures.mjs";
import { dump, roundings, run } from "./tools.mjs";

const FRAME = ["--frames", "1:1"];
const SEEN = 0.002; // share of pixels: more than noise

export function countOf(capture, ...args) {
    return run("lumdump", capture, "-q", ...(args.includes("--frames") ? [] : FRAME), "-o", "-", "--format", "xyz", ...args).split("\n").length - 1;
}

async function differ(page, before, least = SEEN) {
    const after = await pixels(page);
    const { share } = compare(before, after);
    assert.ok(share > least, `only ${share} of the pixels differ`);
    return after;
}

async function hideStats(page) {
    if (await page.locator("#stats").isVisible()) {
        await page.keyboard.press("i");
        await drawn(page);
    }
}

async function showsTheStreet({ page, capture }) {
    await hideStats(page);
    const full = await pixels(page);
    assert.equal(await probe(page, "points"), countOf(capture));
    await page.locator("#blue").uncheck();
    await page.locator("#green").uncheck();
    const empty = await pixels(page);
    const { share, regions } = compare(full, empty);
    assert.ok(share > 0.05, `the street covers ${share}`);
    assert.ok(regions >= 24, `the street is in ${regions} of 64 regions`);
    assert.ok(coloured(full) > 0.05 && coloured(empty) < 0.005);
}

async function selectsReturns({ page, capture }) {
    await hideStats(page);
    let before = await pixels(page);
    for (const choice of ["1", "2", "3", "last", "strongest"]) {
        await choose(page, "return", choice);
        const { shown, returns } = await counts(page);
        assert.equal(shown, countOf(capture, "--return", choice), choice);
        assert.ok(!Number(choice) || Object.keys(returns).join() === choice);
        before = await differ(page, before);
    }
}

async function selectsEdges({ page, capture }) {
    const before = await pixels(page);
    await choose(page, "edges", "falling");
    await until(page, () => window.lumview.counts().falling > 0);
    const falling = await counts(page);
    assert.equal(falling.rising, 0);
    assert.equal(falling.falling, countOf(capture, "--edge", "falling"));
    await differ(page, before);
    await choose(page, "edges", "both");
    await until(page, () => window.lumview.counts().rising > 0);
    assert.equal((await counts(page)).shown, countOf(capture, "--edge", "both"));
}

async function selectsEyes({ page, capture }) {
    await hideStats(page);
    const both = await pixels(page);
    await page.locator("#blue").uncheck();
    assert.deepEqual([(await counts(page)).blue, (await counts(page)).green], [0, countOf(capture, "--eye", "green")]);
    const green = await differ(page, both);
    await page.locator("#green").uncheck();
    await page.locator("#blue").check();
    assert.equal((await counts(page)).shown, countOf(capture, "--eye", "blue"));
    await differ(page, green);
}

// Only points that lie as near to one of the limits as rounding moves them may be on its other side.
function near(a, b, values, limits, most) {
    const unsure = values.filter((v) => limits.some((limit) => Math.abs(v - limit) <= most)).length;
    assert.ok(Math.abs(a - b) <= unsure, `${a} points, lumdump has ${b}, and ${unsure} at the limits`);
    assert.ok(unsure < 0.005 * values.length, `${unsure} points at the limits`);
}

async function clips({ page, capture, folder }) {
    const { step, xyz } = await positions(page);
    const rows = exactPoints(capture, folder);
    const most = roundings(step);
    await hideStats(page);
    let before = await pixels(page);
    await type(page, "range-min", "8");
    await type(page, "range-max", "25");
    near((await counts(page)).shown, countOf(capture, "--range", "8:25"), rows.map(({ range }) => range), [8, 25], most.range);
    before = await differ(page, before);
    await type(page, "range-min", "");
    await type(page, "range-max", "");
    await type(page, "height-min", "-1.5");
    await type(page, "height-max", "0.5");
    const { shown } = await counts(page);
    near(shown, countOf(capture, "--box", "-1000:1000,-1000:1000,-1.5:0.5"), rows.map(({ z }) => z), [-1.5, 0.5], most.coordinate);
    assert.equal(shown, xyz.filter((v, i) => i % 3 === 2 && v >= -1.5 && v <= 0.5).length);
    await differ(page, before);
    assert.ok((await counts(page)).total > (await counts(page)).shown);
}

const COLOURS = {
    range: ["Range", / m$/],
    height: ["Height", / m$/],
    pulse: ["Pulse width", / ns$/],
    return: ["Return", /^(\d|4 and up)$/],
    line: ["Line", /^\d+$/],
    eye: ["Eye", /^(blue|green)$/],
};

async function colours({ page }) {
    await hideStats(page);
    await choose(page, "colour", "eye");
    let before = await pixels(page);
    for (const [choice, [title, tick]] of Object.entries(COLOURS)) {
        await choose(page, "colour", choice);
        assert.equal(await page.locator("#legend-title").textContent(), title);
        const ticks = await page.locator("#legend-ticks li").allTextContents();
        assert.ok(ticks.length >= 2 && ticks.every((text) => tick.test(text)), ticks.join());
        before = await differ(page, before, 0.01);
        await shoot(page, `lumview-colour-${choice}`);
    }
    assert.equal((await counts(page)).shown, await probe(page, "points"));
}

// A frame, come to by stepping on, by a jump back, with other colours before.
async function coloursHaveNoHistory({ page }) {
    const ends = new Map();
    const look = async (frame) => {
        await until(page, (n) => window.lumview.frame === n, frame);
        const seen = (await probe(page, "domain")).join(" to ");
        ends.set(frame, [...(ends.get(frame) ?? []), seen]);
    };
    for (let frame = 1; frame <= 10; frame++) {
        await look(frame);
        await page.keyboard.press(".");
    }
    for (const [key, frame] of [["Home", 1], ["End", 10]]) {
        await page.keyboard.press(key);
        await look(frame);
        for (let i = 0; i < Object.keys(COLOURS).length; i++) {
            await page.keyboard.press("c");
        }
        await look(frame);
    }
    for (const [frame, seen] of ends) {
        assert.equal(new Set(seen).size, 1, `frame ${frame} has had ${seen.join(", ")}`);
    }
    const changes = new Set([...ends.values()].flat()).size;
    assert.ok(changes <= 3, `${changes} ranges of colours in ten frames of one second`);
}

async function maps({ page }) {
    await hideStats(page);
    let before = await pixels(page);
    for (const map of ["cividis", "viridis"]) {
        await choose(page, "map", map);
        before = await differ(page, before, 0.01);
    }
    await type(page, "from", "10");
    await type(page, "to", "40");
    assert.deepEqual(await probe(page, "domain"), [10, 40]);
    await differ(page, before, 0.01);
    const texts = await page.locator("#legend-ticks li").allTextContents();
    assert.deepEqual(texts, ["10 m", "20 m", "30 m", "40 m"]);
}

// Mean brightness of what has colour.
function brightness(image) {
    let [sum, count] = [0, 0];
    for (let i = 0; i < image.width * image.height; i++) {
        const c = image.bytes.subarray(i * image.channels, i * image.channels + 3);
        if (Math.max(...c) - Math.min(...c) > 30) {
            sum += c[0] + c[1] + c[2];
            count++;
        }
    }
    return sum / count;
}

// In perspective, in parallel projection; where there are no points nothing changes.
async function depthShading({ page }) {
    await hideStats(page);
    for (const view of ["0", "1", "3"]) {
        await page.keyboard.press(view);
        await choose(page, "edl", "off");
        const plain = await pixels(page);
        await choose(page, "edl", "on");
        const lit = await differ(page, plain, 0.01);
        assert.ok(brightness(lit) < 0.97 * brightness(plain), `view ${view}: ${brightness(plain)}, lit ${brightness(lit)}`);
        assert.ok(coloured(lit) > 0.6 * coloured(plain), `view ${view}: ${coloured(plain)}, lit ${coloured(lit)}`);
    }
    await page.locator("#blue").uncheck();
    await page.locator("#green").uncheck();
    const empty = await pixels(page);
    await choose(page, "edl", "off");
    assert.equal(compare(empty, await pixels(page)).share, 0);
}

// This browser draws in software: the shading waits until the camera stands.
async function shadesAtRest({ page }) {
    const lit = () => probe(page, "lit");
    assert.equal(await lit(), true);
    const at = await openPoint(page, 0);
    const box = await page.locator("#canvas").boundingBox();
    await page.mouse.move(box.x + at.x, box.y + at.y);
    await page.mouse.down();
    await page.mouse.move(box.x + at.x + 30, box.y + at.y);
    assert.equal(await lit(), false);
    await page.locator("#edl").selectOption("on");
    assert.equal(await lit(), true);
    await page.mouse.up();
    await choose(page, "edl", "auto");
    await drawn(page);
    assert.equal(await lit(), true);
}

// Toward a wall its points grow, up to a limit: it stays as closed as it was.
async function sizeByDistance({ page }) {
    await hideStats(page);
    await page.keyboard.press("3");
    await page.locator("#grid").uncheck();
    await page.locator("#rings").uncheck();
    await drawn(page);
    const far = coloured(await pixels(page));
    await page.keyboard.press("t");
    for (let i = 0; i < 14; i++) {
        await page.keyboard.press("ArrowUp");
    }
    const near = coloured(await pixels(page));
    assert.ok(near > 0.8 * far, `${far} of the pixels, then ${near}`);
}

async function pointSize({ page }) {
    await hideStats(page);
    const small = coloured(await pixels(page));
    await page.locator("#size").fill("5");
    await drawn(page);
    const large = coloured(await pixels(page));
    assert.ok(large > 1.2 * small, `${small} of the pixels, then ${large}`);
}

// However the shown frame was come to, so many frames end there, and the header tells their points.
async function accumulates({ page, capture }) {
    const points = new Map(Array.from({ length: 10 }, (_, i) => [i + 1, countOf(capture, "--frames", `${i + 1}:${i + 1}`)]));
    const shows = async (first, last) => {
        const wanted = [...points].filter(([n]) => n >= first && n <= last).reduce((sum, [, n]) => sum + n, 0);
        const header = first === last ? `frame ${last}` : `frames ${first} to ${last}`;
        await until(page, ([n, points]) => window.lumview.frame === n && window.lumview.points === points, [last, wanted]);
        assert.equal((await counts(page)).total, wanted);
        await until(page, ([text, points]) => document.getElementById("frame-number").textContent === text &&
            document.getElementById("frame-points").textContent === points, [header, `${wanted.toLocaleString("en")} points`]);
    };
    const go = (n) => page.locator("#scrub").fill(String(n));
    await page.locator("#accumulate").fill("3");
    for (const frame of [2, 3, 4]) {
        await page.locator("#forth").click();
        await shows(Math.max(1, frame - 2), frame);
    }
    for (const frame of [9, 2, 8, 6]) {
        await go(frame);
        await shows(Math.max(1, frame - 2), frame);
    }
    await page.locator("#back").click();
    await shows(3, 5);
    await page.locator("#accumulate").fill("5");
    await shows(1, 5);
    await go(8);
    await shows(4, 8);
    await page.locator("#accumulate").fill("2");
    await shows(7, 8);
    await page.locator("#accumulate").fill("3");
    await choose(page, "edges", "falling");
    await until(page, () => window.lumview.counts().falling > 0);
    await choose(page, "edges", "rising");
    await shows(6, 8);
    await page.locator("#first").click(); // as a loop begins again
    await shows(1, 1);
    await go(10);
    await shows(8, 10);
    await page.locator("#accumulate").fill("1");
    await shows(10, 10);
}

async function surroundings({ page }) {
    await hideStats(page);
    await page.locator("#blue").uncheck();
    await page.locator("#green").uncheck();
    const all = await pixels(page);
    await page.locator("#rings").uncheck();
    const noRings = await differ(page, all, 0.001);
    await page.locator("#rings").check();
    await type(page, "ground", "3");
    await differ(page, all, 0.001);
    await type(page, "ground", "");
    await page.locator("#rings").uncheck();
    await page.locator("#grid").uncheck();
    const { share } = compare(noRings, await pixels(page));
    assert.ok(share > 0, "the grid stays");
}

const rowKey = (r) => [r.eye, r.line, r.pixel, r.return_number, r.edge].join();
const pickKey = (p) => [Number(p.eye === "green"), p.line, p.pixel, p.returnNumber, Number(p.edge === "rising")].join();

function equal(picked, row) {
    const most = roundings(picked.step, row);
    const pairs = [
        [picked.position[0], row.x, most.coordinate],
        [picked.position[1], row.y, most.coordinate],
        [picked.position[2], row.z, most.coordinate],
        [picked.range, row.range, most.range],
        [picked.azimuth, row.azimuth, most.azimuth],
        [picked.elevation, row.elevation, most.elevation],
        [picked.pulse, row.pulse_width, 0.006],
        [picked.returns, row.number_of_returns, 0],
        [picked.frame, row.frame, 0],
    ];
    pairs.forEach(([a, b, most], i) => assert.ok(Math.abs(a - b) <= most, `value ${i}: ${a}, lumdump has ${b}`));
}

async function picks(page, rows) {
    const box = await page.locator("#canvas").boundingBox();
    for (const from of [100, 20000, 40000, 60000, 80000, 120000]) {
        const at = await openPoint(page, from);
        await page.mouse.click(box.x + at.x, box.y + at.y);
        await drawn(page);
        const picked = await probe(page, "picked");
        assert.ok(picked, "nothing was picked");
        equal(picked, rows.get(pickKey(picked)));
    }
}

const table = (rows) => new Map(rows.map((row) => [rowKey(row), row]));

async function picksPoints({ page, capture }) {
    await picks(page, table(dump(capture, ...FRAME)));
    const shown = await page.locator("#pick-data").textContent();
    const { step } = await positions(page);
    assert.ok(step > 0 && step <= 0.002, `steps of ${step} m`);
    for (const word of [`each within${(500 * step).toFixed(2)} mm`, "range", "azimuth", "elevation", "line", "pixel", "return", "edge", "pulse width", "frame began", "fitted"]) {
        assert.ok(shown.includes(word), word);
    }
    await shoot(page, "lumview-pick");
    await page.locator("#pick-close").click();
    assert.equal(await probe(page, "picked"), null);
    assert.ok(!(await page.locator("#pick").isVisible()));
}

async function pickAt(page, from, key) {
    const box = await page.locator("#canvas").boundingBox();
    for (let at = from; ; at += 131) {
        const point = await openPoint(page, at);
        if (key) {
            await page.keyboard.down(key);
        }
        await page.mouse.click(box.x + point.x, box.y + point.y);
        if (key) {
            await page.keyboard.up(key);
        }
        await drawn(page);
        const picked = await probe(page, "picked");
        if (picked) {
            return picked;
        }
    }
}

async function distances({ page }) {
    await page.locator("#canvas").focus();
    for (const key of ["k", "x", "k"]) { // the same point is no other end
        await page.keyboard.press(key);
        assert.ok(await probe(page, "picked"));
    }
    assert.equal(await page.locator("#measure-distance").textContent(), "Pick the other end");
    assert.equal(await probe(page, "distance"), null);
    await page.keyboard.press("Escape");
    const first = await pickAt(page, 20000);
    assert.equal(await probe(page, "distance"), null);
    const second = await pickAt(page, 90000, "Shift");
    const isDistance = async (a, b) => {
        const measured = await probe(page, "distance");
        const want = Math.hypot(...a.position.map((v, k) => v - b.position[k]));
        assert.ok(want > 0.1 && Math.abs(measured.distance - want) < 1e-9);
        assert.equal(await page.locator("#measure-distance").textContent(), `${want.toFixed(3)} m`);
        const shown = await page.locator("#measure-data").innerText();
        for (const v of [...a.position, ...b.position]) {
            assert.ok(shown.includes(v.toFixed(3)), `${v} is not in ${shown}`);
        }
    };
    await isDistance(first, second);
    await shoot(page, "lumview-distance");
    await isDistance(first, await pickAt(page, 60000)); // the first end stays
    await page.keyboard.press("x");
    assert.equal(await probe(page, "distance"), null);
    assert.ok(!(await page.locator("#measure").isVisible()));
    const third = await probe(page, "picked");
    await page.locator("#pick-measure").click();
    await page.locator("#canvas").focus();
    await isDistance(third, await pickAt(page, 40000));
    await page.keyboard.press("Escape");
    assert.deepEqual([await probe(page, "distance"), await probe(page, "picked")], [null, null]);
}

async function misses({ page }) {
    const { width, height } = await page.locator("#canvas").boundingBox();
    const miss = page.locator("#miss");
    const click = () => page.locator("#canvas").click({ position: { x: width / 3, y: height / 2 } });
    await pickAt(page, 20000);
    assert.ok(!(await miss.isVisible()));
    await page.locator("#blue").uncheck();
    await page.locator("#green").uncheck();
    await click();
    assert.equal(await miss.textContent(), "no point here");
    assert.ok(await miss.isVisible());
    await page.locator("#blue").check();
    await page.locator("#green").check();
    assert.ok(!(await miss.isVisible()), "the next click ends it");
    await page.locator("#range-max").fill("0.1");
    await page.locator("#canvas").focus();
    await page.keyboard.press("k");
    assert.ok(await miss.isVisible());
    await page.keyboard.press("Escape");
    assert.ok(!(await miss.isVisible()));
}

async function picksGo({ page }) {
    const first = await pickAt(page, 20000);
    await pickAt(page, 90000, "Shift");
    await page.keyboard.press(".");
    await until(page, () => window.lumview.frame === 2);
    assert.deepEqual([await probe(page, "distance"), await probe(page, "picked")], [null, null]);
    assert.ok(!(await page.locator("#pick").isVisible()));
    const { eye } = await pickAt(page, 20000);
    await page.locator(`#${eye}`).uncheck();
    assert.equal(await probe(page, "picked"), null);
    assert.equal(first.frame, 1);
}

// A field, what is refused there, what it says, what is taken.
async function refusesInverted({ page }) {
    const isRefused = async (field, text, place, why) => {
        const before = await settings(page);
        await type(page, field, text);
        assert.deepEqual(await settings(page), before, `${field} ${text}`);
        assert.match(await page.locator(`#${place}`).textContent(), why);
        assert.ok(await page.locator(`#${place}`).isVisible());
        assert.equal(await page.locator(`#${field}`).getAttribute("aria-invalid"), "true");
        assert.equal(await page.locator(`#${field}`).inputValue(), text);
    };
    await type(page, "range-max", "20");
    await isRefused("range-min", "30", "range-why", /30 is above 20/);
    await page.keyboard.press("g"); // what is refused stays there meanwhile
    assert.equal(await page.locator("#range-min").inputValue(), "30");
    await type(page, "range-max", "40");
    assert.deepEqual([(await settings(page)).rangeMin, (await settings(page)).rangeMax], [30, 40]);
    assert.ok(!(await page.locator("#range-why").isVisible()));
    await isRefused("range-min", "-1", "range-why", /below 0/);
    await type(page, "height-min", "1");
    await isRefused("height-max", "0.5", "height-why", /1 is above 0.5/);
    await type(page, "to", "40");
    await isRefused("from", "50", "colour-why", /50 is above 40/);
    await isRefused("from", "40", "colour-why", /same/);
    await isRefused("from", "0", "colour-why", /logarithmic/);
    await choose(page, "colour", "height");
    assert.ok(!(await page.locator("#colour-why").isVisible()));
    await type(page, "from", "0");
    assert.equal((await settings(page)).from, 0);
    await type(page, "to", "-5");
    await page.locator("#reset").click();
    assert.equal(await page.locator("#to").inputValue(), "");
    assert.ok(!(await page.locator("#height-why").isVisible()));
}

async function smooths({ page, capture }) {
    await hideStats(page);
    await page.keyboard.press("3");
    const before = await pixels(page);
    const { shown } = await counts(page);
    await choose(page, "smooth", "15");
    await until(page, () => window.lumview.smooth === 15);
    assert.equal((await counts(page)).shown, shown);
    assert.ok(compare(before, await pixels(page)).share > 0);
    assert.ok(Math.abs((await camera(page)).yaw) < 1e-6);
    await page.keyboard.press("0");
    await drawn(page);
    await picks(page, table(dump(capture, ...FRAME, "--smooth", "15")));
}

async function resets({ page }) {
    const first = { ...await settings(page), panel: null };
    await choose(page, "colour", "height");
    await type(page, "range-max", "10");
    await page.locator("#blue").uncheck();
    await page.locator("#reset").click();
    assert.deepEqual(await settings(page), first);
    assert.equal(await page.locator("#range-max").inputValue(), "");
    assert.ok(await page.locator("#blue").isChecked());
}

export const pointFacts = [
    ["the canvas shows the street", showsTheStreet],
    ["the return selector shows lumdump's points", selectsReturns],
    ["rising, falling and both edges are lumdump's", selectsEdges],
    ["eyes go on and off", selectsEyes],
    ["range and height clip as lumdump does", clips],
    ["each choice of colour colours, with its legend", colours],
    ["the same frame and settings have the same colours", coloursHaveNoHistory],
    ["maps and ends of the colours change them", maps],
    ["what lies behind is shaded, in all projections, and nothing else", depthShading],
    ["without a graphics card shading waits until the camera stands", shadesAtRest],
    ["points grow as the camera comes near", sizeByDistance],
    ["point size changes what points cover", pointSize],
    ["a click beside all points says so", misses],
    ["frames accumulate", accumulates],
    ["grid and rings go on, off and up", surroundings],
    ["a picked point is lumdump's", picksPoints],
    ["the distance of two points", distances],
    ["a picked point goes with its frame and when it is not shown", picksGo],
    ["inverted ranges are refused in place", refusesInverted],
    ["smoothed angles are lumdump's", smooths],
    ["reset resets", resets],
];
