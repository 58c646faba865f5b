// The connection to lumview: it comes back by itself.

const WAIT_FIRST_MS = 500;
const WAIT_MAX_MS = 5000;
const SILENCE_MS = 5000; // a status comes twice a second

function address() {
    const url = new URL("/ws", location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    url.search = location.search; // the token, where there is one
    return url.href;
}

// on: { text(object), binary(ArrayBuffer), up(), down(seconds until the next try) }
export function makeLink(on) {
    let socket = null;
    let isUp = false;
    let wait = WAIT_FIRST_MS;
    let heard = 0;
    let timer = 0;

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
        wait = WAIT_FIRST_MS;
        heard = performance.now();
        on.up();
    }

    function lost() {
        socket = null;
        isUp = false;
        on.down(wait / 1000);
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
