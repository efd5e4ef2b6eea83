// The page of `slicemorph morph --report report.html`: a player, curves and tables of the data that stand in the page; and of
// `slicemorph pick`, of whose shapes a report shows the same.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { startPicker } from './picker.mjs';
import { addLights, byId, decode, frameAll } from './stage.mjs';

const report = byId('report') ? JSON.parse(byId('report').textContent) : null;
const frames = report ? report.frames : [];
const last = frames.length - 1;
/// What is to be done when the time changes; the time is a place among the frames, from 0 to the last.
const listeners = [];
let place = 0;

function setPlace(value) {
  place = Math.min(Math.max(value, 0), last);
  byId('time').value = last > 0 ? place / last : 0;
  const frame = frames[Math.round(place)], t = timeAt(place);
  byId('now').textContent = 'frame ' + frame.frame + (t === null ? '' : ', t = ' + t.toFixed(3));
  for (const listener of listeners) listener(place);
}

function timeAt(at) {
  const i = Math.min(Math.floor(at), Math.max(last - 1, 0)), a = frames[i].t, b = frames[Math.min(i + 1, last)].t;
  return a === null || b === null ? null : a + (at - i) * (b - a);
}

function number(value) {
  if (typeof value !== 'number') return String(value);
  if (Number.isInteger(value)) return String(value);
  return Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(5)));
}

/// Visits the points of all frames: every mesh in all its shapes.
function forPoints(scene, visit) {
  const p = new THREE.Vector3();
  scene.updateMatrixWorld(true);
  scene.traverse(node => {
    if (!node.isMesh) return;
    const base = node.geometry.attributes.position, targets = node.geometry.morphAttributes.position || [];
    for (let k = -1; k < targets.length; ++k)
      for (let i = 0; i < base.count; ++i) {
        p.fromBufferAttribute(base, i);
        if (k >= 0) p.x += targets[k].getX(i), p.y += targets[k].getY(i), p.z += targets[k].getZ(i);
        visit(p.applyMatrix4(node.parent.matrixWorld));
      }
  });
}

function say(text) {
  const note = document.createElement('div');
  note.className = 'none';
  note.textContent = text;
  byId('player').replaceChildren(note);
}

function startPlayer() {
  const data = byId('glb');
  if (!data) return say('this method makes no surface');
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  } catch (error) {
    return say('this browser shows no WebGL');
  }
  const holder = byId('player'), scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(28, 1, 0.01, 100);
  holder.appendChild(renderer.domElement);
  renderer.setPixelRatio(window.devicePixelRatio);
  addLights(scene, camera);
  const controls = new OrbitControls(camera, renderer.domElement);
  const draw = () => renderer.render(scene, camera);
  controls.addEventListener('change', draw);
  const resize = () => {
    renderer.setSize(holder.clientWidth, holder.clientHeight, false);
    camera.aspect = holder.clientWidth / holder.clientHeight;
    camera.updateProjectionMatrix();
    draw();
  };
  window.addEventListener('resize', resize);
  new GLTFLoader().parse(decode(data.textContent), '', gltf => {
    scene.add(gltf.scene);
    gltf.scene.traverse(node => { if (node.isMesh) node.frustumCulled = false; });
    const box = new THREE.Box3();
    forPoints(gltf.scene, p => box.expandByPoint(p));
    box.getCenter(controls.target);
    resize();
    frameAll(visit => forPoints(gltf.scene, visit), camera, controls.target, new THREE.Vector3(0.55, 0.3, 1).normalize());
    controls.update();
    const mixer = new THREE.AnimationMixer(gltf.scene), shown = report.viewer.frames;
    const actions = gltf.animations.map(clip => mixer.clipAction(clip).setLoop(THREE.LoopOnce));
    for (const action of actions) action.clampWhenFinished = true;
    // The player may have fewer frames than the report: its own are `shown`, a second apart.
    listeners.push(at => {
      let i = 0;
      while (i + 2 < shown.length && shown[i + 1] <= at) ++i;
      const share = shown.length > 1 ? (at - shown[i]) / (shown[i + 1] - shown[i]) : 0;
      for (const action of actions) action.reset().play();
      mixer.setTime(i + share);
      draw();
    });
    setPlace(place);
    document.body.dataset.player = 'ready';
  }, error => say('the shapes cannot be read: ' + error.message));
}

function startControls() {
  const button = byId('play');
  let since = null;
  byId('time').addEventListener('input', event => {
    since = null;
    setPlace(event.target.value * last);
  });
  const step = now => {
    if (since === null) {
      button.textContent = 'Play';
      return;
    }
    const next = place + (now - since) / 1000 * report.settings.fps / 2;
    since = now;
    setPlace(next > last ? 0 : next);
    requestAnimationFrame(step);
  };
  button.addEventListener('click', () => {
    since = since === null ? performance.now() : null;
    button.textContent = since === null ? 'Play' : 'Pause';
    if (since !== null) requestAnimationFrame(step);
  });
  if (last < 1) byId('controls').hidden = true;
}

function niceStep(range) {
  const raw = range / 4, power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map(m => m * power).find(s => s >= raw);
}

/// One picture of numbers over the frames. `series`: [name, colour, values]; a value that is null is left out.
function curve(title, series, options = {}) {
  const values = series.flatMap(s => s[2]).filter(v => v !== null && v !== undefined);
  if (!values.length) return;
  const width = 360, height = 210, left = 58, right = 12, top = 34, bottom = 26;
  let low = Math.min(...values, options.from ?? Infinity), high = Math.max(...values);
  if (options.whole) low = Math.min(low, 0), high = Math.max(high, low + 2);
  if (high === 0 && low === 0) high = 1;
  if (high - low < 1e-9 * Math.max(Math.abs(high), 1e-30)) low -= Math.abs(low) / 10 || 1, high += Math.abs(high) / 10 || 1;
  const step = options.whole ? Math.max(1, niceStep(high - low)) : niceStep(high - low);
  low = Math.floor(low / step + 1e-9) * step;
  high = Math.ceil(high / step - 1e-9) * step;
  const x = i => left + (width - left - right) * (last > 0 ? i / last : 0.5);
  const y = v => top + (height - top - bottom) * (1 - (v - low) / (high - low));
  let svg = `<svg viewBox="0 0 ${width} ${height}" font-size="11" fill="#6b737d"><text x="10" y="20" font-size="13" fill="#1d2126">${title}</text>`;
  for (let v = low; v <= high + step / 2; v += step)
    svg += `<line x1="${left}" x2="${width - right}" y1="${y(v)}" y2="${y(v)}" stroke="#eceff2"/>` +
           `<text x="${left - 6}" y="${y(v) + 4}" text-anchor="end">${number(Number(v.toPrecision(6)))}</text>`;
  const ends = frames[0].t === null ? [frames[0].frame, frames[last].frame] : [frames[0].t, frames[last].t].map(t => 't = ' + number(t));
  svg += `<text x="${left}" y="${height - 9}">${ends[0]}</text><text x="${width - right}" y="${height - 9}" text-anchor="end">${last > 0 ? ends[1] : ''}</text>`;
  let key = width - right;
  for (const [name, colour, list, dash] of series) {
    const points = list.map((v, i) => v === null || v === undefined ? null : [x(i), y(v)]).filter(p => p);
    svg += `<polyline points="${points.map(p => p.map(c => c.toFixed(1)).join()).join(' ')}" fill="none" stroke="${colour}" stroke-width="1.8"${dash ? ' stroke-dasharray="4 4"' : ''}/>`;
    if (!dash) for (const p of points) svg += `<circle cx="${p[0].toFixed(1)}" cy="${p[1].toFixed(1)}" r="2" fill="${colour}"/>`;
    if (series.length > 1) {
      svg += `<text x="${key}" y="20" text-anchor="end" fill="${colour}">${name}</text>`;
      key -= 6.2 * name.length + 10;
    }
  }
  svg += `<line class="cursor" y1="${top}" y2="${height - bottom}" stroke="#1d2126" stroke-opacity="0.45"/></svg>`;
  const holder = document.createElement('div');
  holder.innerHTML = svg;
  byId('curves').appendChild(holder);
  const cursor = holder.querySelector('.cursor');
  listeners.push(at => {
    cursor.setAttribute('x1', x(at));
    cursor.setAttribute('x2', x(at));
  });
}

/// Volumes of the labels of a map, of many those that get largest.
function labelCurve() {
  const colours = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8a6d3b', '#1d2126'];
  const volumes = new Map();
  frames.forEach((frame, i) => {
    for (const label of frame.labels ?? []) {
      if (label.label === null || label.label === undefined) continue;
      if (!volumes.has(label.label)) volumes.set(label.label, frames.map(f => f.labels ? 0 : null));
      volumes.get(label.label)[i] = label.volumeMl;
    }
  });
  if (volumes.size === 1 && volumes.has(1)) return;  // the shape itself, whose volume has a curve
  const largest = list => Math.max(...list.filter(v => v !== null));
  const shown = [...volumes].sort((a, b) => largest(b[1]) - largest(a[1])).slice(0, colours.length).sort((a, b) => a[0] - b[0]);
  const title = volumes.size > shown.length ? `Largest ${shown.length} of ${volumes.size} labels, ml` : 'Labels, ml';
  curve(title, shown.map(([label, list], i) => [String(label), colours[i], list]).reverse(), { from: 0 });
}

function drawCurves() {
  const blue = '#0072b2', orange = '#d55e00', green = '#009e73', grey = '#8a929b';
  const of = name => frames.map(f => f[name]);
  curve('Volume', [['frame', blue, of('volume')], ['linear', grey, frames.map(f => f.volume === null ? null : f.volumeLinear), true]], { from: 0 });
  labelCurve();
  curve('Area', [['frame', blue, of('area')]], { from: 0 });
  curve('Pieces', [['pieces', blue, of('pieces')]], { whole: true });
  curve('Genus', [['genus', blue, of('genus')]], { whole: true });
  curve('Folded share of the map', [['fold', orange, frames.map(f => f.volume === null ? null : f.foldShare)]], { from: 0 });
  curve('Change from the frame before', [['difference', green, of('symmetricDifference')]], { from: 0 });
  curve('Seconds', ['evaluate', 'measure', 'write'].map((name, i) => [name, [blue, orange, green][i], frames.map(f => f.seconds[name])]), { from: 0 });
}

function table(id, rows) {
  for (const row of rows) {
    const line = byId(id).insertRow();
    row.forEach((cell, i) => {
      const made = document.createElement(i === 0 || rows.head && row === rows[0] ? 'th' : 'td');
      made.textContent = cell;
      line.appendChild(made);
    });
  }
}

function text(value) {
  if (Array.isArray(value) && !value.length) return '-';
  if (Array.isArray(value)) return value.length > 12 ? value.length + ' values' : value.map(text).join(', ');
  if (value && typeof value === 'object') return Object.entries(value).map(([k, v]) => k + ' ' + text(v)).join(', ');
  return value === null || value === '' ? '-' : number(value);
}

function fillNotes(notes) {
  for (const note of notes) {
    const item = document.createElement('li');
    item.textContent = note;
    byId('notes').appendChild(item);
  }
  byId('notePart').hidden = !notes.length;
}

function fillText() {
  const names = report.settings.inputs.map(path => path.split('/').pop());
  byId('title').textContent = document.title = names.join(' \u2192 ');
  byId('facts').textContent = `${frames.length} frame${last ? 's' : ''}, method ${report.settings.method}; loaded in ` +
    `${number(report.seconds.load)} s, planned in ${number(report.seconds.plan)} s, at most ${number(report.peakMemoryBytes / 2 ** 20)} MB`;
  fillNotes(report.notes);
  byId('sheetPart').hidden = !byId('sheetData');
  if (byId('sheetData')) byId('sheet').src = byId('sheetData').textContent.trim();
  const inputs = [['file', 'volume', 'area', 'pieces', 'genus'],
    ...report.inputs.map(i => [i.file, number(i.volume), number(i.area), i.pieces, i.genus])];
  inputs.head = true;
  table('inputs', inputs);
  table('summary', Object.entries(report.summary).map(([k, v]) => [k, text(v)]));
  table('settings', Object.entries(report.settings).map(([k, v]) => [k, text(v)]));
}

function startSlices() {
  const data = byId('slices');
  byId('slicePart').hidden = !data;
  if (!data) return;
  const pictures = JSON.parse(data.textContent), slider = byId('sliceNumber');
  const show = () => {
    byId('slice').innerHTML = pictures[slider.value];
    byId('sliceName').textContent = 'slice ' + (Number(slider.value) + 1) + ' of ' + pictures.length;
  };
  slider.max = pictures.length - 1;
  slider.value = Math.floor(pictures.length / 2);
  slider.addEventListener('input', show);
  show();
}

/// In a report the shapes are drawn when they come into sight, as most readers do not need them.
function pickWhenSeen() {
  if (!report) {
    const names = startPicker();
    byId('title').textContent = document.title = names.join(' \u2192 ');
    const { notes } = JSON.parse(byId('pick').textContent);
    return fillNotes(notes);
  }
  const sight = new IntersectionObserver(entries => {
    if (!entries.some(e => e.isIntersecting)) return;
    sight.disconnect();
    startPicker();
  }, { rootMargin: '200px' });
  sight.observe(byId('pickPart'));
}

for (const part of document.querySelectorAll('.ofReport')) part.hidden = !report;
byId('pickPart').hidden = !byId('pick');
if (report) {
  fillText();
  drawCurves();
  startControls();
  startSlices();
  startPlayer();
  setPlace(0);
}
if (byId('pick')) pickWhenSeen();
