// How many points a picture may have while the camera moves. A graphics card
// draws them all; without one, as many as keep the movement fluid.

const SETTLE_MS = 200; // after the last movement the picture is whole again
const LEAST = 20000; // points
const FIRST_IN_SOFTWARE = 60000;
const SLOW_MS = 120; // a picture
const WANTED_MS = 90;
const QUICK_MS = 50;
const QUEUE = 3; // pictures that may still wait behind a whole one
const ROUND = 5; // pictures from which it learns

// Whether the browser draws without a graphics card, as far as it says so.
function isSoftware(gl) {
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const name = gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export function makePace(gl) {
    let most = isSoftware(gl) ? FIRST_IN_SOFTWARE : Infinity;
    let moved = -Infinity; // when the camera did last
    let pictures = 0; // of this movement
    let begun = 0; // milliseconds, of the pictures that it learns from

    // By how long a picture took in the mean.
    function learn(took, total) {
        if (took > SLOW_MS) {
            most = Math.max(LEAST, Math.min(most, total) * Math.max(0.5, WANTED_MS / took));
        } else if (took < QUICK_MS) {
            most = most < total ? most * 1.5 : Infinity;
        }
    }

    return {
        move(now) {
            moved = now;
        },
        // Whether moved pictures leave something out.
        get isSlow() {
            return most !== Infinity;
        },
        isMoving: (now) => now - moved < SETTLE_MS,
        // One point of how many there are is drawn; 1: all.
        stride(now, total, isMoving) {
            pictures = isMoving ? pictures + 1 : 0;
            if (pictures === QUEUE + ROUND) {
                learn((now - begun) / ROUND, total);
                pictures = QUEUE;
            }
            begun = pictures === QUEUE ? now : begun;
            return isMoving ? Math.max(1, Math.ceil(total / most)) : 1;
        },
    };
}
