// Where the sensor was, by the poses of the greeting: frames that are shown at once stand where they were taken, as seen from
// the newest one, and the path is drawn. Without poses nothing is moved.
import * as THREE from "three";

const GAP_S = 1; // no pose is found between two that are farther apart
const SLACK_S = 1e-5; // times are rounded
const PATH_COLOUR = 0x6fd3e3;

// rows: [seconds, x, y, z, qx, qy, qz, qw], by time. A function of a time: the matrix of the sensor in the world; null: none.
function makeLookUp(rows) {
    const [one, other] = [new THREE.Quaternion(), new THREE.Quaternion()];
    const [from, to, unit] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3(1, 1, 1)];

    // The first row that is not before a time.
    function search(time) {
        let [low, high] = [0, rows.length];
        while (low < high) {
            const middle = (low + high) >> 1;
            [low, high] = rows[middle][0] < time ? [middle + 1, high] : [low, middle];
        }
        return low;
    }

    return (time) => {
        const next = search(time - SLACK_S);
        const [a, b] = [rows[Math.max(0, next - 1)], rows[next]];
        if (!b || b[0] - a[0] > GAP_S || !(time >= a[0] - SLACK_S)) { // a time that is not known is NaN
            return null;
        }
        const share = b === a ? 0 : Math.max(0, Math.min(1, (time - a[0]) / (b[0] - a[0])));
        from.fromArray(a, 1).lerp(to.fromArray(b, 1), share);
        one.fromArray(a, 4).slerp(other.fromArray(b, 4), share);
        return new THREE.Matrix4().compose(from, one, unit);
    };
}

// Floats hold places near the path's beginning.
function makePath(rows) {
    const [, ...origin] = rows[0].slice(0, 4);
    const geometry = new THREE.BufferGeometry();
    const places = rows.flatMap((row) => origin.map((v, k) => row[1 + k] - v));
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
    const object = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: PATH_COLOUR }));
    object.frustumCulled = false;
    object.matrixAutoUpdate = false;
    return { object, shift: new THREE.Matrix4().makeTranslation(...origin) };
}

export function makeWorld(scene) {
    let find = null;
    let path = null;
    let isUtc = false;
    let lacking = ""; // a sentence

    const timeOf = ({ clock, began }) => (isUtc ? began?.utc : clock * 1e-6);
    const poseOf = (slot) => find(timeOf(slot) ?? NaN);

    function drop() {
        if (path) {
            scene.remove(path.object);
            path.object.geometry.dispose();
        }
        [find, path, lacking] = [null, null, ""];
    }

    function placeAll(cloud, here) {
        const back = here.clone().invert();
        const past = cloud.slots.slice(0, -1).map((slot) => [slot, poseOf(slot)]);
        past.forEach(([slot, pose]) => cloud.place(slot, pose && pose.premultiply(back)));
        lacking = past.some(([, pose]) => !pose) ? "frames without a pose stand as if the sensor had not moved" : "";
        path.object.matrix.multiplyMatrices(back, path.shift);
        path.object.matrixWorldNeedsUpdate = true;
        return back;
    }

    return {
        greet({ poses }) {
            drop();
            if (poses?.rows.length > 0) {
                find = makeLookUp(poses.rows);
                isUtc = poses.utc;
                path = makePath(poses.rows);
                scene.add(path.object);
            }
            const row = document.getElementById("world-row");
            row.hidden = !find;
            row.title = poses?.every > 1 ? `There are so many poses that one of every ${poses.every} is taken.` : "";
        },
        clear: drop,
        // The world as seen from the newest frame; null: the frame's place is not known.
        place(cloud, isOn) {
            const here = find && isOn && cloud.newest ? poseOf(cloud.newest) : null;
            if (path) {
                path.object.visible = Boolean(here);
            }
            if (here) {
                return placeAll(cloud, here);
            }
            lacking = find && isOn && cloud.newest ? "the poses have none for this frame" : "";
            cloud.slots.forEach((slot) => cloud.place(slot, null));
            return null;
        },
        get sentence() {
            return lacking;
        },
    };
}
