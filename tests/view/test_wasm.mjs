// The decoder of lumview.html without a browser: its points are those of lumdump.
//   LUM_BIN=build/bin LUM_WASM=FILE node test_wasm.mjs [FOLDER...]
// on captures of lumsim, and on the conformance captures in folders.
import { execFileSync, spawnSync } from "node:child_process";
import { closeSync, fstatSync, mkdtempSync, openSync, readdirSync, readFileSync, readSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { makeEngine } from "../../tools/lumview/page/engine.js";

const INPUTS = ["calibration", "profile"];
const EDGES = { rising: 1, falling: 2, both: 3 };
const SAMPLE_BYTES = 36;
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

// The engine that reads a capture, whose files are known to it by their base names.
function open(capture, args) {
    const options = new Map(args.flatMap((one, i) => (i % 2 === 0 ? [[one.slice(2), args[i + 1]]] : [])));
    const given = INPUTS.filter((what) => options.has(what)).map((what) => [what, options.get(what)]);
    const paths = [capture, ...given.map(([, name]) => name)];
    const files = new Map(paths.map((name) => [path.basename(name), fileOf(name)]));
    const engine = makeEngine(module, files);
    engine.addCapture(path.basename(capture));
    given.forEach(([what, name]) => engine.set(what, path.basename(name)));
    const sensor = (options.get("sensor") ?? "0.0.0.0").split(".").reduce((sum, part) => sum * 256 + Number(part), 0);
    engine.must(engine.calls.points_open(EDGES[options.get("edge") ?? "rising"], sensor));
    return { ...engine, close: () => [...files.values()].forEach((file) => file.close()) };
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

function simulated(folder) {
    const make = (name, ...rest) => {
        const capture = path.join(folder, name);
        tool("lumsim", "-q", "-o", capture, ...rest);
        return capture;
    };
    const street = make("street.pcap", "--frames", 2);
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
try {
    for (const [name, capture, args] of [...simulated(folder), ...process.argv.slice(2).flatMap(conformance)]) {
        try {
            tally.points += compare(capture, args, folder);
            tally.passed++;
        } catch (error) {
            tally.failed++;
            console.log(`FAIL ${name}: ${error.message}`);
        }
    }
} finally {
    rmSync(folder, { recursive: true });
}
console.log(`${tally.points} points are equal`);
console.log(`${tally.passed} passed, ${tally.failed} failed`);
process.exitCode = tally.failed > 0 || tally.points === 0 ? 1 : 0;
