// lumview's page: the parts and how they meet.
import * as THREE from "three";
import { makeAddress, parseAddress } from "./address.js";
import { makeBeside } from "./beside.js";
import { makeCamera } from "./camera.js";
import { makeCloud } from "./cloud.js";
import { chosenDomain, COLOURINGS, domainOf, nameSensors } from "./colouring.js";
import { extentOf } from "./extent.js";
import { count, makeFilter, NO_EYES, rangeOf } from "./filter.js";
import { letGo, makeFrames, viewOf } from "./frame.js";
import { attachKeys } from "./keys.js";
import { makeLayout } from "./layout.js";
import { makeLegend } from "./legend.js";
import { makeLight } from "./light.js";
import { GONE, LOST, REFUSED } from "./link.js";
import { showMoment } from "./moment.js";
import { attachOpen } from "./open.js";
import { makePace } from "./pace.js";
import { makePalette } from "./palette.js";
import { makePanel } from "./panel.js";
import { makePanes } from "./panes.js";
import { makePick, makeProjection } from "./pick.js";
import { makePictures } from "./pictures.js";
import { makePlayer } from "./player.js";
import { attachPointer } from "./pointer.js";
import { exposeProbe } from "./probe.js";
import { groundOf, makeScene } from "./scene.js";
import { makeSettings } from "./settings.js";
import { takeShot } from "./shot.js";
import { makeSource } from "./source.js";
import { makeStats } from "./stats.js";
import { makeTheme } from "./theme.js";
import { makeWorld } from "./world.js";

const at = (id) => document.getElementById(id);
const MOST_PIXELS = 4e7; // of a picture that is saved

// The cookie has the token; who sees the page or keeps its address has not.
if (location.search !== "") {
    history.replaceState(history.state, "", location.pathname + location.hash);
}

const opened = parseAddress(location.hash);
const settings = makeSettings(opened?.values);
const { values } = settings;
const canvas = at("canvas");
const renderer = makeRenderer();
const surroundings = makeScene();
const palette = makePalette(values.map);
const points = new THREE.Scene();
const cloud = makeCloud(points, palette);
const drawLit = makeLight(renderer, points, surroundings.scene);
const panes = makePanes(canvas, renderer);
const pace = makePace(renderer.getContext());
const drawLegend = makeLegend();
const showStats = makeStats();
const panel = makePanel(settings);
const layout = makeLayout(settings, resize);

let eyes = NO_EYES;
let hello = null;
let status = null;
let unpack = makeFrames(); // what comes
let waiting = null; // the newest frame that is no picture yet
let pasts = []; // of those before it
let isAsked = false; // a picture is due
let domain = [1, 100]; // of the colours, from the points
let ground = null; // height of the ground, from the points
let complaint = ""; // of files that could not be taken
let wantedFrame = opened?.frame ?? null; // the address asks for it; until it is shown, or the user goes elsewhere
let isSought = false; // lumview was asked for it
const tally = { received: 0, shown: 0, pictures: 0, drawn: 0 };
const address = makeAddress(() => ({ values, camera: camera.text, frame: standingFrame() }), (state) => {
    settings.replace(state.values);
    showCamera(state.camera);
    [wantedFrame, isSought] = [state.frame, false];
    seekWanted();
});
const camera = makeCamera(canvas, () => {
    pace.move(performance.now());
    address.changed();
    invalidate();
});

// Until another source is opened.
const tell = (sentence) => showMessage((complaint = sentence));
const world = makeWorld(surroundings.scene);
const beside = makeBeside({
    scene: surroundings.scene,
    cloud,
    panel,
    settings,
    changed: () => {
        placeFrames();
        recolour();
        invalidate();
    },
    tell,
});

function makeRenderer() {
    try {
        return new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    } catch (error) {
        showBanner("this browser offers no WebGL 2: lumview cannot draw");
        throw error;
    }
}

// What did not change is not set again: a screen reader would repeat it.
function showText(id, text) {
    if (at(id).textContent !== text) {
        at(id).textContent = text;
    }
    at(id).hidden = text === "";
}

function showBanner(text) {
    showText("banner", text);
}

const showMessage = (text) => showText("message", text);

// ---- pictures ----

function invalidate() {
    if (!isAsked) {
        isAsked = true;
        requestAnimationFrame(draw);
    }
}

function paint(colours) {
    renderer.setClearColor(colours.ground);
    surroundings.paint(colours);
    invalidate();
}

function recolour() {
    domain = domainOf(values, cloud.slots, eyes);
    const chosen = chosenDomain(values, domain);
    cloud.setDomain(chosen);
    drawLegend(values, domain, palette.bytes);
    pictures.strip.invalidate();
}

function placeGround() {
    surroundings.apply(values, values.ground ?? ground ?? 0);
}

function showFacts() {
    if (!cloud.newest) {
        return;
    }
    const { began } = cloud.newest;
    at("frame-number").textContent = cloud.title;
    showMoment(at("frame-time"), began);
    const counts = panes.names ? cloud.count() : [countPoints()];
    const lacks = missingSensors();
    const { share } = cloud.newest;
    const part = share < 1 ? ` (${Math.floor(100 * share)} %)` : "";
    at("frame-points").textContent = `${counts.map((n) => n.toLocaleString("en")).join(" | ")} points${part}${lacks && `, none of ${lacks}`}`;
}

// Of a rig those without a frame in the newest picture.
function missingSensors() {
    const { parts } = cloud.newest;
    const isMissing = (_, i) => parts.length > 0 && parts.every(({ sensor }) => sensor !== i);
    return (hello.rig?.sensors ?? []).filter(isMissing).join(", ");
}

// A picture that is held stays, unless other edges or smoothing are wanted: what
// a sensor sent is gone, so that is of the newest frame.
function isAwaited(frame) {
    const wanted = viewOf(values);
    return cloud.view !== wanted && viewOf(frame) === wanted;
}

// Whatever came while the page could not draw, only the newest is looked at, and
// those that are shown at once with it.
function takeNewest() {
    const frame = waiting;
    waiting = null;
    cloud.add(frame);
    tally.shown++;
    if (ground === null && frame.count > 0) {
        ground = groundOf(cloud.newest);
        placeGround();
        if (camera.text === null) { // nobody has moved it
            showCamera(null);
        }
    }
    if (frame.share === 1) {
        askPasts();
    }
}

function placeFrames() {
    beside.show(world.place(cloud, values.world));
}

function takeFrames() {
    if (waiting && !(player.held && !isAwaited(waiting))) {
        takeNewest();
    }
    if (cloud.current) {
        pasts.splice(0).forEach(cloud.addPast);
    }
    placeFrames();
    pictures.update();
    pick.check();
    showFacts();
    recolour();
}

function askPasts() {
    const missing = cloud.current ? cloud.missing(status?.first_frame ?? -Infinity) : 0;
    if (missing > 0) {
        link.send(`past ${cloud.newest.number} ${missing}`);
    }
}

// Each frame that is shown counts one more; those before it are asked for.
function takeFrame(frame) {
    const newest = waiting ?? cloud.current;
    const isPast = newest && ((frame.shown - newest.shown) | 0) < 0;
    if (!isPast) {
        waiting && letGo(waiting);
        waiting = frame;
    } else if (frame.share === 1) {
        pasts.push(frame);
    }
    invalidate();
}

function receive(buffer) {
    try {
        for (const frame of unpack(buffer)) {
            tally.received += frame.isNew;
            takeFrame(frame);
        }
    } catch (error) {
        showMessage(error.message);
    }
}

function render() {
    surroundings.prepare(camera);
    panes.render(cloud.choose, () => drawLit(camera.active, camera.distance, isLit()));
    tally.pictures++;
}

// While a slow machine moves the picture, it is drawn without light.
function isLit() {
    return values.edl === "auto" ? !(pace.isSlow && isMoving()) : values.edl === "on";
}

const countPoints = () => cloud.slots.reduce((n, slot) => n + slot.size, 0);

function isMoving() {
    return camera.dragged || pace.isMoving(performance.now());
}

// While the camera moves there is a picture after the other.
function draw(now) {
    isAsked = false;
    camera.tick(now);
    if (waiting || pasts.length > 0) {
        takeFrames();
    }
    const moves = isMoving();
    tally.drawn = cloud.thin(pace.stride(now, countPoints(), moves));
    render();
    pictures.follow();
    if (moves) {
        invalidate();
    } else {
        pictures.draw();
    }
}

// Draws so many pixels to one of the page.
function sharpen(ratio) {
    const [width, height] = [at("view").clientWidth, at("view").clientHeight];
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
    cloud.apply(values, ratio, height);
}

function resize() {
    const [width, height] = [at("view").clientWidth, at("view").clientHeight];
    sharpen(Math.min(2, window.devicePixelRatio));
    const covered = panes.names ? { left: 0, right: 0 } : layout.covered(width);
    camera.resize({ width: Math.max(1, panes.width), height: Math.max(1, height), isPane: panes.names !== null, ...covered });
}

const view = (name) => settings.set({ flat: camera.show(name, extentOf(cloud.newest, eyes)) });

// ---- the address ----

// Where a capture stands still, its frame is a part of what is seen.
function standingFrame() {
    const stands = status && !status.live && (status.state === "paused" || status.state === "ended");
    return wantedFrame ?? (stands ? status.frame : null);
}

// text: of an address; null: the view from the start.
function showCamera(text) {
    camera.show("home", extentOf(cloud.newest, eyes));
    camera.setFlat(values.flat);
    camera.take(text ?? "", values.flat);
}

// The frame that the address names is shown, and stands.
function seekWanted() {
    if (wantedFrame === null || !status || !link.connected) {
        return;
    }
    if (status.last_frame !== null) { // there is no other
        wantedFrame = Math.max(status.first_frame ?? wantedFrame, Math.min(status.last_frame, wantedFrame));
    }
    if (status.live || (status.frame === wantedFrame && status.state !== "playing")) {
        wantedFrame = null;
    } else if (!isSought) {
        isSought = true;
        link.send("pause");
        link.send(`seek ${wantedFrame}`);
    }
}

// A command of the user; it may lead away from the frame of the address.
function sendByUser(text) {
    wantedFrame = null;
    link.send(text);
}

// ---- the server ----

function sendView() {
    link.send(`view ${viewOf(values)}`);
}

function sendFrames() {
    link.send(`frames ${values.accumulate}`);
}

function greet(message) {
    hello = message;
    const names = message.rig?.sensors ?? null;
    eyes = message.eyes.map((eye, i) => ({ ...eye, sensor: names?.[i >> 1] ?? null }));
    nameSensors(names ?? []);
    panel.setSensors(names);
    player.clear();
    pictures.greet(message);
    ground = null;
    unpack = makeFrames();
    waiting = null;
    pasts = [];
    cloud.refresh();
    cloud.setEyes(eyes);
    nameSource(message.source, message.live);
    panel.setSmoothings(message.smooth_max);
    beside.greet(message);
    world.greet(message);
    panes.show(message.profiles);
    resize();
    sendView();
    sendFrames();
}

function nameSource(source, isLive) {
    const name = isLive ? source : source.split("/").at(-1);
    at("source").textContent = name;
    at("source").title = source;
    document.title = `${name} - lumview`;
}

// Another capture: nothing of the one before stays.
function startAnew({ captures }) {
    [status, waiting, pasts, ground] = [null, null, [], null];
    cloud.clear();
    pick.clear();
    pictures.clear();
    beside.clear();
    world.clear();
    complaint = "";
    showBanner("");
    showMessage("");
    player.clear();
    showStats(null);
    ["frame-number", "frame-time", "frame-points"].forEach((id) => (at(id).textContent = ""));
    nameSource(captures.map(({ name }) => name).join(", "));
    showState("opening", "waiting");
    opener?.opening();
    invalidate();
}

function showState(text, state) {
    showText("state", text);
    at("state").dataset.state = state;
}

function showStatus(message) {
    status = message;
    showState(player.held ? "held" : message.state, player.held ? "held" : message.state);
    showMessage([message.message, complaint, world.sentence, beside.sentence].filter(Boolean).join("; "));
    showStats(message);
    player.show(message);
    seekWanted();
    address.changed();
    opener?.show(message);
}

const onText = { hello: greet, status: showStatus };

const link = makeSource({
    text: (message) => onText[message.type]?.(message),
    binary: receive,
    up: () => showBanner(""),
    failed(sentence) {
        showBanner(sentence);
        showState("failed", "failed");
        opener?.failed();
    },
    opening: startAnew,
    inferred: (found) => opener.inferred(found),
    down(seconds, isRefused) {
        showBanner(`${isRefused ? REFUSED : GONE} in ${seconds.toFixed(1)} s`);
        showState("no connection", "gone");
    },
});
const opener = link.open ? attachOpen(link, tell, beside.takeFrom) : null;
if (opener && !link.opened) {
    showState("", "");
}

// ---- what the user does ----

const player = makePlayer(sendByUser, () => {
    showStatus(status);
    invalidate();
});

const mark = (...positions) => {
    surroundings.mark(...positions);
    pictures.strip.mark();
    invalidate();
};
const pick = makePick({ canvas, camera, panes, cloud, settings, eyes: () => eyes, mark });

const shownFrames = () => (cloud.newest ? cloud.title : "no frame");

const pictures = makePictures({
    canvas,
    camera,
    panes,
    cloud,
    settings,
    pick,
    invalidate,
    state: () => ({ hello, eyes, domain: chosenDomain(values, domain), bytes: palette.bytes }),
    about: () => ({ name: `lumview-${cloud.newest?.number ?? 0}`, frames: shownFrames() }),
});

// Pictures have twice as many pixels each way, as far as the browser draws so many.
function pictureRatio() {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const most = Math.min(renderer.capabilities.maxTextureSize / Math.max(width, height), Math.sqrt(MOST_PIXELS / width / height));
    return Math.max(renderer.getPixelRatio(), Math.min(2 * renderer.getPixelRatio(), most));
}

function shot() {
    cloud.thin(1);
    const ratio = renderer.getPixelRatio();
    sharpen(pictureRatio());
    const source = at("source").textContent;
    takeShot({
        canvas,
        render,
        values,
        domain,
        bytes: palette.bytes,
        caption: `${source}, ${shownFrames()}${panes.names ? `: ${panes.names.join(" | ")}` : ""}`,
        name: `lumview-${cloud.newest?.number ?? 0}.png`,
        tell,
    });
    sharpen(ratio);
    invalidate();
}

settings.onChange((changed) => {
    address.changed();
    if (changed.has("map")) {
        palette.use(values.map);
    }
    if (changed.has("edges") || changed.has("smooth")) {
        sendView();
    }
    cloud.apply(values, renderer.getPixelRatio(), canvas.clientHeight);
    if (changed.has("accumulate")) {
        sendFrames();
        askPasts();
        showFacts();
    }
    placeFrames();
    pictures.update();
    pick.check();
    if (changed.has("flat")) {
        camera.setFlat(values.flat);
    }
    placeGround();
    recolour();
    invalidate();
});

for (const name of ["home", "top", "front", "sensor"]) {
    at(`view-${name}`).addEventListener("click", () => view(name));
}
// Not by the address: that has the state.
document.querySelector(".skip").addEventListener("click", (event) => {
    event.preventDefault();
    settings.set({ panel: true });
    at("panel").focus();
});
at("shot").addEventListener("click", shot);
at("help-open").addEventListener("click", () => at("help").showModal());
attachPointer(canvas, camera, {
    click: pick.at,
    doubleClick: (x, y) => pick.find(x, y, camera.turnAbout),
    reach: (x, y) => pick.find(x, y, camera.reachTo),
});
attachKeys({
    camera,
    settings,
    panel,
    player,
    view,
    shot,
    pickMiddle: () => pick.at(...camera.middle()),
    turnAboutMiddle: () => pick.find(...camera.middle(), camera.turnAbout),
    measure: pick.measure,
    drawBox: pictures.begin,
    showAll: pictures.selection.showAll,
    closePick: () => pictures.escape() || pick.clear(),
    focusCanvas: () => canvas.focus(),
    toggle: layout.toggle,
    help: () => at("help").showModal(),
    openFiles: () => opener?.choose(),
});
canvas.addEventListener("webglcontextlost", () => showBanner(LOST));
canvas.addEventListener("webglcontextrestored", () => {
    showBanner("");
    invalidate();
});
new ResizeObserver(resize).observe(at("view"));

exposeProbe({
    connected: () => link.connected,
    frame: () => cloud.newest?.number ?? null,
    began: () => structuredClone(cloud.newest?.began ?? null),
    smooth: () => cloud.newest?.smooth ?? null,
    share: () => cloud.newest?.share ?? null,
    shown: () => tally.shown,
    received: () => tally.received,
    pictures: () => tally.pictures,
    drawn: () => tally.drawn,
    lit: isLit,
    moving: isMoving,
    points: countPoints,
    sides: () => cloud.count(),
    counts: () => () => count(cloud.slots, values, eyes),
    camera: () => camera.look,
    settings: () => () => ({ ...values }),
    status: () => () => structuredClone(status),
    hello: () => () => structuredClone(hello),
    domain: () => () => [...chosenDomain(values, domain)],
    picked: () => () => structuredClone(pick.picked),
    distance: () => () => structuredClone(pick.distance),
    selection: () => () => structuredClone(pictures.selection.numbers()),
    strip: () => pictures.strip.probe,
    place: () => placeOf,
    positions: () => () => ({ step: cloud.newest.step, xyz: cloud.newest.points.xyz.slice(0, 3 * cloud.newest.size) }),
    beside: () => () => ({ labels: [...COLOURINGS.label.labels], truth: beside.shown }),
    memory: () => () => ({ ...renderer.info.memory, programs: renderer.info.programs.length }),
});

function placeOf(i) {
    const out = {};
    const project = makeProjection(camera.active, panes.width, canvas.clientHeight);
    const isInside = project(cloud.newest.points.xyz, i, out) && out.x >= 0 && out.x < panes.width;
    const visible = isInside && makeFilter(values, eyes)(cloud.newest.points, i);
    const x = out.x + panes.left(panes.names && i >= cloud.newest.split ? 1 : 0);
    return { x, y: out.y, depth: out.depth, visible, range: rangeOf(cloud.newest.points, i, eyes) };
}

makeTheme(settings, paint);
placeGround();
layout.apply();
showCamera(opened?.camera);
