// A page of lumview in Chromium, and what the tests do with it.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import path from "node:path";
import { decode } from "./png.mjs";

// npm ci can have run here or in another folder, which LUM_TEST_MODULES names.
const modules = path.resolve(process.env.LUM_TEST_MODULES ?? import.meta.dirname);
const need = createRequire(path.join(modules, "package.json"));
const { chromium } = need("playwright-core");

// Drawn in software: a small picture without smooth edges, but for docs/images.
const forDocs = Boolean(process.env.LUM_VIEW_SHOTS);
const ARGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const FAST = ["--webgl-antialiasing-mode=none"];
const LEGEND = 130; // pixels at the right that the legend may cover
export const SIZE = forDocs ? { width: 1280, height: 800 } : { width: 800, height: 500 };
export const SLOW = 300000; // milliseconds, which only end a fact that hangs; pictures are drawn in software

export function launch() {
    const args = forDocs ? ARGS : [...ARGS, ...FAST];
    return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args });
}

// Opens the page; complaints: what it logged as error.
export async function open(browser, url) {
    const page = await browser.newPage({ viewport: SIZE, colorScheme: "dark" });
    page.complaints = [];
    page.on("pageerror", (error) => page.complaints.push(error.message));
    page.on("console", (message) => message.type() === "error" && page.complaints.push(message.text()));
    page.setDefaultTimeout(SLOW);
    await page.goto(url);
    await page.waitForFunction(() => window.lumview?.shown > 0 && window.lumview.status());
    await showPanel(page);
    await drawn(page);
    return page;
}

// At the size of the tests controls and statistics are folded.
export async function showStats(page) {
    if (!await page.locator("#stats").isVisible()) {
        await page.keyboard.press("i");
    }
}

export async function showPanel(page) {
    if (!await page.locator("#panel").isVisible()) {
        await page.keyboard.press("h");
    }
}

// A busy machine shows a part of a frame first.
const whole = (page) => until(page, () => window.lumview.share === 1 || window.lumview.status()?.live);

// Until what was asked for is on the page, the frame is whole, and the camera stands still.
export async function drawn(page) {
    await whole(page);
    const twice = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 0))));
    await page.evaluate(twice);
    await until(page, () => !window.lumview.moving);
    await page.evaluate(twice);
}

export const probe = (page, what) => page.evaluate((name) => {
    const value = window.lumview[name];
    return typeof value === "function" ? value() : value;
}, what);

export async function counts(page) {
    await whole(page);
    return probe(page, "counts");
}

// { step, xyz }: to what the coordinates of the newest frame are rounded, metres, and those of all its points.
export const positions = (page) => probe(page, "positions");
export const settings = (page) => probe(page, "settings");
export const camera = (page) => probe(page, "camera");

export function until(page, condition, argument) {
    return page.waitForFunction(condition, argument, { timeout: SLOW });
}

// What axe-core finds wrong with the page: the rule, and the elements.
export async function complaints(page) {
    if (!await page.evaluate(() => Boolean(window.axe))) {
        await page.evaluate(readFileSync(need.resolve("axe-core/axe.min.js"), "utf8"));
    }
    const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
    return violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 120)}: ${failureSummary}`));
}

// The pixels of the scene, without what lies over it.
export async function pixels(page) {
    await drawn(page);
    const box = await page.locator("#canvas").boundingBox();
    const clip = { x: box.x, y: box.y, width: Math.round(box.width - LEGEND), height: Math.round(box.height) };
    return decode(await page.screenshot({ clip }));
}

export async function shoot(page, name) {
    if (forDocs) {
        await drawn(page);
        await page.screenshot({ path: path.join(process.env.LUM_VIEW_SHOTS, `${name}.png`) });
    }
}

// Types into a field as a user does, and leaves it.
export async function type(page, id, text) {
    await page.locator(`#${id}`).fill(text);
    await page.locator(`#${id}`).blur();
    await drawn(page);
}

export async function choose(page, id, value) {
    await page.locator(`#${id}`).selectOption(value);
    await drawn(page);
}

// A point of the frame that stands in the open part of the canvas, so many
// metres from the sensor.
export function openPoint(page, from, [least, most] = [0, Infinity]) {
    return page.evaluate(([first, nearest, farthest]) => {
        const view = window.lumview;
        const canvas = document.getElementById("canvas");
        const box = canvas.getBoundingClientRect();
        for (let i = 0; i < view.points; i++) {
            const at = view.place((first + 977 * i) % view.points);
            const isFit = at.visible && at.range >= nearest && at.range <= farthest;
            if (isFit && document.elementFromPoint(at.x + box.x, at.y + box.y) === canvas) {
                return at;
            }
        }
        throw new Error("no point lies open");
    }, [from, least, Math.min(most, 1e9)]);
}
