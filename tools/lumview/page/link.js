// The connection to lumview: it comes back by itself. Where a token is needed, the cookie has it.

// What the page says while it has no connection, or nothing to draw with.
export const GONE = "no connection: lumview has ended or cannot be reached; trying again";
export const REFUSED = "no connection: lumview was started again, and this page's token is no longer valid: open the URL that it "
    + "printed; trying again";
export const LOST = "the system took the graphics card away from this page: the picture comes back when it is there again";

const WAIT_FIRST_MS = 500;
const WAIT_MAX_MS = 5000;
const SILENCE_MS = 5000; // a status comes twice a second

function address() {
    const url = new URL("/ws", location.origin);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    return url.href;
}

// Whether lumview answers, but not to this browser: a socket does not tell why it is refused.
async function isRefused() {
    try {
        return (await fetch("/", { cache: "no-store" })).status === 403;
    } catch {
        return false;
    }
}

// on: { text(object), binary(ArrayBuffer), up(), down(seconds until the next try, whether it is refused) }
export function makeLink(on) {
    let socket = null;
    let isUp = false;
    let wait = WAIT_FIRST_MS;
    let heard = 0;
    let timer = 0;
    let refused = false;

    function hear(event) {
        heard = performance.now();
        if (typeof event.data !== "string") {
            on.binary(event.data);
            return;
        }
        on.text(JSON.parse(event.data));
    }

    function opened() {
        isUp = true;
        refused = false;
        wait = WAIT_FIRST_MS;
        heard = performance.now();
        on.up();
    }

    async function tellDown(seconds) {
        on.down(seconds, refused);
        const before = refused;
        refused = await isRefused();
        if (!isUp && refused !== before) {
            on.down(seconds, refused);
        }
    }

    function lost() {
        socket = null;
        isUp = false;
        tellDown(wait / 1000);
        timer = setTimeout(connect, wait);
        wait = Math.min(WAIT_MAX_MS, wait * 1.6);
    }

    function connect() {
        clearTimeout(timer);
        const mine = new WebSocket(address(), "lumview.1");
        const ifMine = (then) => (event) => {
            if (socket === mine) {
                then(event);
            }
        };
        socket = mine;
        socket.binaryType = "arraybuffer";
        heard = performance.now();
        socket.onopen = ifMine(opened);
        socket.onmessage = ifMine(hear);
        socket.onclose = ifMine(lost);
    }

    // A server that hangs, or a network that is gone, closes nothing.
    function watch() {
        if (socket !== null && performance.now() - heard > SILENCE_MS) {
            socket.close();
            lost();
        }
    }

    connect();
    setInterval(watch, 1000);
    return {
        get connected() {
            return isUp;
        },
        send(text) {
            if (isUp) {
                socket.send(text);
            }
        },
    };
}
