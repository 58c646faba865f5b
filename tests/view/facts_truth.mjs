// What is known beside the points: labels, and points that are true.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { parseNpy } from "../../tools/lumview/page/npy.js";
import { drawn, open, openPoint, pixels, probe, settings, until } from "./page.mjs";
import { run, view } from "./tools.mjs";

const KEYS = ["frame", "line", "eye", "pixel", "return_number"];
const CLASSES = ["", "ground", "building", "car", "truck or van", "cyclist", "person", "tree or bush", "pole", "sign", "other"];
const EYES = ["blue", "green"];

// An array of NumPy with three columns.
function writePlaces(name, places) {
    const text = `{'descr': '<f4', 'fortran_order': False, 'shape': (${places.length}, 3), }`;
    const head = Buffer.concat([Buffer.from("\x93NUMPY\x01\x00", "latin1"), Buffer.alloc(2), Buffer.from(text.padEnd(117) + "\n")]);
    head.writeUInt16LE(118, 8);
    writeFileSync(name, Buffer.concat([head, Buffer.from(Float32Array.from(places.flat()).buffer)]));
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

// True points stand where the array says, in their own colour, and can be hidden.
async function truth({ browser, capture, folder }) {
    const array = path.join(folder, "truth.npy");
    const places = Array.from({ length: 400 }, (_, i) => [10 + (i % 20) / 10, Math.floor(i / 20) / 10 - 1, 1]);
    writePlaces(array, places);
    const server = await view("--paused", "--truth", array, capture);
    const page = await open(browser, `${server.url}#size=4`);
    await until(page, () => window.lumview.beside().truth === 400);
    const before = await truePixels(page);
    assert.ok(before > 100, `${before} pixels`);
    assert.match(await page.locator("#truth-row").innerText(), /ground truth\s+truth\.npy, 400 points/);
    await page.keyboard.press("9");
    assert.equal(await truePixels(page), 0);
    assert.equal((await probe(page, "beside")).truth, 0);
    assert.deepEqual(page.complaints, []);
}

export const truthFacts = [
    ["labels colour the points that they are of", labels],
    ["points that are true stand over the others", truth],
];
