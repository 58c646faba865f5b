// lumview's own code as WebAssembly, with the files that it can open: what tools/lumview/wasm exports, for a worker and
// for tests.
import { makeWasi } from "./wasi.js";

const INPUTS = ["calibration", "profile", "second", "rig", "poses"]; // as inputs.h counts them
const TEXT = 1;
const [PIECE_AT, PIECES_AT] = [84, 88]; // in a message of packed.h: which piece of its frame it is, and of how many

// files: as makeWasi() takes them
export function makeEngine(module, files, log) {
    const wasi = makeWasi(files, log);
    const instance = new WebAssembly.Instance(module, wasi.imports(module));
    wasi.start(instance);
    const calls = instance.exports;
    let whole = new Uint8Array(0); // the pieces of the frame that is under way, one behind the other; used again
    let length = 0;

    function textAt(at) {
        const bytes = new Uint8Array(calls.memory.buffer, at);
        return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
    }

    function must(result) {
        if (result < 0) {
            throw new Error(textAt(calls.engine_error()));
        }
        return result;
    }

    function put(text) {
        const bytes = new TextEncoder().encode(text);
        const at = calls.engine_text(bytes.length);
        if (at === 0) {
            throw new Error("out of memory");
        }
        new Uint8Array(calls.memory.buffer, at, bytes.length).set(bytes);
    }

    function add(piece) {
        if (length + piece.length > whole.length) {
            const larger = new Uint8Array(2 * (length + piece.length));
            larger.set(whole.subarray(0, length));
            whole = larger;
        }
        whole.set(piece, length);
        length += piece.length;
    }

    return {
        calls,
        must,
        addCapture(name) {
            put(name);
            must(calls.engine_add_capture());
        },
        set(what, name) {
            put(name);
            must(calls.engine_set(INPUTS.indexOf(what)));
        },
        open: (isPaused) => must(calls.engine_open(isPaused ? 1 : 0)),
        command(text) {
            put(text);
            must(calls.engine_command());
        },
        work: () => calls.engine_work() / 1e6, // milliseconds until there is more to do
        // { text } or { binary }; null: there is none
        next() {
            for (;;) {
                const kind = must(calls.engine_next());
                if (kind === 0) {
                    return null;
                }
                const bytes = new Uint8Array(calls.memory.buffer, calls.engine_bytes(), calls.engine_length());
                if (kind === TEXT) {
                    return { text: JSON.parse(new TextDecoder().decode(bytes)) };
                }
                const head = new DataView(calls.memory.buffer, bytes.byteOffset);
                if (head.getUint32(PIECE_AT, true) === 0) {
                    length = 0; // one that was left is not shown
                }
                add(bytes);
                if (head.getUint32(PIECE_AT, true) + 1 === head.getUint32(PIECES_AT, true)) {
                    return { binary: whole.slice(0, length).buffer };
                }
            }
        },
        // Instead of open(): the points of the captures as an array of NumPy.
        truth() {
            must(calls.engine_truth());
            return calls.memory.buffer.slice(calls.engine_bytes(), calls.engine_bytes() + calls.engine_length());
        },
        infer() {
            must(calls.engine_infer());
            return { yaml: textAt(calls.engine_profile()), sentence: textAt(calls.engine_sentence()) };
        },
    };
}
