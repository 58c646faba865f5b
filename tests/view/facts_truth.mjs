// What is known beside the points: labels, and points that are true.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { parseNpy } from "../../tools/lumview/page/npy.js";
import { drawn, open, openPoint, pixels, probe, settings, shoot, until } from "./page.mjs";
import { download, readCsv, readPly } from "./facts_pictures.mjs";
import { dump, run, view } from "./tools.mjs";

const KEYS = ["frame", "line", "eye", "pixel", "return_number"];
const CLASSES = ["", "ground", "building", "car", "truck or van", "cyclist", "person", "tree or bush", "pole", "sign", "other"];
const EYES = ["blue", "green"];

// An array of NumPy, of numbers of four bytes.
export function arrayOf(descr, shape, numbers) {
    const text = `{'descr': ${descr}, 'fortran_order': False, 'shape': (${shape}), }`;
    const head = Buffer.concat([Buffer.from("\x93NUMPY\x01\x00", "latin1"), Buffer.alloc(2), Buffer.from(text.padEnd(501) + "\n")]);
    head.writeUInt16LE(502, 8);
    return Buffer.concat([head, Buffer.from(Float32Array.from(numbers).buffer)]);
}

const writePlaces = (name, places) => writeFileSync(name, arrayOf("'<f4'", `${places.length}, 3`, places.flat()));

// Columns lie where the head says; one that is several numbers would move those behind it.
function readsColumns() {
    const parse = (...given) => {
        const bytes = arrayOf(...given);
        return parseNpy(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    };
    assert.deepEqual([...parse("[('x', '<f4'), ('y', '<f4')]", "2,", [1, 2, 3, 4]).column("y")], [2, 4]);
    assert.deepEqual([...parse("'<f4'", "2, 3", [1, 2, 3, 4, 5, 6]).column("1")], [2, 5]);
    assert.throws(() => parse("[('a', '<f4', (2,)), ('x', '<f4')]", "1,", [1, 2, 3]), /more than one number: \('a', '<f4', \(2,\)\);/);
    assert.throws(() => parse("[('a', '<f4', (2,)), ".repeat(9) + "]", "1,", [1]), ({ message }) => message.length < 250);
    const padded = parse("[('x', '<f4'), ('', '|V4'), ('y', '<f4'), ('of', '|V8'), ('z', '<f4')]", "1,", [1, 2, 3, 4, 5, 6]);
    assert.deepEqual([padded.names, ...padded.column("y"), ...padded.column("z")], [["x", "y", "z"], 3, 6]);
    assert.deepEqual(parse("[(('metres', 'x'), '<f4'), ('y', '<f4')]", "1,", [1, 2]).names, ["x", "y"]);
    assert.throws(() => parse("'|V3'", "2, 3", [1, 2, 3, 4, 5, 6]), /of the type \|V3/);
    assert.throws(() => parse("[('x', '>f4')]", "1,", [1]), /of the type >f4/);
    assert.throws(() => parse("'<f4'", "3, 3", [1]), /ends before its 3 rows do/);
}

// The label of a point is that of its row in the array of lumsim.
async function labels({ browser, folder }) {
    const [capture, array] = ["labelled.pcap", "labels.npy"].map((name) => path.join(folder, name));
    run("lumsim", "-q", "-o", capture, "--frames", 3, "--labels", array);
    const bytes = readFileSync(array);
    const table = parseNpy(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    const columns = Object.fromEntries([...KEYS, "class"].map((name) => [name, table.column(name)]));
    const server = await view("--paused", "--labels", array, capture);
    const page = await open(browser, `${server.url}#colour=label&frame=2&panel=off`);
    await until(page, () => window.lumview.frame === 2 && window.lumview.beside().labels.length > 1);
    const present = [...new Set(columns.class)].sort((a, b) => a - b).map((value) => CLASSES[value]);
    assert.deepEqual((await probe(page, "beside")).labels, present);
    assert.equal((await settings(page)).colour, "label");
    for (const first of [0, 20000, 40000, 60000]) {
        const { x, y } = await openPoint(page, first);
        await page.locator("#canvas").click({ position: { x, y } });
        await drawn(page);
        const picked = await probe(page, "picked");
        await page.keyboard.press("Escape");
        const wanted = [picked.frame, picked.line, EYES.indexOf(picked.eye), picked.pixel, picked.returnNumber];
        const row = columns.frame.findIndex((_, i) => KEYS.every((key, k) => columns[key][i] === wanted[k]));
        assert.equal(picked.label, CLASSES[columns.class[row]], JSON.stringify(picked));
    }
    assert.deepEqual(page.complaints, []);
    await page.setViewportSize({ width: 1280, height: 800 });
    await drawn(page);
    const sides = ["#legend", ".ticks li"].map((one) => page.locator(one).evaluateAll((all) => all.map((item) => item.getBoundingClientRect().right)));
    const [[right], texts] = await Promise.all(sides);
    assert.ok(texts.length > 5 && texts.every((end) => end < right), `the legend ends at ${right}, its texts at ${texts}`);
    await page.close();
    await sameLabelsSaved(await open(browser, `${server.url}#frame=2`), columns);
}

// Saved points have the numbers of the array.
async function sameLabelsSaved(page, columns) {
    await until(page, () => window.lumview.frame === 2 && window.lumview.beside().labels.length > 1);
    const rows = readCsv((await download(page, "save-csv")).bytes);
    const places = new Map(Array.from(columns.frame, (_, i) => [KEYS.map((key) => columns[key][i]).join(), i]));
    assert.ok(rows.length > 1000);
    rows.forEach((row) => assert.equal(row.label, columns.class[places.get(KEYS.map((key) => row[key]).join())] ?? -1));
    const ply = readPly((await download(page, "save-ply")).bytes);
    assert.deepEqual(ply.rows.map((row) => row.label), rows.map((row) => row.label));
}

const isTrue = ([r, g, b]) => r > 200 && g < 140 && b > 150;

async function truePixels(page) {
    const { bytes, channels } = await pixels(page);
    let count = 0;
    for (let i = 0; i < bytes.length; i += channels) {
        count += isTrue(bytes.subarray(i, i + 3));
    }
    return count;
}

// True points stand where the array says, in their own colour, and can be hidden. Rows that are no places, be they the first,
// are left out.
async function truth({ browser, capture, folder }) {
    const array = path.join(folder, "truth.npy");
    const places = Array.from({ length: 400 }, (_, i) => [10 + (i % 20) / 10, Math.floor(i / 20) / 10 - 1, 1]);
    writePlaces(array, [[NaN, 0, 0], [1e12, 0, 0], ...places, [0, -Infinity, 0]]);
    const server = await view("--paused", "--truth", array, capture);
    const page = await open(browser, `${server.url}#size=4`);
    await until(page, () => window.lumview.beside().truth === 400);
    const before = await truePixels(page);
    assert.ok(before > 100, `${before} pixels`);
    assert.match(await page.locator("#truth-row").innerText(), /ground truth\s+truth\.npy, 400 points; 3 without coordinates left out/);
    await page.keyboard.press("9");
    assert.equal(await truePixels(page), 0);
    assert.equal((await probe(page, "beside")).truth, 0);
    assert.deepEqual(page.complaints, []);
}

// A capture is true too: its frames stand beside those of the same number. Exact points of what is shown lie on it, so
// there are as many as lumdump has.
async function trueCapture({ browser, folder }) {
    const [shown, exact] = ["noisy.pcap", "exact.pcap"].map((name) => path.join(folder, name));
    run("lumsim", "-q", "-o", shown, "--frames", 3);
    run("lumsim", "-q", "-o", exact, "--frames", 3, "--seed", 2);
    const server = await view("--paused", "--truth", exact, shown);
    const page = await open(browser, `${server.url}#frame=2&panel=off`);
    const count = dump(exact, "--frames", "2:2").length;
    await until(page, (n) => window.lumview.frame === 2 && window.lumview.beside().truth === n, count);
    assert.ok((await truePixels(page)) > 100);
    assert.deepEqual(page.complaints, []);
    await page.close();
}

// Poses of a file, [seconds, x y z, qx qy qz qw]; without a path of its own lumsim has one for all lines of a frame.
const readPoses = (name) => readFileSync(name, "utf8").trim().split("\n").filter((line) => !line.startsWith("#"))
    .map((line) => line.trim().split(/\s+/).map(Number));

const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

function turned([x, y, z, w], v) {
    const t = cross([x, y, z], v).map((one) => 2 * one);
    const u = cross([x, y, z], t);
    return v.map((one, k) => one + w * t[k] + u[k]);
}

// Where a place of the world is, as seen from a pose.
function seenFrom([, ...pose], place) {
    const [x, y, z, w] = pose.slice(3);
    return turned([-x, -y, -z, w], place.map((v, k) => v - pose[k]));
}

// Saved points have the ranges that were measured, and their places say from where they are seen.
async function savesWhatWasMeasured(page, rows) {
    const pointOf = (row) => KEYS.map((key) => row[key]).join();
    const ranges = new Map(rows.map((row) => [pointOf(row), row.range]));
    const saved = readPly((await download(page, "save-ply")).bytes);
    assert.ok(saved.rows.some(({ frame }) => frame === 1));
    const known = saved.rows.filter((row) => ranges.has(pointOf(row)));
    assert.ok(known.length > 0.9 * saved.rows.length, `${known.length} of ${saved.rows.length} points have a pose`);
    known.forEach((row) => assert.ok(Math.abs(ranges.get(pointOf(row)) - row.range) < 0.01, JSON.stringify(row)));
    assert.ok(saved.head.some((line) => line.includes("as seen from frame 3")), saved.head.join("\n"));
}

// A box that stays selects what lies in it now, also of frames that were moved since.
async function selectsWhatMoved(page) {
    const countAfter = async (...keys) => {
        for (const key of keys) {
            await page.keyboard.press(key);
        }
        await drawn(page);
        return (await probe(page, "selection")).count;
    };
    await countAfter("w", "Enter");
    await page.keyboard.press(",");
    await until(page, () => document.getElementById("frame-number").textContent === "frames 1 to 2");
    const kept = await countAfter();
    assert.ok(kept > 0);
    assert.equal(kept, await countAfter("w", "Enter"));
}

// Points of the frames before stand where they were in the world, as seen from the newest one.
async function world({ browser, folder }) {
    const [capture, poses] = ["drive.pcap", "drive.txt"].map((name) => path.join(folder, name));
    run("lumsim", "-q", "-o", capture, "--frames", 3, "--poses", poses);
    const server = await view("--paused", "--poses", poses, capture);
    const page = await open(browser, `${server.url}#accumulate=3&frame=3&panel=off`);
    await until(page, () => document.getElementById("frame-number").textContent === "frames 1 to 3");
    const rows = dump(capture, "--poses", poses, "--to", "world");
    const began = rows.filter(({ frame }) => frame === 3).reduce((least, { timestamp }) => Math.min(least, timestamp), Infinity) * 1e-6;
    const here = readPoses(poses).find(([time]) => time >= began - 1e-5);
    const frames = new Set();
    const { width, height } = await page.locator("#canvas").boundingBox();
    for (let i = 0; i < 24; i++) {
        await page.locator("#canvas").click({ position: { x: width * (0.3 + 0.017 * i), y: height * (0.45 + 0.04 * (i % 4)) } });
        const point = await probe(page, "picked");
        await page.keyboard.press("Escape");
        if (point) {
            const row = rows.find((one) => one.frame === point.frame && one.line === point.line && one.pixel === point.pixel
                && one.eye === EYES.indexOf(point.eye) && one.return_number === point.returnNumber);
            const wanted = seenFrom(here, [row.x, row.y, row.z]);
            wanted.forEach((v, k) => assert.ok(Math.abs(v - point.position[k]) < 0.01, `${wanted}, ${JSON.stringify(point)}`));
            assert.ok(Math.abs(row.range - point.range) < 0.01, "its range is that from where the sensor was");
            frames.add(point.frame);
        }
    }
    assert.ok(frames.size > 1, `points of the frames ${[...frames]}`);
    await shoot(page, "lumview-world");
    await savesWhatWasMeasured(page, rows);
    await selectsWhatMoved(page);
    assert.deepEqual(page.complaints, []);
}

// More poses than the page is given.
async function thinsPoses({ browser, folder }) {
    const [capture, poses] = ["shaken.pcap", "shaken.txt"].map((name) => path.join(folder, name));
    run("lumsim", "-q", "-o", capture, "--frames", 1, "--poses", poses);
    const [begun] = readPoses(poses)[0];
    const row = (i) => `${(begun + i * 1e-3).toFixed(6)} ${i * 0.01} ${i % 2 ? 0.003 : 0} 0 0 0 0 1\n`;
    const heads = readFileSync(poses, "utf8").split("\n").filter((line) => line.startsWith("#")).map((line) => `${line}\n`);
    writeFileSync(poses, heads.concat(Array.from({ length: 120000 }, (_, i) => row(i))).join(""));
    const server = await view("--paused", "--poses", poses, capture);
    const page = await open(browser, `${server.url}#frame=1&accumulate=2`);
    await until(page, () => !document.getElementById("world-row").hidden);
    const title = await page.evaluate(() => document.getElementById("world-row").title);
    assert.match(title, /so many poses that one of every 3 is taken/);
    assert.deepEqual(page.complaints, []);
}

export const truthFacts = [
    ["poses that are left out are told", thinsPoses],
    ["frames at once stand where poses say they were taken", world],
    ["the columns of an array are those of its head", readsColumns],
    ["labels colour the points that they are of", labels],
    ["points that are true stand over the others", truth],
    ["a second capture is ground truth, frame by frame", trueCapture],
];
