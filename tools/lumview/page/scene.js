// What stands around the points: grid, range rings with numbers, the axes of
// the sensor, marks at picked points and the line between them.
import * as THREE from "three";

const GRID_METRES = 150;
const GRID_CELL = 10;
const RINGS = [5, 10, 20, 30, 40, 50, 75, 100, 150, 200, 250];
const RING_PARTS = 180;

function lines(positions) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
}

function makeGrid() {
    const positions = [];
    for (let v = -GRID_METRES; v <= GRID_METRES; v += GRID_CELL) {
        positions.push(v, -GRID_METRES, 0, v, GRID_METRES, 0, -GRID_METRES, v, 0, GRID_METRES, v, 0);
    }
    return lines(positions);
}

function ringLines() {
    const positions = [];
    const point = (radius, part) => {
        const angle = (2 * Math.PI * part) / RING_PARTS;
        positions.push(radius * Math.cos(angle), radius * Math.sin(angle), 0);
    };
    for (const radius of RINGS) {
        for (let i = 0; i < RING_PARTS; i++) {
            point(radius, i);
            point(radius, i + 1);
        }
    }
    return lines(positions);
}

// A text or a sign that keeps its size on the page.
function sprite(width, height, draw) {
    const canvas = document.createElement("canvas");
    const scale = 2;
    canvas.width = width * scale;
    canvas.height = height * scale;
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    draw(pen);
    const map = new THREE.CanvasTexture(canvas);
    map.colorSpace = THREE.SRGBColorSpace;
    map.userData = { pen };
    const made = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, transparent: true }));
    made.userData = { width, height };
    made.renderOrder = 2;
    return made;
}

function writeMiddle(pen, text, width, height, { halo, text: colour }) {
    pen.clearRect(0, 0, width, height);
    pen.font = "600 12px system-ui, 'DejaVu Sans', sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = halo;
    pen.strokeText(text, width / 2, height / 2);
    pen.fillStyle = colour;
    pen.fillText(text, width / 2, height / 2);
}

// Writes on a sprite anew.
function write(made, text, colours) {
    const { map } = made.material;
    writeMiddle(map.userData.pen, text, made.userData.width, made.userData.height, colours);
    map.needsUpdate = true;
}

function makeRings() {
    const group = new THREE.Group();
    group.add(ringLines());
    for (const radius of RINGS) {
        const label = sprite(60, 18, () => {});
        label.userData.text = `${radius} m`;
        label.position.set(radius, 0, 0);
        group.add(label);
    }
    return group;
}

function makeAxes() {
    const group = new THREE.Group();
    group.add(lines([0, 0, 0, 1, 0, 0]), lines([0, 0, 0, 0, 1, 0]), lines([0, 0, 0, 0, 0, 1]));
    return group;
}

function makeMark() {
    const mark = sprite(26, 26, (pen) => {
        for (const [color, width] of [["#000", 5], ["#fff", 2]]) {
            pen.strokeStyle = color;
            pen.lineWidth = width;
            pen.beginPath();
            pen.arc(13, 13, 9, 0, 2 * Math.PI);
            pen.stroke();
        }
    });
    mark.visible = false;
    mark.renderOrder = 3;
    return mark;
}

// The line of a distance, with its length.
function makeRuler() {
    const ruler = lines([0, 0, 0, 0, 0, 0]);
    const label = sprite(90, 20, () => {});
    ruler.material.depthTest = false;
    ruler.material.transparent = true;
    ruler.frustumCulled = false;
    ruler.visible = false;
    ruler.renderOrder = 2;
    label.renderOrder = 4;
    label.center.set(0.5, -0.4);
    ruler.add(label);
    let colours = null;
    let length = "";
    return {
        ruler,
        label,
        paint(next) {
            colours = next;
            ruler.material.color.set(colours.ruler);
            write(label, length, colours);
        },
        show(from, to) {
            ruler.visible = Boolean(from && to);
            if (!ruler.visible) {
                return;
            }
            ruler.geometry.attributes.position.set([...from, ...to]);
            ruler.geometry.attributes.position.needsUpdate = true;
            label.position.fromArray(from.map((v, k) => (v + to[k]) / 2));
            length = `${Math.hypot(...from.map((v, k) => v - to[k])).toFixed(3)} m`;
            write(label, length, colours);
        },
    };
}

function placeMark(mark, position) {
    mark.visible = Boolean(position);
    if (position) {
        mark.position.fromArray(position);
    }
}

export function makeScene() {
    const scene = new THREE.Scene();
    const grid = makeGrid();
    const rings = makeRings();
    const [mark, other] = [makeMark(), makeMark()];
    const axes = makeAxes();
    const { ruler, label: length, show: showRuler, paint: paintRuler } = makeRuler();
    scene.add(grid, rings, axes, mark, other, ruler);
    const place = new THREE.Vector3();

    function keepSize(sign, camera) {
        const metres = camera.metresOfPixel(sign.getWorldPosition(place));
        sign.scale.set(sign.userData.width * metres, sign.userData.height * metres, 1);
    }

    // Numbers that would cover the one before are left out.
    function spaceLabels(camera) {
        let last = null;
        for (const label of rings.children.filter((child) => child.isSprite)) {
            keepSize(label, camera);
            const at = camera.pageOf(place);
            label.visible = last === null || Math.abs(at.x - last.x) > 50 || Math.abs(at.y - last.y) > 17;
            last = label.visible ? at : last;
        }
    }

    return {
        scene,
        // colours: those of a theme.
        paint(colours) {
            grid.material.color.set(colours.grid);
            axes.children.forEach((axis, i) => axis.material.color.set(colours.axes[i]));
            paintRuler(colours);
            for (const child of rings.children) {
                if (child.isSprite) {
                    write(child, child.userData.text, colours);
                } else {
                    child.material.color.set(colours.rings);
                }
            }
        },
        apply(values, ground) {
            grid.visible = values.grid;
            rings.visible = values.rings;
            grid.position.z = ground;
            rings.position.z = ground + 0.01;
        },
        // The picked point, and the one from which its distance is taken.
        mark(from, position) {
            placeMark(mark, position);
            placeMark(other, from);
            showRuler(from, position);
        },
        // Before each picture.
        prepare(camera) {
            spaceLabels(camera);
            [mark, other, length].forEach((sign) => keepSize(sign, camera));
        },
    };
}

const BIN = 0.1; // metres

// Where the ground lies: the height of most points below the sensor.
export function groundOf({ points, split }) {
    const bins = new Map();
    for (let i = 0; i < split; i += 7) {
        const bin = Math.round(points.xyz[3 * i + 2] / BIN);
        if (bin < 0) {
            bins.set(bin, (bins.get(bin) ?? 0) + 1);
        }
    }
    const most = [...bins].reduce((best, bin) => (bin[1] > best[1] ? bin : best), [0, 0]);
    return most[0] * BIN;
}
