// Colours of points: two maps as a texture, and colours for eyes and sensors.
import { DataTexture, LinearFilter } from "three";

// Each eighth colour of the maps' 256, from dark to bright; between them colours change evenly. Both are free of rights (CC0).
const SAMPLES = {
    viridis:
        "440154470d6048186a482374472d7b4536814240863f49893b528b375a8d33638d2f6a8e2c728e297a8e26818e23898e21908c" +
        "1f988b1f9f8821a68528ae8031b57b3ebc744cc26c5dc9636ece5882d34c96d83fabdc32c0df24d5e21aeae51afde725",
    cividis:
        "00224e00285b002e6a0433711a386f273e6e32436d3b496c434e6c4b546c52596d5a5f6e61656f686a716f70737576767c7b78" +
        "8481798b8778938d789b9376a39a75aba072b3a670bbad6cc3b469ccba64d4c15fddc958e6d051efd748f8df3cfee838",
};
export const STEPS = 256;
export const EYES = { blue: [0.42, 0.68, 1.0], green: [0.45, 0.9, 0.5] };
// Of the sensors of a rig, as many as it can have.
export const SENSORS = [
    [0.42, 0.68, 1.0], [1.0, 0.62, 0.26], [0.45, 0.9, 0.5], [0.95, 0.45, 0.75],
    [0.98, 0.9, 0.4], [0.65, 0.5, 1.0], [0.35, 0.9, 0.9], [1.0, 0.42, 0.38],
];
// Of labels, in turn.
export const LABELS = [
    [0.62, 0.55, 0.45], [0.42, 0.68, 1.0], [1.0, 0.42, 0.38], [1.0, 0.62, 0.26], [0.95, 0.45, 0.75], [0.98, 0.9, 0.4],
    [0.45, 0.9, 0.5], [0.35, 0.9, 0.9], [0.65, 0.5, 1.0], [0.85, 0.87, 0.9],
];
export const UNKNOWN = [0.5, 0.53, 0.58];
export const FADED = 0.85; // how grey points are beside a selection

// The darkest parts of the maps would not show on the dark ground.
const SHARE = { viridis: [0.12, 1], cividis: [0.15, 1] };

// A map's colour at a share of it, 0 to 255 each.
export function colourOf(name, share) {
    const samples = SAMPLES[name];
    const place = share * (samples.length / 6 - 1);
    const first = Math.min(Math.floor(place), samples.length / 6 - 2);
    return [0, 2, 4].map((k) => {
        const [a, b] = [first, first + 1].map((n) => parseInt(samples.slice(6 * n + k, 6 * n + k + 2), 16));
        return Math.round(a + (b - a) * (place - first));
    });
}

function bytesOf(name) {
    const bytes = new Uint8Array(4 * STEPS);
    const [first, last] = SHARE[name];
    for (let i = 0; i < STEPS; i++) {
        bytes.set([...colourOf(name, first + ((last - first) * i) / (STEPS - 1)), 255], 4 * i);
    }
    return bytes;
}

export function makePalette(name) {
    const texture = new DataTexture(bytesOf(name), STEPS, 1);
    texture.magFilter = LinearFilter;
    texture.minFilter = LinearFilter;
    texture.needsUpdate = true;
    return {
        texture,
        get bytes() {
            return texture.image.data;
        },
        use(next) {
            texture.image.data.set(bytesOf(next));
            texture.needsUpdate = true;
        },
    };
}
