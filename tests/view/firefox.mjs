// Debian's Firefox by WebDriver BiDi: as much of Playwright's browser and page as the facts of lumview.html use.
// Playwright itself needs a Firefox of its own.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { setTimeout as sleep } from "node:timers/promises";

const modules = path.resolve(process.env.LUM_TEST_MODULES ?? import.meta.dirname);
const { WebSocket } = createRequire(path.join(modules, "package.json"))("ws");

const LOOK_MS = 50;
const KEYS = { Enter: "\uE007", Escape: "\uE00C", Tab: "\uE004", Home: "\uE011", End: "\uE010", " ": " " };
// Nothing of it asks the network, and WebGL is drawn in software.
const PREFERENCES = { "webgl.force-enabled": true, "app.update.enabled": false, "datareporting.policy.dataSubmissionEnabled": false,
    "toolkit.telemetry.reportingpolicy.firstRun": false, "browser.shell.checkDefaultBrowser": false };

// One connection: commands are answered by their ids, all else is an event.
async function connect(url) {
    const socket = new WebSocket(`${url}/session`);
    const waiting = new Map();
    const listeners = [];
    await once(socket, "open");
    socket.on("message", (data) => {
        const message = JSON.parse(data);
        const waits = waiting.get(message.id);
        if (!waits) {
            listeners.forEach((hear) => hear(message));
            return;
        }
        waiting.delete(message.id);
        if (message.type === "success") {
            waits.done(message.result);
        } else {
            waits.fail(new Error(`${message.error}: ${message.message}`));
        }
    });
    socket.on("close", () => waiting.forEach(({ fail }) => fail(new Error("Firefox has ended"))));
    let last = 0;
    return {
        send: (method, params = {}) => new Promise((done, fail) => {
            waiting.set(++last, { done, fail });
            socket.send(JSON.stringify({ id: last, method, params }));
        }),
        listen: (hear) => listeners.push(hear),
        close: () => socket.close(),
    };
}

async function makePage({ send, listen }, viewport) {
    const { context } = await send("browsingContext.create", { type: "tab" });
    const target = { context };
    await send("browsingContext.setViewport", { context, viewport });

    // As Playwright: a function's text runs in the page, and what goes between is JSON.
    async function evaluate(run, argument) {
        const { type, result, exceptionDetails } = await send("script.callFunction", {
            functionDeclaration: `async (text) => JSON.stringify(await (${run})(JSON.parse(text)) ?? null)`,
            arguments: [{ type: "string", value: JSON.stringify(argument ?? null) }],
            awaitPromise: true,
            target,
        });
        if (type === "exception") {
            throw new Error(exceptionDetails.text);
        }
        return JSON.parse(result.value);
    }

    const page = {
        complaints: [],
        requests: [],
        evaluate,
        goto: (url) => send("browsingContext.navigate", { context, url, wait: "complete" }),
        addInitScript: (run) => send("script.addPreloadScript", { functionDeclaration: String(run), contexts: [context] }),
        async waitForFunction(run, argument, { timeout = 60000 } = {}) {
            for (const begun = performance.now(); !(await evaluate(run, argument)); await sleep(LOOK_MS)) {
                if (performance.now() - begun > timeout) {
                    throw new Error(`not within ${timeout} ms: ${run}`);
                }
            }
        },
        async setInputFiles(selector, files) {
            const { nodes } = await send("browsingContext.locateNodes", { context, locator: { type: "css", value: selector } });
            await send("input.setFiles", { context, element: { sharedId: nodes[0].sharedId }, files: [files].flat() });
        },
        keyboard: {
            press: (key) => send("input.performActions", { context, actions: [{ type: "key", id: "keys", actions: [
                { type: "keyDown", value: KEYS[key] ?? key }, { type: "keyUp", value: KEYS[key] ?? key },
            ] }] }),
        },
        screenshot: async ({ path: file }) => {
            const { data } = await send("browsingContext.captureScreenshot", { context });
            writeFileSync(file, Buffer.from(data, "base64"));
        },
        close: () => send("browsingContext.close", { context }),
    };
    listen(({ method, params }) => {
        if (method === "log.entryAdded" && params.level === "error" && params.source?.context === context) {
            page.complaints.push(params.text);
        }
        if (method === "network.beforeRequestSent" && params.context === context) {
            page.requests.push(params.request.url);
        }
    });
    return page;
}

// A screen in memory: without one Firefox has no WebGL.
async function startScreen() {
    const child = spawn("Xvfb", ["-displayfd", "3", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"], {
        stdio: ["ignore", "ignore", "ignore", "pipe"],
    });
    const [line] = await Promise.race([once(createInterface(child.stdio[3]), "line"), once(child, "error").then(([error]) => {
        throw error;
    })]);
    return { child, name: `:${line}` };
}

async function end(child) {
    if (child.exitCode === null && child.signalCode === null) {
        child.kill();
        await once(child, "exit");
    }
}

export async function launchFirefox() {
    const screen = await startScreen();
    const profile = mkdtempSync(path.join(tmpdir(), "lumview-firefox-"));
    const lines = Object.entries(PREFERENCES).map(([key, value]) => `user_pref(${JSON.stringify(key)}, ${JSON.stringify(value)});\n`);
    writeFileSync(path.join(profile, "user.js"), lines.join(""));
    const program = process.env.FIREFOX ?? "/usr/bin/firefox-esr";
    const child = spawn(program, ["--remote-debugging-port=0", "--no-remote", "--profile", profile], {
        stdio: ["ignore", "ignore", "pipe"],
        env: { ...process.env, DISPLAY: screen.name, LIBGL_ALWAYS_SOFTWARE: "1" },
    });
    let url = null;
    for await (const line of createInterface(child.stderr)) {
        url = /WebDriver BiDi listening on (ws:\S+)/.exec(line)?.[1] ?? null;
        if (url) {
            break;
        }
    }
    process.once("exit", () => [child, screen.child].forEach((one) => one.kill())); // also where a fact ended all
    if (url === null) {
        throw new Error(`${program} ended before it could be driven`);
    }
    child.stderr.resume();
    const connection = await connect(url);
    await connection.send("session.new", { capabilities: {} });
    await connection.send("session.subscribe", { events: ["log.entryAdded", "network.beforeRequestSent"] });
    return {
        newPage: ({ viewport }) => makePage(connection, viewport),
        async close() {
            await connection.send("browser.close").catch(() => {});
            await end(child);
            await end(screen.child);
            rmSync(profile, { recursive: true, force: true });
        },
    };
}
