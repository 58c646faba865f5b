// The worker of lumview.html: decodes the captures that the page hands over. What it is told and what it tells stand in
// files.js; texts and frames are those that lumview sends.
import { makeEngine } from "./engine.js";

const BLOCK_BYTES = 1 << 20; // read at once
const BLOCKS = 8; // kept of a file: two places of it are read in turns
const ON_THE_WAY = 2; // frames that the page has not taken yet
const FIX = "allow WebAssembly for this page, or open lumview.html in another browser";
const SINGLE = ["calibration", "profile", "second", "rig", "poses"];

let wasm = null; // the module's bytes, or a module
let module = null; // compiled
let engine = null;
let onTheWay = 0;
let timer = 0;
const now = new MessageChannel(); // sooner than a timer
let isDue = false; // by now: once, however often it was asked for

const tell = (message, transfer) => postMessage(message, transfer ?? []);

// --- Files ---

// A buffer that is sent to nobody is freed at once. A collector would come when a hundred megabytes lie about.
const { port1: nobody, port2 } = new MessageChannel();
port2.close();
const free = (buffer) => nobody.postMessage(null, [buffer]);

// Blocks of a File, the latest of which are kept.
function sliceReader(file) {
    const reader = new FileReaderSync();
    const blocks = new Map();

    function block(i) {
        const bytes = blocks.get(i)
            ?? new Uint8Array(reader.readAsArrayBuffer(file.slice(i * BLOCK_BYTES, (i + 1) * BLOCK_BYTES)));
        blocks.delete(i);
        blocks.set(i, bytes);
        if (blocks.size > BLOCKS) {
            const [[oldest, left]] = blocks;
            blocks.delete(oldest);
            free(left.buffer);
        }
        return bytes;
    }

    // To the end of a block, at most.
    return (offset, length) => {
        const i = Math.floor(offset / BLOCK_BYTES);
        const from = offset - i * BLOCK_BYTES;
        return block(i).subarray(from, from + length);
    };
}

const memoryReader = (bytes) => (offset, length) => bytes.subarray(offset, offset + length);

// What it holds as the engine reads it. A File has functions of the same names.
function asFile(one) {
    if (one instanceof Blob) {
        return { size: one.size, read: sliceReader(one) };
    }
    if (typeof one.text === "string") {
        return asFile({ bytes: new TextEncoder().encode(one.text) });
    }
    const bytes = new Uint8Array(one.bytes);
    return { size: bytes.length, read: memoryReader(bytes) };
}

// A name that no file has yet; "-" would be standard input.
function nameFor(files, name) {
    const [, base, suffix] = /^(.*?)(\.[^.]*)?$/s.exec(name.replaceAll("/", "_").replace(/^-$/, "_"));
    let free = base + (suffix ?? "");
    for (let i = 2; files.has(free); i++) {
        free = `${base} (${i})${suffix ?? ""}`;
    }
    return free;
}

// --- The engine ---

async function compile() {
    module ??= wasm instanceof WebAssembly.Module ? wasm : await WebAssembly.compile(wasm);
    return module;
}

// The files and the engine that may open them. Those beside a rig go by the names that it has for them.
function load(compiled, captures, options) {
    const files = new Map((options.beside ?? []).map((one) => [one.name, asFile(one)]));
    const named = (one) => {
        const name = nameFor(files, one.name);
        files.set(name, asFile(one));
        return name;
    };
    const names = captures.map(named);
    const others = SINGLE.filter((what) => options[what]).map((what) => [what, named(options[what])]);
    const made = makeEngine(compiled, files, (text) => console.info(text));
    names.forEach((name) => made.addCapture(name));
    others.forEach(([what, name]) => made.set(what, name));
    return made;
}

// What a person would read if the engine itself broke.
function fail(error) {
    clearTimeout(timer);
    engine = null;
    const isOurs = typeof WebAssembly === "undefined" || !(error instanceof WebAssembly.RuntimeError);
    tell({ failed: isOurs ? error.message : `the decoder stopped: ${error.message}; this is a fault of lumview, please report it` });
}

function guarded(act) {
    try {
        act();
    } catch (error) {
        fail(error);
    }
}

// Messages as long as the page takes them: frames that it would not draw are not made ready.
function deliver() {
    while (onTheWay < ON_THE_WAY) {
        const message = engine.next();
        if (message === null) {
            return;
        }
        if (message.binary) {
            onTheWay++;
        }
        tell(message, message.binary && [message.binary]);
    }
}

function turn() {
    clearTimeout(timer);
    if (engine === null) {
        return;
    }
    guarded(() => {
        const wait = engine.work();
        deliver();
        if (wait < 1) {
            isDue || now.port2.postMessage(null);
            isDue = true;
        } else {
            timer = setTimeout(turn, wait);
        }
    });
}

now.port1.onmessage = () => {
    isDue = false;
    turn();
};

async function begin({ files, options }, act) {
    try {
        act(load(await compile(), files, options ?? {}));
    } catch (error) {
        fail(typeof WebAssembly === "undefined" || error instanceof WebAssembly.CompileError
            ? new Error(`this browser does not let the page decode captures: ${error.message}; ${FIX}`) : error);
    }
}

const orders = {
    wasm(given) {
        wasm = given;
    },
    open: (order) => begin(order, (made) => {
        engine = made;
        engine.open(order.options?.paused);
        turn();
    }),
    // Of a worker that does nothing else.
    truth: (order) => begin(order, (made) => {
        const truth = made.truth();
        tell({ truth }, [truth]);
    }),
    send(text) {
        if (engine) {
            guarded(() => engine.command(text));
            turn();
        }
    },
    took(buffer) {
        free(buffer);
        onTheWay--;
        turn();
    },
    infer() {
        guarded(() => tell({ inferred: engine.infer() }));
    },
};

onmessage = ({ data }) => Object.entries(data).forEach(([name, value]) => orders[name]?.(value));
