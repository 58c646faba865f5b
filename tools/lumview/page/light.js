// Eye-dome lighting: a second pass darkens what lies behind its surroundings,
// so that edges, kerbs and windows show without lamps and normals. The points
// are drawn to a picture of their own with its depth; what stands around them
// is drawn on the page behind or before them, and is not shaded.
import * as THREE from "three";

const RADIUS = 1.4; // pixels of the page, between a pixel and those it is compared with
const STRENGTH = 45;
const LEAST = 0.28; // of a colour stays, however deep it lies

const VERTEX = `
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// The value in the depth buffer changes evenly over a plane, in perspective and
// in parallel projection: a pixel in the middle between two is as deep as both
// in the mean, unless there is an edge. steep says how much a difference means.
const FRAGMENT = `
uniform highp sampler2D depth;
uniform sampler2D colours;
uniform vec2 origin;
uniform vec2 size;
uniform float radius;
uniform vec2 steep;

float depthAt(vec2 at)
{
    return texelFetch(depth, ivec2(clamp(at, vec2(0.0), size - 1.0)), 0).x;
}

float hidden(float own, vec2 at, vec2 aside)
{
    float a = depthAt(at + aside);
    float b = depthAt(at - aside);
    float between = 0.5 * ((a == 1.0 ? own : a) + (b == 1.0 ? own : b));
    return max(0.0, own - between) + 0.12 * (max(0.0, own - a) + max(0.0, own - b));
}

void main()
{
    vec2 at = gl_FragCoord.xy - origin;
    float own = depthAt(at);
    if (own == 1.0) { discard; }
    float sum = hidden(own, at, vec2(radius, 0.0)) + hidden(own, at, vec2(0.0, radius)) +
          hidden(own, at, 0.7 * vec2(radius, radius)) + hidden(own, at, 0.7 * vec2(radius, -radius));
    float shade = exp(-sum / (steep.x - steep.y * own));
    vec3 colour = texelFetch(colours, ivec2(at), 0).rgb;
    gl_FragColor = vec4(colour * mix(LEAST, 1.0, shade), 1.0);
    gl_FragDepth = own;
}`;

function makeQuad(uniforms) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    const material = new THREE.ShaderMaterial({
        uniforms,
        defines: { LEAST },
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        depthFunc: THREE.AlwaysDepth,
    });
    const quad = new THREE.Mesh(geometry, material);
    quad.frustumCulled = false;
    quad.renderOrder = -1;
    quad.visible = false;
    return quad;
}

// What a difference of depth is divided by, as a and b of a - b * depth: what
// lies as far behind, as a share of its distance from the camera.
function steepOf({ near, far, isPerspectiveCamera }, metres) {
    return isPerspectiveCamera ? [far / (far - near) / STRENGTH, 1 / STRENGTH] : [metres / (far - near) / STRENGTH, 0];
}

// points: a scene of their own; around: what else there is.
export function makeLight(renderer, points, around) {
    const target = new THREE.WebGLRenderTarget(1, 1, { magFilter: THREE.NearestFilter, minFilter: THREE.NearestFilter });
    target.depthTexture = new THREE.DepthTexture(1, 1, THREE.UnsignedIntType);
    const uniforms = {
        depth: { value: target.depthTexture },
        colours: { value: target.texture },
        origin: { value: new THREE.Vector2() },
        size: { value: new THREE.Vector2() },
        radius: { value: 1 },
        steep: { value: new THREE.Vector2() },
    };
    const quad = makeQuad(uniforms);
    const box = new THREE.Vector4();
    around.add(quad);
    renderer.autoClear = false;

    function drawPoints(camera, metres) {
        renderer.getCurrentViewport(box);
        const [width, height] = [box.z, box.w].map((v) => Math.max(1, Math.round(v)));
        target.setSize(width, height);
        renderer.setRenderTarget(target);
        renderer.clear();
        renderer.render(points, camera);
        renderer.setRenderTarget(null);
        uniforms.origin.value.set(box.x, box.y);
        uniforms.size.value.set(width, height);
        uniforms.radius.value = Math.max(1, RADIUS * renderer.getPixelRatio());
        uniforms.steep.value.fromArray(steepOf(camera, metres));
    }

    // One pane. metres: how far away what the camera looks at is.
    return function render(camera, metres, isLit) {
        if (isLit) {
            drawPoints(camera, metres);
        }
        renderer.setClearAlpha(1); // its colour is that of the page again, not the target's
        renderer.clear();
        if (!isLit) {
            renderer.render(points, camera);
        }
        quad.visible = isLit;
        renderer.render(around, camera);
    };
}
