// The pictures beside the cloud, and the points that a box in either selects.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import path from "node:path";
import { fillIndex, findPixels, makeImage, makeSight, NONE, TYPICAL } from "../../tools/lumview/page/image.js";
import { eigen, numbersOf } from "../../tools/lumview/page/plane.js";
import { choose, counts, drawn, open, openPoint, pixels, positions, probe, settings, shoot, showPanel, until } from "./page.mjs";
import { compare } from "./png.mjs";
import { dump, EXACT, roundings, run, view } from "./tools.mjs";

const FRAME = ["--frames", "1:1"];
const EDGE = 0.001; // share of points that may lie at the edge of a box or a pixel

const close = (a, b, within, what) => assert.ok(Math.abs(a - b) <= within, `${what}: ${a} is not ${b}`);
const fnv = (numbers) => numbers.reduce((hash, v) => Math.imul(hash ^ v, 16777619), 2166136261 | 0) >>> 0;

// The numbers are those of tests/unit/test_image.c.
async function isTheLibrarys({ page }) {
    let seed = 1;
    const turn = () => {
        seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
        return seed >>> 20;
    };
    const xyz = new Float32Array(9000);
    for (let i = 0; i < xyz.length; i += 3) {
        xyz.set([turn() / 64 - 1, (turn() - 2048) / 32, (turn() - 3072) / 128], i);
    }
    const found = findPixels(makeImage({ ...TYPICAL, columns: 64, rows_step: 16 }, 1), xyz, [0, 3000], makeSight(), () => true);
    assert.equal(fnv(found.pixels), 1585087420);
    assert.equal(fnv(fillIndex(new Int32Array(1024), found, 0, () => true)), 2793020274);
    assert.deepEqual((await probe(page, "hello")).image, TYPICAL);
}

function planes() {
    const matrix = [[4, 1, 0.5], [1, 3, 0.2], [0.5, 0.2, 1]];
    for (const { value, vector } of eigen(matrix)) {
        matrix.forEach((row, k) => close(row.reduce((sum, v, l) => sum + v * vector[l], 0), value * vector[k], 1e-12, "eigen"));
    }
    const of = (...points) => numbersOf((see) => points.forEach((point) => see(...point)));
    const { plane } = of([1, 0, 0], [0, 1, 0], [0, 0, 1]);
    plane.normal.forEach((v) => close(v, -Math.sqrt(1 / 3), 1e-12, "normal"));
    close(plane.distance, Math.sqrt(1 / 3), 1e-12, "distance");
    close(plane.residual, 0, 1e-12, "residual");
    const square = of([0, 0, 2.1], [1, 0, 1.9], [0, 1, 1.9], [1, 1, 2.1]);
    close(square.plane.residual, 0.1, 1e-12, "residual");
    for (const points of [[], [[1, 2, 3]], [[1, 2, 3], [4, 5, 6]], [[1, 2, 3], [2, 4, 6], [3, 6, 9]], [[1, 1, 1], [1, 1, 1], [1, 1, 1]]]) {
        assert.equal(of(...points).plane, null);
        assert.equal(of(...points).count, points.length);
    }
}

export async function showStrip(page) {
    if (!await page.locator("#strip").isVisible()) {
        await page.locator("#canvas").focus();
        await page.keyboard.press("j");
    }
    await until(page, () => window.lumview.strip()?.frame === window.lumview.frame);
    await drawn(page);
}

const framePoints = (capture, ...args) => dump(capture, ...(args.length > 0 ? args : FRAME));

// With all digits.
export function exactPoints(capture, folder, ...args) {
    const file = path.join(folder, "exact.ply");
    run("lumdump", "-q", capture, ...FRAME, ...args, "-o", file);
    return readPly(readFileSync(file)).rows;
}

const pixelsOf = (image, xyz) => findPixels(image, xyz, [0, xyz.length / 3], makeSight(), () => true);

// The page's coordinates, which are lumdump's but for the step.
async function roundedPoints(page, points) {
    const { step, xyz } = await positions(page);
    assert.equal(xyz.length, 3 * points.length);
    const most = roundings(step).coordinate;
    const away = points.filter(({ x, y, z }, i) => [x, y, z].some((v, k) => Math.abs(xyz[3 * i + k] - v) > most)).length;
    assert.equal(away, 0, `${away} of ${points.length} points are elsewhere`);
    return xyz;
}

// Where points lie that are rounded by so much: all pixels that one may be in, and those that have one surely.
export function pixelsAround(image, points, most) {
    const [possible, sure] = [new Set(), new Set()];
    const signs = [-most, most];
    for (const { x, y, z } of points) {
        const corners = signs.flatMap((a) => signs.flatMap((b) => signs.map((c) => image.pixelOf(...[x + a, y + b, z + c].map(Math.fround)))));
        const inside = corners.filter((pixel) => pixel !== NONE);
        const rows = inside.map((pixel) => Math.floor(pixel / image.columns));
        const columns = inside.map((pixel) => pixel % image.columns);
        for (let row = Math.min(...rows); row <= Math.max(...rows); row++) {
            for (let column = Math.min(...columns); column <= Math.max(...columns); column++) {
                possible.add(row * image.columns + column);
            }
        }
        if (corners[0] !== NONE && corners.every((pixel) => pixel === corners[0])) {
            sure.add(corners[0]);
        }
    }
    return { possible, sure };
}

// Each pixel shows the nearest of the points that lie in it.
async function showsNearest({ page, capture, folder }) {
    await showStrip(page);
    const { rows, columns, index } = await probe(page, "strip");
    assert.deepEqual([rows, columns], [64, 1600]);
    const points = exactPoints(capture, folder);
    const image = makeImage(TYPICAL, 64);
    const expected = fillIndex(new Int32Array(rows * columns), pixelsOf(image, await roundedPoints(page, points)), 0, () => true);
    const other = index.filter((i, k) => i !== expected[k]).length;
    assert.equal(other, 0, `${other} of ${index.length} pixels show another point`);
    assert.ok(index.filter((i) => i >= 0).length > 0.8 * index.length);
    await page.locator("#blue").uncheck();
    await drawn(page);
    assert.ok((await probe(page, "strip")).index.every((i) => i < 0 || points[i].eye === 1));
}

// Its colours, and the share of its pixels that changed since they were asked for last.
async function lookAtStrip(page) {
    await drawn(page);
    return page.evaluate(() => {
        const canvas = document.getElementById("strip-canvas");
        const all = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        const before = window.stripBefore ?? all;
        window.stripBefore = all;
        const colours = [...new Set(all)].slice(0, 1000).filter((v) => v !== 0).map((v) => [v & 255, (v >> 8) & 255, (v >> 16) & 255].join());
        return { changed: all.filter((v, i) => v !== before[i]).length / all.length, colours };
    });
}

async function hasTheColours({ page }) {
    await showStrip(page);
    await lookAtStrip(page);
    for (const choice of ["pulse", "height", "line", "return", "range", "eye"]) {
        await choose(page, "colour", choice);
        const { changed } = await lookAtStrip(page);
        assert.ok(changed > 0.05, `${choice}: ${changed} of the pixels changed`);
    }
    // As the legend has them: those of palette.js.
    assert.deepEqual((await lookAtStrip(page)).colours.sort(), ["107,173,255", "115,230,128"]);
    await page.keyboard.press("g");
    assert.deepEqual((await lookAtStrip(page)).colours, ["107,173,255"]);
}

// Where a pixel of the picture stands on the page.
async function placeOnStrip(page, pixel) {
    const { rows, columns } = await probe(page, "strip");
    const box = await page.locator("#strip-canvas").boundingBox();
    return { x: box.x + (((pixel % columns) + 0.5) * box.width) / columns, y: box.y + ((Math.floor(pixel / columns) + 0.5) * box.height) / rows };
}

const placeOfMark = (page, id) => page.evaluate((name) => {
    const box = document.getElementById(name).getBoundingClientRect();
    return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}, id);

// A pixel of the picture whose point lies open on the canvas.
async function linkedPixel(page) {
    const { index } = await probe(page, "strip");
    const filled = index.flatMap((i, k) => (i >= 0 ? [k] : []));
    return filled[Math.floor(0.4 * filled.length)];
}

async function hoversAndPicks({ page, capture }) {
    await showStrip(page);
    const rows = framePoints(capture);
    const most = roundings((await positions(page)).step).coordinate;
    const pixel = await linkedPixel(page);
    const { index } = await probe(page, "strip");
    const at = await placeOnStrip(page, pixel);
    const before = await pixels(page);
    await page.mouse.move(at.x, at.y);
    const text = new RegExp(`line ${rows[index[pixel]].line}, pixel \\d+$`);
    await until(page, () => document.getElementById("strip-text").textContent !== "");
    assert.match(await page.locator("#strip-text").textContent(), text);
    assert.ok(compare(before, await pixels(page)).share > 0, "no mark in the cloud");
    const [there, ring, canvasAt] = [await page.evaluate((i) => window.lumview.place(i), index[pixel]), await placeOfMark(page, "hover"), await page.locator("#canvas").boundingBox()];
    assert.ok(Math.hypot(ring.x - canvasAt.x - there.x, ring.y - canvasAt.y - there.y) < 3, "the mark in the cloud is elsewhere");
    await page.mouse.click(at.x, at.y);
    const picked = await probe(page, "picked");
    assert.ok(["x", "y", "z"].every((name, k) => rows.some((row) => row.line === picked.line && row.pixel === picked.pixel && Math.abs(row[name] - picked.position[k]) < most)));
    const mark = await placeOfMark(page, "strip-pick");
    assert.ok(Math.hypot(mark.x - at.x, mark.y - at.y) < 6, "the mark is elsewhere");
    // From the cloud.
    await page.mouse.move(1, 1);
    const spot = await openPoint(page, 31000);
    const canvas = await page.locator("#canvas").boundingBox();
    await page.mouse.move(canvas.x + spot.x, canvas.y + spot.y);
    await until(page, () => !document.getElementById("strip-hover").hidden);
    await page.mouse.click(canvas.x + spot.x, canvas.y + spot.y);
    const [x, y, z] = (await probe(page, "picked")).position;
    const image = makeImage(TYPICAL, 64);
    const place = image.pixelOf(...[x, y, z].map(Math.fround));
    if (place !== NONE) {
        const wanted = await placeOnStrip(page, place);
        const pick = await placeOfMark(page, "strip-pick");
        close(pick.x, wanted.x, 1, "the mark's column");
        close(pick.y, wanted.y, 1, "the mark's row");
    }
}

// lumdump's points whose places on the page lie in a box.
async function inBox(page, rows, { left, top, right, bottom }) {
    const inside = await page.evaluate((box) => {
        const out = [];
        for (let i = 0; i < window.lumview.points; i++) {
            const at = window.lumview.place(i);
            if (at.visible && at.x >= box[0] && at.y >= box[1] && at.x <= box[2] && at.y <= box[3]) {
                out.push(i);
            }
        }
        return out;
    }, [left, top, right, bottom]);
    return inside.map((i) => rows[i]);
}

// The numbers of the page are those of lumdump's points.
function assertNumbers(numbers, rows) {
    close(numbers.count, rows.length, EDGE * rows.length + 1, "count");
    const wanted = numbersOf((see) => rows.forEach(({ x, y, z }) => see(x, y, z)));
    for (const end of ["min", "max"]) {
        numbers[end].forEach((v, k) => close(v, wanted[end][k], 0.05, end));
    }
    // Of all planes through the middle, the one with the least residual.
    const middle = ["x", "y", "z"].map((name) => rows.reduce((sum, row) => sum + row[name], 0) / rows.length);
    const residual = (normal) => Math.sqrt(rows.reduce((sum, { x, y, z }) =>
        sum + (normal[0] * (x - middle[0]) + normal[1] * (y - middle[1]) + normal[2] * (z - middle[2])) ** 2, 0) / rows.length);
    const { normal, distance } = numbers.plane;
    close(numbers.plane.residual, residual(normal), 0.002, "residual");
    close(distance, Math.abs(normal.reduce((sum, n, k) => sum + n * middle[k], 0)), 0.01, "distance");
    for (const turned of [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.02], [-0.02, 0, 0], [0, -0.02, 0], [0, 0, -0.02]]) {
        const other = normal.map((n, k) => n + turned[k]);
        const length = Math.hypot(...other);
        assert.ok(residual(other.map((n) => n / length)) > numbers.plane.residual - 0.002, "another plane fits better");
    }
}

async function drag(page, id, [left, top, right, bottom]) {
    const box = await page.locator(`#${id}`).boundingBox();
    const at = (x, y) => [box.x + Math.round(x * box.width), box.y + Math.round(y * box.height)];
    const [from, to] = [at(left, top), at(right, bottom)];
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...to, { steps: 4 });
    await page.mouse.up();
    await drawn(page);
    return { left: from[0] - box.x, top: from[1] - box.y, right: to[0] - box.x, bottom: to[1] - box.y };
}

async function hideCards(page) {
    for (const [key, id] of [["i", "stats"], ["h", "panel"]]) {
        if (await page.locator(`#${id}`).isVisible()) {
            await page.keyboard.press(key);
        }
    }
    await drawn(page);
}

async function selectsInTheCloud({ page, capture }) {
    await hideCards(page);
    const rows = framePoints(capture);
    const { yaw } = await probe(page, "camera");
    await page.keyboard.press("w");
    const box = await drag(page, "canvas", [0.3, 0.4, 0.55, 0.6]);
    assert.equal((await probe(page, "camera")).yaw, yaw, "the camera has moved");
    const wanted = await inBox(page, rows, box);
    assert.ok(wanted.length > 1000);
    assertNumbers(await probe(page, "selection"), wanted);
    assert.match(await page.locator("#selection-data").textContent(), new RegExp(`^points${(await probe(page, "selection")).count.toLocaleString("en")}`));
    // The mode has ended: a drag turns the camera, and the selection stays where it is.
    const { count } = await probe(page, "selection");
    await drag(page, "canvas", [0.5, 0.2, 0.6, 0.2]);
    assert.notEqual((await probe(page, "camera")).yaw, yaw);
    assert.equal((await probe(page, "selection")).count, count);
    // Filters apply, and other frames have their own points there.
    await page.keyboard.press("b");
    const green = wanted.filter(({ eye }) => eye === 1);
    close((await probe(page, "selection")).count, green.length, EDGE * green.length + 1, "green points");
    await page.keyboard.press("Escape");
    assert.equal(await probe(page, "selection"), null);
    assert.ok(!await page.locator("#selection").isVisible());
}

async function selectsInTheStrip({ page, capture }) {
    await hideCards(page);
    await showStrip(page);
    const { left, top, right, bottom } = await drag(page, "strip-canvas", [0.2, 0.3, 0.5, 0.8]);
    const box = await page.locator("#strip-canvas").boundingBox();
    const cells = [Math.floor((left * 1600) / box.width), Math.ceil((right * 1600) / box.width), Math.floor((top * 64) / box.height), Math.ceil((bottom * 64) / box.height)];
    const image = makeImage(TYPICAL, 64);
    const of = (rows) => rows.filter(({ x, y, z }) => {
        const pixel = image.pixelOf(...[x, y, z].map(Math.fround));
        const [row, column] = [Math.floor(pixel / 1600), pixel % 1600];
        return pixel !== NONE && column >= cells[0] && column < cells[1] && row >= cells[2] && row < cells[3];
    });
    assertNumbers(await probe(page, "selection"), of(framePoints(capture)));
    await shoot(page, "lumview-selection");
    await page.keyboard.press("."); // frames that come have it too
    await until(page, () => window.lumview.frame === 2);
    await drawn(page);
    assertNumbers(await probe(page, "selection"), of(framePoints(capture, "--frames", "2:2")));
}

async function cropsAndHides({ page }) {
    await hideCards(page);
    await showStrip(page);
    const whole = await counts(page);
    const before = await pixels(page);
    await drag(page, "strip-canvas", [0.2, 0.3, 0.6, 0.8]);
    const { count } = await probe(page, "selection");
    const faded = await pixels(page);
    assert.ok(compare(before, faded).share > 0.02, "nothing is faded");
    await page.locator("#selection-hide").click();
    await drawn(page);
    assert.equal((await counts(page)).shown, whole.shown - count);
    assert.equal(await probe(page, "selection"), null);
    await page.keyboard.press("u");
    assert.equal((await counts(page)).shown, whole.shown);
    await drag(page, "strip-canvas", [0.2, 0.3, 0.6, 0.8]);
    await page.locator("#selection-crop").click();
    await drawn(page);
    assert.equal((await counts(page)).shown, count);
    const { index } = await probe(page, "strip");
    assert.ok(index.some((i) => i >= 0) && index.filter((i) => i >= 0).length <= count);
    // A box within what is left, and nothing of what is not shown is picked.
    await drag(page, "strip-canvas", [0.4, 0.1, 0.9, 0.9]);
    assert.ok((await probe(page, "selection")).count < count);
    const all = await pixels(page);
    await page.keyboard.press("Escape");
    assert.ok(compare(all, await pixels(page)).share > 0);
    await page.locator("#canvas").focus();
    await page.keyboard.press("z");
    await drawn(page);
    assert.equal((await counts(page)).shown, whole.shown);
}

export async function download(page, id) {
    const [file] = await Promise.all([page.waitForEvent("download"), page.locator(`#${id}`).click()]);
    return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

export function readCsv(bytes) {
    const [head, ...rows] = bytes.toString().trimEnd().split("\n");
    const names = head.split(",");
    return rows.map((row) => Object.fromEntries(row.split(",").map((v, i) => [names[i], Number(v)])));
}

const READERS = {
    float: (bytes, at) => [bytes.readFloatLE(at), 4],
    double: (bytes, at) => [bytes.readDoubleLE(at), 8],
    int: (bytes, at) => [bytes.readInt32LE(at), 4],
    uint16: (bytes, at) => [bytes.readUInt16LE(at), 2],
    uchar: (bytes, at) => [bytes.readUInt8(at), 1],
};

export function readPly(bytes) {
    const end = bytes.indexOf("end_header\n") + 11;
    const head = bytes.subarray(0, end).toString().split("\n");
    const properties = head.filter((line) => line.startsWith("property")).map((line) => line.split(" ").slice(1));
    const rows = Array.from({ length: Number(head.find((line) => line.startsWith("element")).split(" ")[2]) }, () => ({}));
    let at = end;
    for (const row of rows) {
        for (const [type, name] of properties) {
            const [value, width] = READERS[type](bytes, at);
            row[name.replace("scalar_", "").replace("intensity", "pulse_width")] = value;
            at += width;
        }
    }
    assert.equal(at, bytes.length);
    return { head, rows };
}

// Points as lumdump has them, but for the timestamp, and with coordinates that are rounded to a step.
function assertRows(rows, wanted, step) {
    assert.equal(rows.length, wanted.length);
    const names = Object.keys(wanted[0]).filter((name) => name !== "timestamp");
    assert.deepEqual(Object.keys(rows[0]).sort(), names.sort());
    rows.forEach((row, i) => {
        const { coordinate: most, ...others } = roundings(step, wanted[i]);
        const limits = { x: most, y: most, z: most, pulse_width: 0.006, ...others };
        names.forEach((name) => close(row[name], wanted[i][name], limits[name] ?? 0, `${name} of point ${i}`));
    });
}

async function saves({ page, capture }) {
    await hideCards(page);
    const rows = framePoints(capture);
    await page.keyboard.press("h");
    const all = await download(page, "save-csv");
    assert.equal(all.name, "lumview-1.csv");
    const { step } = await positions(page);
    assertRows(readCsv(all.bytes), rows, step);
    await page.keyboard.press("h");
    await page.locator("#canvas").focus();
    await page.keyboard.press("w");
    const box = await drag(page, "canvas", [0.3, 0.4, 0.5, 0.6]);
    const wanted = await inBox(page, rows, box);
    const { count } = await probe(page, "selection");
    close(count, wanted.length, EDGE * count, "points");
    const csv = readCsv((await download(page, "selection-csv")).bytes);
    assert.equal(csv.length, count);
    const ply = readPly((await download(page, "selection-ply")).bytes);
    assertRows(ply.rows, csv, 0);
    assert.ok(ply.head.some((line) => line.includes("street.pcap")) && ply.head.includes("comment frame 1"), ply.head.join("\n"));
    assert.ok(ply.head.includes(`comment coordinates are rounded to steps of ${(1000 * step).toPrecision(3)} mm`), ply.head.join("\n"));
}

async function keyboardSelects({ page }) {
    await hideCards(page);
    await page.locator("#canvas").focus();
    await page.keyboard.press("w");
    assert.ok(await page.locator("#box").isVisible() && await page.locator("#box-hint").isVisible());
    const { yaw } = await probe(page, "camera");
    const sizeOf = async () => (await page.locator("#box").boundingBox());
    const first = await sizeOf();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("Shift+ArrowDown");
    const second = await sizeOf();
    assert.deepEqual([second.x - first.x, second.height - first.height], [-10, 10]);
    await page.keyboard.press("Enter");
    await drawn(page);
    assert.equal((await probe(page, "camera")).yaw, yaw);
    const { count } = await probe(page, "selection");
    assert.ok(count > 0 && !await page.locator("#box").isVisible());
    const tabTo = async (id) => {
        for (let i = 0; i < 80 && (await page.evaluate(() => document.activeElement.id)) !== id; i++) {
            await page.keyboard.press("Tab");
        }
    };
    await tabTo("selection-crop");
    await page.keyboard.press("Enter");
    assert.equal((await counts(page)).shown, count);
    await page.keyboard.press("u");
    assert.ok((await counts(page)).shown > count);
    // The strip.
    await page.keyboard.press("j");
    await showStrip(page);
    await tabTo("strip-canvas");
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("Shift+ArrowLeft");
    assert.notEqual(await page.locator("#strip-text").textContent(), "");
    assert.equal((await probe(page, "camera")).yaw, yaw);
    await page.keyboard.press("Enter");
    assert.ok(await probe(page, "picked"));
    await page.keyboard.press("w");
    assert.ok(await page.locator("#strip-box").isVisible());
    await page.keyboard.press("Enter");
    await drawn(page);
    assert.ok((await probe(page, "selection")).count > 0);
    await page.keyboard.press("w");
    await page.keyboard.press("Escape"); // ends the box, not the selection
    assert.ok(await probe(page, "selection"));
    await page.keyboard.press("Escape");
    assert.equal(await probe(page, "selection"), null);
}

// Help is made of the table of keys.
async function keysAreOnce({ page }) {
    const texts = await page.locator("#help-tables kbd").allTextContents();
    const letters = texts.flatMap((text) => [...new Set(text.match(/\b[A-Z0-9]\b/g))]);
    assert.deepEqual(letters.filter((letter, i) => letters.indexOf(letter) !== i), []);
}

// The cloud comes first: on a small page the strip is folded, and it never takes more than a part.
async function folds({ page }) {
    const usual = page.viewportSize();
    await page.setViewportSize({ width: 800, height: 500 });
    await page.locator("#strip").waitFor({ state: "hidden" });
    await showPanel(page);
    await drawn(page);
    assert.ok(!await page.locator("#strip").isVisible());
    assert.equal((await settings(page)).strip, null);
    const { height } = await page.locator("#canvas").boundingBox();
    await page.locator("#strip-toggle").click();
    await showStrip(page);
    const rest = (await page.locator("#canvas").boundingBox()).height;
    assert.ok(rest < height && rest > 0.6 * height, `${rest} of ${height} pixels are left`);
    await page.locator("#strip-close").click();
    await drawn(page);
    assert.equal((await page.locator("#canvas").boundingBox()).height, height);
    await page.keyboard.press("z");
    await page.setViewportSize({ width: 1280, height: 800 });
    await page.locator("#strip").waitFor({ state: "visible" });
    await page.setViewportSize({ width: 800, height: 500 });
    await page.locator("#strip").waitFor({ state: "hidden" });
    await page.setViewportSize(usual);
}

// A sensor of more lines has more rows; a line more than they can be is none.
async function rowsFollowLines({ browser, folder }) {
    const capture = path.join(folder, "lines.pcap");
    run("lumsim", "-q", "-o", capture, "--frames", 1, "--lines", 640);
    const page = await open(browser, (await view("--paused", capture)).url);
    await showStrip(page);
    const { rows, index } = await probe(page, "strip");
    assert.equal(rows, 640);
    const points = exactPoints(capture, folder);
    assert.deepEqual(index, [...fillIndex(new Int32Array(index.length), pixelsOf(makeImage(TYPICAL, 640), await roundedPoints(page, points)), 0, () => true)]);
    assert.deepEqual(page.complaints, []);
}

// A finger draws where a mouse does, and the page does not turn.
async function fingersSelect({ browser, capture }) {
    const context = await browser.newContext({ hasTouch: true, viewport: { width: 800, height: 500 } });
    const page = await context.newPage();
    await page.goto((await view("--paused", capture)).url);
    await until(page, () => window.lumview?.shown > 0 && window.lumview.status());
    await page.keyboard.press("h");
    await page.locator("#box-begin").tap();
    await drawn(page);
    const { yaw } = await probe(page, "camera");
    const touch = await context.newCDPSession(page);
    const finger = (type, ...at) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: at.map(([x, y]) => ({ x, y })) });
    const box = await page.locator("#canvas").boundingBox();
    await finger("touchStart", [box.x + 150, box.y + 150]);
    await finger("touchMove", [box.x + 250, box.y + 200]);
    await finger("touchMove", [box.x + 350, box.y + 250]);
    await finger("touchEnd");
    await until(page, () => window.lumview.selection() !== null);
    assert.ok((await probe(page, "selection")).count > 0);
    assert.equal((await probe(page, "camera")).yaw, yaw);
    await page.locator("#selection-crop").tap();
    await drawn(page);
    assert.equal((await counts(page)).shown, (await probe(page, "selection")).count);
}

// Facts that need a page of their own.
export const pictureFactsAlone = [
    ["the strip has the rows of its lines", rowsFollowLines],
    ["a finger draws a box", fingersSelect],
];

export const pictureFacts = [
    ["the strip is the library's picture", isTheLibrarys],
    ["planes fit, and few points have none", planes],
    ["the strip shows the nearest point of each pixel", showsNearest],
    ["the strip has the colours of the cloud", hasTheColours],
    ["strip and cloud mark and pick each other's points", hoversAndPicks],
    ["a box in the cloud selects its points", selectsInTheCloud],
    ["a box in the strip selects its points, also of other frames", selectsInTheStrip],
    ["a selection is cropped to and hidden", cropsAndHides],
    ["points are saved as lumdump has them", saves],
    ["the keyboard alone selects", keyboardSelects],
    ["no key has two meanings", keysAreOnce],
    ["the strip folds, and leaves room", folds],
];
