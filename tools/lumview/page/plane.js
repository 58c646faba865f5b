// What is told of many points: how many, between which coordinates, and the
// plane that fits them best.

const SWEEPS = 20; // far more than three by three numbers need
const ROUND = 1e-4; // of the length of a line: thinner than this is a line

// The eigenvalues of a symmetric matrix of three by three, the smallest first,
// with their vectors, by Jacobi's turns.
export function eigen(matrix) {
    const a = matrix.map((row) => [...row]);
    const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const off = () => a[0][1] ** 2 + a[0][2] ** 2 + a[1][2] ** 2;
    for (let sweep = 0; sweep < SWEEPS && off() > 0; sweep++) {
        [[0, 1], [0, 2], [1, 2]].forEach(([p, q]) => turn(a, v, p, q));
    }
    const all = [0, 1, 2].map((k) => ({ value: Math.max(0, a[k][k]), vector: v.map((row) => row[k]) }));
    return all.sort((one, other) => one.value - other.value);
}

// Makes the number at p, q of the matrix 0.
function turn(a, v, p, q) {
    if (a[p][q] === 0) {
        return;
    }
    const slope = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const t = (slope < 0 ? -1 : 1) / (Math.abs(slope) + Math.hypot(slope, 1));
    const c = 1 / Math.hypot(t, 1);
    const rotate = (one, other, set) => set(c * one - t * c * other, t * c * one + c * other);
    for (const row of [...a, ...v]) {
        rotate(row[p], row[q], (x, y) => ([row[p], row[q]] = [x, y]));
    }
    for (let k = 0; k < 3; k++) {
        rotate(a[p][k], a[q][k], (x, y) => ([a[p][k], a[q][k]] = [x, y]));
    }
    [a[p][q], a[q][p]] = [0, 0];
}

// each(see): calls see(x, y, z) for all of them, the same each time.
function boundsOf(each) {
    const out = { count: 0, sum: [0, 0, 0], min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] };
    each((x, y, z) => {
        const at = [x, y, z];
        out.count++;
        for (let k = 0; k < 3; k++) {
            out.sum[k] += at[k];
            out.min[k] = Math.min(out.min[k], at[k]);
            out.max[k] = Math.max(out.max[k], at[k]);
        }
    });
    return out;
}

function spreadOf(each, count, middle) {
    const out = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
    each((x, y, z) => {
        const d = [x - middle[0], y - middle[1], z - middle[2]];
        for (let k = 0; k < 3; k++) {
            for (let l = 0; l < 3; l++) {
                out[k][l] += (d[k] * d[l]) / count;
            }
        }
    });
    return out;
}

// { normal, distance, residual }: the normal looks toward the origin, which is so
// far from the plane; residual: root of the mean square. null: the points are
// fewer than three, or lie on a line.
function planeOf(each, count, middle) {
    const [least, next, most] = eigen(spreadOf(each, count, middle));
    if (count < 3 || Math.sqrt(next.value) <= ROUND * Math.sqrt(most.value)) {
        return null;
    }
    const along = least.vector.reduce((sum, n, k) => sum + n * middle[k], 0);
    const normal = least.vector.map((n) => (along > 0 ? -n : n));
    let squares = 0;
    each((x, y, z) => {
        squares += (normal[0] * (x - middle[0]) + normal[1] * (y - middle[1]) + normal[2] * (z - middle[2])) ** 2;
    });
    return { normal, distance: Math.abs(along), residual: Math.sqrt(squares / count) };
}

// { count, min, max, plane } of points.
export function numbersOf(each) {
    const { count, sum, min, max } = boundsOf(each);
    const middle = sum.map((v) => v / count);
    return count === 0 ? { count, min: null, max: null, plane: null } : { count, min, max, plane: planeOf(each, count, middle) };
}
