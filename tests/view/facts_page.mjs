// The page itself: keyboard, help, names and contrast for everyone.
import assert from "node:assert/strict";
import { camera, choose, complaints, counts, drawn, pixels, probe, settings, shoot, SIZE, until } from "./page.mjs";
import { dump } from "./tools.mjs";

const CONTROLS = "a, button, select, input, #canvas";

// Elements that Tab reaches, by id, in turn.
async function tabRound(page) {
    const seen = [];
    await page.evaluate(() => document.activeElement?.blur());
    for (let i = 0; i < 100; i++) {
        await page.keyboard.press("Tab");
        const at = await page.evaluate(() => {
            const element = document.activeElement;
            const { outlineStyle, outlineWidth } = getComputedStyle(element);
            return { id: element.id || element.tagName, ring: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2 };
        });
        if (seen.some((one) => one.id === at.id)) {
            break;
        }
        seen.push(at);
    }
    return seen;
}

async function tabReachesAll({ page }) {
    await page.keyboard.press("k"); // the point's card has a button too
    await drawn(page);
    const wanted = await page.evaluate((controls) => [...document.querySelectorAll(controls)]
        .filter((e) => e.checkVisibility() && !e.disabled && !e.closest("dialog"))
        .map((e) => e.id || e.tagName), CONTROLS);
    const seen = await tabRound(page);
    const ids = new Set(seen.map((one) => one.id));
    assert.deepEqual(wanted.filter((id) => !ids.has(id)), [], "not reached by Tab");
    assert.deepEqual(seen.filter((one) => !one.ring && one.id !== "BODY").map((one) => one.id), [], "no focus ring");
}

// A key, and the setting that it changes.
const KEYS = [
    ["r", "return"], ["e", "edges"], ["s", "smooth"], ["b", "blue"], ["g", "green"], ["c", "colour"], ["m", "map"],
    ["+", "size"], ["-", "size"], ["4", "edl"], ["5", "theme"], ["a", "accumulate"], ["A", "accumulate"], ["d", "grid"], ["o", "rings"], ["q", "flat"],
];

async function keysChangeSettings({ page }) {
    for (const [key, setting] of KEYS) {
        const before = await settings(page);
        await page.keyboard.press(key);
        const after = await settings(page);
        const changed = Object.keys(after).filter((name) => after[name] !== before[name]);
        assert.deepEqual(changed, [setting], `key ${key}`);
    }
    await page.keyboard.press("z");
    assert.equal((await settings(page)).return, "all");
}

async function keysHideParts({ page }) {
    for (const [key, id] of [["h", "panel"], ["i", "stats"]]) {
        const was = await page.locator(`#${id}`).isVisible();
        await page.keyboard.press(key);
        assert.equal(await page.locator(`#${id}`).isVisible(), !was, key);
        assert.equal(await page.locator(`#${id}-toggle`).getAttribute("aria-expanded"), String(!was));
        await page.keyboard.press(key);
        assert.equal(await page.locator(`#${id}`).isVisible(), was, key);
    }
}

// A session without a mouse: clip, choose, look, pick, play.
async function keyboardAlone({ page }) {
    const tabTo = async (id) => {
        for (let i = 0; i < 60 && (await page.evaluate(() => document.activeElement.id)) !== id; i++) {
            await page.keyboard.press("Tab");
        }
    };
    const { shown } = await counts(page);
    await tabTo("range-max");
    await page.keyboard.type("15");
    assert.equal((await settings(page)).rangeMax, 15);
    assert.ok((await counts(page)).shown < shown);
    await tabTo("grid");
    await page.keyboard.press(" ");
    assert.equal((await settings(page)).grid, false);
    await page.keyboard.press("v");
    assert.equal(await page.evaluate(() => document.activeElement.id), "canvas");
    const before = await camera(page);
    await page.keyboard.press("PageUp");
    assert.ok((await camera(page)).pitch > before.pitch);
    await page.keyboard.press("k");
    assert.ok((await probe(page, "picked")).range <= 15);
    await page.keyboard.press("Escape");
    assert.equal(await probe(page, "picked"), null);
    await page.keyboard.press("End");
    await until(page, () => window.lumview.frame === 10);
}

async function fieldsKeepTheirKeys({ page }) {
    const before = await settings(page);
    await page.locator("#height-min").focus();
    for (const key of ["r", "b", "ArrowUp", "Home", "-", "1"]) {
        await page.keyboard.press(key);
    }
    const after = await settings(page);
    assert.deepEqual({ ...after, heightMin: null }, before);
    await page.locator("#size").focus();
    const at = await camera(page);
    await page.keyboard.press("ArrowRight");
    assert.equal((await settings(page)).size, before.size + 0.5);
    assert.deepEqual(await camera(page), at);
}

async function help({ page }) {
    await page.keyboard.press("?");
    await until(page, () => document.getElementById("help").open);
    assert.equal(await page.evaluate(() => document.getElementById("help").scrollTop), 0, "it is read from its beginning");
    const text = await page.locator("#help").innerText();
    for (const word of ["Shift + arrows", "Ctrl + arrows", "left drag", "screenshot", "loop", "one frame back"]) {
        assert.ok(text.includes(word), word);
    }
    const keys = await page.locator("#help kbd").allTextContents();
    assert.deepEqual(keys.filter((key, i) => keys.indexOf(key) < i), [], "one key, two meanings");
    const before = await settings(page);
    await page.keyboard.press("r");
    assert.deepEqual(await settings(page), before);
    await shoot(page, "lumview-help");
    await page.keyboard.press("Escape");
    await until(page, () => !document.getElementById("help").open);
    await page.locator("#help-open").click();
    await page.locator("#help-close").click();
    await until(page, () => !document.getElementById("help").open);
}

async function names({ page }) {
    const without = await page.evaluate((controls) => [...document.querySelectorAll(controls)].filter((e) => {
        const label = e.getAttribute("aria-label") || e.textContent.trim() || [...(e.labels ?? [])].map((l) => l.textContent.trim()).join("");
        return !label;
    }).map((e) => e.id), CONTROLS);
    assert.deepEqual(without, []);
}

// WCAG AA: 4.5 to 1 for text. Colours under a card count as the darkest and as
// white points.
async function contrast({ page }) {
    await page.keyboard.press("k");
    for (const [theme, ground] of [["light", [238, 241, 245]], ["dark", [14, 18, 24]]]) {
        await choose(page, "theme", theme);
        assert.deepEqual(await poorTexts(page, ground), [], theme);
    }
}

function poorTexts(page, ground) {
    return page.evaluate((under) => {
        const parse = (text) => text.match(/[\d.]+/g).map(Number);
        const channel = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
        const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
        const ratio = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
        const over = ([r, g, b, a = 1], ground) => [r, g, b].map((v, i) => v * a + ground[i] * (1 - a));
        const groundOf = (element, under) => {
            const chain = [];
            for (let e = element; e; e = e.parentElement) {
                chain.unshift(parse(getComputedStyle(e).backgroundColor));
            }
            return chain.reduce((ground, colour) => over(colour, ground), under);
        };
        const hasText = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
        return [...document.querySelectorAll("body *")]
            .filter((e) => hasText(e) && e.checkVisibility() && !e.closest(":disabled, noscript, .skip"))
            .map((e) => [e, ratio(parse(getComputedStyle(e).color), groundOf(e, under))])
            .filter(([, value]) => value < 4.5)
            .map(([e, value]) => `${e.tagName} ${e.id} ${e.textContent.trim().slice(0, 20)} ${value.toFixed(2)}`);
    }, ground);
}

// By the system, which may change, and by choice.
async function themes({ page }) {
    const groundOf = async () => {
        const { bytes } = await pixels(page);
        return bytes[0] + bytes[1] + bytes[2];
    };
    const dark = await groundOf();
    assert.ok(dark < 150, String(dark));
    await page.emulateMedia({ colorScheme: "light" });
    assert.ok(await groundOf() > 600);
    await choose(page, "theme", "dark");
    assert.equal(await groundOf(), dark);
    await page.emulateMedia({ colorScheme: "dark" });
    await choose(page, "theme", "light");
    assert.ok(await groundOf() > 600);
    await until(page, () => location.hash.includes("theme=light"));
}

// Keys that lead to each state of the page, from one where all is folded; what is seen then.
const STATES = {
    "all folded": [[], "#legend-line"],
    "all unfolded": [["h", "i", "y"], "#panel, #stats, #legend-bar"],
    "a distance": [["k", "x"], "#pick-measure"],
    "a selection": [["j", "w", "Enter"], "#strip, #selection"],
    "the help": [["?"], "#help"],
};

// In each state, wide and narrow, axe-core has nothing to say: names, roles, contrast, order, sizes.
async function accessible({ page }) {
    for (const [width, colorScheme] of [[SIZE.width, "light"], [SIZE.width, "dark"], [400, "dark"]]) {
        await page.emulateMedia({ colorScheme });
        await page.setViewportSize({ width, height: SIZE.height });
        for (const [state, [keys, seen]] of Object.entries(STATES)) {
            await page.keyboard.press("z");
            for (const key of keys) {
                await page.keyboard.press(key);
            }
            for (const theme of ["light", "dark"]) {
                await page.emulateMedia({ colorScheme: theme });
                await drawn(page);
                for (const part of await page.locator(seen).all()) {
                    assert.ok(await part.isVisible(), state);
                }
                assert.deepEqual(await complaints(page), [], `${state}, ${width} pixels wide, ${theme}`);
            }
            await page.keyboard.press("Escape"); // the help
            await page.keyboard.press("Escape"); // the point
        }
    }
    await page.emulateMedia({ colorScheme: null });
    await page.setViewportSize(SIZE);
    await drawn(page);
}

async function narrow({ page }) {
    await page.setViewportSize({ width: 400, height: 800 });
    await drawn(page);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    const height = await page.evaluate(() => document.getElementById("canvas").clientHeight);
    await shoot(page, "lumview-narrow");
    await page.setViewportSize(SIZE);
    await drawn(page);
    assert.ok(wide <= 400, `the page is ${wide} pixels wide`);
    assert.ok(height > 200, `the picture is ${height} pixels high`);
}

// Share of the page that the picture has where nothing lies over it, and of the
// points of the first view that stand under something.
function room(page) {
    return page.evaluate(() => {
        const canvas = document.getElementById("canvas");
        const box = canvas.getBoundingClientRect();
        const isFree = (x, y) => document.elementFromPoint(x, y) === canvas;
        let free = 0;
        for (let i = 0; i < 40; i++) {
            for (let k = 0; k < 40; k++) {
                free += isFree(((i + 0.5) / 40) * innerWidth, ((k + 0.5) / 40) * innerHeight);
            }
        }
        let [seen, under] = [0, 0];
        for (let i = 0; i < window.lumview.points; i += 97) {
            const at = window.lumview.place(i);
            if (at.visible && at.x >= 0 && at.y >= 0 && at.x < box.width && at.y < box.height) {
                seen++;
                under += !isFree(at.x + box.x, at.y + box.y);
            }
        }
        return { free: free / 1600, under: under / seen };
    });
}

async function roomForThePicture({ page }) {
    await page.keyboard.press("h"); // as it is when it was not asked for
    await page.keyboard.press("z");
    for (const [width, height] of [[800, 600], [640, 480], [390, 844]]) {
        await page.setViewportSize({ width, height });
        await page.keyboard.press("0");
        await drawn(page);
        const { free } = await room(page);
        assert.ok(free >= 0.6, `${free} of ${width} x ${height}`);
        assert.ok(await page.locator("#legend-strip").isVisible());
    }
    await page.setViewportSize({ width: 1440, height: 900 });
    await page.keyboard.press("0");
    await drawn(page);
    const { under } = await room(page);
    const shown = await page.locator("#stats, #legend-bar, #panel").evaluateAll((all) => all.filter((e) => e.checkVisibility()).length);
    await page.setViewportSize(SIZE);
    await drawn(page);
    assert.equal(shown, 3, "there is room for all at 1440");
    assert.ok(under < 0.01, `${under} of the points are under cards`);
}

async function legendFolds({ page }) {
    await page.keyboard.press("y");
    const was = await page.locator("#legend-bar").isVisible();
    await page.locator("#legend-toggle").click();
    assert.equal(await page.locator("#legend-bar").isVisible(), !was);
    assert.equal(await page.locator("#legend-strip").isVisible(), was);
    assert.match(await page.locator("#legend-to").textContent(), /^\d+ m$/);
}

async function policy({ page }) {
    assert.deepEqual(page.complaints, []);
    const ran = await page.evaluate(() => {
        const script = document.createElement("script");
        script.textContent = "window.intruder = true";
        document.body.append(script);
        return window.intruder === true;
    });
    assert.equal(ran, false);
}

// The capture has no jitter, so a frame began about when its first packet came.
async function tellsTheTime({ page, capture }) {
    const frame = await probe(page, "frame");
    const points = dump(capture, "--time", "arrival", "--frames", `${frame}:${frame}`);
    const came = points.reduce((first, row) => Math.min(first, row.timestamp), Infinity) / 1e6;
    const { utc, kind, error } = await probe(page, "began");
    assert.equal(kind, "fitted");
    assert.ok(Math.abs(utc - came) < 1e-3, `${utc}, ${came}`);
    assert.ok(error > 0 && error < 0.01, String(error));
    const shown = await page.locator("#frame-time").textContent();
    assert.match(shown, /^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{4} UTC, fitted$/);
    assert.equal(shown.slice(0, 19), new Date(utc * 1000).toISOString().slice(0, 19).replace("T", " "));
    const hint = await page.locator("#frame-time").getAttribute("title");
    const local = await page.evaluate((ms) => new Date(ms).toLocaleTimeString("en-GB"), utc * 1000);
    assert.ok(hint.includes(`${local} local time`) && hint.includes("±"), hint);
}

// Day and time, and that they are UTC, can be read on every width; nothing of the header is cut off.
async function timeOnEveryWidth({ page }) {
    for (const width of [320, 400, 500, 640, 761, 800, 900, 1000, 1099, 1100, 1440]) {
        await page.setViewportSize({ width, height: 800 });
        await drawn(page);
        const { text, cut, isInside } = await page.evaluate(() => {
            const element = document.getElementById("frame-time");
            const box = element.getBoundingClientRect();
            const over = document.elementFromPoint((box.left + box.right) / 2, (box.top + box.bottom) / 2);
            const isCut = (one) => one.getBoundingClientRect().right > innerWidth + 0.5;
            const cut = [...document.querySelectorAll("header *")].filter(isCut).map((one) => one.id || one.className);
            return { text: element.innerText, cut, isInside: element.contains(over) };
        });
        assert.match(text, /^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(\.\d{4})? UTC/, `${width} pixels`);
        assert.ok(isInside, `${width} pixels`);
        assert.equal(cut.join(" "), "", `${width} pixels`);
    }
    await page.setViewportSize(SIZE);
    await drawn(page);
}

export const pageFacts = [
    ["the time of a frame is told, and which it is", tellsTheTime],
    ["the time of a frame can be read on every width", timeOnEveryWidth],
    ["Tab reaches every control, with a focus ring", tabReachesAll],
    ["each key changes its setting and no other", keysChangeSettings],
    ["keys hide and show controls and statistics", keysHideParts],
    ["the keyboard alone suffices", keyboardAlone],
    ["fields and sliders keep their keys", fieldsKeepTheirKeys],
    ["? explains the keys", help],
    ["all controls have names", names],
    ["all text has enough contrast", contrast],
    ["the page is dark or light, as the system or as chosen", themes],
    ["axe-core has nothing to say", accessible],
    ["a narrow page is usable", narrow],
    ["small pages are the picture's, and cards lie beside it", roomForThePicture],
    ["the legend folds", legendFolds],
    ["no complaint of the browser, no inline script", policy],
];
