// lumview's page in a real browser.
//   LUM_BIN=build/bin node test_view.mjs [WORD...]
// runs all facts, or those whose names have one of the words. CHROMIUM names
// the browser; LUM_TEST_MODULES the folder where npm ci ran, if not here;
// LUM_VIEW_SHOTS a folder that gets pictures for docs/images.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { addressFacts } from "./facts_address.mjs";
import { besideFacts } from "./facts_beside.mjs";
import { cameraFacts } from "./facts_camera.mjs";
import { linkFacts } from "./facts_link.mjs";
import { pageFacts } from "./facts_page.mjs";
import { pictureFacts, pictureFactsAlone } from "./facts_pictures.mjs";
import { playerFacts } from "./facts_player.mjs";
import { pointFacts } from "./facts_points.mjs";
import { rigFacts } from "./facts_rig.mjs";
import { truthFacts } from "./facts_truth.mjs";
import { drawn, launch, open, probe, showPanel, until } from "./page.mjs";
import { makeTally, run, stop, stopAll, view } from "./tools.mjs";

const words = process.argv.slice(2);
const isWanted = ([name]) => words.length === 0 || words.some((word) => name.includes(word));
const { check, end } = makeTally();

// The page as it was when it was opened, on the first frame.
async function refresh(page) {
    await page.locator("#canvas").focus();
    if ((await probe(page, "status")).state === "playing") {
        await page.keyboard.press(" ");
    }
    for (const key of ["Escape", "z", "0", "Home"]) {
        await page.keyboard.press(key);
    }
    await showPanel(page);
    await until(page, () => {
        const view = window.lumview;
        return view.frame === view.status().first_frame && view.points === view.counts().rising;
    });
    await page.locator("#canvas").blur();
    await drawn(page);
}

// Facts of one page on a capture that stands still.
async function captureFacts(context) {
    const facts = [...pointFacts, ...cameraFacts, ...playerFacts, ...pageFacts, ...pictureFacts].filter(isWanted);
    if (facts.length === 0) {
        return;
    }
    const server = await view("--paused", context.capture);
    const opens = async () => (context.page = await open(context.browser, server.url));
    await check("the page opens and gets a frame", opens, context);
    if (!context.page) {
        return;
    }
    for (const fact of facts) {
        await refresh(context.page).catch((error) => console.log(`     not refreshed: ${error.message}`));
        await check(...fact, context);
    }
    await context.page.close();
    await stop(server.child);
}

const folder = mkdtempSync(path.join(tmpdir(), "lumview-"));
const context = { folder, capture: path.join(folder, "street.pcap"), browser: await launch() };
run("lumsim", "-q", "-o", context.capture, "--frames", 10);
try {
    await captureFacts(context);
    for (const fact of [...addressFacts, ...besideFacts, ...rigFacts, ...pictureFactsAlone, ...truthFacts, ...linkFacts].filter(isWanted)) {
        await check(...fact, context);
        await Promise.all(context.browser.contexts().map((one) => one.close()));
        await stopAll();
    }
} finally {
    await context.browser.close();
    await stopAll();
    rmSync(folder, { recursive: true });
}
end();
