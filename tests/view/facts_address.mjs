// The state of the page in its address: shared, reloaded, typed wrong.
import assert from "node:assert/strict";
import { camera, choose, drawn, open, probe, settings, type, until } from "./page.mjs";
import { view } from "./tools.mjs";

const frameIs = (page, number) => until(page, (n) => window.lumview.frame === n, number);
const hashHas = (page, text) => until(page, (part) => location.hash.includes(part), text);

function assertSameLook(one, other) {
    for (const key of ["yaw", "pitch", "distance"]) {
        assert.ok(Math.abs(one[key] - other[key]) < 0.01, `${key}: ${one[key]}, ${other[key]}`);
    }
    one.target.forEach((v, i) => assert.ok(Math.abs(v - other.target[i]) < 0.01, `${one.target}, ${other.target}`));
    assert.equal(one.flat, other.flat);
}

// Until the address has the camera as it stands.
async function settled(page) {
    await drawn(page);
    await until(page, () => {
        const fields = (new URLSearchParams(location.hash.slice(1)).get("camera") ?? "").split(",").map(Number);
        const [, , , yaw, pitch, away, field, height] = fields;
        const look = window.lumview.camera();
        const distance = height > 0 ? height / 2 / Math.tan((field / 360) * Math.PI) : away;
        const pairs = [[yaw, look.yaw], [pitch, look.pitch], [distance, look.distance]];
        return fields.length === 8 && pairs.every(([one, other]) => Math.abs(one - other) < 0.001);
    });
}

// What one browser shows, another shows by its address, and the same one after a reload.
async function shares({ browser, capture }) {
    const server = await view("--paused", capture);
    const page = await open(browser, server.url);
    await until(page, () => location.hash === "#panel=on&frame=1"); // nothing else differs from the start
    await choose(page, "colour", "height");
    await type(page, "range-max", "35");
    await page.locator("#grid").uncheck();
    await page.keyboard.press("v");
    await page.keyboard.press("1"); // in parallel, straight down: where the angle to the north is hardest to keep
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("End");
    await frameIs(page, 10);
    await page.keyboard.press(",");
    await frameIs(page, 9);
    await hashHas(page, "frame=9");
    await settled(page);
    const [values, look, url] = [await settings(page), await camera(page), page.url()];
    assert.ok(!/token/.test(url), url);
    await page.keyboard.press("Home"); // another look at the same lumview: the address leads back
    await frameIs(page, 1);
    const other = await open(browser, url);
    await frameIs(other, 9);
    assert.deepEqual({ ...(await settings(other)), panel: null }, { ...values, panel: null });
    assertSameLook(await camera(other), look);
    await other.reload();
    await until(other, () => window.lumview?.shown > 0 && window.lumview.frame === 9);
    assertSameLook(await camera(other), look);
    assert.deepEqual(other.complaints, []);
}

// The address of another view, in the same tab, and that of the view as it was at first.
async function follows({ browser, capture }) {
    const server = await view("--paused", capture);
    const page = await open(browser, server.url);
    const start = await camera(page);
    await choose(page, "colour", "eye");
    await page.evaluate(() => {
        location.hash = "#map=cividis&blue=off&camera=10,1,0,90,30,20,50,0&frame=4";
    });
    await frameIs(page, 4);
    await drawn(page);
    const values = await settings(page);
    assert.deepEqual([values.map, values.blue, values.colour], ["cividis", false, "range"]);
    assertSameLook(await camera(page), { yaw: 90, pitch: 30, distance: 20, target: [10, 1, 0], flat: false });
    await page.evaluate(() => {
        location.hash = "#size=3&smooth=6"; // no window
    });
    await until(page, () => window.lumview.settings().size === 3);
    assert.equal((await settings(page)).smooth, 0);
    await drawn(page);
    assertSameLook(await camera(page), start);
}

// Each field for itself; the tab's own choices are not mixed in.
async function ignoresNonsense({ browser, capture }) {
    const server = await view("--paused", capture);
    const first = await open(browser, server.url);
    await choose(first, "return", "last");
    const bad = "colour=purple&map=cividis&size=99&accumulate=2.5&from=abc&to=&rangeMin=30&rangeMax=20&heightMax=4&smooth=6.5"
        + "&blue=maybe&camera=1,2,3&frame=x&token=1&__proto__=1&rings=off";
    await first.goto("about:blank");
    await first.goto(`${server.url.split("#")[0]}#${bad}`);
    await until(first, () => window.lumview?.shown > 0 && window.lumview.status());
    const values = await settings(first);
    const wanted = { colour: "range", map: "cividis", size: 2, accumulate: 1, from: null, to: null, rangeMin: null, rangeMax: null,
        heightMax: 4, smooth: 0, blue: true, return: "all", rings: false };
    assert.deepEqual(Object.fromEntries(Object.keys(wanted).map((key) => [key, values[key]])), wanted);
    assert.equal(await probe(first, "frame"), 1);
    assert.deepEqual(first.complaints, []);
}

export const addressFacts = [
    ["an address shows what it was taken from", shares],
    ["an address that is pasted is followed", follows],
    ["what an address has wrong is left out", ignoresNonsense],
];
