// lumview.html in Chromium and in Firefox.
//   LUM_BIN=build/bin node test_alone.mjs [WORD...]
// runs all facts, or those whose names have one of the words. LUM_PAGE names the file, if not lumview.html beside LUM_BIN;
// LUM_BROWSERS those to use, of chromium and firefox; CHROMIUM and FIREFOX their programs.
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { aloneFacts } from "./facts_alone.mjs";
import { launchFirefox } from "./firefox.mjs";
import { launch } from "./page.mjs";
import { makeTally, run, stopAll } from "./tools.mjs";

const BROWSERS = { chromium: launch, firefox: launchFirefox };
const words = process.argv.slice(2);
const facts = aloneFacts.filter(([name]) => words.length === 0 || words.some((word) => name.includes(word)));
const chosen = (process.env.LUM_BROWSERS ?? "chromium firefox").split(" ");
const { check, end } = makeTally();

const top = mkdtempSync(path.join(tmpdir(), "lumview-alone-"));
const capture = path.join(top, "street.pcap");
run("lumsim", "-q", "-o", capture, "--frames", 5);
try {
    for (const name of chosen) {
        const folder = path.join(top, name);
        mkdirSync(folder);
        const browser = await BROWSERS[name]();
        for (const [fact, holds] of facts) {
            await check(`${name}: ${fact}`, holds, { folder, capture, browser });
        }
        await browser.close();
    }
} finally {
    await stopAll();
    rmSync(top, { recursive: true });
}
end();
