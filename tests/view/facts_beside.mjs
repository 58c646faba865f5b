// Two profiles side by side, and what the page says where none fits.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import path from "node:path";
import { camera, drawn, open, pixels, probe, until } from "./page.mjs";
import { compare } from "./png.mjs";
import { dump, run, view } from "./tools.mjs";

const SWAPPED = "version: 1\neye_values: {blue: 1, green: 0}\n";
const OPEN = [0.3, 0.85]; // of the picture: above are the names, below the folded legend
const SAME = 0.001; // share of pixels: no more than noise

function profile(folder, name, text) {
    const file = path.join(folder, name);
    writeFileSync(file, text);
    return file;
}

// The same part of each pane, without what lies over the picture.
async function panes(page) {
    const image = await pixels(page);
    const pane = Math.floor(await page.evaluate(() => document.getElementById("canvas").clientWidth / 2));
    const [top, bottom] = OPEN.map((share) => Math.floor(share * image.height));
    const { channels } = image;
    const [width, height] = [image.width - pane - 2, bottom - top];
    const row = (left, y) => image.bytes.subarray((y * image.width + left) * channels, (y * image.width + left + width) * channels);
    const crop = (left) => Buffer.concat(Array.from({ length: height }, (_, y) => row(left, top + y)));
    return [2, pane + 2].map((left) => ({ width, height, channels, bytes: crop(left) }));
}

const differ = (a, b) => compare(a, b).share > SAME;

const sizeOf = (capture, frame, ...args) =>
    run("lumdump", capture, "-q", "--frames", `${frame}:${frame}`, "-o", "-", "--format", "xyz", ...args).split("\n").length - 1;

async function hideParts(page) {
    for (const id of ["stats", "panel"]) {
        if (await page.locator(`#${id}`).isVisible()) {
            await page.locator(`#${id}-toggle`).click();
        }
    }
    await drawn(page);
}

async function sideBySide({ browser, capture, folder }) {
    const one = profile(folder, "usual.yaml", "version: 1\n");
    const other = profile(folder, "swapped.yaml", SWAPPED);
    const server = await view("--paused", capture, "--profile", one, "--profile", other);
    const page = await open(browser, server.url);
    await hideParts(page);
    assert.equal(await page.locator("#beside-0").textContent(), "usual.yaml");
    assert.equal(await page.locator("#beside-1-keys").textContent(), "eye_values.blue 1, eye_values.green 0");
    const size = sizeOf(capture, 1);
    assert.deepEqual(await probe(page, "sides"), [size, sizeOf(capture, 1, "--profile", other)]);
    assert.match(await page.locator("#frame-points").textContent(), / \| /);
    const before = await panes(page);
    assert.ok(differ(...before), "the panes show the same");
    // One camera.
    await page.locator("#canvas").focus();
    await page.keyboard.press("ArrowLeft");
    const after = await panes(page);
    assert.ok(differ(after[0], before[0]) && differ(after[1], before[1]), "a pane stands still");
    // One time, also after a jump.
    await page.keyboard.press("End");
    await until(page, () => window.lumview.frame === window.lumview.status().last_frame);
    await drawn(page);
    const last = (await probe(page, "status")).last_frame;
    assert.deepEqual(await probe(page, "sides"), [sizeOf(capture, last), sizeOf(capture, last, "--profile", other)]);
    await page.keyboard.press(",");
    await until(page, (frame) => window.lumview.frame === frame - 1, last);
    assert.deepEqual(await probe(page, "sides"), [sizeOf(capture, last - 1), sizeOf(capture, last - 1, "--profile", other)]);
    assert.deepEqual(page.complaints, []);
}

async function twins({ browser, capture, folder }) {
    const one = profile(folder, "one.yaml", "version: 1\n");
    const page = await open(browser, (await view("--paused", capture, "--profile", one, "--profile", one)).url);
    await hideParts(page);
    assert.equal(await page.locator("#beside-0-keys").textContent(), "the same layout");
    for (const key of ["0", "1", "3"]) {
        await page.keyboard.press(key);
        assert.ok(!differ(...await panes(page)), `the panes differ in view ${key}`);
    }
    assert.equal((await camera(page)).flat, false);
}

// The point of a pane that is near the middle of it.
async function pick(page, side) {
    const place = await page.evaluate((which) => {
        const view = window.lumview;
        const canvas = document.getElementById("canvas");
        const box = canvas.getBoundingClientRect();
        const [first] = view.sides;
        for (let i = which * first; i < (which === 0 ? first : view.points); i += 97) {
            const at = view.place(i);
            if (at.visible && document.elementFromPoint(at.x + box.x, at.y + box.y) === canvas) {
                return [at.x + box.x, at.y + box.y];
            }
        }
        throw new Error("no point lies open");
    }, side);
    await page.keyboard.press("Escape");
    await page.mouse.click(...place);
    return probe(page, "picked");
}

// The same word is of one eye by one profile, and of the other by the other.
async function picksInEither({ browser, capture, folder }) {
    const [one, other] = [profile(folder, "a.yaml", "version: 1\n"), profile(folder, "b.yaml", SWAPPED)];
    const page = await open(browser, (await view("--paused", capture, "--profile", one, "--profile", other)).url);
    await hideParts(page);
    for (const [side, file] of [[0, one], [1, other]]) {
        const point = await pick(page, side);
        const rows = dump(capture, "--profile", file, "--frames", "1:1", "--eye", point.eye);
        assert.ok(rows.some((row) => row.line === point.line && row.pixel === point.pixel &&
            Math.abs(row.x - point.position[0]) < 1e-3 && Math.abs(row.y - point.position[1]) < 1e-3),
        `no such point by ${file}`);
    }
}

// Both panes show what is selected; the numbers are of the one that the box was drawn in.
async function boxesInEither({ browser, capture, folder }) {
    const [one, other] = [profile(folder, "c.yaml", "version: 1\n"), profile(folder, "d.yaml", SWAPPED)];
    const page = await open(browser, (await view("--paused", capture, "--profile", one, "--profile", other)).url);
    await hideParts(page);
    const canvas = await page.locator("#canvas").boundingBox();
    for (const [side, from, to] of [[0, 0.1, 0.4], [1, 0.6, 0.9]]) {
        await page.keyboard.press("w");
        const [left, right] = [from, to].map((share) => Math.round(share * canvas.width));
        await page.mouse.move(canvas.x + left, canvas.y + 200);
        await page.mouse.down();
        await page.mouse.move(canvas.x + right, canvas.y + 300, { steps: 3 });
        await page.mouse.up();
        await drawn(page);
        const wanted = await page.evaluate(([which, a, b]) => {
            const [first] = window.lumview.sides;
            let count = 0;
            for (let i = which * first; i < (which === 0 ? first : window.lumview.points); i++) {
                const { x, y, visible } = window.lumview.place(i);
                count += visible && x >= a && x <= b && y >= 200 && y <= 300;
            }
            return count;
        }, [side, left, right]);
        const { count } = await probe(page, "selection");
        assert.ok(wanted > 1000 && Math.abs(count - wanted) <= 0.001 * wanted, `${count} of ${wanted} points`);
    }
}

async function namesTheCommand({ browser, capture, folder }) {
    const wrong = profile(folder, "wrong.yaml", "version: 1\ndata_packet_type: 9\n");
    const page = await browser.newPage();
    await page.goto((await view(capture, "--profile", wrong)).url);
    await until(page, () => document.getElementById("message").textContent.includes("--infer"));
    const text = await page.locator("#message").textContent();
    assert.ok(text.includes(`lumdump ${capture} --infer -o profile.yaml finds the layout`), text);
}

export const besideFacts = [
    ["two profiles stand side by side, with one camera and one time", sideBySide],
    ["the same profile twice gives the same picture twice", twins],
    ["a click picks a point of the pane that it is in", picksInEither],
    ["a box selects the points of the pane that it is in", boxesInEither],
    ["where nothing decodes the page names the command that finds the layout", namesTheCommand],
];
