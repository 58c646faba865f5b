// Colours of points: three maps as a texture, and colours for eyes and sensors.
import { interpolateCividis, interpolateTurbo, interpolateViridis } from "d3-scale-chromatic";
import { rgb } from "d3-color";
import { DataTexture, LinearFilter } from "three";

const MAPS = { turbo: interpolateTurbo, viridis: interpolateViridis, cividis: interpolateCividis };
export const STEPS = 256;
export const EYES = { blue: [0.42, 0.68, 1.0], green: [0.45, 0.9, 0.5] };
// Of the sensors of a rig, as many as it can have.
export const SENSORS = [
    [0.42, 0.68, 1.0], [1.0, 0.62, 0.26], [0.45, 0.9, 0.5], [0.95, 0.45, 0.75],
    [0.98, 0.9, 0.4], [0.65, 0.5, 1.0], [0.35, 0.9, 0.9], [1.0, 0.42, 0.38],
];
export const UNKNOWN = [0.5, 0.53, 0.58];

// The darkest parts of the maps would not show on the dark ground.
const SHARE = { turbo: [0.1, 0.95], viridis: [0.12, 1], cividis: [0.15, 1] };

function bytesOf(name) {
    const bytes = new Uint8Array(4 * STEPS);
    const [first, last] = SHARE[name];
    for (let i = 0; i < STEPS; i++) {
        const c = rgb(MAPS[name](first + ((last - first) * i) / (STEPS - 1)));
        bytes.set([c.r, c.g, c.b, 255], 4 * i);
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
