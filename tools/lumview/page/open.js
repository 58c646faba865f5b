// What the user opens in lumview.html: captures, and what belongs to them, dropped or chosen.
import { save } from "./save.js";

const at = (id) => document.getElementById(id);

const KINDS = ["profile", "calibration", "rig"];
const NO_CAPTURE = "that is no capture yet: drop one too";
const FOLDER = "is a folder: drop the captures that are in it";

// What a YAML file is, by the keys at its left; null: none of it is known.
function kindOf(text) {
    const keys = new Set([...text.matchAll(/^([a-z_]+)\s*:/gm)].map(([, key]) => key));
    const hasAny = (...names) => names.some((name) => keys.has(name));
    if (hasAny("sensors")) return "rig";
    if (hasAny("eyes", "tof_lsb_ps", "speed_of_light")) return "calibration";
    return hasAny("group", "tlv", "eye_values", "data_packet_type", "set_ip_order", "angle_order", "sample_order", "angle_lsb_deg",
        "line_span_us") ? "profile" : null;
}

function button(text, run) {
    const one = document.createElement("button");
    one.type = "button";
    one.textContent = text;
    one.addEventListener("click", run);
    return one;
}

// A question with buttons: the value of the one that was chosen, null for none. keep: those that do not close it.
function ask(text, choices, keep = {}) {
    return new Promise((answer) => {
        const dialog = document.createElement("dialog");
        const [words, row] = [document.createElement("p"), document.createElement("p")];
        dialog.className = "ask";
        dialog.setAttribute("aria-labelledby", (words.id = "ask-words"));
        words.textContent = text;
        row.className = "pair";
        const close = (value) => {
            dialog.remove();
            answer(value);
        };
        row.append(...Object.entries(choices).map(([label, value]) => button(label, () => close(value))));
        row.append(...Object.entries(keep).map(([label, run]) => button(label, run)));
        dialog.append(words, row);
        dialog.addEventListener("close", () => close(null));
        document.body.append(dialog);
        dialog.showModal();
    });
}

async function kindByUser(name) {
    const choices = { Profile: "profile", Calibration: "calibration", Rig: "rig", "Leave it out": null };
    return ask(`What is ${name}? None of its keys shows that.`, choices);
}

// The names of the files that were dropped, and folders, which cannot be read as files.
function filesOf(transfer) {
    const folders = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry?.isDirectory);
    const names = new Set(folders.map((entry) => entry.name));
    return { files: [...transfer.files].filter(({ name }) => !names.has(name)), folders: [...names] };
}

const isYaml = ({ name }) => /\.ya?ml$/i.test(name);
const isArray = ({ name }) => /\.npy$/i.test(name);

// Poses, TUM or CSV, also such as cannot be read, for their reader says why: the first line that is no comment begins with
// a number, or names columns of poses.
async function isPoses(file) {
    const text = /\.(txt|csv|tum)$/i.test(file.name) ? await file.slice(0, 4096).text() : "";
    const words = text.split("\n").find((line) => /^\s*[^\s#]/.test(line))?.trim().split(/[\s,;]+/) ?? [];
    const isNumber = /^[+-]?(nan|inf(inity)?|[\d.]+(e[+-]?\d+)?)$/i.test(words[0]);
    return words.length > 1 && (isNumber || words.includes("qw") || /^"?(t|time|timestamp)(\b|_)/i.test(words[0]));
}

// Of pcap in either order of bytes, by micro- and nanoseconds, pcapng, MCAP, bags, gzip and Zstandard.
const HEADS = ["d4c3b2a1", "a1b2c3d4", "4d3cb2a1", "a1b23c4d", "0a0d0d0a", "894d4341", "23524f53", "1f8b", "28b52ffd"];

// Whether it is one, or is meant to be.
async function isCapture(file) {
    const bytes = new Uint8Array(await file.slice(0, 4).arrayBuffer());
    const head = [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    return /\.(pcap|pcapng|cap|mcap|bag)(\.\w+)?$/i.test(file.name) || HEADS.some((one) => head.startsWith(one));
}

const leftOut = (one, used, kind) => `${one.name} is left out: ${used.name} already gives the ${kind}; drop ${one.name} alone to use it`;

// One list of each kind; the kind of a file may take a look into it. left: gets sentences on those that are of no use. Files
// of no kind are taken for captures where there are no others: then the reader of these says what they are.
async function sortFiles(files, left) {
    const kinds = await Promise.all(files.map(async (file) => {
        if (isYaml(file)) return "yaml";
        if (isArray(file)) return "arrays";
        if (await isPoses(file)) return "poses";
        return (await isCapture(file)) ? "captures" : "others";
    }));
    const of = (kind) => files.filter((_, i) => kinds[i] === kind);
    const [captures, others] = [of("captures"), of("others")];
    if (captures.length > 0) {
        left.push(...others.map(({ name }) => `${name} is left out: not a capture`));
    }
    const taken = (captures.length > 0 ? captures : others).sort(inTurn);
    return { yaml: of("yaml"), arrays: of("arrays"), poses: of("poses"), captures: taken };
}

const inTurn = (a, b) => a.name.localeCompare(b.name, "en", { numeric: true });

// With a rig all other YAML files lie beside it, as it names them; else each is what its keys say. left: gets sentences on
// those that are of no use.
async function sortYaml(files, left) {
    const out = { profile: null, calibration: null, rig: null, beside: null };
    const texts = await Promise.all(files.map(async (file) => ({ name: file.name, text: await file.text() })));
    const kinds = texts.map(({ text }) => kindOf(text));
    out.rig = texts[kinds.indexOf("rig")] ?? null;
    out.beside = out.rig && [];
    for (const [i, one] of texts.entries()) {
        const kind = out.rig ? "beside" : kinds[i] ?? (await kindByUser(one.name));
        if (kind === "beside" && one !== out.rig) {
            out.beside.push(one);
        } else if (out[kind] && one !== out.rig) {
            left.push(leftOut(one, out[kind], kind));
        } else if (KINDS.includes(kind)) {
            out[kind] = one;
        }
    }
    return out;
}

// The licences are in the file too: a link would need a server.
export function attachLicenses(unpack) {
    at("licenses").addEventListener("click", async (event) => {
        event.preventDefault();
        const tables = [...at("help-tables").querySelectorAll("table")];
        const text = document.createElement("pre");
        text.tabIndex = 0;
        text.textContent = new TextDecoder().decode(await unpack("licenses.txt"));
        if (tables.length > 0) {
            at("help-tables").replaceChildren(text);
            at("help").addEventListener("close", () => at("help-tables").replaceChildren(...tables), { once: true });
        }
    });
}

// source: one with open(); tell(sentence) shows it until something is opened or there is another one; takeArray(name, read):
// read() promises the bytes of an array of labels, or of true points.
export function attachOpen(source, tell, takeArray) {
    let waiting = {}; // YAML files and poses that came before a capture
    let known = []; // arrays, { name, read } each, of the capture that is shown or comes next

    // left: sentences on what was left out
    function showWaiting(left) {
        const names = [...KINDS, "poses"].filter((kind) => waiting[kind]).map((kind) => `${kind}: ${waiting[kind].name}`);
        names.push(...known.map(({ name }) => `array: ${name}`));
        at("landing-kept").textContent = names.join(", ");
        tell([...left, ...(names.length > 0 ? [NO_CAPTURE] : [])].join("; "));
    }

    // Captures begin anew; YAML files alone are for what is shown.
    async function take({ files, folders = [] }) {
        const left = folders.map((name) => `${name} ${FOLDER}`);
        const { yaml, arrays, poses, captures } = await sortFiles(files, left);
        const sorted = yaml.length > 0 ? await sortYaml(yaml, left) : {};
        const given = Object.fromEntries(Object.entries(sorted).filter(([, value]) => value !== null));
        if (poses.length > 0) {
            given.poses = poses[0];
            left.push(...poses.slice(1).map((one) => leftOut(one, poses[0], "poses")));
        }
        const come = arrays.map((file) => ({ name: file.name, read: () => file.arrayBuffer() }));
        known = captures.length > 0 && source.opened ? come : [...known, ...come];
        const isGiven = Object.keys(given).length > 0;
        if (captures.length > 0) {
            await source.open({ captures, ...waiting, ...given });
            waiting = {};
        } else if (source.opened && isGiven) {
            await source.open({ ...source.opened, ...given });
        } else if (!source.opened) {
            waiting = { ...waiting, ...given };
            showWaiting(left);
            return;
        }
        tell(left.join("; ")); // what was told of files before is past
        takeAll(captures.length > 0 || isGiven ? known : come);
    }

    const takeAll = (arrays) => arrays.forEach(({ name, read }) => takeArray(name, read));

    // Arrays say what they are; captures are the truth beside what is shown.
    async function takeTruth({ files, folders }) {
        const left = [];
        const { arrays, captures } = await sortFiles(files, left);
        if (captures.length === 0 || !source.opened) {
            await take({ files: source.opened ? arrays : files, folders });
            return;
        }
        const name = captures.map((file) => file.name).join(", ");
        const read = () => {
            tell(`reading ${name} as ground truth`);
            return source.readTruth(captures).finally(() => tell(left.join("; ")));
        };
        known.push({ name, read });
        takeAll(known.slice(-1));
    }

    // A file may go before it is read.
    const guarded = (use) => (given) => use(given).catch((error) => tell(error.message));
    const [open, openTruth] = [take, takeTruth].map(guarded);

    async function offer({ yaml, sentence }) {
        const profile = { name: "profile.yaml", text: yaml };
        const choices = yaml ? { "Use it": "use", Close: null } : { Close: null };
        const keep = yaml ? { "Save profile.yaml": () => save([yaml], "text/yaml", profile.name) } : {};
        if ((await ask(sentence, choices, keep)) === "use") {
            await source.open({ ...source.opened, profile });
            takeAll(known);
        }
    }

    const choose = () => at("files").click();
    const over = (isOver) => (document.body.dataset.over = String(isOver));
    for (const id of ["open-files", "landing-open"]) {
        at(id).addEventListener("click", choose);
    }
    at("open-files").hidden = false;
    at("landing").hidden = Boolean(source.opened);
    at("infer").addEventListener("click", () => {
        at("infer").disabled = true;
        source.infer();
    });
    at("truth-open").addEventListener("click", () => at("truth-files").click());
    for (const [id, use] of [["files", open], ["truth-files", openTruth]]) {
        at(id).addEventListener("change", ({ target }) => {
            use({ files: [...target.files] });
            target.value = "";
        });
    }
    document.addEventListener("dragover", (event) => {
        event.preventDefault();
        over(true);
    });
    document.addEventListener("dragleave", (event) => event.relatedTarget === null && over(false));
    document.addEventListener("drop", (event) => {
        event.preventDefault();
        over(false);
        (event.shiftKey ? openTruth : open)(filesOf(event.dataTransfer));
    });

    return {
        choose,
        async inferred(found) {
            at("infer").disabled = false;
            await offer(found);
        },
        opening() {
            at("landing").hidden = true;
            at("infer").hidden = true;
            at("infer").disabled = false; // what is asked of the source before is not answered
            at("truth-open-row").hidden = false;
        },
        // Something else can be opened, as nothing was.
        failed() {
            at("landing").hidden = false;
            at("infer").disabled = false;
        },
        // What the status says of packets that the profile does not fit.
        show({ message }) {
            at("infer").hidden = !message.includes("--infer");
        },
    };
}
