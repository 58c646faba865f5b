// The camera: mouse, keys, views.
import assert from "node:assert/strict";
import { camera, drawn, pixels, settings, shoot } from "./page.mjs";
import { compare } from "./png.mjs";

const length = (v) => Math.hypot(...v);
const isNear = (a, b, most = 1e-6) => a.every((v, i) => Math.abs(v - b[i]) <= most);

async function drag(page, modifier) {
    const box = await page.locator("#canvas").boundingBox();
    const [x, y] = [box.x + 0.35 * box.width, box.y + 0.4 * box.height];
    await page.mouse.move(x, y);
    if (modifier) {
        await page.keyboard.down(modifier);
    }
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 25, { steps: 6 });
    await page.mouse.up();
    if (modifier) {
        await page.keyboard.up(modifier);
    }
    await drawn(page);
}

// What a move does to the camera; pixels must differ.
async function move(page, act) {
    const [before, old] = [await camera(page), await pixels(page)];
    await act();
    await drawn(page);
    assert.ok(compare(old, await pixels(page)).share > 0.01, "the picture stays");
    return [before, await camera(page)];
}

function isRotation([a, b]) {
    assert.ok(isNear(a.target, b.target) && Math.abs(a.distance - b.distance) < 1e-9);
    assert.ok(a.yaw !== b.yaw || a.pitch !== b.pitch);
}

function isPan([a, b]) {
    assert.ok(a.yaw === b.yaw && a.pitch === b.pitch && a.distance === b.distance);
    assert.ok(!isNear(a.target, b.target, 0.1));
}

function isOrbit([a, b]) {
    assert.ok(a.yaw !== b.yaw || a.pitch !== b.pitch);
    assert.ok(!isNear(a.target, b.target, 0.1), "the target turns about the sensor");
    assert.ok(Math.abs(length(a.position) - length(b.position)) < 1e-6, "as far from the sensor");
}

function isZoom([a, b]) {
    assert.ok(isNear(a.target, b.target) && a.yaw === b.yaw && a.pitch === b.pitch);
    assert.ok(a.distance !== b.distance);
}

async function mouse({ page }) {
    isRotation(await move(page, () => drag(page)));
    isPan(await move(page, () => drag(page, "Shift")));
    isOrbit(await move(page, () => drag(page, "Control")));
    const [before, after] = await move(page, () => page.mouse.wheel(0, -300));
    isZoom([before, after]);
    assert.ok(after.distance < before.distance);
}

async function arrows({ page }) {
    const press = (key) => () => page.keyboard.press(key);
    const [far, near] = await move(page, press("ArrowUp"));
    assert.ok(near.distance < far.distance);
    isZoom(await move(page, press("ArrowDown")));
    isRotation(await move(page, press("ArrowLeft")));
    isRotation(await move(page, press("PageUp")));
    for (const arrow of ["Left", "Right", "Up", "Down"]) {
        isPan(await move(page, press(`Shift+Arrow${arrow}`)));
        isOrbit(await move(page, press(`Control+Arrow${arrow}`)));
    }
}

async function views({ page }) {
    const seen = {};
    for (const [name, key] of [["home", "0"], ["top", "1"], ["front", "2"], ["sensor", "3"]]) {
        await page.keyboard.press(key);
        seen[name] = { at: await camera(page), picture: await pixels(page), flat: (await settings(page)).flat };
        await shoot(page, `lumview-${name}`);
    }
    assert.deepEqual([seen.top.at.pitch, seen.top.flat], [90, true]);
    assert.deepEqual([seen.front.at.pitch, seen.front.flat], [0, true]);
    assert.equal(seen.sensor.flat, false);
    assert.ok(length(seen.sensor.at.position) < 0.2, "the camera is at the sensor");
    const pictures = Object.values(seen).map((one) => one.picture);
    pictures.forEach((one, i) => assert.ok(compare(one, pictures[(i + 1) % 4]).share > 0.02));
    await page.locator("#view-top").click();
    assert.equal((await camera(page)).pitch, 90);
}

async function parallel({ page }) {
    const before = await pixels(page);
    await page.locator("#flat").check();
    assert.ok(compare(before, await pixels(page)).share > 0.02);
}

export const cameraFacts = [
    ["drag rotates, with Shift pans, with Ctrl orbits, the wheel zooms", mouse],
    ["arrow keys zoom and turn, with Shift pan, with Ctrl orbit", arrows],
    ["start, top, front and sensor are views of their own", views],
    ["parallel projection is another picture", parallel],
];
