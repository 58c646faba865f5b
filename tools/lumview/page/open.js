// What the user opens in lumview.html: captures and YAML files, dropped or chosen.

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

export function save(name, text, type) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

async function kindByUser(name) {
    const choices = { Profile: "profile", Calibration: "calibration", Rig: "rig", "Leave it out": null };
    return ask(`What is ${name}? It has no key by which that is known.`, choices);
}

// The names of the files that were dropped, and folders, which cannot be read as files.
function filesOf(transfer) {
    const folders = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry?.isDirectory);
    const names = new Set(folders.map((entry) => entry.name));
    return { files: [...transfer.files].filter(({ name }) => !names.has(name)), folders: [...names] };
}

const isYaml = ({ name }) => /\.ya?ml$/i.test(name);
const isArray = ({ name }) => /\.npy$/i.test(name);
const inTurn = (a, b) => a.name.localeCompare(b.name, "en", { numeric: true });

// With a rig all other YAML files lie beside it, as it names them; else each is what its keys say.
async function sortYaml(files) {
    const out = { profile: null, calibration: null, rig: null, beside: [] };
    const texts = await Promise.all(files.map(async (file) => ({ name: file.name, text: await file.text() })));
    const kinds = texts.map(({ text }) => kindOf(text));
    out.rig = texts[kinds.indexOf("rig")] ?? null;
    for (const [i, one] of texts.entries()) {
        const kind = out.rig ? "beside" : kinds[i] ?? (await kindByUser(one.name));
        if (kind === "beside" && one !== out.rig) {
            out.beside.push(one);
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
        const text = document.createElement("pre");
        text.tabIndex = 0;
        text.textContent = new TextDecoder().decode(await unpack("licenses.txt"));
        at("help-tables").replaceChildren(text);
    });
}

// source: one with open(); tell(sentence) shows it until something is opened; takeArray(file): of labels, or of true points.
export function attachOpen(source, tell, takeArray) {
    let waiting = {}; // YAML files that came before a capture

    function showWaiting() {
        const names = KINDS.filter((kind) => waiting[kind]).map((kind) => `${kind}: ${waiting[kind].name}`);
        at("landing-kept").textContent = names.join(", ");
        tell(names.length > 0 ? NO_CAPTURE : "");
    }

    // Captures begin anew; YAML files alone are for what is shown.
    async function take({ files, folders = [] }) {
        if (folders.length > 0) {
            tell(`${folders[0]} ${FOLDER}`);
        }
        const captures = files.filter((file) => !isYaml(file) && !isArray(file)).sort(inTurn);
        const arrays = files.filter(isArray);
        const yaml = files.some(isYaml) ? await sortYaml(files.filter(isYaml)) : {};
        const given = Object.fromEntries(Object.entries(yaml).filter(([, value]) => value !== null));
        if (captures.length > 0) {
            await source.open({ captures, ...waiting, ...given });
            waiting = {};
        } else if (source.opened && files.length > arrays.length) {
            source.open({ ...source.opened, ...given });
        } else if (files.length > arrays.length) {
            waiting = { ...waiting, ...given };
            showWaiting();
        }
        arrays.forEach(takeArray);
    }

    async function offer({ yaml, sentence }) {
        const profile = { name: "profile.yaml", text: yaml };
        const choices = yaml ? { "Use it": "use", Close: null } : { Close: null };
        const keep = yaml ? { "Save profile.yaml": () => save(profile.name, yaml, "text/yaml") } : {};
        if ((await ask(sentence, choices, keep)) === "use") {
            source.open({ ...source.opened, profile });
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
    at("files").addEventListener("change", ({ target }) => {
        take({ files: [...target.files] });
        target.value = "";
    });
    document.addEventListener("dragover", (event) => {
        event.preventDefault();
        over(true);
    });
    document.addEventListener("dragleave", (event) => event.relatedTarget === null && over(false));
    document.addEventListener("drop", (event) => {
        event.preventDefault();
        over(false);
        take(filesOf(event.dataTransfer));
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
