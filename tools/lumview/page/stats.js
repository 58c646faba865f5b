// Numbers of the server's status.

const whole = (v) => Math.round(v).toLocaleString("en");

const RATES = [
    ["points a second", (s) => whole(s.points_per_second)],
    ["frames a second", (s) => s.frames_per_second.toFixed(1)],
    ["megabytes a second", (s) => (s.bytes_per_second / 1e6).toFixed(2)],
    ["points", (s) => whole(s.points)],
    ["frames", (s) => whole(s.frames)],
    ["packets", (s) => whole(s.packets) + (s.packets_joined > 0 ? `, ${whole(s.packets_joined)} of them joined` : "")],
    ["frames left out", (s) => whole(s.skipped)],
    ["browsers", (s) => whole(s.browsers)], // the last, as it is not always shown
];

// What was lost where, and what that means; what of it was under way when the stream was joined, and so is no loss.
const LOSSES = [
    ["wire_words", "ranges, on the wire", "range words that never came, at least", "joined_words"],
    ["wire_lines", "lines, on the wire", "lines that never came or came without angles, at least", "joined_lines"],
    ["pauses", "pauses", "how often the sensor, or one eye, sent no lines; its missing lines are counted above"],
    ["kernel", "packets, in the system", "the receive buffer of the system was full"],
    ["ring", "packets, in lumview", "lumview was too slow to decode them"],
    ["refused", "packets, not usable", "late, malformed, foreign, or of an unknown kind"],
];

const BIT_HINT = "A hazard: the laser is shut down";

function row(name, hint) {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.textContent = name;
    dt.title = hint;
    return [dt, dd];
}

function makeRows(list, rows) {
    return rows.map(([name, hint]) => {
        const [dt, dd] = row(name, hint ?? "");
        list.append(dt, dd);
        return dd;
    });
}

function bitItem(name, isHazard) {
    const item = document.createElement("li");
    item.textContent = name;
    item.className = isHazard ? "hazard" : "";
    item.title = isHazard ? BIT_HINT : "";
    return item;
}

function laserWord(laser) {
    return laser.on ? "on" : laser.up ? "may be on" : "off";
}

function makeLaser() {
    const block = document.getElementById("laser-block");
    const state = document.getElementById("laser-state");
    const bits = document.getElementById("laser-bits");
    let shown = null;
    return (laser) => {
        const key = JSON.stringify(laser);
        if (key === shown) {
            return;
        }
        shown = key;
        block.hidden = laser === null;
        if (laser === null) {
            return;
        }
        const hazards = new Set(laser.hazards);
        const status = `0x${laser.status.toString(16).padStart(4, "0")}`;
        state.textContent = `${laserWord(laser)}, status ${status}${hazards.size > 0 ? ", hazard" : ""}`;
        state.className = hazards.size > 0 ? "bad" : laser.on ? "good" : "";
        bits.replaceChildren(...laser.bits.map((name) => bitItem(name, hazards.has(name))));
    };
}

// What must be seen where the statistics are folded.
function showShort({ losses, laser }) {
    const isLossy = Object.values(losses).some((count) => count > 0);
    const badge = document.getElementById("lost-short");
    const short = document.getElementById("laser-short");
    badge.hidden = !isLossy;
    badge.textContent = isLossy ? "losses" : "";
    short.textContent = laser ? `laser ${laserWord(laser)}` : "";
    short.className = laser?.hazards.length > 0 ? "bad" : laser?.on ? "good" : "";
}

export function makeStats() {
    const rates = makeRows(document.getElementById("rates"), RATES.map(([name]) => [name]));
    const losses = makeRows(document.getElementById("losses"), LOSSES.map(([, name, hint]) => [name, hint]));
    const showLaser = makeLaser();
    const again = document.getElementById("again");
    let last = null;
    return (status) => {
        if (status === null) { // of no capture
            [...rates, ...losses].forEach((dd) => (dd.textContent = ""));
            showShort({ losses: {}, laser: null });
            showLaser(null);
            again.hidden = true;
            last = null;
            return;
        }
        const isBack = status.packets > 0 && last !== null && status.frame < last;
        again.hidden = status.live || (again.hidden && !isBack);
        last = status.frame;
        RATES.forEach(([, text], i) => {
            rates[i].textContent = text(status);
        });
        rates.at(-1).hidden = rates.at(-1).previousElementSibling.hidden = status.browsers < 2;
        LOSSES.forEach(([key, , , joinedKey], i) => {
            const joined = status.losses[joinedKey] ?? 0;
            const lost = status.losses[key] - joined;
            losses[i].textContent = whole(lost) + (joined > 0 ? ` + ${whole(joined)} under way` : "");
            losses[i].title = joined > 0 ? "under way when the stream was joined: not lost" : "";
            losses[i].className = lost > 0 ? "bad" : "";
        });
        showShort(status);
        showLaser(status.laser);
    };
}
