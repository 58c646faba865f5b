// The decoder of lumview.html without a browser: its points are those of lumdump, and it plays captures as lumview does.
//   LUM_BIN=build/bin LUM_WASM=FILE node test_wasm.mjs [FOLDER...]
// on captures of lumsim, and on the conformance captures in folders.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { closeSync, fstatSync, mkdtempSync, openSync, readdirSync, readFileSync, readSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { makeEngine } from "../../tools/lumview/page/engine.js";

const INPUTS = ["calibration", "profile"];
const EDGES = { rising: 1, falling: 2, both: 3 };
const SAMPLE_BYTES = 36;
const FRAMES = 5;
const MEMORY_MAX = 64 * 1024 * 1024;
const SLOW = 300000; // milliseconds, which only end a fact that hangs
const bin = path.resolve(process.env.LUM_BIN ?? "build/release/bin");
const module = new WebAssembly.Module(readFileSync(process.env.LUM_WASM));
const tool = (name, ...rest) => execFileSync(path.join(bin, name), rest.map(String), { stdio: ["ignore", "ignore", "pipe"] });

function fileOf(name) {
    const fd = openSync(name);
    const read = (offset, length) => {
        const bytes = new Uint8Array(length);
        return bytes.subarray(0, readSync(fd, bytes, 0, length, offset));
    };
    return { size: fstatSync(fd).size, read, close: () => closeSync(fd) };
}

// The engine with files of paths, by their base names.
function load(paths) {
    const files = new Map(paths.map((name) => [path.basename(name), fileOf(name)]));
    return { ...makeEngine(module, files), close: () => [...files.values()].forEach((file) => file.close()) };
}

// The engine that reads a capture, whose files are known to it by their base names.
function open(capture, args) {
    const options = new Map(args.flatMap((one, i) => (i % 2 === 0 ? [[one.slice(2), args[i + 1]]] : [])));
    const given = INPUTS.filter((what) => options.has(what)).map((what) => [what, options.get(what)]);
    const engine = load([capture, ...given.map(([, name]) => name)]);
    engine.addCapture(path.basename(capture));
    given.forEach(([what, name]) => engine.set(what, path.basename(name)));
    const sensor = (options.get("sensor") ?? "0.0.0.0").split(".").reduce((sum, part) => sum * 256 + Number(part), 0);
    engine.must(engine.calls.points_open(EDGES[options.get("edge") ?? "rising"], sensor));
    return engine;
}

// Each point as the row of a CSV file has it.
function* pointsOf(its) {
    const { calls } = its;
    const names = ["x", "y", "z", "range", "azimuth", "elevation", "pulse_width"];
    for (;;) {
        const count = calls.points_next();
        if (count < 0) {
            return; // also where a capture is broken off, which lumdump reads as far
        }
        const line = { timestamp: calls.points_clock(), frame: calls.points_frame(),
                       eye: calls.points_eye(), line: calls.points_line() };
        const data = new DataView(calls.memory.buffer, calls.points_samples(), count * SAMPLE_BYTES);
        for (let at = 0; at < count * SAMPLE_BYTES; at += SAMPLE_BYTES) {
            const floats = names.map((name, i) => [name, data.getFloat32(at + 4 * i, true)]);
            yield { ...Object.fromEntries(floats), ...line, pixel: data.getUint16(at + 28, true),
                    return_number: data.getUint16(at + 30, true), number_of_returns: data.getUint16(at + 32, true),
                    edge: data.getUint8(at + 34) };
        }
    }
}

// A number of the file is the one that is printed with so many digits.
function isPrinted(text, value) {
    const digits = text.includes(".") ? text.length - text.indexOf(".") - 1 : 0;
    return Math.abs(Number(text) - value) <= 0.5000001 * 10 ** -digits;
}

// Throws where they differ; returns how many there are.
function compare(capture, args, folder) {
    const csv = path.join(folder, "points.csv");
    rmSync(csv, { force: true });
    tool("lumdump", "-q", capture, ...args, "-o", csv);
    const [head, ...rows] = readFileSync(csv, "utf8").trimEnd().split("\n");
    const names = head.split(",");
    const its = open(capture, args);
    let count = 0;
    for (const point of pointsOf(its)) {
        const row = rows[count]?.split(",") ?? [];
        const wrong = names.findIndex((name, i) => !isPrinted(row[i] ?? "none", point[name]));
        if (wrong >= 0) {
            throw new Error(`point ${count}, ${names[wrong]}: lumdump ${row[wrong]}, here ${point[names[wrong]]}`);
        }
        count++;
    }
    its.close();
    if (count !== rows.length) {
        throw new Error(`${count} points, lumdump ${rows.length}`);
    }
    return count;
}

// --- The engine as the worker drives it ---

// A capture that is played: its latest status, and how many bytes of frames came.
function play(capture, isPaused) {
    const engine = load([capture]);
    engine.addCapture(path.basename(capture));
    engine.open(isPaused);
    const seen = { hello: null, status: null, bytes: 0 };

    function take({ text, binary }) {
        seen.bytes += binary?.byteLength ?? 0;
        if (text) {
            seen[text.type] = text;
        }
    }

    async function until(what, condition) {
        const begun = performance.now();
        while (!(seen.status && condition(seen.status))) {
            const wait = engine.work();
            for (let message = engine.next(); message !== null; message = engine.next()) {
                take(message);
            }
            await new Promise((done) => setTimeout(done, Math.min(wait, 20)));
            assert(performance.now() - begun < SLOW, `${what}: not seen, but ${JSON.stringify(seen.status)}`);
        }
    }

    return { ...engine, seen, until };
}

function countOf(capture, ...args) {
    const csv = `${capture}.csv`;
    rmSync(csv, { force: true });
    tool("lumdump", "-q", capture, ...args, "-o", csv);
    return readFileSync(csv, "utf8").trimEnd().split("\n").length - 1;
}

// Of the text that a failure gives.
function refusal(act) {
    try {
        act();
    } catch (error) {
        return error.message;
    }
    throw new Error("it is not refused");
}

const facts = {
    async "a paused capture shows its first frame"({ street }) {
        const its = play(street, true);
        await its.until("a frame", ({ state, frames }) => state === "paused" && frames === 1);
        assert.equal(its.seen.hello.source, "street.pcap");
        assert(its.seen.bytes > 7 * countOf(street, "--frames", "1:1"));
        its.close();
    },
    async "frames are sought, forth and back"({ street }) {
        const its = play(street, true);
        await its.until("the ends", ({ last_frame: last }) => last === FRAMES);
        for (const [command, frame] of [[`seek ${FRAMES}`, FRAMES], ["step -1", FRAMES - 1], ["seek 1", 1], ["seek 3", 3]]) {
            its.command(command);
            await its.until(command, (status) => status.frame === frame && status.state === "paused");
        }
        assert.match(refusal(() => its.command("laser on")), /no such command: laser on/);
        its.close();
    },
    async "a capture is played to its end"({ street }) {
        const its = play(street, false);
        its.command("speed 100");
        await its.until("the end", ({ state }) => state === "ended");
        assert.equal(its.seen.status.points, countOf(street));
        assert(its.calls.memory.buffer.byteLength < MEMORY_MAX);
        its.close();
    },
    async "captures that break off say so"({ street, folder }) {
        const cut = path.join(folder, "cut.pcap");
        writeFileSync(cut, readFileSync(street).subarray(0, -1000));
        const its = play(cut, false);
        its.command("speed 100");
        await its.until("the end", ({ state }) => state === "ended" || state === "failed");
        await its.until("what is wrong", ({ message }) => message.includes("cut short"));
        its.close();
    },
    async "what is no capture is refused"({ folder }) {
        const text = path.join(folder, "notes.txt");
        writeFileSync(text, "nothing that a lidar sends\n".repeat(100));
        assert.match(refusal(() => play(text, false)), /^notes\.txt: .*pcap/);
    },
    async "the layout of a capture is found"({ street, folder }) {
        const its = load([street]);
        its.addCapture("street.pcap");
        const { yaml, sentence } = its.infer();
        assert.match(sentence, /^A layout was found: /);
        writeFileSync(path.join(folder, "profile.yaml"), yaml);
        assert.equal(countOf(street, "--profile", path.join(folder, "profile.yaml")), countOf(street));
        its.close();
    },
};

// --- Captures ---

function simulated(folder) {
    const make = (name, ...rest) => {
        const capture = path.join(folder, name);
        tool("lumsim", "-q", "-o", capture, ...rest);
        return capture;
    };
    const street = make("drive.pcap", "--frames", 2);
    const packed = (program, suffix) => {
        const { status, error } = spawnSync(program, ["-kqf", street]);
        if (status !== 0) {
            console.log(`     ${program} packs nothing: ${error?.message ?? status}`);
        }
        return status === 0 ? [`${street}.${suffix}`] : [];
    };
    const captures = [street, make("drive.pcapng", "--frames", 2), make("drive.mcap", "--frames", 2),
                      ...packed("gzip", "gz"), ...packed("zstd", "zst")];
    return captures.map((capture) => [path.basename(capture), capture, ["--edge", "both"]]);
}

function conformance(folder) {
    const isCase = (name) => name.endsWith(".json") && name !== "packets.json";
    return readdirSync(folder).filter(isCase).map((name) => {
        const { capture, arguments: args } = JSON.parse(readFileSync(path.join(folder, name), "utf8"));
        return [name.replace(/\.json$/, ""), path.join(folder, capture),
                args.map((one) => (one.endsWith(".yaml") ? path.join(folder, one) : one))];
    });
}

const folder = mkdtempSync(path.join(tmpdir(), "lumview-"));
const tally = { passed: 0, failed: 0, points: 0 };

async function check(name, fact) {
    try {
        await fact();
        tally.passed++;
    } catch (error) {
        tally.failed++;
        console.log(`FAIL ${name}: ${error.message}`);
    }
}

try {
    const street = path.join(folder, "street.pcap");
    tool("lumsim", "-q", "-o", street, "--frames", FRAMES);
    for (const [name, fact] of Object.entries(facts)) {
        await check(name, () => fact({ street, folder }));
    }
    for (const [name, capture, args] of [...simulated(folder), ...process.argv.slice(2).flatMap(conformance)]) {
        await check(name, () => {
            tally.points += compare(capture, args, folder);
        });
    }
} finally {
    rmSync(folder, { recursive: true });
}
console.log(`${tally.points} points are equal`);
console.log(`${tally.passed} passed, ${tally.failed} failed`);
process.exitCode = tally.failed > 0 || tally.points === 0 ? 1 : 0;
