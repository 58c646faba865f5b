// Pause, step, scrub, loop, speed of a capture; the screenshot.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { drawn, probe, until } from "./page.mjs";
import { coloured, decode } from "./png.mjs";

const frameIs = (page, n) => until(page, (want) => window.lumview.frame === want, n);
const statusIs = (page, key, value) => until(page, ([k, v]) => window.lumview.status()[k] === v, [key, value]);

async function steps({ page }) {
    await page.locator("#forth").click();
    await frameIs(page, 2);
    await page.keyboard.press(".");
    await frameIs(page, 3);
    await page.keyboard.press(",");
    await frameIs(page, 2);
    await page.locator("#back").click();
    await frameIs(page, 1);
    await page.keyboard.press("End");
    await frameIs(page, 10);
    await page.locator("#first").click();
    await frameIs(page, 1);
    assert.equal((await probe(page, "status")).state, "paused");
}

async function scrubs({ page }) {
    await page.locator("#scrub").fill("6");
    await frameIs(page, 6);
    await until(page, () => document.getElementById("scrub-out").textContent.startsWith("6 "));
    await page.locator("#scrub").fill("3");
    await frameIs(page, 3);
}

async function plays({ page }) {
    if (!await page.locator("#loop").isChecked()) {
        await page.locator("#loop").click();
    }
    await statusIs(page, "loop", true);
    await page.locator("#speed").selectOption("2");
    await statusIs(page, "speed", 2);
    await page.locator("#play").click();
    await statusIs(page, "state", "playing");
    const { frames } = await probe(page, "status");
    await until(page, (n) => window.lumview.status().frames > n + 15, frames); // more than the capture has
    await page.locator("#play").click();
    await statusIs(page, "state", "paused");
    const { frame } = await probe(page, "status");
    await frameIs(page, frame);
}

async function ends({ page }) {
    if (await page.locator("#loop").isChecked()) {
        await page.locator("#loop").click(); // not uncheck(): a status on its way may still show it checked
    }
    await statusIs(page, "loop", false);
    await page.locator("#speed").selectOption("10");
    await page.locator("#play").click();
    await statusIs(page, "state", "ended");
    await frameIs(page, 10);
    await page.locator("#speed").selectOption("0.1");
    await statusIs(page, "speed", 0.1);
    await page.keyboard.press("v"); // the space key is the picture's
    await page.keyboard.press(" ");
    await statusIs(page, "state", "playing");
    await until(page, () => window.lumview.frame < 10);
    await page.keyboard.press(" ");
    await statusIs(page, "state", "paused");
    await page.locator("#speed").selectOption("1");
    await statusIs(page, "speed", 1);
}

async function screenshot({ page }) {
    for (const ask of [() => page.keyboard.press("p"), () => page.locator("#shot").click()]) {
        const [download] = await Promise.all([page.waitForEvent("download"), ask()]);
        assert.match(download.suggestedFilename(), /^lumview-1\.png$/);
        const picture = decode(readFileSync(await download.path()));
        const size = await page.evaluate(() => [window.canvas.width, window.canvas.height]);
        assert.deepEqual([picture.width, picture.height], size.map((pixels) => 2 * pixels));
        assert.ok(coloured(picture) > 0.05, "it shows points");
    }
}

async function memorySteady({ page }) {
    const before = await probe(page, "memory");
    await page.locator("#accumulate").fill("4");
    for (let i = 0; i < 12; i++) {
        const shown = await probe(page, "shown");
        await page.keyboard.press(i < 9 ? "." : ",");
        await until(page, (n) => window.lumview.shown > n, shown);
    }
    const most = await probe(page, "memory");
    assert.ok(most.geometries <= before.geometries + 3, `${most.geometries} geometries, ${before.geometries} before`);
    await page.locator("#accumulate").fill("1");
    await drawn(page);
    assert.ok((await probe(page, "memory")).geometries <= before.geometries);
}

export const playerFacts = [
    ["steps and jumps show the frame asked for", steps],
    ["the slider scrubs", scrubs],
    ["it plays round and round at the speed chosen, and pauses", plays],
    ["without loop it ends, and begins anew", ends],
    ["the screenshot is a PNG of the picture", screenshot],
    ["buffers of past frames are given back", memorySteady],
];
