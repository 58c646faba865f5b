// Memory of a tab and of lumview while a live sensor is looked at, and what depth shading costs.
//   LUM_BIN=build/bin node soak_view.mjs [SECONDS]       default: 300
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";
import { launch, open, probe, until } from "./page.mjs";
import { sim, stopAll, view } from "./tools.mjs";

const SENSOR = "127.0.5.18";
const SAMPLES = 30;
const MEGABYTE = 1e6;
const PICTURES = 12; // of a rate
const ROUNDS = 9;
const LEAST_RATE = 0.7; // with depth shading, of that without

function resident(pid) {
    return Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) * 1024;
}

async function rendererPid(browser) {
    const session = await browser.newBrowserCDPSession();
    const { processInfo } = await session.send("SystemInfo.getProcessInfo");
    const pids = processInfo.filter((one) => one.type === "renderer").map((one) => one.id);
    return pids.reduce((a, b) => (resident(a) > resident(b) ? a : b));
}

async function sample(page, control, pids) {
    await control.send("HeapProfiler.collectGarbage");
    const { usedSize } = await control.send("Runtime.getHeapUsage");
    return { heap: usedSize, tab: resident(pids.tab), server: resident(pids.server) };
}

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];

// Whole pictures a second of what stands still.
async function rate(page, edl) {
    await page.locator("#edl").selectOption(edl);
    return page.evaluate(async (count) => {
        const next = () => new Promise((done) => requestAnimationFrame(done));
        let begun = 0;
        for (let i = -4; i < count; i++) {
            begun = i === 0 ? performance.now() : begun;
            document.getElementById("grid").click();
            await next();
        }
        return (1000 * count) / (performance.now() - begun);
    }, PICTURES);
}

// Without, with, and with as a share of without. In turns, so that other work on the machine meets both.
async function shadingRates(page) {
    const rounds = [];
    for (let i = 0; i < ROUNDS; i++) {
        rounds.push([await rate(page, "off"), await rate(page, "on")]);
    }
    return [...[0, 1].map((k) => median(rounds.map((rates) => rates[k]))), median(rounds.map(([plain, shaded]) => shaded / plain))];
}

// The last third against the second: the first fills caches.
function growth(samples, what) {
    const third = Math.floor(samples.length / 3);
    const of = (from) => median(samples.slice(from, from + third).map((one) => one[what]));
    return { before: of(third), after: of(2 * third) };
}

const seconds = Number(process.argv[2] ?? 300);
const browser = await launch();
let failed = 0;
try {
    sim("--address", SENSOR);
    const server = await view("--laser", `udp://${SENSOR}`);
    const page = await open(browser, server.url);
    await until(page, () => window.lumview.points > 100000);
    await page.locator("#accumulate").fill("3");
    const control = await page.context().newCDPSession(page);
    const pids = { tab: await rendererPid(browser), server: server.child.pid };
    const [samples, graphics] = [[], await probe(page, "memory")];
    for (let i = 0; i < SAMPLES; i++) {
        await sleep((seconds * 1000) / SAMPLES);
        samples.push(await sample(page, control, pids));
    }
    const limits = { heap: 5 * MEGABYTE, tab: 30 * MEGABYTE, server: 8 * MEGABYTE };
    for (const [what, most] of Object.entries(limits)) {
        const { before, after } = growth(samples, what);
        const isSteady = after - before < most;
        failed += !isSteady;
        const text = `${(before / MEGABYTE).toFixed(1)} MB, then ${(after / MEGABYTE).toFixed(1)} MB`;
        console.log(`${isSteady ? "ok  " : "FAIL"} memory of ${what} is steady: ${text}`);
    }
    const after = await probe(page, "memory");
    assert.ok(after.geometries <= graphics.geometries + 2 && after.textures === graphics.textures);
    const { frames, skipped } = await probe(page, "status");
    console.log(`ok   ${await probe(page, "shown")} frames shown of ${frames}, ${skipped} left out by the server`);
    await page.locator("#play").click();
    await until(page, () => document.getElementById("state").dataset.state === "held");
    const [plain, shaded, share] = await shadingRates(page);
    const isQuick = share >= LEAST_RATE;
    failed += !isQuick;
    console.log(`${isQuick ? "ok  " : "FAIL"} ${plain.toFixed(1)} pictures a second, ${shaded.toFixed(1)} with depth shading, ${share.toFixed(2)} of them`);
} catch (error) {
    failed++;
    console.log(`FAIL ${error.stack}`);
} finally {
    await browser.close();
    await stopAll();
}
console.log(`${5 - Math.min(5, failed)} passed, ${failed} failed`);
process.exitCode = failed > 0 ? 1 : 0;
