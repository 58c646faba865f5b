// lumview.html: captures that the page decodes by itself, opened as a file, in Chromium and in Firefox.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { once } from "node:events";
import { closeSync, copyFileSync, ftruncateSync, openSync, readFileSync, statSync, writeFileSync, writeSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";
import { makeFrames } from "../../tools/lumview/page/frame.js";
import { arrayOf } from "./facts_truth.mjs";
import { SIZE, SLOW } from "./page.mjs";
import { dump, run } from "./tools.mjs";

export const PAGE = path.resolve(process.env.LUM_PAGE ?? path.join(process.env.LUM_BIN ?? "build/bin", "../lumview.html"));
const LARGEST = 600e3; // bytes of lumview.html
const BANNER = "banner";
const LONGEST_RECORD = 262144;

const until = (page, condition, argument) => page.waitForFunction(condition, argument, { timeout: SLOW });
const text = (page, id) => page.evaluate((name) => document.getElementById(name).textContent, id);
const says = (page, id, words) => until(page, ([name, part]) => document.getElementById(name).textContent.includes(part), [id, words]);
const shows = (page, frame) => until(page, (number) => window.lumview.frame === number, frame);
const pause = (page) => page.evaluate(() => document.getElementById("play").textContent === "Pause" && document.getElementById("play").click());
const points = (page) => page.evaluate(() => window.lumview.counts().total);

// The page with its landing. before: runs in it ahead of its scripts.
async function openPage({ browser, url = pathToFileURL(PAGE).href }, before = null) {
    const page = await browser.newPage({ viewport: SIZE });
    if (!page.complaints) {
        page.complaints = [];
        page.requests = [];
        page.on("pageerror", (error) => page.complaints.push(error.message));
        page.on("console", (message) => message.type() === "error" && page.complaints.push(message.text()));
        page.on("request", (request) => page.requests.push(request.url()));
    }
    if (before) {
        await page.addInitScript(before);
    }
    await page.goto(url);
    await until(page, () => window.lumview && !document.getElementById("landing").hidden);
    return page;
}

// With files, on the frame that the page is to stand at.
async function openFiles(context, files, frame = 1) {
    const page = await openPage(context);
    await page.setInputFiles("#files", files);
    await until(page, () => window.lumview.shown > 0 && window.lumview.status()?.last_frame !== null);
    await goTo(page, frame);
    return page;
}

// A step stops it also where it has come to the end; from there a seek alone would play on.
async function goTo(page, frame) {
    await page.keyboard.press(",");
    await until(page, () => window.lumview.status().state === "paused");
    await page.evaluate((number) => {
        const scrub = document.getElementById("scrub");
        scrub.value = number;
        scrub.dispatchEvent(new Event("input"));
    }, frame);
    await shows(page, frame);
}

// Drops files as a file manager does: { name, bytes (base64) } each.
function drop(page, files) {
    return page.evaluate((all) => {
        const transfer = new DataTransfer();
        for (const { name, bytes } of all) {
            transfer.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
        }
        for (const kind of ["dragover", "drop"]) {
            document.getElementById("view").dispatchEvent(new DragEvent(kind, { dataTransfer: transfer, bubbles: true, cancelable: true }));
        }
    }, files);
}

const dropped = (...files) => files.map((file) => ({ name: path.basename(file), bytes: readFileSync(file).toString("base64") }));

function write(folder, name, content) {
    const file = path.join(folder, name);
    writeFileSync(file, content);
    return file;
}

function simulate(folder, name, ...options) {
    const file = path.join(folder, name);
    run("lumsim", "-q", "-o", file, "--frames", 3, ...options);
    return file;
}

async function showsTheSamePoints(context) {
    const page = await openFiles(context, context.capture, 2);
    const rows = dump(context.capture, "--frames", "2:2");
    assert.equal(await points(page), rows.length);
    const ranges = await page.evaluate(() => Array.from({ length: 300 }, (_, i) => window.lumview.place(Math.floor((i * window.lumview.points) / 300)).range));
    const known = rows.map(({ range }) => range).sort((a, b) => a - b);
    const isKnown = (range) => {
        let [low, high] = [0, known.length];
        while (low < high) {
            const middle = (low + high) >> 1;
            [low, high] = known[middle] < range - 0.003 ? [middle + 1, high] : [low, middle];
        }
        return Math.abs(known[low] - range) <= 0.003;
    };
    assert.deepEqual(ranges.filter((range) => !isKnown(range)), []);
    assert.equal(await page.evaluate(() => window.lumview.hello().live), false);
    await until(page, () => document.title.includes("street.pcap"));
    assert.deepEqual(page.complaints, []);
    const asked = page.requests.filter((url) => !/^(file|blob|data):/.test(url));
    assert.deepEqual(asked, [], "it asked for something");
    await page.close();
}

async function playerWorks(context) {
    const page = await openFiles(context, context.capture);
    await page.keyboard.press(".");
    await shows(page, 2);
    await page.keyboard.press("End");
    await until(page, () => window.lumview.frame === window.lumview.status().last_frame);
    await page.keyboard.press("Home");
    await shows(page, 1);
    await page.keyboard.press("l");
    await until(page, () => window.lumview.status().loop);
    await page.keyboard.press(" ");
    const shown = await page.evaluate(() => window.lumview.shown);
    await until(page, (n) => window.lumview.shown > n + 12, shown);
    await pause(page);
    assert.ok(await page.evaluate(() => !document.getElementById("again").hidden), "what is counted twice is told");
    await page.keyboard.press("e");
    await until(page, () => window.lumview.counts().falling > 0 && window.lumview.counts().rising === 0);
    await page.close();
}

async function dropReplaces(context) {
    const { folder } = context;
    const [one, other] = [simulate(folder, "one.pcap"), simulate(folder, "other.pcapng", "--seed", 2)];
    const page = await openPage(context);
    await drop(page, dropped(one));
    await until(page, () => window.lumview.shown > 0);
    await drop(page, dropped(other));
    await until(page, () => window.lumview.hello().source.includes("other.pcapng") && window.lumview.frame !== null);
    await goTo(page, 1);
    assert.equal(await points(page), dump(other, "--frames", "1:1").length);
    assert.ok(await page.evaluate(() => document.getElementById("landing").hidden));
    assert.deepEqual(page.complaints, []);
    await page.close();
}

async function compressedAndSeveral(context) {
    const { folder } = context;
    const whole = simulate(folder, "whole.pcap", "--frames", 6);
    const rows = dump(whole, "--frames", "5:5").length;
    const packed = write(folder, "whole.pcap.gz", gzipSync(readFileSync(whole)));
    const page = await openFiles(context, packed, 5);
    assert.equal(await points(page), rows);
    await page.close();
    const parts = cutInTwo(whole, folder);
    const joined = await openFiles(context, parts.reverse(), 5);
    assert.equal(await points(joined), rows);
    await joined.close();
}

// Two captures of one, as a rotated recording has them.
function cutInTwo(capture, folder) {
    const bytes = readFileSync(capture);
    let at = 24;
    while (at < bytes.length / 2) {
        at += 16 + bytes.readUInt32LE(at + 8);
    }
    return [
        write(folder, "r-1.pcap", bytes.subarray(0, at)),
        write(folder, "r-2.pcap", Buffer.concat([bytes.subarray(0, 24), bytes.subarray(at)])),
    ];
}

async function yamlIsKnown(context) {
    const { folder } = context;
    const profile = write(folder, "other.yaml", "version: 1\ndata_packet_type: 9\n");
    const capture = simulate(folder, "other-layout.pcap", "--profile", profile);
    const calibration = write(folder, "far.yaml", "version: 1\ntof_lsb_ps: 26.0\n");
    const page = await openPage(context);
    await drop(page, dropped(profile));
    await says(page, "landing-kept", "profile: other.yaml");
    await drop(page, dropped(capture));
    await until(page, () => window.lumview.shown > 0);
    await goTo(page, 1);
    const near = await page.evaluate(() => window.lumview.place(0).range);
    await drop(page, dropped(calibration));
    await until(page, () => /playing|ended/.test(window.lumview.status()?.state)); // opened again: it stood at frame 1
    await goTo(page, 1);
    assert.ok(Math.abs(await page.evaluate(() => window.lumview.place(0).range) / near - 2) < 0.01);
    await drop(page, dropped(calibration, write(folder, "further.yaml", "version: 1\ntof_lsb_ps: 39.0\n")));
    await says(page, "message", "further.yaml is left out: far.yaml already gives the calibration");
    await page.close();
}

async function findsTheLayout(context) {
    const { folder } = context;
    const profile = write(folder, "nine.yaml", "version: 1\ndata_packet_type: 9\n");
    const capture = simulate(folder, "nine.pcap", "--profile", profile);
    const page = await openPage(context);
    await page.setInputFiles("#files", capture);
    await until(page, () => !document.getElementById("infer").hidden);
    await page.evaluate(() => document.getElementById("infer").click());
    await until(page, () => document.querySelector("dialog.ask[open]"));
    await page.evaluate(() => [...document.querySelectorAll("dialog.ask button")].find((one) => one.textContent === "Use it").click());
    await until(page, () => window.lumview.shown > 0);
    await goTo(page, 1);
    assert.equal(await points(page), dump(capture, "--profile", profile, "--frames", "1:1").length);
    await page.close();
}

// Poses, an array and a second capture as ground truth, dropped one by one, are what lumview takes by options.
async function takesWhatIsBeside(context) {
    const { folder } = context;
    const [poses, labels, exact] = ["drive.txt", "labels.npy", "exact.pcap"].map((name) => path.join(folder, name));
    const drive = simulate(folder, "drive.pcap", "--poses", poses, "--labels", labels);
    run("lumsim", "-q", "-o", exact, "--frames", 3, "--seed", 2);
    const page = await openPage(context);
    await drop(page, dropped(labels));
    await says(page, "landing-kept", "array: labels.npy");
    await drop(page, dropped(drive));
    await until(page, () => window.lumview.shown > 0 && window.lumview.beside().labels.includes("ground"));
    assert.ok(await page.evaluate(() => document.getElementById("world-row").hidden));
    await drop(page, dropped(poses));
    await until(page, () => !document.getElementById("world-row").hidden && window.lumview.beside().labels.includes("ground"));
    await page.setInputFiles("#truth-files", exact);
    await until(page, () => document.getElementById("truth-name").textContent.startsWith("exact.pcap"));
    await shows(page, 3); // its last one
    await until(page, (n) => window.lumview.beside().truth === n, dump(exact, "--frames", "3:3").length);
    await page.setInputFiles("#truth-files", write(folder, "notes.txt", "no capture\n".repeat(100)));
    await says(page, "message", "notes.txt: not a capture");
    assert.deepEqual(page.complaints, []);
    await page.close();
}

// What a dropped file is told to be stays until the next one comes.
async function refusesArrays(context) {
    const { folder } = context;
    const labels = path.join(folder, "own.npy");
    const capture = simulate(folder, "labelled.pcap", "--labels", labels);
    const page = await openFiles(context, capture);
    await drop(page, dropped(write(folder, "wide.npy", arrayOf("'<f4'", "3, 300", Array(900).fill(0)))));
    await says(page, "message", "wide.npy: its shape is (3, 300): points are rows of 3 numbers");
    const columns = (all) => `[${all.map((name) => `('${name}', '<f4')`).join(", ")}]`;
    await drop(page, dropped(write(folder, "many.npy", arrayOf(columns([...Array(14).keys()]), "1,", Array(14).fill(1)))));
    await says(page, "message", "10, 11 and 2 more: points are");
    const keys = ["frame", "line", "eye", "pixel", "return_number", "label"];
    await drop(page, dropped(write(folder, "other.npy", arrayOf(columns(keys), "1,", [101, 1, 0, 1, 1, 7]))));
    await says(page, "message", "other.npy has no label for this frame");
    assert.ok(!(await text(page, "message")).includes("many.npy"));
    await drop(page, dropped(labels));
    await until(page, () => window.lumview.beside().labels.includes("ground") && document.getElementById("message").textContent === "");
    assert.deepEqual(page.complaints, []);
    await page.close();
}

// Poses that cannot be read are told by their reader, and a file that is nothing is left out.
async function refusesFiles(context) {
    const { folder } = context;
    const page = await openPage(context);
    await drop(page, dropped(context.capture, write(folder, "notes.md", "hello\n".repeat(99))));
    await says(page, "message", "notes.md is left out: not a capture");
    await until(page, () => window.lumview.shown > 0);
    for (const [name, content, words] of [
        ["nan.txt", "# t x y z\nnan 0 0 0 0 0 0 1\n", "nan.txt: line 2"],
        ["few.csv", "time,x,y,z\n5,0,0,0\n", "few.csv: line 1: has names, but lacks qx"],
        ["few.tum", "5 0 0 0\n", "few.tum: line 1"],
    ]) {
        await drop(page, dropped(write(folder, name, content)));
        await says(page, BANNER, words);
        await drop(page, dropped(context.capture));
        await until(page, () => window.lumview.shown > 0 && document.getElementById("banner").hidden);
    }
    await page.close();
}

async function textFile(context) {
    const page = await openPage(context);
    await page.setInputFiles("#files", write(context.folder, "notes.txt", "no capture\n".repeat(100)));
    await says(page, BANNER, "notes.txt: not a capture");
    assert.ok(!(await page.evaluate(() => document.getElementById("landing").hidden)), "another file can be chosen");
    await page.setInputFiles("#files", context.capture);
    await until(page, () => window.lumview.shown > 0 && document.getElementById("banner").hidden);
    await until(page, () => document.getElementById("rates").textContent.includes("packets"));
    await page.setInputFiles("#files", path.join(context.folder, "notes.txt"));
    await says(page, BANNER, "notes.txt: not a capture");
    const told = await page.evaluate(() => [document.title, document.getElementById("source").textContent,
        [...document.querySelectorAll("#rates dd, #losses dd")].map((dd) => dd.textContent).join("")]);
    assert.deepEqual(told, ["notes.txt - lumview", "notes.txt", ""], "nothing of the capture before stays");
    await page.close();
}

// An address may name a frame that the capture does not have.
async function frameBeyondTheEnd(context) {
    const page = await openPage({ ...context, url: `${pathToFileURL(PAGE).href}#frame=1000` });
    await page.setInputFiles("#files", context.capture);
    await until(page, () => window.lumview.frame !== null && window.lumview.frame === window.lumview.status().last_frame);
    await until(page, () => location.hash.includes(`frame=${window.lumview.frame}`));
    await page.close();
}

async function truncated(context) {
    const bytes = readFileSync(context.capture);
    const page = await openFiles(context, write(context.folder, "cut.pcap", bytes.subarray(0, Math.floor(bytes.length * 0.7))));
    await says(page, "message", "a record is cut short");
    await page.close();
}

async function otherSensor(context) {
    const page = await openPage(context);
    await page.setInputFiles("#files", write(context.folder, "foreign.pcap", foreignCapture()));
    await says(page, "message", "there is no frame in it");
    await page.close();
}

// A capture of UDP packets that are no sensor's of ours.
function foreignCapture() {
    const head = Buffer.from("d4c3b2a1020004000000000000000000ffff000001000000", "hex");
    const payload = Buffer.alloc(1206, 0xee);
    const ip = Buffer.from("450004d200004000401100000a0000020a000001", "hex");
    const udp = Buffer.from("0940094004be0000", "hex");
    const packet = Buffer.concat([Buffer.alloc(12), Buffer.from("0800", "hex"), ip, udp, payload]);
    const record = Buffer.alloc(16);
    record.writeUInt32LE(packet.length, 8);
    record.writeUInt32LE(packet.length, 12);
    return Buffer.concat([head, ...Array.from({ length: 200 }, () => Buffer.concat([record, packet]))]);
}

// Records of nothing, the longest that there can be, of which the disk has only the heads.
function lengthen(file, size) {
    const handle = openSync(file, "r+");
    const record = Buffer.alloc(16);
    record.writeUInt32LE(LONGEST_RECORD, 8);
    record.writeUInt32LE(LONGEST_RECORD, 12);
    let at = statSync(file).size;
    for (; at < size; at += record.length + LONGEST_RECORD) {
        writeSync(handle, record, 0, record.length, at);
    }
    ftruncateSync(handle, at);
    closeSync(handle);
}

async function threeGigabytes(context) {
    const file = path.join(context.folder, "large.pcap");
    copyFileSync(context.capture, file);
    lengthen(file, 3e9);
    const page = await openPage(context);
    await page.setInputFiles("#files", file);
    await says(page, "scrub-out", " % read");
    await until(page, () => window.lumview.shown > 0);
    await until(page, () => window.lumview.status().last_frame === 5);
    await page.close();
}

// What a tab that slept missed is not made up for.
async function sleeps(context) {
    const page = await openFiles(context, context.capture);
    await page.keyboard.press("l");
    await page.keyboard.press(" ");
    await until(page, () => window.lumview.status().state === "playing");
    const other = await context.browser.newPage({ viewport: SIZE });
    await other.goto("about:blank");
    await sleep(3000);
    const before = await page.evaluate(() => window.lumview.received);
    await page.evaluate(() => document.getElementById("play").click());
    await until(page, () => window.lumview.status().state === "paused" && window.lumview.frame === window.lumview.status().frame);
    const waited = (await page.evaluate(() => window.lumview.received)) - before;
    assert.ok(waited < 20, `${waited} frames waited`);
    await other.close();
    await page.close();
}

async function twoTabs(context) {
    const other = simulate(context.folder, "tab.pcap", "--seed", 3);
    const [one, two] = [await openFiles(context, context.capture), await openFiles(context, other)];
    assert.equal(await points(one), dump(context.capture, "--frames", "1:1").length);
    assert.equal(await points(two), dump(other, "--frames", "1:1").length);
    await one.close();
    await two.close();
}

async function lostGraphics(context) {
    const page = await openFiles(context, context.capture);
    await page.evaluate(() => {
        const pen = document.getElementById("canvas").getContext("webgl2");
        window.lost = pen.getExtension("WEBGL_lose_context");
        window.lost.loseContext();
    });
    await says(page, BANNER, "the system took the graphics card away");
    const pictures = await page.evaluate(() => {
        window.lost.restoreContext();
        return window.lumview.pictures;
    });
    await until(page, (n) => document.getElementById("banner").hidden && window.lumview.pictures > n, pictures);
    await until(page, () => {
        const { drawn, points: all } = window.lumview;
        return drawn === all;
    });
    await page.close();
}

async function withoutWebAssembly(context) {
    const { url, close } = await serve(context, "script-src 'unsafe-inline'; worker-src blob:");
    const page = await openPage({ ...context, url });
    await page.setInputFiles("#files", context.capture);
    await says(page, BANNER, "WebAssembly");
    await page.close();
    await close();
    const none = await openPage(context, () => {
        const { Blob } = window;
        window.Blob = function blob(parts, options) {
            const isScript = options?.type === "text/javascript"; // that of the worker
            return new Blob(isScript ? ["delete globalThis.WebAssembly;", ...parts] : parts, options);
        };
    });
    await none.setInputFiles("#files", context.capture);
    await says(none, BANNER, "this browser does not let the page decode captures");
    await none.close();
}

async function withoutWorker(context) {
    const page = await openPage(context, () => {
        delete window.Worker;
    });
    await page.setInputFiles("#files", context.capture);
    await says(page, BANNER, "this browser does not let a page start a worker");
    await page.close();
}

// A static host, as any is.
async function serve(_, policy = null) {
    const asked = [];
    const server = createServer((request, answer) => {
        asked.push(request.url);
        answer.writeHead(request.url === "/lumview.html" ? 200 : 404, {
            "content-type": "text/html",
            ...(policy ? { "content-security-policy": policy } : {}),
        });
        answer.end(request.url === "/lumview.html" ? readFileSync(PAGE) : "");
    });
    server.listen(0, "127.0.0.1");
    await once(server, "listening");
    const close = async () => {
        server.closeAllConnections();
        server.close();
        await once(server, "close");
    };
    return { url: `http://127.0.0.1:${server.address().port}/lumview.html`, asked, close };
}

async function fromAStaticHost(context) {
    const { url, asked, close } = await serve(context);
    const page = await openPage({ ...context, url });
    await close(); // from here on there is no network
    await page.setInputFiles("#files", context.capture);
    await until(page, () => window.lumview.shown > 0);
    assert.deepEqual(asked, ["/lumview.html"]);
    await page.close();
}

async function keyboardOpens(context) {
    const page = await openPage(context, () => {
        window.clicks = [];
        addEventListener("click", (event) => window.clicks.push(event.target.id), true);
    });
    await page.keyboard.press("f");
    await page.evaluate(() => document.getElementById("landing-open").focus());
    await page.keyboard.press("Enter");
    assert.deepEqual((await page.evaluate(() => window.clicks)).filter((id) => id === "files").length, 2);
    await page.close();
}

async function licences(context) {
    const page = await openPage(context);
    await page.keyboard.press("?");
    await page.evaluate(() => document.getElementById("licenses").click());
    await until(page, () => ["three", "zlib", "Zstandard", "libyaml"].every((name) => document.getElementById("help").textContent.includes(`==== ${name}`)));
    await page.evaluate(() => document.getElementById("help").close());
    await until(page, () => document.querySelector("#help-tables table"));
    await page.close();
}

// What lumsdk.view() makes: the page of a frame, that in a cell of a notebook, and the frame's coordinates.
const BY_PYTHON = `
import sys, numpy, lumsdk
capture, folder = sys.argv[1:]
frame = lumsdk.open(capture)[1]
view = lumsdk.view(frame.with_columns(label=(frame["x"] // 10).astype("i2")), browser=False)
view.save(folder + "/view.html")
with open(folder + "/cell.html", "w") as file:
    file.write("<!doctype html><title>cell</title>" + view._repr_html_())
frame.xyz.tofile(folder + "/xyz.bin")
lumsdk.view(numpy.random.rand(300, 3) * [40, 40, 5] + [5000, -3000, 90], browser=False).save(folder + "/far.html")
`;

// Where a Python has no NumPy, this is false.
function viewByPython({ folder, capture }) {
    const env = { ...process.env, PYTHONPATH: path.join(path.dirname(PAGE), "python") };
    const has = (python) => spawnSync(python, ["-c", "import cffi, numpy"]).status === 0;
    const python = [process.env.LUM_PYTHON, "python3", "/usr/bin/python3"].find((one) => one && has(one));
    if (!python) {
        return false;
    }
    execFileSync(python, ["-c", BY_PYTHON, capture, folder], { env, stdio: ["ignore", "inherit", "inherit"] });
    return true;
}

const isShown = () => window.lumview?.shown > 0 && window.lumview.status()?.state === "ended";
const labelled = () => [window.lumview.points, window.lumview.settings().colour, ...window.lumview.beside().labels];

async function framesOfPython(context) {
    const { browser, folder } = context;
    if (!viewByPython(context)) {
        console.log("  left out: no python3 has cffi and numpy");
        return;
    }
    const xyz = new Float32Array(new Uint8Array(readFileSync(path.join(folder, "xyz.bin"))).buffer);
    const html = readFileSync(path.join(folder, "view.html"), "utf8");
    const data = JSON.parse(/id="lumview-data">(.*?)<\/script>/s.exec(html)[1]);
    const [frame] = makeFrames()(new Uint8Array(Buffer.from(data.frames[0], "base64")).buffer);
    const off = (i) => Math.abs(frame.xyz[i] - xyz[i]);
    assert.equal(frame.xyz.length, xyz.length);
    assert.ok(xyz.every((_, i) => off(i) <= frame.step / 2 + 1e-6), "a coordinate is off by more than half a step");

    const page = await browser.newPage({ viewport: SIZE });
    await page.goto(pathToFileURL(path.join(folder, "view.html")).href);
    await until(page, isShown);
    const range = (i) => Math.hypot(...xyz.subarray(3 * i, 3 * i + 3));
    const places = Array.from({ length: 300 }, (_, i) => Math.floor((i * frame.count) / 300));
    const ranges = await page.evaluate((all) => all.map((i) => window.lumview.place(i).range), places);
    assert.deepEqual(places.filter((place, i) => Math.abs(ranges[i] - range(place)) > frame.step), []);
    const [count, colour, ...labels] = await page.evaluate(labelled);
    assert.deepEqual([count, colour], [frame.count, "label"]);
    assert.deepEqual(labels, data.hello.labels.names);
    await page.goto(pathToFileURL(path.join(folder, "far.html")).href);
    await until(page, isShown);
    const seen = await page.evaluate(() => Array.from({ length: 300 }, (_, i) => window.lumview.place(i).visible).filter(Boolean).length);
    assert.ok(seen > 250, `of 300 points far away ${seen} are seen`);
    assert.match(await page.evaluate(() => document.getElementById("rates").textContent), /points300frames/);
    await page.close();
    if (browser.contexts) { // Firefox is driven without the frames of a page
        const notebook = await browser.newPage({ viewport: SIZE });
        const complaints = [];
        notebook.on("pageerror", (error) => complaints.push(error.message));
        await notebook.goto(pathToFileURL(path.join(folder, "cell.html")).href);
        const cell = notebook.frames()[1];
        await cell.waitForFunction(isShown, undefined, { timeout: SLOW });
        assert.deepEqual(await cell.evaluate(labelled), [count, colour, ...labels]);
        assert.deepEqual(complaints, []);
        await notebook.close();
    }
}

async function isSmall() {
    const { size } = statSync(PAGE);
    assert.ok(size <= LARGEST, `lumview.html has ${size} bytes`);
}

export const aloneFacts = [
    ["lumview.html is small", isSmall],
    ["a capture is shown, with lumdump's points, and nothing is asked for", showsTheSamePoints],
    ["it plays, steps, seeks and loops as lumview does", playerWorks],
    ["captures are dropped, also onto what is shown", dropReplaces],
    ["compressed captures, and several as one", compressedAndSeveral],
    ["YAML files are known by their keys", yamlIsKnown],
    ["it finds the layout of packets that do not decode", findsTheLayout],
    ["poses, labels and a true capture are taken beside it", takesWhatIsBeside],
    ["arrays that are of no use are told", refusesArrays],
    ["poses and files that are of no use are told", refusesFiles],
    ["a text file is no capture", textFile],
    ["an address beyond the last frame shows that", frameBeyondTheEnd],
    ["a truncated capture is shown as far as it goes", truncated],
    ["a capture of another sensor has no frame", otherSensor],
    ["3 GB are opened, and it tells how far it has read", threeGigabytes],
    ["a tab in the background catches up with nothing", sleeps],
    ["two tabs show two captures", twoTabs],
    ["the picture comes back after WebGL was lost", lostGraphics],
    ["WebAssembly that is refused is told", withoutWebAssembly],
    ["a browser without workers is told", withoutWorker],
    ["a static host serves one file, and then nothing", fromAStaticHost],
    ["the keyboard opens files", keyboardOpens],
    ["the licences are in the page", licences],
    ["frames of Python are shown, in a notebook's cell too", framesOfPython],
];
