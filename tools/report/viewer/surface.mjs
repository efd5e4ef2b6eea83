// A triangle mesh that tells where a ray meets it, by a tree of boxes.
const LEAF = 8;  // triangles that are not parted further

export class Surface {
  /// `points`: x y z after x y z; `triangles`: three indices each.
  constructor(points, triangles) {
    this.points = points;
    this.triangles = triangles;
    this.order = Uint32Array.from({ length: triangles.length / 3 }, (_, i) => i);
    this.centers = new Float32Array(triangles.length);
    for (let t = 0; t < this.order.length; ++t)
      for (let d = 0; d < 3; ++d)
        this.centers[3 * t + d] = (this.corner(t, 0, d) + this.corner(t, 1, d) + this.corner(t, 2, d)) / 3;
    this.root = this.nodeOf(0, this.order.length);
  }

  corner(triangle, k, d) { return this.points[3 * this.triangles[3 * triangle + k] + d]; }

  nodeOf(from, to) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const first = [...low], last = [...high];  // of the centres
    for (let i = from; i < to; ++i)
      for (let d = 0; d < 3; ++d) {
        const c = this.centers[3 * this.order[i] + d];
        first[d] = Math.min(first[d], c), last[d] = Math.max(last[d], c);
        for (let k = 0; k < 3; ++k) {
          const x = this.corner(this.order[i], k, d);
          low[d] = Math.min(low[d], x), high[d] = Math.max(high[d], x);
        }
      }
    const node = { low, high, from, to };
    if (to - from <= LEAF) return node;
    const sides = last.map((x, d) => x - first[d]), axis = sides.indexOf(Math.max(...sides));
    const middle = (first[axis] + last[axis]) / 2;
    let cut = from;
    for (let i = from; i < to; ++i)
      if (this.centers[3 * this.order[i] + axis] < middle) {
        [this.order[i], this.order[cut]] = [this.order[cut], this.order[i]];
        ++cut;
      }
    if (cut === from || cut === to) cut = (from + to) >> 1;
    node.parts = [this.nodeOf(from, cut), this.nodeOf(cut, to)];
    return node;
  }

  /// The first triangle that a ray meets from outside or inside: {distance, triangle, weights of its corners}; null: none.
  cast(origin, direction) {
    let best = null;
    const stack = [this.root];
    while (stack.length) {
      const node = stack.pop();
      if (!meetsBox(node, origin, direction, best ? best.distance : Infinity)) continue;
      if (node.parts) {
        stack.push(...node.parts);
        continue;
      }
      for (let i = node.from; i < node.to; ++i) {
        const hit = this.meetsTriangle(this.order[i], origin, direction);
        if (hit && (!best || hit.distance < best.distance)) best = hit;
      }
    }
    return best;
  }

  /// By the signed volumes of ray and edges.
  meetsTriangle(triangle, o, v) {
    const p = k => [this.corner(triangle, k, 0), this.corner(triangle, k, 1), this.corner(triangle, k, 2)];
    const a = p(0), ab = minus(p(1), a), ac = minus(p(2), a), h = cross(v, ac), det = dot(ab, h);
    if (det === 0) return null;
    const s = minus(o, a), b = dot(s, h) / det, q = cross(s, ab), c = dot(v, q) / det, distance = dot(ac, q) / det;
    return b < 0 || c < 0 || b + c > 1 || distance <= 0 ? null : { distance, triangle, weights: [1 - b - c, b, c] };
  }

  /// Values of points, three each, at a hit.
  at(hit, values = this.points) {
    return [0, 1, 2].map(d => hit.weights.reduce((sum, w, k) => sum + w * values[3 * this.triangles[3 * hit.triangle + k] + d], 0));
  }

  /// Index of the mesh's point that is nearest.
  nearest(place) {
    let best = 0, least = Infinity;
    for (let i = 0; i < this.points.length; i += 3) {
      const x = this.points[i] - place[0], y = this.points[i + 1] - place[1], z = this.points[i + 2] - place[2];
      const square = x * x + y * y + z * z;
      if (square < least) least = square, best = i / 3;
    }
    return best;
  }
}

function meetsBox(box, o, v, until) {
  let near = 0, far = until;
  for (let d = 0; d < 3; ++d) {
    if (v[d] === 0) {
      if (o[d] < box.low[d] || o[d] > box.high[d]) return false;
      continue;
    }
    const a = (box.low[d] - o[d]) / v[d], b = (box.high[d] - o[d]) / v[d];
    near = Math.max(near, Math.min(a, b)), far = Math.min(far, Math.max(a, b));
  }
  return near <= far * (1 + 1e-6);
}

export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = a => Math.sqrt(dot(a, a));
