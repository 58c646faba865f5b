// The sensors of a rig in one picture, and what the page says of each.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import path from "node:path";
import { makeImage, TYPICAL } from "../../tools/lumview/page/image.js";
import { choose, counts, drawn, open, openPoint, pixels, positions, probe, until } from "./page.mjs";
import { exactPoints, pixelsAround, showStrip } from "./facts_pictures.mjs";
import { compare } from "./png.mjs";
import { dump, roundings, run, view } from "./tools.mjs";

const POSES = { front: [1.2, 0, 1.8, 0], left: [0, 0.9, 2.1, 90], rear: [0, 0, 1.8, 180] };
const ADDRESSES = { front: "10.42.0.37", left: "10.42.0.38", rear: "10.42.0.39" };

function writeRig(folder, name, ...sensors) {
    const lines = sensors.map((sensor) => {
        const [x, y, z, yaw] = POSES[sensor];
        return `  - {name: ${sensor}, address: ${ADDRESSES[sensor]}, pose: {x_m: ${x}, y_m: ${y}, z_m: ${z}, yaw_deg: ${yaw}}}\n`;
    });
    const file = path.join(folder, name);
    writeFileSync(file, `version: 1\nsensors:\n${lines.join("")}`);
    return file;
}

function moved([x, y, z, yaw], p) {
    const [c, s] = [Math.cos((yaw * Math.PI) / 180), Math.sin((yaw * Math.PI) / 180)];
    return [x + c * p.x - s * p.y, y + s * p.x + c * p.y, z + p.z];
}

const keyOf = (eye, line, pixel, turn) => [eye, line, pixel, turn].join();

// The picked point is that of its sensor's own run, moved by its pose.
function assertPicked(picked, capture) {
    const rows = dump(capture, "--sensor", ADDRESSES[picked.sensor], "--frames", `${picked.sensorFrame}:${picked.sensorFrame}`);
    const wanted = keyOf(Number(picked.eye === "green"), picked.line, picked.pixel, picked.returnNumber);
    const row = rows.find((one) => keyOf(one.eye, one.line, one.pixel, one.return_number) === wanted);
    const [x, y, z] = moved(POSES[picked.sensor], row);
    const { coordinate, range, azimuth, elevation } = roundings(picked.step, row);
    const pairs = [
        [picked.position, [x, y, z], [coordinate, coordinate, coordinate]],
        [[picked.range, picked.azimuth, picked.elevation], [row.range, row.azimuth, row.elevation], [range, azimuth, elevation]],
    ];
    for (const [got, right, most] of pairs) {
        got.forEach((v, i) => assert.ok(Math.abs(v - right[i]) < most[i], `${picked.sensor}: ${got} is not ${right}`));
    }
}

async function pickEach(page, capture) {
    await page.locator("#view-top").click();
    const seen = new Set();
    for (let i = 0; seen.size < 2 && i < 20; i++) {
        const at = await openPoint(page, i * 20011);
        const box = await page.locator("#canvas").boundingBox();
        await page.mouse.click(box.x + at.x, box.y + at.y);
        const picked = await probe(page, "picked");
        if (picked && !seen.has(picked.sensor)) {
            assertPicked(picked, capture);
            assert.match(await page.locator("#pick-data").textContent(), new RegExp(`^sensor${picked.sensor}its frame`));
            seen.add(picked.sensor);
        }
    }
    assert.deepEqual([...seen].sort(), ["front", "left"]);
}

// The strip is of one sensor, seen from where that is.
async function showsPicturesOf(page, capture, folder) {
    await showStrip(page);
    const image = makeImage(TYPICAL, 64);
    const most = roundings((await positions(page)).step).range; // turned by the pose
    for (const sensor of ["front", "left"]) {
        await page.locator("#strip-sensor").selectOption({ label: sensor });
        await drawn(page);
        const { index } = await probe(page, "strip");
        const { possible, sure } = pixelsAround(image, exactPoints(capture, folder, "--sensor", ADDRESSES[sensor]), most);
        const other = index.filter((i, k) => (i >= 0 ? !possible.has(k) : sure.has(k))).length;
        assert.equal(other, 0, `${sensor}: ${other} of ${index.length} pixels`);
        assert.ok(sure.size > 0.5 * possible.size, `${sure.size} of ${possible.size} pixels are sure`);
    }
    await page.locator("#strip-close").click();
}

async function showsARig({ browser, folder, capture: alone }) {
    const capture = path.join(folder, "rig.pcapng");
    run("lumsim", "-q", "--rig", writeRig(folder, "two.yaml", "front", "left"), "-o", capture, "--frames", 3, "--lines", 64);
    const server = await view("--paused", "--rig", writeRig(folder, "three.yaml", "front", "rear", "left"), capture);
    const page = await open(browser, server.url);
    assert.match(await page.locator("#frame-points").textContent(), /^[0-9,]+ points, none of rear$/);
    const sizes = ["front", "left"].map((sensor) => dump(capture, "--sensor", ADDRESSES[sensor], "--frames", "1:1").length);
    assert.equal((await counts(page)).shown, sizes[0] + sizes[1]);
    const before = await pixels(page);
    await choose(page, "colour", "sensor");
    assert.ok(compare(before, await pixels(page)).share > 0.01);
    assert.equal(await page.locator("#legend-ticks").textContent(), "frontrearleft");
    assert.ok(await page.locator("#map").isDisabled());
    await pickEach(page, capture);
    await showsPicturesOf(page, capture, folder);
    await page.reload();
    await until(page, () => window.lumview?.shown > 0);
    assert.equal((await probe(page, "settings")).colour, "sensor");
    assert.deepEqual(page.complaints, []);
    const other = await view("--paused", alone);
    const single = await open(browser, other.url);
    assert.equal(await single.locator("#colour [value=sensor]").count(), 0);
    assert.doesNotMatch(await single.locator("#frame-points").textContent(), /none of/);
    assert.deepEqual(single.complaints, []);
}

// Labels name no sensor, and true points of a capture are seen from one.
async function refusesWhatIsOfOneSensor({ browser, folder }) {
    const [alone, array, both] = ["labelled.pcap", "labels.npy", "both.pcapng"].map((name) => path.join(folder, name));
    const rig = writeRig(folder, "both.yaml", "front", "left");
    run("lumsim", "-q", "-o", alone, "--frames", 2, "--labels", array);
    run("lumsim", "-q", "--rig", rig, "-o", both, "--frames", 2, "--lines", 64);
    const server = await view("--paused", "--rig", rig, "--labels", array, both);
    const page = await open(browser, server.url);
    await until(page, () => document.getElementById("message").textContent.includes("labels.npy: labels belong to one sensor"));
    assert.equal(await page.locator("#colour [value=label]").count(), 0);
    await assert.rejects(view("--paused", "--rig", rig, "--truth", alone, both), /true points of a capture are seen from its sensor/);
}

export const rigFacts = [
    ["what is of one sensor is refused beside a rig", refusesWhatIsOfOneSensor],
    ["the sensors of a rig are shown together, each point with its sensor", showsARig],
];
