// lumview, lumsim and lumdump, as the tests use them.
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { createInterface } from "node:readline";
import { setTimeout as sleep } from "node:timers/promises";

const BIN = path.resolve(process.env.LUM_BIN ?? "build/bin");
const started = new Set();

export function run(tool, ...args) {
    return execFileSync(path.join(BIN, tool), args.map(String), { maxBuffer: 1 << 28, encoding: "utf8" });
}

// Points as lumdump tells them, one object a point.
export function dump(source, ...args) {
    const [head, ...rows] = run("lumdump", source, "-o", "-", "--format", "csv", "-q", ...args).trimEnd().split("\n");
    const names = head.split(",");
    return rows.map((row) => Object.fromEntries(row.split(",").map((v, i) => [names[i], Number(v)])));
}

export const EXACT = 2e-4; // metres: the last digit of what lumdump writes, and a little

// How far from a point of lumdump's the page's may be, whose coordinates are rounded to steps.
export function roundings(step, { range = 1, elevation = 0 } = {}) {
    const away = (Math.sqrt(3) * step) / 2;
    const degrees = (Math.asin(Math.min(1, away / range)) * 180) / Math.PI + 1e-4;
    return { coordinate: step / 2 + EXACT, range: away + EXACT, azimuth: degrees / Math.cos((elevation * Math.PI) / 180), elevation: degrees };
}

function start(tool, args, environment = {}) {
    const child = spawn(path.join(BIN, tool), args.map(String), {
        stdio: ["ignore", "pipe", "pipe"],
        env: { ...process.env, ...environment },
    });
    child.errors = "";
    child.stderr.on("data", (text) => (child.errors += text));
    started.add(child);
    child.once("exit", () => started.delete(child));
    return child;
}

export async function stop(child, signal = "SIGTERM") {
    if (child.exitCode === null && child.signalCode === null) {
        child.kill(signal);
        await once(child, "exit");
    }
    return child.exitCode;
}

// lumview, listening; { child, url, port }.
export async function view(...args) {
    const child = start("lumview", ["--no-open", "--json", ...args]);
    const [line] = await Promise.race([
        once(createInterface(child.stdout), "line"),
        once(child, "exit").then(() => [null]),
    ]);
    if (line === null) {
        throw new Error(`lumview ended: ${child.errors}`);
    }
    return { child, ...JSON.parse(line) };
}

// What lumview gives a browser that it starts.
export async function viewInBrowser(folder, ...args) {
    const [script, seen] = ["browser", "seen"].map((name) => path.join(folder, name));
    writeFileSync(script, `#!/bin/sh\necho "$1" >${seen}.part\nmv ${seen}.part ${seen}\n`, { mode: 0o755 });
    const child = start("lumview", ["-q", ...args], { BROWSER: script });
    while (!existsSync(seen)) {
        if (child.exitCode !== null) {
            throw new Error(`lumview ended: ${child.errors}`);
        }
        await sleep(20);
    }
    return readFileSync(seen, "utf8").trim();
}

export function sim(...args) {
    return start("lumsim", ["-q", ...args]);
}

export async function stopAll() {
    await Promise.all([...started].map((child) => stop(child, "SIGKILL")));
}

// Facts, one after the other: what became of each is told at once, and of all at the end.
export function makeTally() {
    const tally = { passed: 0, failed: 0 };
    return {
        async check(name, fact, context) {
            const begun = performance.now();
            try {
                await fact(context);
                tally.passed++;
                console.log(`ok   ${name} (${((performance.now() - begun) / 1000).toFixed(1)} s)`);
            } catch (error) {
                tally.failed++;
                console.log(`FAIL ${name}\n     ${error.stack.split("\n").slice(0, 8).join("\n     ")}`);
            }
        },
        // Without any fact nothing was shown.
        end() {
            console.log(`${tally.passed} passed, ${tally.failed} failed`);
            process.exitCode = tally.failed > 0 || tally.passed === 0 ? 1 : 0;
        },
    };
}
