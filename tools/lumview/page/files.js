// Captures of this computer, decoded by lumview's own code as WebAssembly in a worker. Files stay where they are:
// the worker reads slices of them.

const NO_WORKER = "this browser does not let a page start a worker, and captures are read in one: allow it for this page, "
    + "or open lumview.html in another browser";

// The module and the worker's script, unpacked once.
async function unpackEngine(unpack) {
    const [script, wasm] = await Promise.all(["worker.js", "lumview.wasm"].map(unpack));
    return { url: URL.createObjectURL(new Blob([script], { type: "text/javascript" })), wasm };
}

// on: that of makeSource()
export function makeFiles(on, unpack) {
    const engine = unpackEngine(unpack);
    let worker = null;
    let opened = null; // { captures, options }, to open the same again with another profile
    let isUp = false;

    const say = (message, transfer) => worker?.postMessage(message, transfer ?? []);

    function fail(sentence) {
        isUp = false;
        on.failed(sentence);
    }

    const hear = {
        text(message) {
            isUp = true;
            on.text(message);
        },
        binary(buffer) {
            on.binary(buffer);
            say({ took: buffer }, [buffer]); // the next one is sent when this one was taken
        },
        failed: fail,
        inferred: on.inferred,
    };

    function listen(mine) {
        mine.onmessage = ({ data }) => {
            if (mine === worker) {
                Object.entries(data).forEach(([key, value]) => hear[key]?.(value));
            }
        };
        mine.onerror = (event) => {
            event.preventDefault();
            if (mine === worker) {
                fail(`the decoder has ended: ${event.message || "the browser does not say why"}`);
            }
        };
    }

    // A worker for each opening: what the one before held goes with it.
    async function start() {
        worker?.terminate();
        worker = null;
        isUp = false;
        const { url, wasm } = await engine;
        worker?.terminate(); // of an opening meanwhile
        const mine = new Worker(url);
        worker = mine;
        listen(mine);
        say({ wasm });
    }

    // So that a first capture need not wait for it.
    const ready = typeof Worker === "function" ? start() : null;
    ready?.catch((error) => on.failed(error.message));
    let isFresh = true;

    // Whether there is a worker for it, and nothing else is to be opened meanwhile.
    async function prepare(next) {
        try {
            await ready;
            if (!isFresh) {
                await start();
            }
        } catch (error) {
            fail(error.message);
            return false;
        }
        return next === opened;
    }

    async function open(next) {
        opened = next;
        await null; // the page's own parts are made first
        if (ready === null) {
            fail(NO_WORKER);
            return;
        }
        on.opening(next);
        if (await prepare(next)) {
            isFresh = false;
            const { captures, ...options } = next;
            say({ open: { files: captures, options } });
        }
    }

    // Points of captures that are true, as an array of NumPy. What is shown goes on meanwhile.
    async function readTruth(files) {
        const { captures, ...options } = opened;
        const { url, wasm } = await engine;
        const other = new Worker(url);
        const heard = new Promise((resolve, reject) => {
            other.onmessage = ({ data }) => (data.failed ? reject(new Error(data.failed)) : resolve(data.truth));
            other.onerror = (event) => reject(new Error(`the decoder has ended: ${event.message || "the browser does not say why"}`));
        });
        other.postMessage({ wasm });
        other.postMessage({ truth: { files, options } });
        return heard.finally(() => other.terminate());
    }

    return {
        readTruth,
        get connected() {
            return isUp;
        },
        get opened() {
            return opened;
        },
        send: (text) => isUp && say({ send: text }),
        infer: () => say({ infer: true }),
        open,
    };
}
