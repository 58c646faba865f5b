// lumview.html in Chromium and in Firefox: how soon a capture of 51 MB is a picture, how fast the worker decodes, and the
// memory of the page's process with a capture of 1 GB.
//   LUM_BIN=build/bin node soak_alone.mjs [BROWSER...]
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { PAGE } from "./facts_alone.mjs";
import { launchFirefox } from "./firefox.mjs";
import { launch, SIZE, until } from "./page.mjs";
import { run } from "./tools.mjs";

const BROWSERS = { chromium: launch, firefox: launchFirefox };
const FRAMES = { small: 30, large: 632 };
const ROUNDS = 3;
const POINTS = 30e6; // that a rate is of
const TICKS = 100; // a second, of /proc
const LOOK_MS = 100;
const SEEKS = [600, 20, 300, 632];
const BARS = { "ms until the first picture of 51 MB": [1000, -1], "million points in a second of the worker": [10, 1],
    "MB of the page's process with 1 GB": [150, -1] };

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];

// ---- processes ----

const readProcess = (pid, file) => {
    try {
        return readFileSync(`/proc/${pid}/${file}`, "utf8");
    } catch {
        return ""; // it has ended
    }
};

// Those that this one has started, and theirs.
function descendants() {
    const parents = new Map(readdirSync("/proc").filter((name) => /^\d+$/.test(name)).map((pid) => [
        pid, /^PPid:\s+(\d+)/m.exec(readProcess(pid, "status"))?.[1],
    ]));
    const isOurs = (pid) => pid === String(process.pid) || (parents.has(pid) && isOurs(parents.get(pid)));
    return [...parents.keys()].filter(isOurs);
}

const pages = () => descendants().filter((pid) => /--type=renderer|[\0 ]tab\0*$/.test(readProcess(pid, "cmdline")));

// Megabytes that are the process's own, of the largest that shows pages.
function pageMemory() {
    const own = (pid) => Number(/^RssAnon:\s+(\d+)/m.exec(readProcess(pid, "status"))?.[1] ?? 0) * 1.024e-3;
    return Math.max(...pages().map(own));
}

// Seconds that decoders' threads have worked.
function workerSeconds() {
    const threads = pages().flatMap((pid) => readdirSync(`/proc/${pid}/task`).map((id) => readProcess(pid, `task/${id}/stat`)));
    const ticks = threads.filter((stat) => /\((DedicatedWorker|DOM Worker)/.test(stat)).map((stat) => {
        const [user, system] = stat.slice(stat.lastIndexOf(")") + 2).split(" ").slice(11, 13);
        return Number(user) + Number(system);
    });
    return ticks.reduce((sum, one) => sum + one, 0) / TICKS;
}

// ---- what is measured ----

async function openPage(browser) {
    const page = await browser.newPage({ viewport: SIZE });
    await page.goto(pathToFileURL(PAGE).href);
    await until(page, () => window.lumview && !document.getElementById("landing").hidden);
    return page;
}

// From the choice of the file until its points are drawn.
async function firstPicture(page, capture) {
    await page.evaluate(() => document.getElementById("files").addEventListener("change", () => {
        const begun = performance.now();
        const look = () => {
            const isThere = window.lumview.points > 0 && window.lumview.drawn > 0;
            window.firstMs = isThere ? performance.now() - begun : requestAnimationFrame(look) && 0;
        };
        requestAnimationFrame(look);
    }, true));
    await page.setInputFiles("#files", capture);
    await until(page, () => window.firstMs > 0);
    return page.evaluate(() => window.firstMs);
}

// Millions of points in a second of the worker's time, while all is played as fast as it can be.
async function decodingRate(page) {
    await until(page, () => window.lumview.status().last_frame !== null);
    await page.keyboard.press("l");
    await page.evaluate(() => {
        const speed = document.getElementById("speed");
        speed.add(new Option("100", "100"));
        speed.value = "100";
        speed.dispatchEvent(new Event("change"));
    });
    await until(page, () => window.lumview.status().loop && window.lumview.status().speed === 100);
    const points = (least) => until(page, (n) => window.lumview.status().points > n, least)
        .then(() => page.evaluate(() => window.lumview.status().points));
    const first = await points(await points(0));
    const begun = workerSeconds();
    const last = await points(first + POINTS);
    return (last - first) / 1e6 / (workerSeconds() - begun);
}

// Each 100 ms while it is read and while it goes here and there.
async function memoryOf(browser, capture) {
    const page = await openPage(browser);
    const before = pageMemory();
    let most = before;
    const look = setInterval(() => {
        most = Math.max(most, pageMemory());
    }, LOOK_MS).unref();
    const begun = performance.now();
    await page.setInputFiles("#files", capture);
    await until(page, () => window.lumview.status()?.last_frame > 0);
    const seconds = (performance.now() - begun) / 1000;
    for (const frame of SEEKS) {
        await page.evaluate((number) => {
            const scrub = document.getElementById("scrub");
            scrub.value = number;
            scrub.dispatchEvent(new Event("input"));
        }, frame);
        await until(page, (number) => window.lumview.frame >= number && window.lumview.frame < number + 30, frame);
    }
    clearInterval(look);
    await page.close();
    return { before, most, seconds };
}

// ---- what is told ----

let failed = 0;

function tell(browser, what, value) {
    const [bar, sign] = BARS[what];
    const isGood = sign * value >= sign * bar;
    failed += !isGood;
    console.log(`${isGood ? "ok  " : "FAIL"} ${browser}: ${value.toFixed(1)} ${what} (bar: ${bar}), load ${loadavg()[0].toFixed(1)}`);
}

async function measure(name, captures) {
    const browser = await BROWSERS[name]();
    const [firsts, rates] = [[], []];
    for (let i = 0; i < ROUNDS; i++) {
        const page = await openPage(browser);
        firsts.push(await firstPicture(page, captures.small));
        rates.push(await decodingRate(page));
        await page.close();
    }
    await browser.close();
    const [pictures, points, memory] = Object.keys(BARS);
    tell(name, pictures, median(firsts));
    tell(name, points, median(rates));
    const fresh = await BROWSERS[name](); // a process that has held nothing else
    const { before, most, seconds } = await memoryOf(fresh, captures.large);
    await fresh.close();
    tell(name, memory, most);
    console.log(`     ${before.toFixed(1)} MB of it before the capture was opened, which was read to its end in ${seconds.toFixed(1)} s`);
}

const top = mkdtempSync(path.join(tmpdir(), "lumview-alone-"));
try {
    const captures = {};
    for (const [name, frames] of Object.entries(FRAMES)) {
        captures[name] = path.join(top, `${name}.pcap`);
        run("lumsim", "-q", "-o", captures[name], "--frames", frames);
        console.log(`     ${name}: ${frames} frames, ${(statSync(captures[name]).size / 1e6).toFixed(1)} MB`);
    }
    for (const name of process.argv.length > 2 ? process.argv.slice(2) : Object.keys(BROWSERS)) {
        await measure(name, captures);
    }
} finally {
    rmSync(top, { recursive: true });
}
process.exitCode = failed > 0 ? 1 : 0;
