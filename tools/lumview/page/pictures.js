// What stands beside the cloud: the strip of pictures, and the points that a box
// in either selects; how they and the cloud hear of each other.
import { makeBox } from "./box.js";
import { cloudVolume, imageVolume, makeSelection } from "./selection.js";
import { makeCsv, makePly, save } from "./save.js";
import { describe, makeProjection } from "./pick.js";
import { makeStrip } from "./strip.js";

const REST = 4; // looking under the pointer takes at most one part of so many of the time
const at = (id) => document.getElementById(id);

// Which point is under the pointer in the cloud; told(found): { slot, index }, or null.
function attachHover(canvas, isWanted, find, told) {
    let last = null; // where the pointer is
    let timer = null;

    function look() {
        timer = null;
        if (!last || !isWanted()) {
            return;
        }
        const begun = performance.now();
        told(find(...last));
        const took = performance.now() - begun;
        last = null;
        timer = setTimeout(look, REST * took);
    }

    canvas.addEventListener("pointermove", (event) => {
        const box = canvas.getBoundingClientRect();
        last = event.buttons === 0 ? [event.clientX - box.left, event.clientY - box.top] : null;
        timer ??= setTimeout(look, 0);
    });
    canvas.addEventListener("pointerleave", () => {
        last = null;
        told(null);
    });
}

// app: the parts of the page, and state(): { hello, domain, bytes, eyes } as they are.
export function makePictures({ canvas, camera, panes, cloud, settings, pick, state, about, invalidate }) {
    const { values } = settings;
    let sensor = 0; // of a rig, whose pictures these are
    let source = null;
    let hovered = null; // { slot, filling, index }: the point under the pointer in the strip

    // Over the picture, which is not drawn again for it.
    function follow() {
        const out = {};
        const isThere = hovered !== null && hovered.slot.filling === hovered.filling &&
            makeProjection(camera.active, panes.width, canvas.clientHeight)(hovered.slot.points.xyz, hovered.index, out) &&
            out.x >= 0 && out.x < panes.width && out.y >= 0 && out.y < canvas.clientHeight;
        at("hover").hidden = !isThere;
        if (isThere) {
            [at("hover").style.left, at("hover").style.top] = [`${out.x}px`, `${out.y}px`];
        }
    }

    const strip = makeStrip({
        hover(i) {
            hovered = i >= 0 ? { slot: strip.slot, filling: strip.slot.filling, index: i } : null;
            follow();
        },
        pick: (i, isEnd) => pick.take(i >= 0 ? { slot: strip.slot, index: i } : null, isEnd),
        picked: (slot) => pick.indexIn(slot),
        describe: (slot, index) => describe({ slot, index }, state().eyes),
    });

    const selection = makeSelection({
        cloud,
        settings,
        eyes: () => state().eyes,
        changed() {
            self.update();
            pick.check();
            invalidate();
        },
    });

    function takeFromCloud({ left, top, right, bottom }) {
        const { side } = panes.find(left);
        const [across, down] = [panes.width, canvas.clientHeight];
        const share = (x) => Math.max(0, Math.min(1, (x - panes.left(side)) / across));
        const box = { left: share(left), right: share(right), top: top / down, bottom: bottom / down };
        selection.take(cloudVolume(camera.active, box, side));
    }

    function takeFromStrip(box) {
        if (strip.isShown) {
            const { image } = strip;
            selection.take(imageVolume(image, strip.cellsOf(box), image.sight, image.sensor));
        }
    }

    function showMode(isOn) {
        at("box-begin").setAttribute("aria-pressed", String(isOn));
        at("box-hint").hidden = !isOn;
    }

    const boxes = [
        makeBox(canvas, at("box"), { box: takeFromCloud, mode: showMode }),
        makeBox(strip.canvas, at("strip-box"), { box: takeFromStrip, mode: showMode }, true),
    ];

    function begin() {
        const isOn = boxes.some((box) => box.isOn);
        const isStrip = document.activeElement === strip.canvas;
        boxes.forEach((box) => box.end());
        if (!isOn) {
            boxes[Number(isStrip)].begin(isStrip ? strip.cursor : undefined);
        }
    }

    // The selection, or all that is shown.
    function saveAs(kind) {
        const { hello, eyes } = state();
        const { name, frames } = about();
        const has = { isRig: Boolean(hello?.rig), isLabelled: cloud.isLabelled };
        const head = {
            program: `lumview ${hello?.version ?? ""}`.trim(),
            source: hello?.source ?? "",
            frames,
            step: cloud.newest?.step ?? 0,
            seenFrom: cloud.slots.some(({ placed }) => placed !== "") ? cloud.newest.number : null,
        };
        const parts = kind === "csv" ? makeCsv({ each: selection.each, eyes, has }) : makePly({ each: selection.each, eyes, has, about: head });
        save(parts, kind === "csv" ? "text/csv" : "application/octet-stream", `${name}.${kind}`);
    }

    for (const kind of ["csv", "ply"]) {
        [`save-${kind}`, `selection-${kind}`].forEach((id) => at(id).addEventListener("click", () => saveAs(kind)));
    }
    at("box-begin").addEventListener("click", begin);
    at("strip-close").addEventListener("click", () => settings.set({ strip: false }));
    at("strip-sensor").addEventListener("change", () => {
        sensor = Number(at("strip-sensor").value);
        self.update();
        invalidate();
    });
    settings.onReset(selection.showAll);
    attachHover(canvas, () => strip.isShown && !camera.dragged, pick.under, (found) => strip.hover(found?.slot ?? null, found?.index ?? -1));

    const self = {
        selection,
        strip,
        begin,
        // A selection is of the source that it was made in.
        greet({ source: next, rig }) {
            const names = rig?.sensors;
            if (next !== source) {
                selection.showAll();
            }
            [source, sensor] = [next, 0];
            at("strip-sensor").replaceChildren(...(names ?? []).map((name, i) => new Option(name, String(i))));
            at("strip-sensor-of").hidden = (names ?? []).length < 2;
        },
        // Another source.
        clear() {
            hovered = null;
            strip.clear();
            self.update();
        },
        // Frames, settings or colours changed.
        update() {
            selection.update();
            strip.invalidate();
        },
        // After each picture of the cloud.
        follow,
        // After those while the camera stands still.
        draw() {
            const { hello, domain, bytes, eyes } = state();
            strip.draw({ slot: cloud.newest, hello, sensor, values, domain, bytes, eyes, fades: selection.isOn });
        },
        // Ends a box that is drawn, or else the selection; returns whether there was one.
        escape() {
            const isOn = boxes.some((box) => box.isOn);
            boxes.forEach((box) => box.end());
            if (!isOn) {
                selection.clear();
            }
            return isOn;
        },
    };
    return self;
}
