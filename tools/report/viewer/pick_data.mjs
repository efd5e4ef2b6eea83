// The shapes of the picking part as they stand in the page, and the colours that show what meets what.
import { byId, decode } from './stage.mjs';
import { Surface } from './surface.mjs';

/// Colours of places and limbs that are told apart also by colour-blind eyes.
const PALETTE = ['#d55e00', '#0072b2', '#009e73', '#cc79a7', '#8a6d3b', '#e69f00', '#56b4e9', '#1d2126'];
export const colourOf = index => PALETTE[index % PALETTE.length];
export const ALONE = '#8a929b';

export const stem = path => path.split('/').pop().replace(/\{.*\}$/, '').replace(/(\.#+)?(\.[A-Za-z0-9]+)+(:[^:]*)?$/, '') || path;

/// The data of the page: JSON, and for each shape its surface, `meets[k]`, where its points are on shape k (null: not
/// known, or itself), `own`, its colours (null: none), `size`, and `lowest` and `sides` of its box.
export function readData() {
  const data = JSON.parse(byId('pick').textContent), bytes = decode(byId('pickMeshes').textContent);
  let at = 0;
  const take = (Type, count) => {
    const part = new Type(bytes, at, count);
    at += part.byteLength;
    return part;
  };
  const names = data.shapes.map(s => stem(s.name));
  data.shapes.forEach((shape, k) => {
    shape.short = names.filter(n => n === names[k]).length > 1 ? names[k] + ' ' + (k + 1) : names[k];
    shape.surface = new Surface(take(Float32Array, 3 * shape.points), take(Uint32Array, 3 * shape.triangles));
    shape.meets = data.shapes.map((_, other) => data.overlap === null || other === k ? null : take(Float32Array, 3 * shape.points));
    shape.own = shape.colors ? take(Uint8Array, 4 * shape.points) : null;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    shape.surface.points.forEach((x, i) => { low[i % 3] = Math.min(low[i % 3], x), high[i % 3] = Math.max(high[i % 3], x); });
    shape.lowest = low;
    shape.sides = low.map((x, d) => high[d] - x);
    shape.size = Math.max(...shape.sides);
  });
  return data;
}

/// Oklab to linear red, green, blue.
function linear(L, a, b) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3, m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3,
    s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s].map(x => Math.min(Math.max(x, 0), 1));
}

/// Colours of a shape's points, linear: by where each is on the first shape, so that what meets has one colour. Along the
/// first shape's longest side the hue changes, across it hue and lightness a little, so that left is not right.
export function meetingColours(data, k) {
  const first = data.shapes[0], shape = data.shapes[k], where = k === 0 ? shape.surface.points : shape.meets[0];
  const axes = [0, 1, 2].sort((a, b) => first.sides[b] - first.sides[a]);
  const colours = new Float32Array(where.length);
  for (let i = 0; i < where.length; i += 3) {
    const [along, across, third] = axes.map(d => Math.min(Math.max((where[i + d] - first.lowest[d]) / first.sides[d], 0), 1) - 0.5);
    const hue = (205 - 260 * along + 60 * third) * Math.PI / 180;
    colours.set(linear(0.75 + 0.2 * across, 0.125 * Math.cos(hue), 0.125 * Math.sin(hue)), i);
  }
  return colours;
}

/// The input's own colours, linear; else clay.
export function ownColours(shape, clay) {
  const colours = new Float32Array(3 * shape.points);
  for (let i = 0; i < shape.points; ++i)
    for (let d = 0; d < 3; ++d)
      colours[3 * i + d] = clay || !shape.own ? [0.62, 0.55, 0.48][d] : (shape.own[4 * i + d] / 255) ** 2.2;
  return colours;
}

/// Where the map takes a place of shape `from` on shape `to`, both in the inputs' coordinates; null: not known. `hit`: on
/// the surface; without one the nearest point of the mesh tells.
export function carried(data, from, to, place, hit) {
  const a = data.shapes[from], b = data.shapes[to], meets = a.meets[to];
  if (!meets) return null;
  if (hit) return a.surface.at(hit, meets).map((x, d) => x + b.origin[d]);
  const i = a.surface.nearest(place.map((x, d) => x - a.origin[d]));
  return [0, 1, 2].map(d => meets[3 * i + d] + b.origin[d]);
}
