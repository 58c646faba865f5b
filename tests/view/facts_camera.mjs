// The camera: mouse, fingers, keys, views.
import assert from "node:assert/strict";
import { camera, drawn, openPoint, pixels, probe, settings, shoot, until } from "./page.mjs";
import { compare } from "./png.mjs";

const length = (v) => Math.hypot(...v);
const apart = (a, b) => length(a.map((v, i) => v - b[i]));
const isNear = (a, b, most = 1e-4) => a.every((v, i) => Math.abs(v - b[i]) <= most);
const turned = (a, b) => !isNear([a.yaw, a.pitch], [b.yaw, b.pitch], 0.5);

async function drag(page, modifier) {
    const box = await page.locator("#canvas").boundingBox();
    const [x, y] = [box.x + 0.55 * box.width, box.y + 0.4 * box.height];
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
    assert.ok(isNear(a.target, b.target) && Math.abs(a.distance - b.distance) < 1e-4);
    assert.ok(turned(a, b));
}

function isPan([a, b]) {
    assert.ok(!turned(a, b));
    assert.ok(!isNear(a.position, b.position, 0.1) && !isNear(a.target, b.target, 0.1));
}

function isOrbit([a, b]) {
    assert.ok(turned(a, b));
    assert.ok(!isNear(a.target, b.target, 0.1), "the target turns about the sensor");
    assert.ok(Math.abs(length(a.position) - length(b.position)) < 1e-4, "as far from the sensor");
}

function isZoom([a, b]) {
    assert.ok(isNear(a.target, b.target) && !turned(a, b));
    assert.ok(Math.abs(a.distance - b.distance) > 0.1);
}

async function mouse({ page }) {
    isRotation(await move(page, () => drag(page)));
    isPan(await move(page, () => drag(page, "Shift")));
    isOrbit(await move(page, () => drag(page, "Control")));
    const [before, after] = await move(page, () => page.mouse.wheel(0, -300));
    assert.ok(!turned(before, after) && after.distance < before.distance);
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
    assert.deepEqual([Math.round(seen.top.at.pitch), seen.top.flat], [90, true]);
    assert.deepEqual([Math.round(seen.front.at.pitch), seen.front.flat], [0, true]);
    assert.equal(seen.sensor.flat, false);
    assert.ok(length(seen.sensor.at.position) < 0.2, "the camera is at the sensor");
    for (const { at } of Object.values(seen)) {
        assert.ok(Math.abs(at.yaw) < 1e-6, "forward is up or ahead");
    }
    const pictures = Object.values(seen).map((one) => one.picture);
    pictures.forEach((one, i) => assert.ok(compare(one, pictures[(i + 1) % 4]).share > 0.02));
    await page.locator("#view-top").click();
    assert.equal(Math.round((await camera(page)).pitch), 90);
}

async function parallel({ page }) {
    const before = await pixels(page);
    await page.locator("#flat").check();
    assert.ok(compare(before, await pixels(page)).share > 0.02);
    const [middle, wide] = [await camera(page), await pixels(page)];
    const box = await page.locator("#canvas").boundingBox();
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.4 * box.height);
    await page.mouse.wheel(0, -400);
    assert.ok(compare(wide, await pixels(page)).share > 0.02);
    const near = await camera(page);
    assert.ok(near.distance < middle.distance && !turned(near, middle));
    await page.locator("#flat").uncheck();
    await drawn(page);
    const after = await camera(page);
    assert.ok(Math.abs(after.distance - near.distance) < 1e-3 && isNear(after.target, near.target));
}

// A thing about 60 m away, picked so that nothing stands before it.
async function farThing(page) {
    const box = await page.locator("#canvas").boundingBox();
    for (let from = 0; from < 20; from++) {
        const at = await openPoint(page, 211 * from, [50, 75]);
        await page.mouse.click(box.x + at.x, box.y + at.y);
        const picked = await probe(page, "picked");
        if (picked && picked.range > 50) {
            return { x: box.x + at.x, y: box.y + at.y, position: picked.position };
        }
    }
    throw new Error("there is nothing 60 m away");
}

// Until the camera is so far from a place.
function cameraIsOff(page, place, least, most) {
    return until(page, ([[x, y, z], a, b]) => {
        const [u, v, w] = window.lumview.camera().position;
        const off = Math.hypot(u - x, v - y, w - z);
        return off >= a && off <= b;
    }, [place, least, most]);
}

async function wheelEndsThere({ page }) {
    const there = await farThing(page);
    const before = apart((await camera(page)).position, there.position);
    assert.ok(before > 50);
    await page.mouse.move(there.x, there.y);
    for (let i = 0; i < 30; i++) {
        await page.mouse.wheel(0, -100);
    }
    await cameraIsOff(page, there.position, 0, 3);
    for (let i = 0; i < 30; i++) {
        await page.mouse.wheel(0, 100);
    }
    await cameraIsOff(page, there.position, 0.95 * before, 1.05 * before);
}

async function doubleClickTurns({ page }) {
    const there = await farThing(page);
    const before = await camera(page);
    await page.mouse.dblclick(there.x, there.y);
    await until(page, ([x, y, z]) => {
        const { target } = window.lumview.camera();
        return Math.hypot(target[0] - x, target[1] - y, target[2] - z) < 0.5;
    }, there.position);
    await drawn(page);
    const after = await camera(page);
    assert.ok(isNear(after.position, before.position, 0.01), "the camera stays");
    await page.keyboard.press("ArrowRight");
    await drawn(page);
    const turn = await camera(page);
    assert.ok(turned(turn, after) && isNear(turn.target, after.target));
}

async function touch(control, type, ...points) {
    await control.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: points.map(([x, y], id) => ({ x, y, id })),
    });
}

async function fingers({ page }) {
    const control = await page.context().newCDPSession(page);
    const box = await page.locator("#canvas").boundingBox();
    const [x, y] = [box.x + 0.55 * box.width, box.y + 0.5 * box.height];
    isRotation(await move(page, async () => {
        await touch(control, "touchStart", [x, y]);
        for (let i = 1; i <= 6; i++) {
            await touch(control, "touchMove", [x + 12 * i, y]);
        }
        await touch(control, "touchEnd");
    }));
    const [before, after] = await move(page, async () => {
        await touch(control, "touchStart", [x - 20, y]);
        await touch(control, "touchStart", [x - 20, y], [x + 20, y]);
        for (let i = 1; i <= 6; i++) {
            await touch(control, "touchMove", [x - 20 - 8 * i, y], [x + 20 + 8 * i, y]);
        }
        await touch(control, "touchEnd");
    });
    assert.ok(apart(before.position, after.position) > 1 && !turned(before, after), "two fingers zoom");
}

// What the pictures of a movement have, against the one after it.
async function movingIsThin({ page }) {
    await page.locator("#accumulate").fill("10");
    for (let frame = 2; frame <= 10; frame++) {
        await page.keyboard.press(".");
        await until(page, (n) => window.lumview.frame === n, frame);
    }
    await page.locator("#canvas").focus();
    const all = await probe(page, "points");
    assert.ok(all > 1000000);
    await drawn(page);
    assert.equal(await probe(page, "drawn"), all);
    const box = await page.locator("#canvas").boundingBox();
    await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.55 * box.width, box.y + 0.5 * box.height, { steps: 4 });
    await until(page, (n) => window.lumview.drawn > 10000 && window.lumview.drawn < n / 5, all);
    await page.mouse.up();
    await until(page, (n) => !window.lumview.moving && window.lumview.drawn === n, all);
    await page.locator("#accumulate").fill("1");
}

export const cameraFacts = [
    ["drag rotates, with Shift pans, with Ctrl orbits, the wheel zooms", mouse],
    ["arrow keys zoom and turn, with Shift pan, with Ctrl orbit", arrows],
    ["start, top, front and sensor are views of their own", views],
    ["parallel projection is another picture, and zooms", parallel],
    ["30 steps of the wheel end at what is 60 m away", wheelEndsThere],
    ["a double click sets the turning point", doubleClickTurns],
    ["one finger turns, two zoom", fingers],
    ["while the camera moves a part of the points is drawn, then all", movingIsThin],
];
