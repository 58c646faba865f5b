// The connection: lost and found, slow pages, several, a live sensor.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { connect, createServer } from "node:net";
import path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { choose, counts, drawn, open, pixels, probe, settings, shoot, showStats, until } from "./page.mjs";
import { countOf } from "./facts_points.mjs";
import { coloured } from "./png.mjs";
import { run, sim, stop, view, viewInBrowser } from "./tools.mjs";

const BYTES_A_POINT = 10; // of a whole frame, at most
const UNDER_WAY = 2e6; // bytes that the system and the browser may have of frames before it
const SLICE = 4096; // bytes that a slow link lets through at once
const SENSOR = "127.0.5.17";
const GONE = /no connection: lumview has ended or cannot be reached; trying again/;

const bannerShows = (page) => until(page, () => !document.getElementById("banner").hidden);
const bannerGone = (page) => until(page, () => document.getElementById("banner").hidden && window.lumview.connected);

async function killed({ browser, capture }) {
    const server = await view("--loop", capture);
    const page = await open(browser, server.url);
    await choose(page, "edges", "falling");
    await until(page, () => window.lumview.counts().falling > 0);
    await stop(server.child, "SIGKILL");
    await bannerShows(page);
    assert.match(await page.locator("#banner").textContent(), GONE);
    assert.equal(await page.locator("#banner").getAttribute("role"), "alert");
    assert.equal(await probe(page, "connected"), false);
    assert.ok(coloured(await pixels(page)) > 0.03, "the last picture stays");
    await shoot(page, "lumview-gone");
    const shown = await probe(page, "shown");
    await view("--loop", "--port", server.port, capture);
    await bannerGone(page);
    await until(page, (n) => window.lumview.shown > n + 2, shown);
    await until(page, () => window.lumview.counts().rising === 0);
}

async function hung({ browser, capture }) {
    const server = await view("--loop", capture);
    const page = await open(browser, server.url);
    server.child.kill("SIGSTOP");
    await bannerShows(page);
    assert.match(await page.locator("#banner").textContent(), GONE);
    server.child.kill("SIGCONT");
    await bannerGone(page);
    const shown = await probe(page, "shown");
    await until(page, (n) => window.lumview.shown > n, shown);
}

// Pauses, and how many frames came until the newest was shown.
async function behind(page) {
    const before = await probe(page, "received");
    await page.keyboard.press(" ");
    await until(page, () => window.lumview.status().state === "paused");
    await until(page, () => window.lumview.frame === window.lumview.status().frame);
    await drawn(page);
    return (await probe(page, "received")) - before;
}

async function throttled({ browser, capture }) {
    const server = await view("--loop", "--speed", "4", capture);
    const page = await open(browser, server.url);
    const control = await page.context().newCDPSession(page);
    await control.send("Emulation.setCPUThrottlingRate", { rate: 20 });
    const { frames } = await probe(page, "status");
    // On a busy machine the server is throttled too, and it takes longer until a frame is left out.
    await until(page, (n) => window.lumview.status().frames > n + 50 && window.lumview.status().skipped > 0, frames);
    const waiting = await behind(page);
    assert.ok(waiting < 20, `${waiting} frames waited`);
}

// What goes through a SOCKS proxy that lets so many bits a second come back; the times and sizes of what came.
function makeSlowLink(bits) {
    const passed = [];
    const server = createServer((near) => {
        near.on("error", () => near.destroy());
        near.once("data", () => {
            near.write(Uint8Array.of(5, 0));
            near.once("data", (request) => {
                const far = connect(request.readUInt16BE(request.length - 2), "127.0.0.1", () => near.write(Uint8Array.of(5, 0, 0, 1, 0, 0, 0, 0, 0, 0)));
                near.pipe(far);
                far.on("error", () => near.destroy());
                pipeSlowly(far, near, bits, (bytes) => passed.push({ bytes, ms: performance.now() }));
            });
        });
    });
    return new Promise((done) => server.listen(0, "127.0.0.1", () => done({ server, passed, proxy: { server: `socks5://127.0.0.1:${server.address().port}` } })));
}

async function pipeSlowly(from, to, bits, tell) {
    let due = performance.now();
    try {
        for await (const all of from) {
            for (let at = 0; at < all.length; at += SLICE) {
                const part = all.subarray(at, at + SLICE);
                due = Math.max(due, performance.now() - 20) + (8000 * part.length) / bits; // a pause is not made up for
                await sleep(Math.max(0, due - performance.now()));
                to.write(part);
                tell(part.length);
            }
        }
    } catch {
        // the browser or lumview has gone
    }
    to.destroy();
}

// Frames that a link cannot bring as quickly as they play: coarse pictures of the newest, and of a frame that stands all of it.
async function limited({ browser, folder }, lines, megabits) {
    const capture = path.join(folder, `limited-${lines}.pcap`);
    run("lumsim", "-q", "-o", capture, "--frames", 3, "--lines", lines);
    const { server, passed, proxy } = await makeSlowLink(1e6 * megabits);
    const { url } = await view("--loop", capture);
    const page = await (await browser.newContext({ proxy })).newPage();
    await page.goto(url);
    await until(page, () => window.lumview?.shown > 0 && window.lumview.status());
    await until(page, () => /\(\d+ %\)$/.test(document.getElementById("frame-points").textContent));
    const { shown, frames } = await page.evaluate(() => ({ shown: window.lumview.shown, frames: window.lumview.received }));
    await until(page, ([s, f]) => window.lumview.shown > s + 5 && window.lumview.received > f + 5, [shown, frames]);
    assert.ok((await probe(page, "status")).skipped > 0, "none was left out");
    const sum = () => passed.reduce((all, part) => all + part.bytes, 0);
    const before = sum();
    await behind(page);
    const [came, points, frame] = [sum() - before, await probe(page, "points"), await probe(page, "frame")];
    assert.equal(points, countOf(capture, "--frames", `${frame}:${frame}`));
    assert.ok(came < BYTES_A_POINT * points + UNDER_WAY, `${came} bytes came until ${points} points were there`);
    const rate = (8 * sum()) / 1000 / (passed.at(-1).ms - passed[0].ms);
    assert.ok(rate < 1.1 * megabits, `${rate} Mbit/s`);
    server.close();
}

async function frozen({ browser, capture }) {
    const server = await view("--loop", "--speed", "4", capture);
    const page = await open(browser, server.url);
    const control = await page.context().newCDPSession(page);
    const before = await probe(page, "status");
    await control.send("Page.setWebLifecycleState", { state: "frozen" });
    await sleep(4000);
    await control.send("Page.setWebLifecycleState", { state: "active" });
    const waiting = await behind(page);
    const { frames } = await probe(page, "status");
    assert.ok(waiting < (frames - before.frames) / 2, `${waiting} of ${frames - before.frames} frames waited`);
}

async function several({ browser, capture }) {
    const server = await view("--paused", capture);
    const pages = [];
    for (let i = 0; i < 3; i++) {
        pages.push(await open(browser, server.url));
    }
    await choose(pages[1], "edges", "falling");
    await until(pages[1], () => window.lumview.counts().falling > 0);
    await choose(pages[2], "edges", "both");
    await until(pages[2], () => window.lumview.counts().falling > 0);
    const seen = [];
    for (const page of pages) {
        const { rising, falling } = await counts(page);
        seen.push([rising > 0, falling > 0]);
    }
    assert.deepEqual(seen, [[true, false], [false, true], [true, true]]);
    await until(pages[0], () => window.lumview.status().browsers === 3);
    await pages[0].keyboard.press(".");
    for (const page of pages) {
        await until(page, () => window.lumview.frame === 2);
    }
}

async function live({ browser }) {
    const sensor = sim("--address", SENSOR);
    const server = await view("--laser", `udp://${SENSOR}`);
    const page = await open(browser, server.url);
    await until(page, () => window.lumview.points > 100000 && window.lumview.status().points_per_second > 100000);
    assert.ok(coloured(await pixels(page)) > 0.05);
    await until(page, () => document.getElementById("laser-bits").textContent.includes("TLV_CMD_ON"));
    assert.match(await page.locator("#laser-state").textContent(), /^on, status 0x0800/);
    assert.equal(await page.locator("#scrub").isVisible(), false);
    await shoot(page, "lumview-live");
    await page.keyboard.press(" ");
    await drawn(page);
    const [held, received] = [await probe(page, "frame"), await probe(page, "received")];
    await until(page, (n) => window.lumview.received > n + 3, received);
    await drawn(page);
    assert.equal(await probe(page, "frame"), held, "the picture is held");
    await choose(page, "return", "strongest");
    const { shown, total } = await counts(page);
    assert.ok(shown > 0 && shown < total);
    await choose(page, "edges", "falling");
    await until(page, () => window.lumview.counts().falling > 0);
    assert.equal((await probe(page, "status")).live, true);
    const [other, next] = [await probe(page, "frame"), await probe(page, "received")];
    await until(page, (n) => window.lumview.received > n + 3, next);
    await drawn(page);
    assert.equal(await probe(page, "frame"), other, "it is held again");
    await choose(page, "edges", "rising");
    await until(page, () => window.lumview.counts().rising > 0);
    await page.keyboard.press(" ");
    await until(page, (n) => window.lumview.frame > n, held);
    await stop(sensor);
    await until(page, () => window.lumview.status().state === "silent");
    assert.equal(await page.locator("#message").isVisible(), true);
}

// What was chosen is there after a reload: the address has it.
async function reloads({ browser, capture }) {
    const server = await view("--paused", capture);
    const page = await open(browser, server.url);
    await choose(page, "colour", "height");
    await choose(page, "return", "strongest");
    await choose(page, "edges", "both");
    await choose(page, "smooth", "7");
    await page.locator("#range-max").fill("20");
    await page.locator("#green").uncheck();
    const before = await settings(page);
    await until(page, () => location.hash.includes("green=off")); // not at once
    const again = async () => {
        await page.reload();
        await page.waitForFunction(() => window.lumview?.shown > 0 && window.lumview.status());
        await drawn(page);
        return settings(page);
    };
    assert.deepEqual(await again(), before);
    await until(page, () => window.lumview.counts().falling > 0 && window.lumview.smooth === 7);
    assert.equal(await page.locator("#range-max").inputValue(), "20");
    assert.equal(await page.locator("#legend-title").textContent(), "Height");
    assert.equal((await counts(page)).green, 0);
    assert.deepEqual(page.complaints, []);
}

async function hazard({ browser }) {
    const sensor = sim("--address", SENSOR, "--fault", "fan@USR1");
    const server = await view("--laser", `udp://${SENSOR}`);
    const page = await open(browser, server.url);
    await until(page, () => document.getElementById("laser-state").textContent.startsWith("on"));
    sensor.kill("SIGUSR1");
    await showStats(page);
    const item = page.locator("#laser-bits li.hazard");
    await item.filter({ hasText: "FAN_PWM_BAD" }).waitFor();
    assert.match(await page.locator("#laser-state").textContent(), /^off, status 0x.*hazard/);
    assert.equal(await item.first().evaluate((e) => getComputedStyle(e).borderTopColor), "rgb(255, 154, 143)");
    await until(page, () => document.getElementById("message").textContent.includes("FAN_PWM_BAD"));
    await shoot(page, "lumview-hazard");
}

// The token comes by a file; the cookie then has it, also when the page is loaded again.
async function byFile({ browser, capture, folder }) {
    const url = await viewInBrowser(folder, "--bind", "127.0.0.1", capture);
    assert.match(url, /^file:\/\/\/.*\.html$/);
    const page = await open(browser, url);
    assert.match(page.url(), /^http:\/\/127\.0\.0\.1:\d+\/(#(?!.*token).*)?$/);
    await page.reload();
    await until(page, () => window.lumview?.shown > 0);
    const loaded = await page.evaluate(() => performance.getEntriesByType("resource")
        .filter((one) => /\.(js|css)$/.test(one.name)).map((one) => one.transferSize));
    assert.deepEqual(loaded, [0, 0], "script and style were kept");
    assert.deepEqual(page.complaints, []);
}

// A page of a run before has another token. It comes back when another page has brought the new one.
async function startedAgain({ browser, capture }) {
    const server = await view("--bind", "127.0.0.1", "--paused", capture);
    const context = await browser.newContext();
    const page = await open(context, server.url);
    assert.deepEqual([page.url().split("#")[0], page.complaints], [`http://127.0.0.1:${server.port}/`, []]);
    await stop(server.child);
    await bannerShows(page);
    assert.match(await page.locator("#banner").textContent(), GONE);
    const { url } = await view("--bind", "127.0.0.1", "--port", server.port, "--paused", capture);
    await until(page, () => document.getElementById("banner").textContent.includes("token is no longer valid"));
    assert.match(await page.locator("#banner").textContent(), /open the URL that it printed/);
    await (await context.newPage()).goto(url);
    await bannerGone(page);
}

// A capture without its first packets: the lines that they began are counted, and are no loss.
async function joined({ browser, capture, folder }) {
    const whole = readFileSync(capture);
    const cut = path.join(folder, "joined.pcap");
    let at = 24;
    for (let i = 0; i < 5; i++) {
        at += 16 + whole.readUInt32LE(at + 8);
    }
    writeFileSync(cut, Buffer.concat([whole.subarray(0, 24), whole.subarray(at)]));
    const server = await view(cut);
    const page = await open(browser, server.url);
    await until(page, () => window.lumview.status().losses.joined_lines > 0);
    await until(page, () => document.getElementById("losses").textContent.includes("under way"));
    assert.match(await page.locator("#losses").textContent(), /0 \+ [12] under way/);
    assert.equal(await page.locator("#losses .bad").count(), 0);
}

async function withoutAClock({ browser, capture, folder }) {
    const profile = path.join(folder, "no_clock.yaml");
    writeFileSync(profile, "version: 1\ngroup: {timestamp: none}\n");
    const page = await open(browser, (await view("--paused", "--profile", profile, capture)).url);
    assert.equal((await probe(page, "began")).kind, "arrival");
    assert.match(await page.locator("#frame-time").textContent(), / UTC, arrival$/);
    assert.match(await page.locator("#frame-time").getAttribute("title"), /when its first packet came/);
}

// Every other status says nothing of marks: they stay.
async function marksLosses({ browser, capture }) {
    const server = await view("--paused", capture);
    const context = await browser.newContext();
    let told = 0;
    await context.routeWebSocket(/\/ws$/, (socket) => {
        const lumview = socket.connectToServer();
        lumview.onMessage((message) => {
            const isStatus = typeof message === "string" && JSON.parse(message).type === "status";
            const marks = [[3, 1234, 0, 5], [7, 0, 2, 30]];
            const sent = isStatus && told++ % 2 === 0 ? JSON.stringify({ ...JSON.parse(message), marks }) : message;
            socket.send(sent);
        });
    });
    const page = await open(context, server.url);
    await until(page, () => document.querySelectorAll("#marks i").length === 2);
    const box = await page.locator("#scrub").boundingBox();
    const at = await page.locator("#marks i").evaluateAll((all) => all.map((e) => [e.className, e.getBoundingClientRect().x + 1]));
    assert.deepEqual(at.map(([kind]) => kind), ["lost", "pause"]);
    at.forEach(([, x], i) => assert.ok(Math.abs(x - (box.x + 8 + ([2, 6][i] / 9) * (box.width - 16))) < 1.5, `${x}, ${JSON.stringify(box)}`));
    const [third, seventh] = [[3, "1,234 ranges lost, 5 lines lost"], [7, "30 lines lost, 2 pauses"]];
    for (const [key, frame, text] of [["n", ...third], ["n", ...seventh], ["N", ...third]]) {
        await page.keyboard.press(key);
        await until(page, ([n, hint]) => window.lumview.frame === n && document.getElementById("scrub").title === hint, [frame, text]);
    }
    assert.match(await page.locator("#scrub").getAttribute("aria-valuetext"), /^frame 3 of 10, 1,234 ranges lost, 5 lines lost$/);
}

// Who wants little motion sees the camera where it goes in the next picture.
async function reducedMotion({ browser, capture }) {
    const server = await view("--paused", capture);
    const context = await browser.newContext({ reducedMotion: "reduce" });
    const page = await open(context, server.url);
    await page.keyboard.press("v");
    const before = await probe(page, "camera");
    const next = await page.evaluate(async () => {
        document.getElementById("canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true }));
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        return window.lumview.camera();
    });
    await drawn(page);
    const after = await probe(page, "camera");
    assert.ok(Math.abs(Math.abs(after.yaw - before.yaw) - 5) < 1e-6, `${before.yaw}, ${after.yaw}`);
    assert.ok(Math.abs(next.yaw - after.yaw) < 1e-9, `${next.yaw}, ${after.yaw}`);
    const moving = await page.evaluate(() => [...document.querySelectorAll("*")].filter((e) => {
        const { animationName, transitionDuration } = getComputedStyle(e);
        return animationName !== "none" || parseFloat(transitionDuration) > 0;
    }).map((e) => e.id || e.tagName));
    assert.deepEqual(moving, []);
}

export const linkFacts = [
    ["with reduced motion nothing glides", reducedMotion],
    ["losses and pauses are marked at the slider", marksLosses],
    ["without a clock to fit the arrival is told", withoutAClock],
    ["a page with a token is opened by a file, and keeps its script and style", byFile],
    ["started again, lumview says that a page's token is not valid any more", startedAgain],
    ["a killed server gives a message, and back the page recovers", killed],
    ["so does one that hangs", hung],
    ["a throttled page shows the newest frame", throttled],
    ["a link of 4 Mbit/s shows 64 lines", (context) => limited(context, 64, 4)],
    ["a link of 30 Mbit/s shows 640 lines", (context) => limited(context, 640, 30)],
    ["a frozen page shows the newest frame when it wakes", frozen],
    ["what was under way when the stream was joined is not red", joined],
    ["several pages have views of their own", several],
    ["settings survive a reload", reloads],
    ["live: the street, the laser's status, a held picture, silence", live],
    ["live: a hazard is named and coloured", hazard],
];
